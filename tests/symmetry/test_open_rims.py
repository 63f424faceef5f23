"""Holes whose rims are circles of known place and width; closed bodies have none."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from symmetry.bodies import ellipsoid, jug, vase

from meshlab_symrecon.symmetry.completion import mirror_complete
from meshlab_symrecon.symmetry.open_rims import open_rims

PLANE = np.array([1.0, 0.0, 0.0, 0.0])
UP, ASIDE = np.array([0.0, 0.0, 1.0]), np.array([0.0, -0.8, -0.6])


def sphere(count, seed=0):
    points = np.random.default_rng(seed).normal(size=(count, 3))
    return points / np.linalg.norm(points, axis=1, keepdims=True)


def without_cap(points, middle, angle):
    return points[points @ middle < np.cos(angle)]


def assert_rim(rim, middle, angle, accuracy=0.1):
    np.testing.assert_allclose(rim[:3], np.cos(angle) * middle, atol=accuracy)
    assert rim[3] == pytest.approx(2.0 * np.sin(angle), abs=1.5 * accuracy)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("count", [6_000, 30_000])
@pytest.mark.parametrize("angle", [0.35, 0.7])
def test_the_rim_of_a_missing_cap_is_its_circle(seed, count, angle):
    (rim,) = open_rims(without_cap(sphere(count, seed), UP, angle))
    assert_rim(rim, UP, angle)


def test_the_widest_comes_first():
    scan = without_cap(without_cap(sphere(8_000), UP, 0.3), ASIDE, 0.6)
    first, second = open_rims(scan)
    assert_rim(first, ASIDE, 0.6)
    assert_rim(second, UP, 0.3)


@pytest.mark.parametrize("seed", range(3))
def test_closed_bodies_have_none(shapes, seed):
    bodies = [
        sphere(5_000, seed),
        sphere(40_000, seed),
        ellipsoid(6_000, [1.0, 0.7, 0.4], seed),
        shapes.blob(7_000, seed, mirrored=True),
        shapes.blob(7_000, seed, mirrored=False),
        vase(7_000, seed),
        jug(9_000, seed),
    ]
    for body in bodies:
        assert open_rims(body).shape == (0, 4)


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_rims_follow_motion_scale_and_order(scale):
    rng = np.random.default_rng(1)
    scan = without_cap(sphere(6_000), UP, 0.6)
    at_rest = open_rims(scan)
    matrix, place = Rotation.random(random_state=2).as_matrix(), np.array([5.0, -40.0, 9.0])
    moved = open_rims(rng.permutation(scale * (scan @ matrix.T + place)))
    np.testing.assert_allclose(moved[:, :3] / scale, at_rest[:, :3] @ matrix.T + place, atol=1e-6)
    np.testing.assert_allclose(moved[:, 3] / scale, at_rest[:, 3], atol=1e-6)


@pytest.mark.parametrize("count", [1, 2, 5, 16, 17, 60])
def test_a_handful_of_points_is_no_rim(count):
    assert open_rims(sphere(count)).shape == (0, 4)


def test_points_that_all_coincide_are_no_rim():
    assert open_rims(np.ones((100, 3))).shape == (0, 4)


def test_a_hole_on_one_side_is_closed_and_one_on_both_sides_is_told():
    one, other = np.array([0.6, 0.0, 0.8]), np.array([0.6, -0.8, 0.0])
    scan = without_cap(sphere(8_000), one, 0.5)
    assert len(open_rims(scan)) == 1
    assert mirror_complete(scan, PLANE, blend=0.0).open_rims.shape == (0, 4)
    both = without_cap(without_cap(scan, other, 0.4), other * [-1.0, 1.0, 1.0], 0.4)
    rims = mirror_complete(both, PLANE, blend=0.0).open_rims
    assert len(rims) == 2
    left, right = rims[np.argsort(rims[:, 0])]
    assert_rim(right, other, 0.4)
    assert_rim(left, other * [-1.0, 1.0, 1.0], 0.4)


def test_a_hole_across_the_plane_stays_open():
    scan = without_cap(sphere(8_000), UP, 0.5)
    (rim,) = mirror_complete(scan, PLANE, blend=0.0).open_rims
    assert_rim(rim, UP, 0.5)
