"""Inner and outer poles, told apart by evidence that travels through the power diagram.

The evidence is weighed in two steps that survive noise, outliers and wide holes better than a
greedy queue.  *Paths*: shortest paths in the signed double cover of the pole graph (every pole has
an outer and an inner copy; opposite poles join different copies, intersecting balls equal ones)
give a first label and its confidence.  *Cuts*: a minimum cut then lets intersecting balls outvote
a pole's own evidence, which is mostly what the opposite pole's label says; a second cut starts from
the labels of the first.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import breadth_first_order, dijkstra, maximum_flow

from meshlab_symrecon import _native
from meshlab_symrecon.arrays import Booleans, Floats, Indices
from meshlab_symrecon.geometry.triangulation import Triangulation
from meshlab_symrecon.powercrust.pole_graph import (
    Intersections,
    Opposites,
    intersections,
    opposites,
)
from meshlab_symrecon.powercrust.poles import Poles

__all__ = ["Labels", "label_poles"]

SMOOTHNESS = 100.0  # capacity between balls that coincide
OPPOSITION = 50.0  # capacity of a certain opposite
CONFIDENCE = 5.0  # capacity gained with each unit of a path's confidence
MOST_CONFIDENCE = 20.0
ROUNDS = 2
MOST_TURNED = 0.4  # of the inner poles: cuts that correct more found a short way across a hole
RESOLUTION = 256.0  # capacities are whole numbers: a finer unit makes ties between cuts rare
CERTAIN = 1 << 30  # capacity of a tie that the cut must not break
SMALLEST_PIECE = 0.005  # share of the samples; a smaller island or bubble is noise


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
    near = intersections(poles, diagram, representative)
    across = opposites(poles, representative)
    to_outer, to_inner = _path_costs(near, across, outer)
    reached = np.isfinite(to_outer) | np.isfinite(to_inner)
    shown = np.zeros(len(outer), dtype=bool)
    shown[diagram.cells.ravel()] = True
    inside = _smoothed(near, across, to_outer, to_inner, outer) & shown & reached
    samples = np.bincount(representative[poles.pairs].ravel(), minlength=len(outer))
    inside, flipped = _turn_small_pieces(diagram, inside, outer, samples)
    return Labels(
        inside=inside[representative],
        unreached=int(np.count_nonzero(~reached & shown)),
        flipped=flipped,
    )


def _certainly_outside(poles: Poles, diagram: Triangulation, representative: Indices) -> Booleans:
    """Return (p,) True for poles that lie outside for certain, and for those on the hull."""
    outer = np.zeros(len(poles.centres), dtype=bool)
    outer[representative[poles.outermost]] = True
    for corner in range(4):
        on_hull = diagram.neighbours[:, corner] < 0
        others = [other for other in range(4) if other != corner]
        outer[diagram.cells[on_hull][:, others].ravel()] = True
    return outer


def _path_costs(near: Intersections, across: Opposites, outer: Booleans) -> tuple[Floats, Floats]:
    """Return the cost of the best path of evidence to 'outside' and to 'inside', (p,) each.

    A pole i has the copies i (outside) and p + i (inside).
    """
    count = len(outer)
    same = -np.log(near.cosine)
    first, second, other = _cheapest(across)
    rows = np.concatenate([near.start, near.start + count, first, first + count])
    columns = np.concatenate([near.end, near.end + count, second + count, second])
    costs = np.concatenate([same, same, other, other])
    cover = csr_matrix((costs, (rows, columns)), shape=(2 * count, 2 * count))
    cost = dijkstra(cover, directed=False, indices=np.flatnonzero(outer), min_only=True)
    return cost[:count], cost[count:]


def _cheapest(across: Opposites) -> tuple[Indices, Indices, Floats]:
    """Return each pair of opposites once, with its smallest cost: samples may share both poles."""
    with np.errstate(divide="ignore"):
        costs = -np.log(across.certainty)
    low = np.minimum(across.first, across.second)
    high = np.maximum(across.first, across.second)
    order = np.lexsort((costs, high, low))
    low, high = low[order], high[order]
    fresh = np.ones(len(low), dtype=bool)
    fresh[1:] = (np.diff(low) != 0) | (np.diff(high) != 0)
    return low[fresh], high[fresh], costs[order][fresh]


def _smoothed(
    near: Intersections, across: Opposites, to_outer: Floats, to_inner: Floats, outer: Booleans
) -> Booleans:
    """Return (p,) True for inner poles: the paths' labels, corrected by cuts."""
    by_paths = to_inner < to_outer
    reached = np.isfinite(to_outer) | np.isfinite(to_inner)
    confidence = np.zeros(len(outer))
    confidence[reached] = np.clip(
        to_outer[reached] - to_inner[reached], -MOST_CONFIDENCE, MOST_CONFIDENCE
    )
    inside = by_paths
    for _ in range(ROUNDS):
        side = np.where(inside, 1.0, -1.0)
        told = np.bincount(
            np.concatenate([across.first, across.second]),
            np.concatenate(
                [
                    -across.certainty * side[across.second],
                    -across.certainty * side[across.first],
                ]
            ),
            minlength=len(outer),
        )
        inside = _minimum_cut(near, OPPOSITION * told + CONFIDENCE * confidence, outer)
    turned = np.count_nonzero(inside != by_paths)
    return inside if turned <= MOST_TURNED * np.count_nonzero(by_paths) else by_paths


def _minimum_cut(near: Intersections, belief: Floats, outer: Booleans) -> Booleans:
    """Return (p,) True for poles on the inner side of the cheapest cut.

    ``belief`` is the capacity of a pole's tie: to the inside when positive, else to the outside.
    """
    count = len(outer)
    source, sink = count, count + 1  # outside, inside
    capacity = np.round(RESOLUTION * SMOOTHNESS * near.cosine**4).astype(np.int64)
    joined = capacity > 0
    start, end, capacity = near.start[joined], near.end[joined], capacity[joined]
    strength = np.round(RESOLUTION * np.abs(belief)).astype(np.int64)
    strength[outer] = CERTAIN
    tied = strength > 0
    to_outside = np.flatnonzero(tied & (outer | (belief < 0.0)))
    to_inside = np.flatnonzero(tied & ~outer & (belief > 0.0))
    network = csr_matrix(
        (
            np.concatenate([capacity, capacity, strength[to_outside], strength[to_inside]]).astype(
                np.int32
            ),
            (
                np.concatenate([start, end, np.full(len(to_outside), source), to_inside]),
                np.concatenate([end, start, to_outside, np.full(len(to_inside), sink)]),
            ),
        ),
        shape=(count + 2, count + 2),
    )
    residual = network - maximum_flow(network, source, sink).flow
    residual.data[residual.data < 0] = 0
    residual.eliminate_zeros()
    inside = np.ones(count + 2, dtype=bool)
    inside[breadth_first_order(residual, source, return_predecessors=False)] = False
    return inside[:count]


def _turn_small_pieces(
    diagram: Triangulation, inside: Booleans, outer: Booleans, samples: Indices
) -> tuple[Booleans, int]:
    """Turn over islands and bubbles that a negligible share of the samples lies on.

    Pieces are connected through the faces of the power diagram, so turning one over keeps the
    surface closed.  ``samples`` counts the samples of each pole.
    """
    smallest = SMALLEST_PIECE * samples.sum() / 2
    turned = inside.copy()
    for islands in (True, False):
        piece = _native.label_pieces(diagram.cells, turned.astype(np.uint8))
        sizes = np.bincount(piece, weights=samples)
        keep = sizes >= smallest
        keep[piece[outer]] = True
        inner = np.unique(piece[turned])
        if islands and len(inner):
            keep[inner[np.argmax(sizes[inner])]] = True
        turned[~keep[piece] & (turned == islands)] = not islands
    shown = np.zeros(len(inside), dtype=bool)
    shown[diagram.cells.ravel()] = True
    return turned, int(np.count_nonzero((turned != inside) & shown))
