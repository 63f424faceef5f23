"""Labels by shortest paths of evidence, corrected by minimum cuts.

The evidence is weighed in two steps that survive noise, outliers and wide holes better than a
greedy queue.  *Paths*: shortest paths in the signed double cover of the pole graph (every pole has
an outer and an inner copy; opposite poles join different copies, intersecting balls equal ones)
give a first label and its confidence.  *Cuts*: a minimum cut then lets intersecting balls outvote
a pole's own evidence, which is mostly what the opposite pole's label says; a second cut starts from
the labels of the first.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from meshlab_symrecon import _native
from meshlab_symrecon.arrays import Booleans, Floats
from meshlab_symrecon.powercrust.pole_graph import Intersections, Opposites
from meshlab_symrecon.powercrust.progress import Progress, part

__all__ = ["corrected_by_cuts", "path_costs"]


SMOOTHNESS = 100.0  # capacity between balls that coincide
OPPOSITION = 50.0  # capacity of a certain opposite
CONFIDENCE = 10.0  # capacity gained with each unit of a path's confidence
MOST_CONFIDENCE = 20.0
ROUNDS = 2
MOST_TURNED = 0.5  # of the inner poles: cuts that correct more found a short way across a hole
RESOLUTION = 256.0  # capacities are whole numbers: a finer unit makes ties between cuts rare
CHUNK = 1 << 18  # edges at a time: few enough to stay in the cache
CERTAIN = 1 << 30  # capacity of a tie that the cut must not break


def path_costs(
    near: Intersections,
    across: Opposites,
    outer: Booleans,
    *,
    progress: Progress | None = None,
) -> tuple[Floats, Floats]:
    """Return the cost of the best path of evidence to 'outside' and to 'inside', (p,) each.

    Parameters
    ----------
    near : Intersections
        An edge joins equal labels.
    across : Opposites
        A pair costs -log(certainty) and joins different labels.
    outer : (p,) bool
        Poles that lie outside for certain, where the paths start.
    progress : callable, optional
        Called with the share done, 0 to 1; what it raises stops the work.
    """
    with np.errstate(divide="ignore"):
        crossings = -np.log(across.certainty)
    to_outer, to_inner = _native.evidence_paths(
        near.offsets,
        near.ends,
        near.cost,
        across.first,
        across.second,
        crossings,
        outer.view(np.uint8),
        progress,
    )
    return to_outer, to_inner


def corrected_by_cuts(
    near: Intersections,
    across: Opposites,
    costs: tuple[Floats, Floats],
    outer: Booleans,
    *,
    progress: Progress | None = None,
) -> Booleans:
    """Return (p,) True for inner poles: the paths' labels, corrected by cuts.

    Parameters
    ----------
    near, across, outer, progress
        As for ``path_costs``.
    costs : ((p,) float, (p,) float)
        What ``path_costs`` returns.
    """
    to_outer, to_inner = costs
    by_paths: Booleans = to_inner < to_outer
    confidence = _confidence(to_outer, to_inner)
    cut = _native.MinimumCut(near.offsets, near.ends, _capacities(near.cost))
    inside: Booleans = by_paths
    told: Floats = np.full(len(outer), np.nan)
    for turn in range(ROUNDS):
        before, told = told, _told_by_opposites(across, inside)
        if np.array_equal(before, told):
            break
        ties = _ties(OPPOSITION * told + CONFIDENCE * confidence, outer)
        share = part(progress, turn / ROUNDS, (turn + 1) / ROUNDS)
        inside = cut.inner_side(ties, share).view(np.bool_)
    turned = np.count_nonzero(inside != by_paths)
    return inside if turned <= MOST_TURNED * np.count_nonzero(by_paths) else by_paths


def _confidence(to_outer: Floats, to_inner: Floats) -> Floats:
    """Return (p,) how much more a pole's outer label costs than its inner one, within limits."""
    reached = np.isfinite(to_outer) | np.isfinite(to_inner)
    confidence = np.zeros(len(to_outer))
    confidence[reached] = np.clip(
        to_outer[reached] - to_inner[reached], -MOST_CONFIDENCE, MOST_CONFIDENCE
    )
    return confidence


def _told_by_opposites(across: Opposites, inside: Booleans) -> Floats:
    """Return (p,) the certainties of the opposites that lie outside less those inside."""
    side = np.where(inside, -1.0, 1.0)
    told = np.bincount(
        np.concatenate([across.first, across.second]),
        np.concatenate(
            [across.certainty * side[across.second], across.certainty * side[across.first]]
        ),
        minlength=len(inside),
    )
    return np.asarray(told, dtype=np.float64)


def _ties(belief: Floats, outer: Booleans) -> NDArray[np.int32]:
    """Return (p,) whole capacities: to the outside where positive, to the inside where negative."""
    # one pole may be the opposite of very many, as in an exact sphere; less than certain it stays
    ties = np.clip(np.round(-RESOLUTION * belief), -(CERTAIN // 2), CERTAIN // 2).astype(np.int32)
    ties[outer] = CERTAIN
    return ties


def _capacities(cost: NDArray[np.float32]) -> NDArray[np.uint16]:
    """Return (e,) whole capacities of the edges, the fourth power of their cosine."""
    capacities = np.zeros(len(cost), dtype=np.uint16)
    for start in range(0, len(cost), CHUNK):
        fourth_power = np.exp(np.float32(-4.0) * cost[start : start + CHUNK])
        fourth_power *= np.float32(RESOLUTION * SMOOTHNESS)
        capacities[start : start + CHUNK] = np.rint(fourth_power)
    return capacities
