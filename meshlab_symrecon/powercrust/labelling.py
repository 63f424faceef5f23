"""Inner and outer poles, told apart by evidence that travels through the power diagram.

Two facts carry the evidence (Amenta, Choi, Kolluri 2001, section 4): the two poles of a sample lie
on different sides of the surface, the more certainly the flatter the angle between them; and two
balls that intersect deeply lie on the same side.  Here the evidence is weighed in two steps that
survive noise and outliers better than a greedy queue: shortest paths in the *signed double cover*
of the pole graph (every pole has an outer and an inner copy; opposite poles join different copies,
neighbours equal ones), then a minimum cut that lets neighbours outvote a weak path.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.csgraph import (
    breadth_first_order,
    connected_components,
    dijkstra,
    maximum_flow,
)
from scipy.spatial import cKDTree

from meshlab_symrecon.arrays import Booleans, Floats, Indices
from meshlab_symrecon.geometry.triangulation import Triangulation
from meshlab_symrecon.powercrust.poles import CUBE, Poles

__all__ = ["Labels", "label_poles"]

DEEPEST = 1.0 - 1e-9  # cosine of two equal balls; keeps -log of it above zero
LONG = 3.0  # spacings: a sample with both poles farther than this lies on the surface for certain
TYPICAL = 1.5  # times the median length, where noise makes most cells round
STEEPNESS = 4.0  # power with which certainty falls with nearer poles
NEIGHBOURS = 4
MOST_PARTNERS = 24  # balls that meet in a sample, of which about eight are usual
SMOOTHNESS = 200.0  # capacity of an edge between balls that coincide
TERMINAL = 20.0  # capacity gained with each unit of path confidence
STRONGEST_TERMINAL = 400.0
RESOLUTION = 256.0  # capacities are whole numbers: a finer unit makes ties between cuts rare
CERTAIN = 1 << 30  # capacity of a tie that the cut must not break
SMALLEST_PIECE = 0.005  # share of the poles; a smaller island or bubble is noise


@dataclass(frozen=True, slots=True, eq=False)
class Labels:
    """Which poles lie inside.

    Attributes
    ----------
    inside : (p,) bool
    unreached : int
        Poles that no path of evidence reaches; they count as outside.
    flipped : int
        Poles of islands and bubbles too small to be part of the shape, turned over.
    """

    inside: Booleans
    unreached: int
    flipped: int


@dataclass(frozen=True, slots=True, eq=False)
class _Graph:
    """Regular edges between poles with the cosine at which their balls intersect."""

    start: Indices
    end: Indices
    cosine: Floats


def label_poles(poles: Poles, diagram: Triangulation) -> Labels:
    """Tell inner poles from outer ones.

    Parameters
    ----------
    poles : Poles
    diagram : Triangulation
        Regular triangulation of the polar balls.
    """
    representative = diagram.representative.astype(np.int64)
    outer = _certainly_outside(poles, diagram, representative)
    graph = _pole_graph(poles, diagram, representative)
    to_outer, to_inner = _path_costs(poles, graph, outer, representative)
    inside = _minimum_cut(graph, to_outer, to_inner, outer)
    if not inside.any():  # so few poles that the cut prefers none inside: the paths alone decide
        inside = to_inner < to_outer
    reached = np.isfinite(to_outer) | np.isfinite(to_inner)
    shown = np.zeros(len(outer), dtype=bool)
    shown[np.unique(diagram.cells)] = True
    inside &= shown
    inside, flipped = _turn_small_pieces(graph, inside, outer, shown)
    return Labels(
        inside=inside[representative],
        unreached=int(np.count_nonzero(~reached & shown)),
        flipped=flipped,
    )


def _certainly_outside(poles: Poles, diagram: Triangulation, representative: Indices) -> Booleans:
    """Return (p,) True for poles of the enclosing corners, and for those on the hull."""
    outer = np.zeros(len(poles.centres), dtype=bool)
    outer[representative[poles.outermost]] = True
    for corner in range(4):
        on_hull = diagram.neighbours[:, corner] < 0
        others = [other for other in range(4) if other != corner]
        outer[diagram.cells[on_hull][:, others].ravel()] = True
    return outer


def _pole_graph(poles: Poles, diagram: Triangulation, representative: Indices) -> _Graph:
    """Return the edges of the power diagram's dual, and those between balls that share a sample.

    About eight balls meet in every sample, and rounding decides which of them the triangulation
    joins there; with all their pairs the evidence does not depend on it.
    """
    cells = diagram.cells.astype(np.int64)
    sides = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]
    keys = [_edge_keys(cells[:, a], cells[:, b]) for a, b in sides]
    keys += _pairs_at_samples(poles, diagram, representative)
    unique = np.concatenate(keys)
    unique.sort()
    unique = unique[np.flatnonzero(np.diff(unique, prepend=-1))]
    start, end = unique >> 32, unique & 0xFFFFFFFF
    arms = poles.centres[start] - poles.centres[end]
    squares = np.einsum("ij,ij->i", arms, arms)
    r, s = poles.radii[start], poles.radii[end]
    cosine = (r * r + s * s - squares) / (2.0 * r * s)
    return _Graph(start, end, np.minimum(cosine, DEEPEST))


def _edge_keys(a: Indices, b: Indices) -> Indices:
    return (np.minimum(a, b) << 32) | np.maximum(a, b)


def _pairs_at_samples(
    poles: Poles, diagram: Triangulation, representative: Indices
) -> list[Indices]:
    """Return keys of the pairs of shown poles whose balls touch one sample."""
    used = np.flatnonzero((representative == np.arange(len(representative))) & ~diagram.hidden)
    sample = poles.samples[used].ravel()
    order = np.argsort(sample, kind="stable")
    sample, pole = sample[order], np.repeat(used, 4)[order]
    count = len(poles.sites) - len(CUBE)
    kept = np.searchsorted(sample, count)
    sample, pole = sample[:kept], pole[:kept]
    keys = []
    for step in range(1, MOST_PARTNERS):
        together = sample[step:] == sample[:-step]
        if not together.any():
            break
        keys.append(_edge_keys(pole[:-step][together], pole[step:][together]))
    return keys


def _path_costs(
    poles: Poles, graph: _Graph, outer: Booleans, representative: Indices
) -> tuple[Floats, Floats]:
    """Return the cost of the best path of evidence to 'outside' and to 'inside', (p,) each.

    A pole i has the copies i (outside) and p + i (inside).
    """
    count = len(outer)
    deep = graph.cosine > 0.0
    start, end = graph.start[deep], graph.end[deep]
    same = -np.log(graph.cosine[deep])

    arms = poles.centres[poles.pairs] - poles.sites[poles.pair_samples][:, None, :]
    lengths = np.linalg.norm(arms, axis=2)
    angle = np.einsum("ij,ij->i", arms[:, 0], arms[:, 1]) / np.maximum(
        lengths[:, 0] * lengths[:, 1], np.finfo(float).tiny
    )
    first, second = representative[poles.pairs].T
    useful = (angle < 0.0) & (first != second)
    first, second = first[useful], second[useful]
    opposite = -np.log(np.minimum(-angle[useful], DEEPEST)) + _doubt(poles)[useful]

    rows = np.concatenate([start, start + count, first, first + count])
    columns = np.concatenate([end, end + count, second + count, second])
    costs = np.concatenate([same, same, opposite, opposite])
    low, high = np.minimum(rows, columns), np.maximum(rows, columns)
    cover = _cheapest(low, high, costs, 2 * count)
    cost = dijkstra(cover, directed=False, indices=np.flatnonzero(outer), min_only=True)
    return cost[:count], cost[count:]


def _doubt(poles: Poles) -> Floats:
    """Return (k,) the cost of believing that the surface parts the two poles of a sample.

    The Voronoi cell of a sample on a well sampled surface is long and thin: both poles are much
    farther away than the next samples.  An outlier's cell is round, and says nothing.  Where noise
    makes most cells round, only those rounder than the median are doubted.
    """
    samples = poles.sites[: -len(CUBE)]
    count = min(NEIGHBOURS + 1, len(samples))
    apart = cKDTree(samples).query(poles.sites[poles.pair_samples], k=count)[0]
    spacing = apart[:, 1:].mean(axis=1)
    nearer = poles.radii[poles.pairs].min(axis=1)
    length = nearer / spacing
    certain = min(LONG, TYPICAL * float(np.median(length)))
    doubt: Floats = STEEPNESS * np.maximum(0.0, np.log(certain / length))
    return doubt


def _cheapest(rows: Indices, columns: Indices, costs: Floats, size: int) -> csr_matrix:
    """Return a sparse matrix with the smallest cost where an entry is given more than once."""
    order = np.lexsort((costs, columns, rows))
    rows, columns, costs = rows[order], columns[order], costs[order]
    first = np.ones(len(rows), dtype=bool)
    first[1:] = (np.diff(rows) != 0) | (np.diff(columns) != 0)
    return csr_matrix((costs[first], (rows[first], columns[first])), shape=(size, size))


def _minimum_cut(graph: _Graph, to_outer: Floats, to_inner: Floats, outer: Booleans) -> Booleans:
    """Return (p,) True for poles on the inner side of the cheapest cut."""
    count = len(outer)
    source, sink = count, count + 1  # outside, inside
    deep = graph.cosine > 0.0
    capacity = np.round(RESOLUTION * SMOOTHNESS * graph.cosine[deep] ** 4).astype(np.int64)
    kept = capacity > 0
    start, end, capacity = graph.start[deep][kept], graph.end[deep][kept], capacity[kept]

    reached = np.isfinite(to_outer) | np.isfinite(to_inner)
    with np.errstate(invalid="ignore"):
        confidence = np.where(reached, np.abs(to_outer - to_inner), 0.0)
    strength = np.minimum(1.0 + TERMINAL * confidence, STRONGEST_TERMINAL)
    strength = np.round(RESOLUTION * strength).astype(np.int64)
    towards_outer = reached & (to_outer <= to_inner) & ~outer
    towards_inner = reached & (to_outer > to_inner) & ~outer
    tie_out = np.flatnonzero(towards_outer)
    tie_in = np.flatnonzero(towards_inner)
    seeds = np.flatnonzero(outer)

    rows = [start, end, np.full(len(tie_out), source), tie_in, np.full(len(seeds), source)]
    columns = [end, start, tie_out, np.full(len(tie_in), sink), seeds]
    capacities = [
        capacity,
        capacity,
        strength[tie_out],
        strength[tie_in],
        np.full(len(seeds), CERTAIN),
    ]
    network = csr_matrix(
        (
            np.concatenate(capacities).astype(np.int32),
            (np.concatenate(rows), np.concatenate(columns)),
        ),
        shape=(count + 2, count + 2),
    )
    flow = maximum_flow(network, source, sink).flow
    residual = network - flow
    residual.data[residual.data < 0] = 0
    residual.eliminate_zeros()
    from_source = _reachable(residual, source)
    return ~from_source[:count] & reached


def _reachable(residual: csr_matrix, source: int) -> Booleans:
    """Return (n,) True for nodes that a path of positive capacity from ``source`` reaches."""
    order = breadth_first_order(residual, source, directed=True, return_predecessors=False)
    reached = np.zeros(residual.shape[0], dtype=bool)
    reached[order] = True
    return reached


def _turn_small_pieces(
    graph: _Graph, inside: Booleans, outer: Booleans, shown: Booleans
) -> tuple[Booleans, int]:
    """Turn over islands and bubbles that hold a negligible share of the poles.

    Pieces are connected through the faces of the power diagram, so turning one over keeps the
    surface closed.
    """
    smallest = SMALLEST_PIECE * np.count_nonzero(shown)
    turned = inside.copy()
    for islands in (True, False):
        equal = turned[graph.start] == turned[graph.end]
        links = (np.ones(np.count_nonzero(equal)), (graph.start[equal], graph.end[equal]))
        pieces, piece = connected_components(
            coo_matrix(links, shape=(len(inside), len(inside))), directed=False
        )
        sizes = np.bincount(piece[shown], minlength=pieces)
        keep = sizes >= smallest
        keep[piece[outer]] = True
        if islands and len(sizes):
            inner = np.unique(piece[turned])
            if len(inner):
                keep[inner[np.argmax(sizes[inner])]] = True
        small = shown & ~keep[piece] & (turned == islands)
        turned[small] = not islands
    return turned, int(np.count_nonzero(turned != inside))
