"""The compiled messages beside the formulas written out, and what sparse graphs may leave out."""

from itertools import combinations

import numpy as np
import pytest
from scipy.spatial.distance import cdist

from meshlab_symrecon import _native
from meshlab_symrecon.clustering import messages
from meshlab_symrecon.clustering.messages import (
    Schedule,
    choose_among_equals,
    propagate_dense,
    propagate_neighbours,
    propagate_sparse,
)
from meshlab_symrecon.clustering.neighbour_graph import Neighbours, neighbour_graph

USUAL = Schedule(damping=0.7, max_iter=1000, convergence_iter=15)


def responsibilities(s, a):
    sums = a + s
    others = np.where(np.eye(len(s), dtype=bool), -np.inf, sums[:, np.newaxis, :])
    return s - others.max(axis=2)


def availabilities(r):
    received = np.maximum(r, 0.0)
    np.fill_diagonal(received, 0.0)
    totals = np.add.accumulate(received)[-1]  # in this order
    a = np.minimum(0.0, np.diagonal(r) + totals - received)
    np.fill_diagonal(a, totals)
    return a


def written_out(s, schedule):
    """Return what the kernel should: exemplars, converged, iterations, damping."""
    r, a = np.zeros_like(s), np.zeros_like(s)
    damping, calm = schedule.damping, 0
    chosen = np.zeros(len(s), dtype=bool)
    turns = np.zeros(len(s))
    for iteration in range(1, schedule.max_iter + 1):
        update = responsibilities(s, a)
        support = np.diagonal(update)
        r = damping * r + (1 - damping) * update
        update = availabilities(r)
        support = support + np.diagonal(update)
        a = damping * a + (1 - damping) * update
        before, chosen = chosen, np.diagonal(r + a) > 0
        turns += chosen != before
        if (turns >= 20).any():
            damping, turns = (1 + damping) / 2, np.zeros(len(s))
        calm = calm + 1 if np.array_equal(chosen, before) else 1
        if not np.array_equal(chosen, support > 0):
            calm = 0
        if calm >= schedule.convergence_iter and chosen.any():
            return np.flatnonzero(chosen), True, iteration, damping
    if not chosen.any():
        chosen[np.argmax(np.diagonal(r + a))] = True
    return np.flatnonzero(chosen), False, schedule.max_iter, damping


def similarities(rows, preference):
    found = -cdist(rows, rows, "sqeuclidean")
    np.fill_diagonal(found, preference)
    return found


def tight_clusters(size, spread):
    centres = 10 * np.eye(4)[:3, np.newaxis]
    noise = np.random.default_rng(0).normal(size=(3, size, 4))
    return (centres + spread * noise).reshape(-1, 4)


def mixture(count, dimensions, seed):
    rng = np.random.default_rng(seed)
    centres = 3 * rng.normal(size=(8, dimensions))
    return centres[rng.integers(8, size=count)] + 0.5 * rng.normal(size=(count, dimensions))


def same(one, other):
    return (
        np.array_equal(one.exemplars, other.exemplars)
        and (one.converged, one.iterations, one.damping)
        == (other.converged, other.iterations, other.damping)
    )  # fmt: skip


def test_the_formulas_are_those_of_the_paper_element_by_element():
    rng = np.random.default_rng(0)
    s, a = rng.normal(size=(7, 7)), rng.normal(size=(7, 7))
    r, found = responsibilities(s, a), availabilities(s)
    for i in range(7):
        for k in range(7):
            rivals = [a[i, j] + s[i, j] for j in range(7) if j != k]
            assert r[i, k] == s[i, k] - max(rivals)
            received = sum(max(0.0, s[j, k]) for j in range(7) if j not in (i, k))
            expected = received if i == k else min(0.0, s[k, k] + received)
            assert found[i, k] == pytest.approx(expected, abs=1e-14)


@pytest.mark.parametrize("damping", [0.5, 0.7, 0.9])
@pytest.mark.parametrize("seed", range(6))
def test_the_kernel_follows_the_formulas(seed, damping):
    rng = np.random.default_rng(seed)
    s = rng.normal(size=(60, 60)) - 3.0  # not even symmetric
    schedule = Schedule(damping, max_iter=200, convergence_iter=10)
    found = propagate_dense(s, schedule)
    expected = written_out(s, schedule)
    assert np.array_equal(found.exemplars, expected[0])
    assert (found.converged, found.iterations, found.damping) == expected[1:]


@pytest.mark.parametrize("spread", [0.05, 1e-3])
def test_the_kernel_follows_the_formulas_through_oscillations(spread):
    s = similarities(tight_clusters(20, spread), -200.0 - 1e-6 * np.arange(60.0))
    schedule = Schedule(0.5, 1000, 15)
    found = propagate_dense(s, schedule)
    expected = written_out(s, schedule)
    assert np.array_equal(found.exemplars, expected[0])
    assert (found.converged, found.iterations, found.damping) == expected[1:]
    assert found.damping > 0.5


@pytest.mark.parametrize("iterations", range(1, 30))
def test_after_every_iteration_there_are_valid_exemplars(iterations):
    s = similarities(np.random.default_rng(4).normal(size=(60, 3)), -2.0)
    schedule = Schedule(0.9, iterations, 15)
    found = propagate_dense(s, schedule)
    assert not found.converged
    assert np.array_equal(found.exemplars, written_out(s, schedule)[0])
    assert len(found.exemplars) >= 1


@pytest.mark.parametrize("damping", [0.5, 0.7, 0.9])
@pytest.mark.parametrize("preference", [-1.0, -20.0, -200.0])
@pytest.mark.parametrize("spread", [0.05, 1e-6])
def test_tight_clusters_neither_oscillate_nor_count_as_calm_too_early(spread, preference, damping):
    """Scikit-learn never converges here below .9; messages in unison seem calm for a while."""
    rows = tight_clusters(100, spread)
    preferences = preference * (1 + 1e-12 * np.random.default_rng(1).random(300))
    found = propagate_dense(similarities(rows, preferences), Schedule(damping, 1000, 15))
    assert found.converged
    assert np.array_equal(found.exemplars // 100, [0, 1, 2])


def test_damping_rises_only_with_oscillation():
    calm = propagate_dense(similarities(mixture(200, 2, 0), -1.0), USUAL)
    wild = propagate_dense(similarities(tight_clusters(100, 1e-3), -20.0), Schedule(0.5, 1000, 15))
    assert calm.damping == 0.7
    assert wild.damping in {0.75, 0.875, 0.9375}


@pytest.mark.parametrize("seed", range(6))
def test_a_missing_edge_is_a_similarity_of_minus_infinity(seed):
    rng = np.random.default_rng(seed)
    targets = np.array([[i, *rng.permutation(np.delete(np.arange(50), i))[:12]] for i in range(50)])
    sparse = np.concatenate([np.full((50, 1), -1.0), -rng.random((50, 12))], axis=1)
    sparse[:, 9:][rng.random((50, 4)) < 0.5] = -np.inf
    dense = np.full((50, 50), -np.inf)
    dense[np.arange(50)[:, np.newaxis], targets] = sparse
    one = propagate_sparse(sparse, targets, 0.7, 300, 15)
    other = propagate_dense(dense, Schedule(0.7, 300, 15))
    assert same(one, other)
    assert one.edges == np.isfinite(sparse).sum()


def test_points_without_edges_are_exemplars():
    sparse = np.full((5, 3), -np.inf)
    sparse[:, 0] = -1.0
    targets = np.array([[i, (i + 1) % 5, (i + 2) % 5] for i in range(5)])
    found = propagate_sparse(sparse, targets, 0.7, 100, 15)
    assert found.converged
    assert np.array_equal(found.exemplars, np.arange(5))


KINDS = {
    "uniform 2": lambda: np.random.default_rng(1).random((500, 2)),
    "uniform 9": lambda: np.random.default_rng(2).random((500, 9)),
    "mixture 3": lambda: mixture(500, 3, 3),
    "mixture 12": lambda: mixture(500, 12, 4),
    "tight": lambda: tight_clusters(100, 1e-3),
    "duplicates": lambda: np.repeat(np.random.default_rng(5).random((60, 2)), 8, axis=0),
    "lattice": lambda: np.stack(np.meshgrid(*2 * [np.arange(22.0)]), axis=-1).reshape(-1, 2),
}


@pytest.mark.parametrize("share", [0.02, 0.5, 0.95])
@pytest.mark.parametrize("kind", KINDS)
def test_a_graph_that_may_grow_gives_the_exemplars_of_all_pairs(kind, share):
    rows = KINDS[kind]()
    noise = 1 + 1e-5 * np.random.default_rng(6).random(len(rows))
    every = similarities(rows, 0.0)
    preferences = min(-1e-3, np.quantile(every, share)) * noise
    np.fill_diagonal(every, preferences)
    dense = propagate_dense(every, USUAL)
    sparse = propagate_neighbours(Neighbours(rows), preferences, 16, USUAL)
    assert dense.converged
    assert sparse.exact
    assert same(sparse, dense)
    assert sparse.edges < 0.9 * dense.edges


@pytest.mark.parametrize("count", [1, 2, 5])
def test_however_few_neighbours_it_begins_with(count):
    rows = np.random.default_rng(7).random((150, 2))
    dense = propagate_dense(similarities(rows, -0.01), USUAL)
    sparse = propagate_neighbours(Neighbours(rows), np.full(150, -0.01), count, USUAL)
    assert sparse.exact
    assert same(sparse, dense)


def test_a_graph_without_room_to_grow_says_so():
    rows = np.random.default_rng(8).random((600, 2))
    preferences = np.full(600, -30.0)  # one exemplar for all, and far from most
    found = propagate_neighbours(Neighbours(rows), preferences, 2, USUAL)
    assert not found.exact
    assert found.edges <= messages.GROWTH * 3 * 600
    assert 1 <= len(found.exemplars) < 300


def test_exemplars_follow_scaling_and_permutation():
    rows = mixture(300, 3, 9)
    preferences = np.full(300, -2.0)
    found = propagate_neighbours(Neighbours(rows), preferences, 16, USUAL)
    scaled = propagate_neighbours(Neighbours(1024 * rows), 2.0**20 * preferences, 16, USUAL)
    assert same(scaled, found)
    order = np.random.default_rng(10).permutation(300)
    permuted = propagate_neighbours(Neighbours(rows[order]), preferences, 16, USUAL)
    assert np.array_equal(np.sort(order[permuted.exemplars]), found.exemplars)


def test_inputs_are_not_changed():
    rows = np.random.default_rng(3).normal(size=(30, 2))
    sparse, targets = neighbour_graph(rows, 8)
    dense = similarities(rows, -1.0)
    preferences = np.full(30, -1.0)
    given = sparse, targets, dense, rows, preferences
    before = [values.copy() for values in given]
    propagate_sparse(sparse, targets, 0.7, 20, 5)
    propagate_dense(dense, USUAL)
    propagate_neighbours(Neighbours(rows), preferences, 3, USUAL)
    for values, kept in zip(given, before, strict=True):
        assert np.array_equal(values, kept)


@pytest.mark.parametrize("seed", range(20))
def test_the_choice_among_equals_has_the_largest_net_similarity(seed):
    rng = np.random.default_rng(seed)
    similarity, preferences = -rng.random(), -rng.random(6).round(1)

    def net(chosen):
        return preferences[list(chosen)].sum() + similarity * (6 - len(chosen))

    subsets = [chosen for size in range(1, 7) for chosen in combinations(range(6), size)]
    best = max(net(chosen) for chosen in subsets)
    assert net(choose_among_equals(preferences, similarity)) == pytest.approx(best)


OWN = np.array([[0, 1], [1, 0]], dtype=np.int32)


@pytest.mark.parametrize(
    ("values", "targets", "error", "words"),
    [
        (np.zeros((2, 3)), OWN, ValueError, "one similarity an edge"),
        (np.zeros((2, 2)), OWN[::-1].copy(), ValueError, "start with the edge to itself"),
        (np.zeros((2, 0)), OWN[:, :0].copy(), ValueError, "each row needs an edge"),
        (np.zeros((2, 2)), OWN + 1, ValueError, "unknown point"),
    ],
)
def test_the_kernel_refuses_tables_that_are_none(values, targets, error, words):
    with pytest.raises(error, match=words):
        _native.propagate_sparse_affinity(values, targets, 0.7, 10, 5)


def test_the_kernel_refuses_a_matrix_that_is_not_square():
    with pytest.raises(ValueError, match="square"):
        _native.propagate_dense_affinity(np.zeros((2, 3)), 0.7, 10, 5)


def ask(more):
    rows = np.random.default_rng(11).random((20, 2))
    table, targets = Neighbours(rows).nearest(np.arange(20, dtype=np.int32), 2)
    table[:, 0] = -1.0
    return _native.propagate_sparse_affinity(table, targets, 0.7, 100, 5, more)


def test_errors_of_the_source_of_edges_pass_through():
    def more(points, width):
        raise KeyError("no more")

    with pytest.raises(KeyError, match="no more"):
        ask(more)


def test_the_kernel_refuses_the_wrong_number_of_rows():
    with pytest.raises(ValueError, match="one row a point"):
        ask(lambda points, width: (np.zeros((0, width)), np.zeros((0, width), dtype=np.int32)))
