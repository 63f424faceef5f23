"""One side of a body is moved by a known field: the offsets in a hole of it must follow."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from meshlab_symrecon.geometry.neighbours import principal_normals
from meshlab_symrecon.geometry.planes import reflect
from meshlab_symrecon.symmetry.asymmetry import asymmetry_field
from meshlab_symrecon.symmetry.preparation import prepare

PLANE = np.array([1.0, 0.0, 0.0, 0.0])
SEEDS = range(2)
LONGEST = 0.25


def shift(places):
    return np.tile([0.0, 0.026, 0.02], (len(places), 1))


def turn(places):
    return np.cross(np.radians(1.5) * np.array([0.6, 0.0, 0.8]), places)


def bend(places):
    return np.outer(0.1 * places[:, 2] ** 2, [0.0, 1.0, 0.5])


def still(places):
    return np.zeros_like(places)


class Body:
    """A body of which x > 0 is moved, with a hole there."""

    def __init__(self, shapes, seed, moved=still, noise=0.0, clutter=0.0):
        rng = np.random.default_rng(seed)
        body = shapes.blob(4_000, seed, mirrored=True)
        self.diagonal = np.linalg.norm(np.ptp(body, axis=0))
        right = body[:, 0] > 0.0
        middle = body[np.argmax(body @ [1.0, 0.3, 0.0])]
        hole = right & (np.linalg.norm(body - middle, axis=1) < 0.35)
        cloud = body + np.where(right[:, np.newaxis], moved(body), 0.0)
        cloud += rng.normal(0.0, 1.0, body.shape) * noise * self.diagonal
        loose = rng.uniform(body.min(axis=0), body.max(axis=0), (int(clutter * len(body)), 3))
        self.scan = np.vstack([cloud[~hole], loose])
        self.missing = body[hole]  # where the mirror images lie
        self.normals = principal_normals(body, self.missing, 16)[0]
        self.true = moved(self.missing)

    def offsets(self):
        cloud = prepare(self.scan, None, 16)
        return asymmetry_field(cloud, PLANE, LONGEST).offsets(self.missing)

    def off(self, offsets):
        """RMS height of the surface that is filled in over the true one."""
        return np.sqrt((np.einsum("ni,ni->n", offsets - self.true, self.normals) ** 2).mean())


def size(vectors):
    return np.sqrt((vectors**2).sum(axis=1).mean())


def test_an_exact_mirror_image_has_no_offset(shapes):
    half = shapes.blob(3_000, 1, mirrored=True)
    half = half[half[:, 0] < 0.0]
    cloud = prepare(np.vstack([half, reflect(half, PLANE)]), None, 16)
    offsets = asymmetry_field(cloud, PLANE, LONGEST).offsets(half)
    assert np.abs(offsets).max() < 1e-9 * cloud.scale


@pytest.mark.parametrize("seed", SEEDS)
def test_two_samples_of_a_symmetric_body_have_hardly_any(shapes, seed):
    body = Body(shapes, seed)
    assert np.linalg.norm(body.offsets(), axis=1).max() < 2e-4 * body.diagonal


@pytest.mark.parametrize("moved", [shift, turn, bend], ids=lambda field: field.__name__)
@pytest.mark.parametrize("seed", SEEDS)
def test_offsets_in_a_hole_are_right_to_a_fifth_and_a_third_better_than_none(shapes, seed, moved):
    body = Body(shapes, seed, moved)
    assert size(body.true) > 1e-3 * body.diagonal
    assert body.off(body.offsets()) < min(0.2 * size(body.true), 2.0 / 3.0 * body.off(0.0))


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("noise", [0.003])
def test_noise_carries_no_more_than_half_of_what_a_point_has(shapes, seed, noise):
    body = Body(shapes, seed, noise=noise)
    assert size(body.offsets()) < 0.5 * noise * body.diagonal


@pytest.mark.parametrize("seed", SEEDS)
def test_clutter_does_not_disturb(shapes, seed):
    body = Body(shapes, seed, turn, clutter=0.2)
    assert body.off(body.offsets()) < 0.15 * size(body.true)


@pytest.mark.parametrize("scale", [1e-4, 1e5])
def test_offsets_follow_motion_and_scale(shapes, scale):
    body = Body(shapes, 4, turn)
    at_rest = body.offsets()
    matrix = Rotation.from_rotvec([0.4, -1.0, 0.7]).as_matrix()
    place = np.array([30.0, -20.0, 50.0])

    def move(points):
        return scale * (points @ matrix.T + place)

    normal = matrix @ PLANE[:3]
    cloud = prepare(move(body.scan), None, 16)
    plane = np.append(normal, -scale * normal @ place)
    moved = asymmetry_field(cloud, plane, LONGEST).offsets(move(body.missing))
    assert np.abs(moved / scale @ matrix - at_rest).max() < 1e-6 * size(at_rest)


def test_nothing_is_said_where_one_side_was_not_measured(shapes):
    body = shapes.blob(3_000, 1, mirrored=True)
    for scan in (body[body[:, 0] < -0.1], body[body[:, 0] < 0.02]):
        assert asymmetry_field(prepare(scan, None, 16), PLANE, LONGEST) is None


def test_nothing_is_said_of_too_few_places(shapes):
    few = shapes.blob(5_000, 1, mirrored=True)
    few = np.vstack([few, reflect(few, PLANE)])[::101]
    assert len(few) < 100
    assert asymmetry_field(prepare(few, None, 16), PLANE, LONGEST) is None
