import numpy as np
import pytest
from symmetry.bodies import no_planes

from meshlab_symrecon.geometry.planes import plane_angles
from meshlab_symrecon.symmetry.cascade import (
    KEPT,
    SAME,
    SHIFT,
    TILT,
    _beside,
    refine_and_verify,
    refine_drawn,
    refine_nearby,
)
from meshlab_symrecon.symmetry.preparation import prepare
from meshlab_symrecon.symmetry.traits import merit

STEPS = {"drawn": refine_drawn, "nearby": refine_nearby}


@pytest.fixture(scope="module")
def cloud(statue):
    return prepare(statue, None, 2_500)


@pytest.fixture(scope="module")
def true(cloud):
    return cloud.from_input(np.array([[1.0, 0.0, 0.0, 0.0]]))


def beside(plane, degrees, share, seed):
    """The plane turned about a random axis in it, and shifted."""
    rng = np.random.default_rng(seed)
    aside = np.cross(plane[:3], rng.normal(size=3))
    aside *= np.tan(np.radians(degrees)) / np.linalg.norm(aside)
    moved = np.append(plane[:3] + aside, plane[3] + rng.choice([-1.0, 1.0]) * share)
    return moved / np.linalg.norm(moved[:3])


def assert_close(found, expected, angle, shift):
    signs = np.sign(np.einsum("ki,ki->k", found[:, :3], expected[:, :3]))
    assert np.abs(signs[:, np.newaxis] * found[:, :3] - expected[:, :3]).max() < angle
    assert np.abs(signs * found[:, 3] - expected[:, 3]).max() < shift


@pytest.mark.parametrize(("degrees", "share"), [(8.0, 0.04), (12.0, 0.05)])
@pytest.mark.parametrize("seed", range(3))
def test_a_drawn_plane_ends_where_the_true_one_does(cloud, true, seed, degrees, share):
    drawn = beside(true[0], degrees, share, seed)[np.newaxis]
    assert np.degrees(plane_angles(drawn, true[0])[0]) == pytest.approx(degrees)
    from_truth = refine_drawn(cloud, true)
    assert_close(refine_drawn(cloud, drawn), from_truth, 1e-3, 1e-3)
    assert_close(from_truth, true, np.radians(0.5), 0.003)


def test_nearly_right_planes_are_put_right(cloud, true):
    near = np.stack([beside(true[0], 1.5, 0.005, seed) for seed in range(4)])
    assert_close(refine_nearby(cloud, near), np.repeat(true, 4, axis=0), np.radians(0.5), 0.003)


@pytest.mark.parametrize("name", STEPS)
def test_planes_come_back_in_their_order(cloud, true, name):
    some = np.stack([beside(true[0], angle, 0.0, 1) for angle in (60.0, 1.0, 80.0)])
    together = STEPS[name](cloud, some)
    assert together.shape == (3, 4)
    for start, plane in zip(some, together, strict=True):
        assert np.array_equal(STEPS[name](cloud, start[np.newaxis])[0], plane)
    assert_close(together[1:2], true, np.radians(0.5), 0.003)


def test_beside_a_plane_are_four_tilted_and_two_shifted_ones():
    plane = np.array([0.48, -0.6, 0.64, 0.1])
    found = _beside(plane)
    assert np.allclose(np.linalg.norm(found[:, :3], axis=1), 1.0)
    assert np.allclose(plane_angles(found, plane), [TILT] * 4 + [0.0] * 2)
    assert np.allclose(found[:, 3] - plane[3], [0.0] * 4 + [-SHIFT, SHIFT])
    tilts = found[:4, :3] - np.cos(TILT) * plane[:3]
    assert np.allclose(tilts.sum(axis=0), 0.0)
    assert np.linalg.matrix_rank(tilts, tol=1e-9) == 2


@pytest.mark.parametrize("name", STEPS)
def test_no_planes_stay_none(cloud, name):
    assert STEPS[name](cloud, no_planes()).shape == (0, 4)


def test_the_best_planes_come_first_and_differ(cloud, some_planes):
    planes, evidence = refine_and_verify(cloud, some_planes)
    assert 1 <= len(planes) <= KEPT
    assert (np.diff(merit(evidence)) <= 0.0).all()
    assert len(evidence.support) == len(planes)
    assert np.allclose(np.linalg.norm(planes[:, :3], axis=1), 1.0)
    for row, plane in enumerate(planes):
        others = np.delete(planes, row, axis=0)
        signs = np.sign(others[:, :3] @ plane[:3])
        alike = plane_angles(others, plane) < SAME[0]
        alike &= np.abs(signs * others[:, 3] - plane[3]) < SAME[1]
        assert not alike.any()


def test_the_true_plane_wins_from_afar(cloud, true):
    starts = np.stack([beside(true[0], 6.0, 0.03, seed) for seed in range(3)])
    planes, _ = refine_and_verify(cloud, np.vstack([np.eye(4)[1:3], starts]))
    assert_close(planes[:1], true, np.radians(0.5), 0.003)


def test_no_planes_are_verified_as_none(cloud):
    planes, evidence = refine_and_verify(cloud, no_planes())
    assert planes.shape == (0, 4)
    assert evidence.support.shape == evidence.residual.shape == (0,)
