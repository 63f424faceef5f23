"""Labels of poles: each loop against brute force or an oracle, and the labels against the truth."""

import dataclasses
import itertools

import numpy as np
import pytest
import shapes
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import (
    breadth_first_order,
    connected_components,
    dijkstra,
    maximum_flow,
)

from meshlab_symrecon import _native
from meshlab_symrecon.errors import GeometryError
from meshlab_symrecon.geometry.triangulation import delaunay, regular_triangulation
from meshlab_symrecon.powercrust import minimum_cut
from meshlab_symrecon.powercrust.labelling import METHODS, label_poles
from meshlab_symrecon.powercrust.pole_graph import (
    MOST_PARTNERS,
    intersections,
    opposites,
    shown_poles,
)
from meshlab_symrecon.powercrust.poles import enclose, find_poles


def poles_of(samples):
    poles = find_poles(delaunay(enclose(samples)), len(samples))
    return poles, regular_triangulation(poles.centres, poles.radii**2)


@pytest.fixture(scope="module")
def torus():
    return poles_of(shapes.torus(4000, seed=21))


def in_torus(centres):
    return (np.hypot(centres[:, 0], centres[:, 1]) - 1) ** 2 + centres[:, 2] ** 2 < 0.4**2


def noisy_statue(seed):
    rng = np.random.default_rng(seed)
    samples = shapes.statue(1500, seed=seed)
    samples += rng.normal(scale=0.02, size=samples.shape)
    return np.vstack([samples, rng.uniform(-1.5, 1.5, (60, 3))])


def crowd():
    """A sample in the middle of others: the balls of all of them meet there."""
    return np.vstack([shapes.statue(300, seed=1), np.zeros(3)])


# ------------------------------------------------------------------------------- the pole graph


def brute_force_pairs(poles, diagram):
    shown = shown_poles(diagram)
    pairs = {
        tuple(sorted(pair))
        for cell in diagram.cells.tolist()
        for pair in itertools.combinations(cell, 2)
    }
    for sample in range(poles.sample_count):
        there = np.flatnonzero((poles.samples == sample).any(axis=1) & shown).tolist()
        there.sort(key=lambda pole: (-poles.radii[pole], *poles.centres[pole]))
        for pole in there[:MOST_PARTNERS]:
            pairs.update(tuple(sorted((pole, other))) for other in there if other != pole)
    costs = {}
    for i, j in pairs:
        square = ((poles.centres[i] - poles.centres[j]) ** 2).sum()
        r, s = poles.radii[i], poles.radii[j]
        cosine = (r * r + s * s - square) / (2 * r * s)
        if cosine > 0:
            costs[i, j] = -np.log(min(1.0, cosine))
    return costs


@pytest.mark.parametrize(
    "samples",
    [
        shapes.torus(300, seed=2),
        noisy_statue(3)[:400],
        shapes.box_lattice(3),
        crowd(),
    ],
    ids=["torus", "noisy", "lattice", "crowded"],
)
def test_the_pole_graph_holds_every_pair_that_meets(samples):
    poles, diagram = poles_of(samples)
    near = intersections(poles, diagram)
    start = np.repeat(np.arange(len(poles.centres)), np.diff(near.offsets))
    found = dict(zip(zip(start.tolist(), near.ends.tolist(), strict=True), near.cost, strict=True))
    expected = brute_force_pairs(poles, diagram)
    assert len(found) == len(near.ends)
    assert found.keys() == expected.keys() | {(j, i) for i, j in expected}
    for (i, j), cost in expected.items():
        assert found[i, j] == found[j, i]
        assert found[i, j] == pytest.approx(cost, rel=1e-4, abs=1e-6)
    for row in np.split(near.ends, near.offsets[1:-1]):
        assert (np.diff(row) > 0).all()


def test_more_balls_meet_in_a_crowd_than_may_all_be_paired():
    poles, _ = poles_of(crowd())
    assert np.bincount(poles.samples.ravel())[300] > 5 * MOST_PARTNERS


def test_flatness_is_one_straight_across_a_flat_sheet():
    grid = np.stack(np.meshgrid(np.arange(20.0), np.arange(20.0)), -1).reshape(-1, 2)
    wavy = np.column_stack([grid, 1e-3 * np.random.default_rng(0).random(400)])
    poles, diagram = poles_of(wavy)
    across = opposites(poles, diagram.representative)
    assert np.median(across.flatness) > 1 - 1e-4
    assert across.flatness.max() < 1.0
    assert (across.certainty <= across.flatness).all()
    assert (across.certainty > 0.0).all()


# ------------------------------------------------------------------------------------ the paths


def random_network(rng, nodes, edges):
    """A symmetric network in rows, with the upper ends of each row in order."""
    pairs = np.unique(np.sort(rng.integers(0, nodes, (edges, 2)), axis=1), axis=0)
    pairs = pairs[pairs[:, 0] != pairs[:, 1]]
    values = np.arange(1, len(pairs) + 1)
    both = csr_matrix((values, pairs.T), shape=(nodes, nodes))
    both = both + both.T
    both.sort_indices()
    return both.indptr.astype(np.int64), both.indices.astype(np.int32), both.data - 1, pairs


@pytest.mark.parametrize("seed", range(40))
def test_paths_are_those_of_the_signed_double_cover(seed):
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, 80))
    offsets, ends, edge, pairs = random_network(rng, count, int(rng.integers(1, 4 * count)))
    lengths = (rng.random(len(pairs)) ** 8 + 1e-9).astype(np.float32)
    first, second = rng.permutation(count)[: 2 * (count // 2)].reshape(2, -1).astype(np.int32)
    crossings = rng.exponential(size=len(first))
    crossings[rng.random(len(first)) < 0.1] = np.inf
    seeds = rng.random(count) < 0.1
    seeds[0] = True
    found = _native.evidence_paths(
        offsets, ends, lengths[edge], first, second, crossings, seeds.astype(np.uint8)
    )
    rows, columns = pairs.T
    open_ones = np.isfinite(crossings)
    one, other, cost = first[open_ones], second[open_ones], crossings[open_ones]
    cover = csr_matrix(
        (
            np.concatenate([lengths, lengths, cost, cost]).astype(float),
            (
                np.concatenate([rows, rows + count, one, one + count]),
                np.concatenate([columns, columns + count, other + count, other]),
            ),
        ),
        shape=(2 * count, 2 * count),
    )
    expected = dijkstra(cover, directed=False, indices=np.flatnonzero(seeds), min_only=True)
    np.testing.assert_allclose(np.concatenate(found), expected, rtol=1e-12)


# ------------------------------------------------------------------------------------- the cuts


def scipy_inner_side(offsets, ends, capacities, ties):
    count = len(ties)
    outside, inside = np.flatnonzero(ties > 0), np.flatnonzero(ties < 0)
    start = np.repeat(np.arange(count), np.diff(offsets))
    network = csr_matrix(
        (
            np.concatenate([capacities, ties[outside], -ties[inside]]).astype(np.int32),
            (
                np.concatenate([start, np.full(len(outside), count), inside]),
                np.concatenate([ends, outside, np.full(len(inside), count + 1)]),
            ),
        ),
        shape=(count + 2, count + 2),
    )
    network.eliminate_zeros()
    residual = network - maximum_flow(network, count, count + 1).flow
    residual.data[residual.data < 0] = 0
    residual.eliminate_zeros()
    inner = np.ones(count + 2, dtype=bool)
    inner[breadth_first_order(residual, count, return_predecessors=False)] = False
    return inner[:count]


@pytest.mark.parametrize("seed", range(200))
def test_the_cut_is_the_minimum_cut_with_most_inside(seed):
    """Small capacities make ties frequent; the second ties go on from the flow of the first."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, 70))
    offsets, ends, edge, pairs = random_network(rng, count, int(rng.integers(1, 6 * count)))
    largest = int(rng.choice([2, 9, 32767]))
    capacities = rng.integers(0, largest + 1, len(pairs)).astype(np.uint16)[edge]
    cut = _native.MinimumCut(offsets, ends, capacities)
    for _ in range(3):
        ties = rng.integers(-2 * largest, 2 * largest + 1, count).astype(np.int32)
        ties[rng.random(count) < 0.5] = 0
        ties[rng.integers(count)] = 1 << 30
        inner = cut.inner_side(ties)
        assert np.array_equal(inner, scipy_inner_side(offsets, ends, capacities, ties))


def test_a_capacity_beyond_sixteen_bits_is_refused():
    offsets, ends = np.array([0, 1, 2]), np.array([1, 0], dtype=np.int32)
    with pytest.raises(ValueError, match="32767"):
        _native.MinimumCut(offsets, ends, np.full(2, 32768, dtype=np.uint16))


def test_the_cut_of_the_recipe_is_the_one_of_scipy():
    poles, diagram = poles_of(noisy_statue(5))
    near = intersections(poles, diagram)
    across = opposites(poles, diagram.representative)
    outer = poles.outermost
    costs = minimum_cut.path_costs(near, across, outer)
    inside = costs[1] < costs[0]
    confidence = minimum_cut._confidence(*costs)
    capacities = minimum_cut._capacities(near.cost)
    for _ in range(minimum_cut.ROUNDS):
        told = minimum_cut._told_by_opposites(across, inside)
        belief = minimum_cut.OPPOSITION * told + minimum_cut.CONFIDENCE * confidence
        ties = minimum_cut._ties(belief, outer)
        inside = scipy_inner_side(near.offsets, near.ends, capacities, ties)
    assert inside.any()
    corrected = minimum_cut.corrected_by_cuts(near, across, costs, outer)
    assert np.array_equal(corrected, inside)


# ----------------------------------------------------------------------------------- the pieces


def pieces_of(cells, labels):
    pairs = np.concatenate([cells[:, pair] for pair in itertools.combinations(range(4), 2)])
    pairs = pairs[labels[pairs[:, 0]] == labels[pairs[:, 1]]]
    graph = csr_matrix((np.ones(len(pairs)), pairs.T), shape=(len(labels), len(labels)))
    return connected_components(graph, directed=False)[1]


def turned_one_by_one(cells, labels, fixed, samples, smallest):
    labels = labels.copy()
    for label in (True, False):
        piece = pieces_of(cells, labels)
        sizes = np.bincount(piece, weights=samples)
        small = [
            k
            for k in range(len(sizes))
            if sizes[k] < smallest
            and not fixed[piece == k].any()
            and labels[piece == k][0] == label
        ]
        islands = np.unique(piece[labels])
        if label and len(islands):
            largest = islands[np.argmax(sizes[islands])]
            small = [k for k in small if k != largest]
        labels[np.isin(piece, small)] = not label
    return labels


@pytest.mark.parametrize("seed", range(20))
def test_small_islands_and_bubbles_are_turned_over(seed):
    rng = np.random.default_rng(seed)
    cells = delaunay(rng.random((200, 3))).cells
    labels = rng.random(200) < rng.choice([0.15, 0.5, 0.85])
    fixed = (rng.random(200) < 0.05) & ~labels
    samples = rng.integers(0, 5, 200).astype(np.int32)
    smallest = float(rng.choice([5.0, 20.0, 1e9]))
    turned = _native.turn_small_pieces(
        cells, labels.view(np.uint8), fixed.view(np.uint8), samples, smallest
    )
    expected = turned_one_by_one(cells, labels, fixed, samples, smallest)
    assert np.array_equal(turned, expected)


# ----------------------------------------------------------------------------------- the labels


@pytest.mark.parametrize("method", METHODS)
def test_labels_of_a_torus_are_the_truth(torus, method):
    poles, diagram = torus
    labels = label_poles(poles, diagram, method=method)
    certain = poles.radii > 0.05
    assert np.array_equal(labels.inside[certain], in_torus(poles.centres)[certain])
    assert np.mean(labels.inside == in_torus(poles.centres)) > 0.99
    assert (labels.unreached, labels.flipped) == (0, 0)


@pytest.mark.parametrize("method", METHODS)
def test_labels_of_a_sphere_are_the_truth(method):
    poles, diagram = poles_of(shapes.fibonacci_sphere(3000))
    labels = label_poles(poles, diagram, method=method)
    assert np.array_equal(labels.inside, (poles.centres**2).sum(axis=1) < 1.0)


@pytest.mark.parametrize("method", METHODS)
def test_bodies_stay_although_most_of_their_poles_are_covered(method):
    """The poles of an exact sphere crowd at its centre, where all but a few have no power cell."""
    ball = shapes.fibonacci_sphere(2000)
    centres = np.array([[0.0, 0.0, 0.0], [3.3, 0.0, 0.0], [0.0, 3.1, 0.2]])
    poles, diagram = poles_of(np.vstack([ball + centre for centre in centres]))
    assert np.count_nonzero(diagram.hidden) > 0.4 * len(poles.centres)
    labels = label_poles(poles, diagram, method=method)
    squares = ((poles.centres[:, None] - centres) ** 2).sum(axis=2).min(axis=1)
    assert np.array_equal(labels.inside, squares < 1.0)
    assert labels.flipped == 0


@pytest.mark.parametrize("method", METHODS)
def test_a_covered_pole_has_the_label_of_what_covers_it(method):
    """The outer poles of a spherical hollow crowd at its centre."""
    sphere = shapes.fibonacci_sphere(3000)
    poles, diagram = poles_of(np.vstack([sphere, 1.3 * sphere]))
    labels = label_poles(poles, diagram, method=method)
    distance = np.linalg.norm(poles.centres, axis=1)
    assert diagram.hidden[distance < 0.5].any()
    assert not diagram.hidden[distance < 0.5].all()
    assert np.array_equal(labels.inside, (distance > 1.0) & (distance < 1.3))


@pytest.mark.parametrize("seed", [8, 9, 10])
def test_the_cut_bears_outliers_and_propagation_does_not(seed):
    rng = np.random.default_rng(seed)
    samples = np.vstack([shapes.torus(4000, seed=seed), rng.uniform(-1.4, 1.4, (400, 3))])
    poles, diagram = poles_of(samples)
    certain = poles.radii > 0.1
    truth = in_torus(poles.centres)[certain]
    wrong = {
        method: np.mean(label_poles(poles, diagram, method=method).inside[certain] != truth)
        for method in METHODS
    }
    assert wrong["min cut"] == 0.0
    assert wrong["propagation"] > 0.01


def test_an_unknown_method_is_refused(torus):
    with pytest.raises(GeometryError, match="'min cut' or 'propagation'; got 'guess'"):
        label_poles(*torus, method="guess")


@pytest.mark.parametrize("method", METHODS)
def test_the_numbering_of_the_poles_does_not_matter(method):
    poles, diagram = poles_of(noisy_statue(9))
    order = np.random.default_rng(0).permutation(len(poles.centres))
    number = np.argsort(order)
    shuffled = dataclasses.replace(
        poles,
        centres=poles.centres[order],
        radii=poles.radii[order],
        samples=poles.samples[order],
        pairs=number[poles.pairs],
        outermost=poles.outermost[order],
    )
    again = regular_triangulation(shuffled.centres, shuffled.radii**2)
    labels = label_poles(poles, diagram, method=method)
    others = label_poles(shuffled, again, method=method)
    assert labels.inside.any()
    assert np.array_equal(others.inside, labels.inside[order])
    assert (others.unreached, others.flipped) == (labels.unreached, labels.flipped)


@pytest.mark.parametrize("method", METHODS)
def test_labels_do_not_depend_on_the_unit(method):
    """A power of two rounds nothing."""
    poles, diagram = poles_of(noisy_statue(10))
    unit = 2.0**-20
    small = dataclasses.replace(
        poles,
        sites=unit * poles.sites,
        centres=unit * poles.centres,
        radii=unit * poles.radii,
        spacing=unit * poles.spacing,
        room=unit * poles.room,
    )
    inside = label_poles(poles, diagram, method=method).inside
    assert inside.any()
    again = regular_triangulation(small.centres, small.radii**2)
    assert np.array_equal(inside, label_poles(small, again, method=method).inside)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("motion", shapes.MOTIONS, ids=lambda motion: motion.name)
def test_labels_follow_motions(motion, method):
    """Poles are known again by the samples that they belong to."""
    samples = shapes.torus(1500, seed=4)
    inside = []
    for cloud in (samples, motion(samples)):
        poles, diagram = poles_of(cloud)
        labels = label_poles(poles, diagram, method=method).inside
        keys = map(tuple, np.sort(poles.samples, axis=1).tolist())
        within = (poles.samples < len(samples)).all(axis=1)
        inside.append({key: label for key, label, w in zip(keys, labels, within, strict=True) if w})
    common = inside[0].keys() & inside[1].keys()
    assert len(common) > 0.99 * len(inside[0])
    assert all(inside[0][key] == inside[1][key] for key in common)


def test_flat_angles_win_where_offers_contradict():
    """A chain of balls: 0 is outside; 1 intersects it; 2 lies across from 1, and 3 from nothing."""
    offsets = np.array([0, 1, 3, 4, 4])
    ends = np.array([1, 0, 2, 1], dtype=np.int32)
    cosine = np.array([0.9, 0.9, 0.5, 0.5], dtype=np.float32)
    first, second = np.array([1], dtype=np.int32), np.array([2], dtype=np.int32)
    seeds = np.array([1, 0, 0, 0], dtype=np.uint8)
    for flatness, label in ((0.8, 2), (0.3, 1)):
        labels = _native.propagate_labels(
            *(offsets, ends, -np.log(cosine), first, second, np.array([flatness])),
            *(np.ones(4), seeds, 0.0, 0.0),
        )
        assert labels.tolist() == [1, 1, label, 0]


def test_what_was_offered_nothing_goes_by_its_surroundings():
    """Balls that meet too shallowly for an offer: 1 goes by its neighbour, 2 by its opposite."""
    offsets = np.array([0, 1, 2, 2, 2])
    ends = np.array([1, 0], dtype=np.int32)
    lengths = np.full(2, -np.log(0.35), dtype=np.float32)
    first, second = np.array([1], dtype=np.int32), np.array([2], dtype=np.int32)
    seeds = np.array([1, 0, 0, 0], dtype=np.uint8)
    for accepted, expected in ((0.3, [1, 1, 2, 0]), (0.5, [1, 0, 0, 0])):
        labels = _native.propagate_labels(
            *(offsets, ends, lengths, first, second, np.array([0.9])),
            *(np.ones(4), seeds, 0.4, accepted),
        )
        assert labels.tolist() == expected


def test_a_radius_is_needed_for_each_pole():
    offsets, nothing = np.zeros(5, dtype=np.int64), np.zeros(0, dtype=np.int32)
    lengths = np.zeros(0, dtype=np.float32)
    seeds = np.array([1, 0, 0, 0], dtype=np.uint8)
    with pytest.raises(ValueError, match="one radius for each seed"):
        _native.propagate_labels(
            *(offsets, nothing, lengths, nothing, nothing),
            *(np.zeros(0), np.ones(3), seeds, 0.0, 0.0),
        )


# --------------------------------------------------------------------------------- the progress


@pytest.mark.parametrize("method", METHODS)
def test_progress_rises_and_changes_nothing(torus, method):
    told = []
    with_progress = label_poles(*torus, method=method, progress=told.append)
    assert told == sorted(told)
    assert told[0] > 0.0
    assert told[-1] <= 1.0
    assert np.array_equal(with_progress.inside, label_poles(*torus, method=method).inside)


class Stop(Exception):
    pass


@pytest.mark.parametrize("method", METHODS)
def test_what_progress_raises_stops_every_loop(torus, method):
    calls = []
    label_poles(*torus, method=method, progress=calls.append)
    for last in range(len(calls)):
        seen = []

        def stop_at_last(fraction, seen=seen, last=last):
            seen.append(fraction)
            if len(seen) > last:
                raise Stop

        with pytest.raises(Stop):
            label_poles(*torus, method=method, progress=stop_at_last)
        assert seen == calls[: last + 1]
