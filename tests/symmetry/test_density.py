import numpy as np
import pytest
from scipy.spatial import cKDTree
from symmetry.bodies import even_sphere

from meshlab_symrecon.symmetry.completion import mirror_complete
from meshlab_symrecon.symmetry.density import as_dense_as_around

PLANE = np.array([1.0, 0.0, 0.0, 0.0])
MIDDLE, HOLE = np.array([0.8, 0.6, 0.0]), 0.5


def spacings(points):
    return cKDTree(points).query(points, k=5)[0][:, 1:].mean(axis=1)


def grid(spacing, shift=0.0):
    """Even places in a square, along a curve: row by row, to and fro."""
    steps = np.arange(0.5 * spacing, 1.0, spacing)
    rows = [np.column_stack([np.full(len(steps), x), steps]) for x in steps]
    square = np.concatenate([row[:: (-1) ** number] for number, row in enumerate(rows)])
    return np.column_stack([square[:, 0] + shift, square[:, 1], np.zeros(len(square))])


def thinned(own, outside):
    """Choose from a square of spacing ``own`` that lies beside one of spacing ``outside``."""
    images, points = grid(own, shift=1.0), grid(outside)
    rim = cKDTree(points).query(images)[1]
    given = np.full(len(images), own), points, np.full(len(points), outside), rim
    return images, as_dense_as_around(images, *given)


@pytest.mark.parametrize("outside", [0.02, 0.01, 0.025])
def test_of_a_fill_as_dense_as_its_surroundings_or_sparser_all_is_kept(outside):
    assert thinned(0.02, outside)[1].all()


@pytest.mark.parametrize("ratio", [1.5, 2.0, 3.0])
def test_a_denser_fill_is_thinned_evenly_to_the_spacing_outside(ratio):
    images, kept = thinned(0.01, 0.01 * ratio)
    assert kept.mean() == pytest.approx(ratio**-2, abs=2 / len(images))
    runs = np.diff(np.flatnonzero(kept))  # every n-th along the curve, but for rounding
    assert runs.max() <= np.ceil(ratio**2)
    assert runs.min() >= np.floor(ratio**2)


def test_an_empty_fill_stays_empty():
    none = np.zeros(0)
    kept = as_dense_as_around(np.zeros((0, 3)), none, np.ones((5, 3)), np.ones(5), none.astype(int))
    assert kept.shape == (0,)


def test_a_few_images_by_a_few_points():
    images, points = np.eye(3), np.eye(3) + 3.0
    rim = np.array([0, 1, 2])
    assert as_dense_as_around(images, np.ones(3), points, np.ones(3), rim).all()


def halves(left, right):
    """Two evenly measured halves of a sphere, with a hole in the right one, and what was there."""
    left, right = even_sphere(left), even_sphere(right)
    left, right = left[left[:, 0] < 0.0], right[right[:, 0] > 0.0]
    hole = np.linalg.norm(right - MIDDLE, axis=1) < HOLE
    return left, right[~hole], right[hole]


@pytest.mark.parametrize("count", [3_000, 7_000])
def test_a_side_measured_four_times_as_densely_fills_no_denser_than_the_other(count):
    left, right, missing = halves(4 * count, count)
    found = mirror_complete(np.vstack([left, right]), PLANE, blend=0.0)
    fill = found.points[found.mirrored]
    apart = np.linalg.norm(fill - MIDDLE, axis=1)
    usual = np.median(spacings(right))
    assert (apart < HOLE).all()
    inside = spacings(found.points)[found.mirrored][apart < HOLE - 2.0 * usual]
    assert np.median(inside) == pytest.approx(usual, rel=0.25)
    assert len(fill) == pytest.approx(len(missing), rel=0.25)
    assert cKDTree(fill).query(missing)[0].max() < 2.0 * usual  # evenly: no place is left out


def test_equally_dense_sides_leave_nothing_out():
    left, right, _ = halves(8_000, 8_000)
    found = mirror_complete(np.vstack([left, right]), PLANE, blend=0.0)
    inner = np.linalg.norm(left - MIDDLE * [-1.0, 1.0, 1.0], axis=1) < HOLE - 0.05
    assert np.isin(np.flatnonzero(inner), found.source[found.mirrored]).all()
