import numpy as np
import pytest
from scipy.spatial import cKDTree
from symmetry.bodies import ellipsoid

from meshlab_symrecon.geometry.planes import plane_angles
from meshlab_symrecon.symmetry.breaks import (
    FEWEST_RIM,
    NOT_BROKEN,
    RAGGED,
    broken_off,
    on_plane,
    rim_plane,
    rim_reach,
)
from meshlab_symrecon.symmetry.preparation import prepare

SPACING = 0.01


def half_ball():
    """A ball of diameter 1 without what lies below a plane, and which points are its rim."""
    cut = np.array([0.0, 0.6, 0.8, 0.1])
    points = ellipsoid(6_000, [0.5, 0.5, 0.5])
    heights = points @ cut[:3] + cut[3]
    points, heights = points[heights > 0.0], heights[heights > 0.0]
    return points, heights < SPACING, cut


def assert_plane(found, expected, angle, shift):
    assert plane_angles(found[np.newaxis], expected)[0] < angle
    assert found[:3] @ expected[:3] > 0.0
    assert abs(found[3] - expected[3]) < shift


def test_rims_on_one_plane_are_found_to_the_last_digit():
    cut = np.array([0.48, -0.6, 0.64, 0.2])
    turn = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    first, second = np.linalg.svd(cut[np.newaxis, :3])[2][1:]
    ring = 0.4 * (np.cos(turn)[:, np.newaxis] * first + np.sin(turn)[:, np.newaxis] * second)
    ring -= cut[3] * cut[:3]
    rim = np.arange(120) < 60
    for side in (1.0, -1.0):
        points = np.vstack([ring, ring + 0.3 * side * cut[:3]])
        assert np.abs(rim_plane(points, rim, SPACING) - side * cut).max() < 1e-12


def test_the_normal_of_a_cut_faces_the_cloud():
    points, rim, cut = half_ball()
    assert_plane(rim_plane(points, rim, SPACING), cut, np.radians(1.0), SPACING)


def test_rims_of_other_holes_do_not_move_the_plane():
    points, rim, cut = half_ball()
    alone = rim_plane(points, rim, SPACING)
    away = points @ cut[:3] + cut[3] > 0.15
    other = np.zeros_like(rim)
    other[np.flatnonzero(away)[: int(0.8 * rim.sum())]] = True
    assert np.abs(rim_plane(points, rim | other, SPACING) - alone).max() < 1e-3


def test_few_rim_points_or_a_straight_rim_have_no_plane():
    points, rim, _ = half_ball()
    few = np.zeros_like(rim)
    few[np.flatnonzero(rim)[: FEWEST_RIM - 1]] = True
    assert rim_plane(points, few, SPACING) is None
    assert rim_plane(points, np.zeros_like(rim), SPACING) is None
    line = np.outer(np.linspace(0, 1, 50), [1.0, 2.0, 2.0])
    assert rim_plane(line, np.ones(50, dtype=bool), SPACING) is None
    assert rim_plane(np.ones((50, 3)), np.ones(50, dtype=bool), SPACING) is None


def test_rim_points_are_on_a_plane_up_to_the_reach():
    reach = rim_reach(SPACING)
    points = np.outer([-1.01, -0.99, 0.0, 0.99, 1.01], [0.0, 0.0, reach])
    near = on_plane(points + 0.3, np.array([0.0, 0.0, 1.0, -0.3]), SPACING)
    assert list(near) == [False, True, True, True, False]
    assert rim_reach(1e-9) > 1e-3  # a dense cloud's rims are not flat to a spacing


def test_a_cloud_that_ends_at_a_plane_is_broken_off_where_its_break_begins():
    points, rim, cut = half_ball()
    plane = rim_plane(points, rim, SPACING)
    found = broken_off(points, rim, plane, SPACING)
    assert np.array_equal(found[:3], plane[:3])
    assert found[3] == pytest.approx(plane[3] - RAGGED * SPACING)  # towards the cloud
    assert_plane(found, cut, np.radians(1.0), 3.0 * SPACING)


def test_a_cloud_with_something_beyond_or_with_other_rims_is_not_broken_off():
    points, rim, cut = half_ball()
    plane = rim_plane(points, rim, SPACING)
    below = points[: len(points) // 50] - 1.5 * cut[:3]
    more = np.vstack([points, below])
    assert (
        broken_off(more, np.append(rim, np.zeros(len(below), bool)), plane, SPACING) is NOT_BROKEN
    )
    elsewhere = rim | (points @ cut[:3] + cut[3] > 0.3)
    assert broken_off(points, elsewhere, plane, SPACING) is NOT_BROKEN
    assert broken_off(points, rim, None, SPACING) is NOT_BROKEN


def test_everything_lies_above_the_plane_of_a_cloud_that_is_not_broken():
    places = np.random.default_rng(0).normal(0, 1e6, (100, 3))
    assert (places @ NOT_BROKEN[:3] + NOT_BROKEN[3] > 0.0).all()


def test_a_prepared_half_is_known_to_end_and_a_whole_or_a_pitted_one_is_not():
    points = ellipsoid(7_000, [1.0, 0.7, 0.5])
    cut = np.array([0.6, 0.0, 0.8, 0.05])
    half = prepare(points[points @ cut[:3] + cut[3] > 0.0], None, 10)
    assert_plane(half.rim_plane, half.from_input(cut[np.newaxis])[0], np.radians(1.0), 0.01)
    heights = half.points @ half.broken_off[:3] + half.broken_off[3]
    assert heights.min() > -(RAGGED + 2.0) * half.spacing  # the break itself, but nothing more
    assert (heights > 0.0).mean() > 0.9
    holes = half.border & ~on_plane(half.points, half.rim_plane, half.spacing)
    assert holes.sum() < 0.1 * half.border.sum()  # the rim of the break is not a hole's
    gaps = cKDTree(half.points[holes]).query(half.points)[0] if holes.any() else np.inf
    assert np.array_equal(half.border_distance, np.broadcast_to(gaps, len(half.points)))
    assert np.array_equal(prepare(points, None, 10).broken_off, NOT_BROKEN)
    middles = np.array([[1.0, 0.0, 0.0], [0.0, 0.7, 0.0], [-0.5, -0.4, 0.3]])
    gaps = np.linalg.norm(points[:, np.newaxis] - middles, axis=2).min(axis=1)
    pitted = prepare(points[gaps > 0.25], None, 10)
    assert pitted.border.any()
    assert np.array_equal(pitted.broken_off, NOT_BROKEN)
    assert np.isfinite(pitted.border_distance).all()
