import numpy as np
import pytest
from scipy.spatial.distance import cdist

from meshlab_symrecon.clustering.neighbour_graph import Neighbours, neighbour_graph


@pytest.mark.parametrize("dimensions", [1, 3, 12])
def test_neighbours_are_the_nearest_of_all(dimensions):
    rows = np.random.default_rng(dimensions).normal(size=(80, dimensions))
    similarities, targets = neighbour_graph(rows, 7)
    expected = cdist(rows, rows, "sqeuclidean")
    order = np.argsort(expected, axis=1)[:, :8]
    assert np.array_equal(targets, order)
    assert np.allclose(-similarities, np.take_along_axis(expected, order, axis=1))


@pytest.mark.parametrize("neighbours", [1, 6, 79, 500])
def test_each_row_starts_with_itself_even_among_duplicates(neighbours):
    rows = np.repeat(np.random.default_rng(5).normal(size=(4, 3)), 20, axis=0)
    similarities, targets = neighbour_graph(rows, neighbours)
    width = min(neighbours, 79) + 1
    assert similarities.shape == targets.shape == (80, width)
    assert np.array_equal(targets[:, 0], np.arange(80))
    assert (similarities[:, 0] == 0).all()
    assert (np.diff(similarities, axis=1) <= 0).all()
    assert all(len(set(row)) == width for row in targets)


def test_a_lone_row_has_itself():
    similarities, targets = neighbour_graph(np.ones((1, 3)), 5)
    assert np.array_equal(similarities, [[0.0]])
    assert np.array_equal(targets, [[0]])


def test_some_rows_get_what_all_would():
    rows = np.random.default_rng(6).random((50, 4))
    members = np.array([7, 3, 30], dtype=np.int32)
    everyone = np.arange(50, dtype=np.int32)
    some, every = Neighbours(rows).nearest(members, 9), Neighbours(rows).nearest(everyone, 9)
    for one, other in zip(some, every, strict=True):
        assert np.array_equal(one, other[members])
