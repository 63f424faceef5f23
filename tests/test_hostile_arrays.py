"""Input that nobody in his right mind would give: refused in one sentence, or answered rightly."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import shapes

from meshlab_symrecon import _native
from meshlab_symrecon.arrays import LARGEST_NORMAL, as_normals
from meshlab_symrecon.clustering.affinity_propagation import AffinityPropagation
from meshlab_symrecon.errors import GeometryError
from meshlab_symrecon.geometry.local_planes import local_planes
from meshlab_symrecon.geometry.triangulation import delaunay
from meshlab_symrecon.powercrust import Recipe, reconstruct
from meshlab_symrecon.powercrust.minimum_cut import _ties
from meshlab_symrecon.symmetry import detect_reflection_planes

FUZZ = Path(__file__).parents[1] / "benchmarks" / "fuzz_kernel.py"


def test_a_few_hundred_hostile_calls_do_no_harm():
    """In a child process, since a defect may be a crash; `make fuzz` makes many more."""
    command = [sys.executable, str(FUZZ), "--seeds", "300", "--first", "700000"]
    found = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)
    assert found.returncode == 0, found.stdout + found.stderr
    assert "300 calls, 0 defects" in found.stdout


# The bindings: every array of indices is checked before it is used.

BALL = delaunay(shapes.fibonacci_sphere(30))
TRIANGLE = np.array([[0, 1, 2]], dtype=np.int32)
NUMBERS = np.arange(3, dtype=np.int32)


def network(ends=(1, 0), capacities=(3, 3)):
    offsets = np.array([0, 1, 2], dtype=np.int64)
    return offsets, np.array(ends, dtype=np.int32), np.array(capacities, dtype=np.uint16)


@pytest.mark.parametrize(
    "wrong", [network(ends=(1, 1)), network(ends=(0, 1)), network(capacities=(3, 4))]
)
def test_a_cut_refuses_edges_that_are_not_there_from_both_ends(wrong):
    with pytest.raises(ValueError, match="from both ends"):
        _native.MinimumCut(*wrong)


def test_a_cut_refuses_ties_beyond_what_sums_hold():
    cut = _native.MinimumCut(*network())
    limits = np.iinfo(np.int32)
    with pytest.raises(ValueError, match="ties must be at most"):
        cut.inner_side(np.array([limits.min, 0], dtype=np.int32))
    assert cut.inner_side(np.array([limits.max, 0], dtype=np.int32)).tolist() == [0, 0]
    assert cut.inner_side(np.array([-limits.max, 0], dtype=np.int32)).tolist() == [1, 1]
    with pytest.raises(ValueError, match="one tie a node"):
        cut.inner_side(np.zeros(3, dtype=np.int32))


def test_a_cut_at_work_is_not_asked_again():
    count = 5000  # nodes in a row: enough steps for a report
    offsets = np.concatenate([[0], np.cumsum([1] + [2] * (count - 2) + [1])]).astype(np.int64)
    rows = [[node - 1, node + 1] for node in range(count)]
    ends = np.array([end for row in rows for end in row if 0 <= end < count], dtype=np.int32)
    cut = _native.MinimumCut(offsets, ends, np.full(len(ends), 9, dtype=np.uint16))
    ties = np.zeros(count, dtype=np.int32)
    ties[0], ties[-1] = 5, -5
    with pytest.raises(ValueError, match="at work"):
        cut.inner_side(ties, lambda _: cut.inner_side(ties))
    assert cut.inner_side(ties).any()


@pytest.mark.parametrize("index", [-1, 3, 2**31 - 1])
def test_indices_out_of_range_are_refused(index):
    points, spacing = np.eye(3), np.ones(3)
    beyond = np.array([[0, 1, index]], dtype=np.int32)
    for refused in (
        lambda: _native.surface_topology(beyond, 3),
        lambda: _native.far_faces(points, beyond, NUMBERS, points, spacing, 1.0),
        lambda: _native.far_faces(points, TRIANGLE, beyond[0], points, spacing, 1.0),
        lambda: _native.contract_edges(points, beyond, NUMBERS, points, spacing, 0.1, 0.0),
        lambda: _native.nearest_kept(points, spacing, beyond[0], 1.0),
        lambda: _native.closest_faces(points, beyond, points[:1], points, points, 0.0, False, 1.0),
        lambda: _native.flatness_of_pairs(points, beyond[:, 1:], points, NUMBERS[:1]),
    ):
        with pytest.raises(ValueError, match="unknown"):
            refused()


def test_lengths_that_would_never_let_a_search_end_are_refused():
    offsets, ends, _ = network()
    none, seeds = np.zeros(0, dtype=np.int32), np.ones(2, dtype=np.uint8)
    for length in (-1.0, np.nan):
        lengths = np.full(2, length, dtype=np.float32)
        with pytest.raises(ValueError, match="lengths cannot be negative"):
            _native.evidence_paths(offsets, ends, lengths, none, none, np.zeros(0), seeds)


def test_two_bodies_that_touch_at_a_vertex_are_refused():
    body = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]], dtype=np.int32)
    both = np.concatenate([body, np.where(body == 0, 0, body + 3)]).astype(np.int32)
    points = np.random.default_rng(0).random((7, 3))
    nearest = np.zeros(7, dtype=np.int32)
    with pytest.raises(ValueError, match="pinched"):
        _native.contract_edges(points, both, nearest, points[:1], np.ones(1), 0.1, 0.0)


def test_vertices_without_faces_are_passed_over():
    points = np.eye(3)
    bare = np.zeros((0, 3), dtype=np.int32)
    left = _native.contract_edges(points, bare, 0 * NUMBERS, points[:1], np.ones(1), 0.1, 0.0)
    assert [len(array) for array in left] == [0, 0, 0]


def test_neighbours_that_do_not_know_each_other_are_refused():
    sides = np.zeros(len(BALL.cells), dtype=np.uint8)
    wrong = BALL.neighbours.copy()
    wrong[0] = np.roll(wrong[0], 1)
    with pytest.raises(ValueError, match="share a facet"):
        _native.settle_sides(BALL.sites, BALL.cells, wrong, 0, sides, 1)
    with pytest.raises(ValueError, match="on the hull"):
        _native.settle_sides(BALL.sites, BALL.cells, BALL.neighbours, 30, sides, 1)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_places_that_are_no_places_are_refused(bad):
    points = np.eye(3)
    points[1, 1] = bad
    for refused in (
        lambda: _native.curve_order(points),
        lambda: _native.regular_triangulation(points, np.zeros(3)),
        lambda: _native.relief(points, np.eye(3), 1.0),
        lambda: _native.NearestField(points, np.zeros((1, 1, 1), np.int32), np.zeros(3), 1.0),
        lambda: _native.nearest_kept(points, np.ones(3), NUMBERS, 1.0),
    ):
        with pytest.raises(ValueError, match="finite"):
            refused()


@pytest.mark.parametrize(("damping", "most"), [(np.nan, 5), (1.0, 5), (-0.1, 5), (0.5, -1)])
def test_schedules_that_lead_nowhere_are_refused(damping, most):
    with pytest.raises(ValueError, match=r"damping|iterations"):
        _native.propagate_dense_affinity(-np.ones((3, 3)), damping, most, 2)


# The public border.


def test_normals_too_long_to_square_are_refused():
    assert len(as_normals(np.full((2, 3), LARGEST_NORMAL), 2)) == 2
    with pytest.raises(GeometryError, match="unit length"):
        as_normals(np.full((2, 3), 2 * LARGEST_NORMAL), 2)


@pytest.mark.parametrize("size", [1e200, 1e-200, 1e308])
def test_data_that_cannot_be_squared_are_refused_by_the_estimator(size):
    rows = size * np.random.default_rng(0).uniform(-1.0, 1.0, (20, 3))
    with pytest.raises(GeometryError, match="extend over"):
        AffinityPropagation().fit(rows)


def test_planes_are_fitted_where_points_coincide_but_for_rounding():
    sphere = shapes.fibonacci_sphere(100)
    doubled = np.concatenate([sphere, sphere[:10]])
    planes = local_planes(doubled)
    assert planes.normals.shape == (110, 3)
    assert np.abs((planes.normals * doubled).sum(axis=1)).min() > 0.9


def test_a_body_with_no_pair_of_poles_left_is_closed():
    crust = reconstruct(shapes.fibonacci_sphere(60), Recipe(smallest_ball=1e9))
    assert crust.topology.closed


def test_samples_nearer_than_a_square_can_tell_are_samples():
    body = shapes.fibonacci_sphere(60)
    twin = np.array([[0.0, 0.0, 0.0], [0.0, 1e-200, 0.0], [1e-200, 0.0, 0.0], [0.0, 0.0, 1e-200]])
    crust = reconstruct(np.concatenate([body, twin]), Recipe(keep_outliers=True))
    assert crust.topology.closed


def test_beliefs_beyond_whole_numbers_keep_their_sign():
    belief = np.array([1e12, -1e12, 0.5, 1e12])
    ties = _ties(belief, np.array([False, False, False, True]))
    assert np.sign(ties).tolist() == [-1, 1, -1, 1]
    assert ties[3] > np.abs(ties[:3]).max()


def test_stray_points_round_a_body_too_small_to_see_are_refused():
    scales = 10.0 ** np.random.default_rng(20802).integers(-12, 13, (200, 1))
    points = np.random.default_rng(1).normal(size=(200, 3)) * scales
    points[20:] *= 1e-30
    with pytest.raises(GeometryError, match="nearly all of 200 points in one place"):
        detect_reflection_planes(points)
