"""Inputs on which the original program fails, or anybody might: all must give a closed manifold."""

import numpy as np
import pytest
import shapes
from scipy.spatial import cKDTree

from meshlab_symrecon.geometry.surfaces import enclosed_volume
from meshlab_symrecon.powercrust import Recipe, reconstruct

TORUS_VOLUME = 2 * np.pi**2 * 0.4**2


def assert_closed(crust):
    shape = crust.topology
    assert shape.closed
    assert shape.edge_manifold
    assert shape.vertex_manifold
    assert shape.oriented
    assert enclosed_volume(crust.points, crust.faces) > 0.0
    assert len(np.unique(crust.points, axis=0)) == len(crust.points)


def assert_solid(crust, volume, genus=0, components=1, rel=0.02):
    assert_closed(crust)
    assert (crust.topology.genus, crust.topology.components) == (genus, components)
    assert enclosed_volume(crust.points, crust.faces) == pytest.approx(volume, rel=rel)


def blob(count, seed):
    """Random samples of a smooth body of genus 0 with dents and bumps, about 2 units wide."""
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(count, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    return points * blob_radius(points)[:, None]


def blob_radius(directions):
    x, y, z = directions.T
    return 1.0 + 0.15 * np.sin(3 * x + 1.0) * np.cos(2 * y) + 0.1 * np.sin(4 * z)


def from_blob(points):
    """Distance to the blob, along the ray from its centre."""
    length = np.linalg.norm(points, axis=1)
    return np.abs(length - blob_radius(points / length[:, None]))


def cube_lattice(steps):
    return shapes.box_lattice(steps) / steps


def torus_grid(rows, columns):
    return shapes.torus_mesh(rows, columns)[0]


def random_sphere(count, seed):
    points = np.random.default_rng(seed).normal(size=(count, 3))
    return points / np.linalg.norm(points, axis=1, keepdims=True)


def test_two_thousand_duplicates():
    samples = shapes.torus(6000, seed=1)
    again = np.random.default_rng(0).integers(0, 6000, 2000)
    doubled, once = reconstruct(np.concatenate([samples, samples[again]])), reconstruct(samples)
    assert_solid(doubled, TORUS_VOLUME, genus=1)
    assert doubled.points.tobytes() == once.points.tobytes()


def test_the_grids_of_a_cube():
    assert_solid(reconstruct(cube_lattice(30)), 1.0, rel=0.005)


def test_a_torus_of_cospherical_rings():
    assert_solid(reconstruct(torus_grid(120, 60)), TORUS_VOLUME, genus=1, rel=0.03)


@pytest.mark.parametrize("noise", [0.0, 1e-15, 1e-9])
def test_a_nearly_cospherical_sphere_of_50k(noise):
    rng = np.random.default_rng(2)
    samples = random_sphere(50_000, 2) * (1.0 + noise * rng.normal(size=(50_000, 1)))
    assert_solid(reconstruct(samples), 4 * np.pi / 3, rel=1e-3)


@pytest.mark.parametrize("offset", [1e3, -1e3, 1e6, -1e6])
def test_far_from_the_origin(offset):
    samples = shapes.torus(5000, seed=3)
    crust = reconstruct(samples + offset)
    assert_solid(crust, TORUS_VOLUME, genus=1)
    spacing = np.sqrt(4 * np.pi**2 * 0.4 / 5000)
    assert cKDTree(samples).query(crust.points - offset)[0].max() < 5 * spacing  # no spikes


@pytest.mark.parametrize("diagonal", [1e-6, 1e6])
def test_tiny_and_huge(diagonal):
    samples = shapes.torus(5000, seed=4)
    scale = diagonal / np.linalg.norm(np.ptp(samples, axis=0))
    crust = reconstruct(samples * scale)
    assert_solid(crust, TORUS_VOLUME * scale**3, genus=1)


@pytest.mark.parametrize("share", [0.01, 0.05])
@pytest.mark.parametrize("seed", range(3))
def test_outliers(share, seed):
    rng = np.random.default_rng(seed + 100)
    samples = blob(10_000, seed)
    low, high = samples.min(axis=0), samples.max(axis=0)
    stray = rng.uniform(low, high, (int(share * len(samples)), 3))
    crust = reconstruct(np.concatenate([samples, stray]))
    assert_closed(crust)
    assert (crust.topology.genus, crust.topology.components) == (0, 1)
    diagonal = np.linalg.norm(high - low)
    # an outlier within three spacings of the surface is no outlier: the spacing is .8 % here
    limit = 0.015 if share == 0.01 else 0.025
    assert from_blob(crust.points).max() < limit * diagonal


@pytest.mark.parametrize("noise", [0.05, 0.1, 0.2, 0.5])
@pytest.mark.parametrize("seed", range(2))
def test_noise_in_percent_of_the_diagonal(noise, seed):
    samples = blob(20_000, seed)
    deviation = noise / 100 * np.linalg.norm(np.ptp(samples, axis=0))
    samples += np.random.default_rng(seed + 100).normal(0.0, deviation, samples.shape)
    crust = reconstruct(samples)
    assert_closed(crust)
    assert (crust.topology.genus, crust.topology.components) == (0, 1)
    corners = crust.points[crust.faces]
    areas = np.linalg.norm(np.cross(*(corners[:, k] - corners[:, 0] for k in (1, 2))), axis=1)
    distance = np.average(from_blob(corners.mean(axis=1)), weights=areas)
    assert distance < 0.6 * deviation + 5e-4  # the mean of the samples themselves is .8


@pytest.mark.parametrize("noise", [0.05, 0.1, 0.2])
def test_a_noisy_torus_keeps_its_handle(noise):
    samples = shapes.torus(20_000, seed=5)
    deviation = noise / 100 * np.linalg.norm(np.ptp(samples, axis=0))
    samples += np.random.default_rng(105).normal(0.0, deviation, samples.shape)
    assert_solid(reconstruct(samples), TORUS_VOLUME, genus=1)


@pytest.mark.parametrize("thickness", [0.04, 0.1])
def test_thin_sheets(thickness):
    """Both sides of a square plate, without its rim."""
    rng = np.random.default_rng(6)
    samples = rng.random((8000, 3))
    samples[:, 2] = thickness * rng.integers(0, 2, 8000)
    assert_solid(reconstruct(samples), thickness, rel=0.1)


def test_two_touching_balls():
    ball = random_sphere(4000, 7)
    other = random_sphere(4000, 8) + np.array([2.0, 0.0, 0.0])
    crust = reconstruct(np.concatenate([ball, other]))
    assert_closed(crust)
    assert crust.topology.genus == 0
    assert crust.topology.components in (1, 2)
    assert enclosed_volume(crust.points, crust.faces) == pytest.approx(8 * np.pi / 3, rel=0.01)


TETRAHEDRON = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])


@pytest.mark.parametrize("extra", [0, 1])
def test_four_points_and_a_tetrahedron_with_its_centre(extra):
    samples = np.concatenate([TETRAHEDRON, [TETRAHEDRON.mean(axis=0)]])[: 4 + extra]
    crust = reconstruct(samples)
    assert_solid(crust, 1 / 6, rel=1e-12)
    assert crust.hull


def latitudes(rings):
    turn, height = np.meshgrid(
        np.linspace(0, 2 * np.pi, 2 * rings, endpoint=False), np.linspace(0, np.pi, rings)
    )
    turn, height = turn.ravel(), height.ravel()
    ring = np.sin(height)
    return np.stack([ring * np.cos(turn), ring * np.sin(turn), np.cos(height)], axis=1)


def helix():
    turn = np.linspace(0, 20 * np.pi, 1000)
    return np.stack([np.cos(turn), np.sin(turn), turn / 20], axis=1)


def doubled(shift):
    samples = shapes.torus(1500, seed=9)
    return np.concatenate([samples, samples + shift])


@pytest.mark.parametrize("surface", ["power crust", "interpolating"])
@pytest.mark.parametrize(
    "samples",
    [latitudes(3), latitudes(8), latitudes(20), helix(), doubled(1e-12), doubled(1e-16)],
    ids=["three latitudes", "eight", "twenty", "a curve", "twice", "twice but for rounding"],
)
@pytest.mark.filterwarnings("error")
def test_slivers_everywhere(surface, samples):
    """Nothing but cospherical or nearly equal points, whose cells are all nearly flat."""
    assert_closed(reconstruct(samples, Recipe(surface=surface)))


def test_either_zero_is_the_same_zero():
    samples = np.round(shapes.torus(2000, seed=10), 2)
    samples = np.concatenate([samples, samples * [1, 1, -1], -samples])
    shuffled = samples[np.random.default_rng(0).permutation(len(samples))]
    one, other = reconstruct(samples), reconstruct(shuffled)
    assert one.points.tobytes() == other.points.tobytes()


def test_progress_never_falls_even_when_outliers_are_left_out():
    rng = np.random.default_rng(11)
    samples = np.concatenate([shapes.torus(2000, seed=11), rng.uniform(-1.5, 1.5, (100, 3))])
    told = []
    crust = reconstruct(samples, progress=lambda share, stage: told.append(share))
    assert crust.outliers > 0
    assert told == sorted(told)
    assert told[-1] == 1.0
