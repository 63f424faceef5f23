"""Shapes whose symmetry is known by construction, cut and moved."""

from types import SimpleNamespace

import numpy as np
import pytest

from meshlab_symrecon.symmetry.preparation import prepare


def even_directions(count):
    steps = np.arange(count) + 0.5
    polar, turn = np.arccos(1 - 2 * steps / count), np.pi * (1 + 5**0.5) * steps
    return np.stack(
        [np.cos(turn) * np.sin(polar), np.sin(turn) * np.sin(polar), np.cos(polar)], axis=1
    )


def blob(count, seed, *, mirrored):
    """A star-shaped body with random bumps, mirrored across x = 0 or not; evenly sampled."""
    rng = np.random.default_rng(seed)
    fine = even_directions(6 * count)
    radii = np.ones(len(fine))
    for _ in range(6):
        centre = rng.normal(size=3)
        centre /= np.linalg.norm(centre)
        height, width = rng.uniform(0.3, 0.8), rng.uniform(0.2, 0.45)
        for side in (1.0, -1.0) if mirrored else (1.0,):
            squares = ((fine - centre * [side, 1.0, 1.0]) ** 2).sum(axis=1)
            radii += height * np.exp(-0.5 * squares / width**2)
    surface = fine * radii[:, np.newaxis] * [1.0, 1.4, 0.8]
    # Keep points in proportion to the area they stand for.
    stretch = radii**2 / (radii**2).max()
    chosen = np.flatnonzero(rng.random(len(fine)) < stretch * count / (stretch.sum()))
    return rng.permutation(surface[chosen])


def box_with_horns(count, seed):
    """A box with two mirrored horns: one plane, x = 0, and no other."""
    rng = np.random.default_rng(seed)
    parts = [((0, 0, 0), (1.0, 0.7, 0.4)), ((0.55, 0.3, 0.6), (0.2, 0.15, 0.3))]
    parts += [((-0.55, 0.3, 0.6), (0.2, 0.15, 0.3)), ((0, 0.75, 0.1), (0.25, 0.2, 0.2))]
    clouds = []
    for centre, half in parts:
        half = np.array(half)
        areas = np.array([half[1] * half[2], half[0] * half[2], half[0] * half[1]])
        faces = rng.choice(3, int(count * areas.sum()), p=areas / areas.sum())
        places = rng.uniform(-1, 1, size=(len(faces), 3))
        places[np.arange(len(faces)), faces] = rng.choice([-1.0, 1.0], len(faces))
        clouds.append(places * half + centre)
    cloud = np.vstack(clouds)
    hidden = np.zeros(len(cloud), dtype=bool)
    for centre, half in parts:
        hidden |= (np.abs(cloud - centre) < np.array(half) - 1e-9).all(axis=1)
    return cloud[~hidden]


def twisted_prism(count, seed):
    """A square bar twisted by a right angle and a half: rotations, but no mirror plane."""
    rng = np.random.default_rng(seed)
    turn, height = rng.uniform(0, 2 * np.pi, count), rng.uniform(-1, 1, count)
    sector = np.pi / 2
    radius = 0.6 / np.cos(turn % sector - sector / 2)
    angle = turn + 1.2 * height
    side = np.stack([radius * np.cos(angle), radius * np.sin(angle), 1.5 * height], axis=1)
    caps = side[: count // 5].copy()
    shrink = np.sqrt(rng.random(len(caps)))
    angle = turn[: len(caps)] + 1.2 * np.sign(height[: len(caps)])
    caps[:, 0] = shrink * radius[: len(caps)] * np.cos(angle)
    caps[:, 1] = shrink * radius[: len(caps)] * np.sin(angle)
    caps[:, 2] = 1.5 * np.sign(height[: len(caps)])
    return np.vstack([side, caps])


def bitten(points, direction, share):
    """Remove the share of the points that lies farthest in a direction."""
    heights = points @ np.asarray(direction, dtype=float)
    return points[heights <= np.quantile(heights, 1.0 - share)]


@pytest.fixture(scope="session")
def statue():
    """A mirrored blob with a quarter missing on one side; its plane is x = 0."""
    return bitten(blob(7_000, 3, mirrored=True), [1.0, 0.25, -0.15], 0.25)


@pytest.fixture(scope="session")
def shapes():
    """The shapes above, by name."""
    return SimpleNamespace(
        bitten=bitten, blob=blob, box_with_horns=box_with_horns, twisted_prism=twisted_prism
    )


@pytest.fixture(scope="session")
def some_planes(statue):
    """Planes of the prepared statue: the true one, some near it, and any others."""
    rng = np.random.default_rng(8)
    cloud = prepare(statue, None, 100)
    true = cloud.from_input(np.array([[1.0, 0.0, 0.0, 0.0]]))[0]
    planes = np.vstack([true + rng.normal(0, 0.03, (30, 4)), rng.normal(0, 1, (30, 4)), true])
    planes[:, 3] = np.clip(planes[:, 3], -0.2, 0.2)
    planes[:, :3] /= np.linalg.norm(planes[:, :3], axis=1, keepdims=True)
    return planes
