import numpy as np
import pytest

from meshlab_symrecon.clustering.messages import (
    dense_availabilities,
    dense_responsibilities,
    propagate_dense,
    propagate_sparse,
    sparse_availabilities,
    sparse_responsibilities,
)
from meshlab_symrecon.clustering.neighbour_graph import dense_similarities, neighbour_graph


def naive_responsibilities(s, a):
    n = len(s)
    return np.array(
        [
            [s[i, k] - max(a[i, j] + s[i, j] for j in range(n) if j != k) for k in range(n)]
            for i in range(n)
        ]
    )


def naive_availabilities(r):
    n = len(r)
    a = np.zeros((n, n))
    for i in range(n):
        for k in range(n):
            received = sum(max(0.0, r[j, k]) for j in range(n) if j not in (i, k))
            a[i, k] = received if i == k else min(0.0, r[k, k] + received)
    return a


@pytest.fixture
def messages():
    rng = np.random.default_rng(0)
    return rng.normal(size=(9, 9)), rng.normal(size=(9, 9))


def test_dense_messages_follow_the_formulas(messages):
    s, a = messages
    assert np.allclose(dense_responsibilities(s, a), naive_responsibilities(s, a), atol=1e-14)
    assert np.allclose(dense_availabilities(s), naive_availabilities(s), atol=1e-14)


def test_sparse_messages_are_the_dense_ones_on_a_complete_graph(messages):
    s, a = messages
    rng = np.random.default_rng(1)
    targets = np.array([[i, *rng.permutation([j for j in range(9) if j != i])] for i in range(9)])
    rows = np.arange(9)[:, np.newaxis]
    expected = naive_responsibilities(s, a)[rows, targets]
    assert np.allclose(sparse_responsibilities(s[rows, targets], a[rows, targets]), expected)
    expected = naive_availabilities(s)[rows, targets]
    assert np.allclose(sparse_availabilities(s[rows, targets], targets), expected)


def test_sparse_sums_run_over_existing_edges_only():
    """A missing edge is the same as a dense similarity of minus infinity."""
    rng = np.random.default_rng(2)
    s = rng.normal(size=(6, 6))
    targets = np.array([[i, (i + 1) % 6, (i + 2) % 6] for i in range(6)])
    rows = np.arange(6)[:, np.newaxis]
    dense = np.full((6, 6), -np.inf)
    dense[rows, targets] = s[rows, targets]
    r = dense_responsibilities(dense, np.zeros((6, 6)))
    sparse = sparse_responsibilities(dense[rows, targets], np.zeros((6, 3)))
    assert np.allclose(sparse, r[rows, targets])
    a = dense_availabilities(r)[rows, targets]
    assert np.allclose(sparse_availabilities(sparse, targets), a)


@pytest.mark.parametrize("seed", range(5))
def test_sparse_propagation_is_dense_propagation_on_a_complete_graph(seed):
    rows = np.random.default_rng(seed).normal(size=(80, 3))
    dense = dense_similarities(rows)
    np.fill_diagonal(dense, np.median(dense))
    sparse, targets = neighbour_graph(rows, len(rows))
    sparse[:, 0] = dense[0, 0]
    one = propagate_dense(dense, 0.7, 300, 15)
    other = propagate_sparse(sparse, targets, 0.7, 300, 15)
    assert one.converged
    assert other.converged
    assert one.iterations == other.iterations
    assert np.array_equal(one.exemplars, other.exemplars)


def test_inputs_are_not_changed():
    rows = np.random.default_rng(3).normal(size=(30, 2))
    similarities, targets = neighbour_graph(rows, 8)
    before = similarities.copy(), targets.copy()
    propagate_sparse(similarities, targets, 0.7, 20, 5)
    assert np.array_equal(similarities, before[0])
    assert np.array_equal(targets, before[1])


@pytest.mark.parametrize("iterations", [1, 2, 3])
def test_stopping_early_is_reported_and_still_gives_exemplars(iterations):
    dense = dense_similarities(np.random.default_rng(4).normal(size=(60, 3)))
    np.fill_diagonal(dense, np.median(dense))
    found = propagate_dense(dense, 0.9, iterations, 15)
    assert not found.converged
    assert found.iterations == iterations
    assert len(found.exemplars) >= 1


def test_each_row_of_a_graph_starts_with_itself_even_among_duplicates():
    rows = np.repeat(np.random.default_rng(5).normal(size=(4, 3)), 20, axis=0)
    similarities, targets = neighbour_graph(rows, 6)
    assert np.array_equal(targets[:, 0], np.arange(80))
    assert (similarities[:, 0] == 0).all()
    assert all(len(set(row)) == 7 for row in targets)
