"""The messages of affinity propagation, dense and along the edges of a graph (Frey, Dueck 2007).

With similarities ``s(i, k)``, the preference of point k being ``s(k, k)``, responsibilities and
availabilities start at 0 and are updated in turn, both damped::

    r(i, k) <- s(i, k) - max over k' != k of (a(i, k') + s(i, k'))
    a(i, k) <- min(0, r(k, k) + sum over i' not in {i, k} of max(0, r(i', k)))    i != k
    a(k, k) <- sum over i' != k of max(0, r(i', k))

Point k is an exemplar when ``r(k, k) + a(k, k) > 0``. On a graph sums and maxima run over the edges
there are, and an iteration takes O(edges) time and memory.

Notes
-----
Beyond the paper: iterations count as converged only while the updates before damping call the same
points exemplars, since strongly moving messages can keep a wrong choice for long; and whenever a
point has turned exemplar and back again and again, the damping rises halfway to 1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from meshlab_symrecon import _native
from meshlab_symrecon.arrays import Floats, Indices
from meshlab_symrecon.clustering.neighbour_graph import Neighbours

__all__ = [
    "GROWTH",
    "Propagation",
    "Schedule",
    "choose_among_equals",
    "propagate_dense",
    "propagate_neighbours",
    "propagate_sparse",
]

GROWTH = 32  # edges in the end / edges in the beginning, at most


@dataclass(frozen=True, slots=True)
class Schedule:
    """How messages are damped, and when they stop."""

    damping: float  # share of the old message kept, 0.5 to 1
    max_iter: int  # most iterations
    convergence_iter: int  # iterations with the same exemplars that count as converged


@dataclass(frozen=True, slots=True, eq=False)
class Propagation:
    """Where message passing ended."""

    exemplars: Indices  # (m,)  indices of the exemplars, ascending, at least one
    converged: bool  # False: stopped at the iteration limit
    exact: bool  # False: a missing edge could have changed a message
    iterations: int  # number of iterations done
    damping: float  # of the last one: oscillation raises it
    edges: int  # in the end, those of points to themselves included
    earlier: Indices  # exemplars `convergence_iter` iterations before; none if there were fewer


def _propagation(
    found: tuple[NDArray[np.uint8], bool, bool, int, float, int, NDArray[np.uint8]],
) -> Propagation:
    chosen, converged, exact, iterations, damping, edges, earlier = found
    now, before = np.flatnonzero(chosen), np.flatnonzero(earlier)
    return Propagation(now, converged, exact, iterations, damping, edges, before)


def propagate_dense(similarities: Floats, schedule: Schedule) -> Propagation:
    """Pass messages between all points until the exemplars stay the same.

    Parameters
    ----------
    similarities : (n, n) float
        ``s`` with preferences on the diagonal.
    schedule : Schedule
        Damping and limits.

    Returns
    -------
    Propagation
        Exemplars; never empty, even when stopped early.
    """
    found = _native.propagate_dense_affinity(
        np.ascontiguousarray(similarities, dtype=np.float64),
        schedule.damping,
        schedule.max_iter,
        schedule.convergence_iter,
    )
    return _propagation(found)


def propagate_sparse(
    similarities: Floats,
    targets: Indices | NDArray[np.int32],
    damping: float,
    max_iter: int,
    convergence_iter: int,
) -> Propagation:
    """Pass messages along given edges until the exemplars stay the same.

    Parameters
    ----------
    similarities : (n, k) float
        ``s`` on the edges, the preference first. An edge with ``s = -inf`` does not exist.
    targets : (n, k) int
        Where each edge ends; ``targets[i, 0] == i``.
    damping, max_iter, convergence_iter
        As in `Schedule`.

    Returns
    -------
    Propagation
        Exemplars; never empty, even when stopped early. These edges are all there are: exact.
    """
    found = _native.propagate_sparse_affinity(
        np.ascontiguousarray(similarities, dtype=np.float64),
        np.ascontiguousarray(targets, dtype=np.int32),
        damping,
        max_iter,
        convergence_iter,
    )
    return _propagation(found)


def propagate_neighbours(
    neighbours: Neighbours, preferences: Floats, count: int, schedule: Schedule
) -> Propagation:
    """Pass messages between neighbours, as many as it takes to choose as if between all.

    Since ``a(i, k) <= 0``, a missing edge whose similarity is no larger than the second largest sum
    ``a(i, k') + s(i, k')`` of its row is not one of the two largest, and its responsibility is not
    positive: it changes no message. Where that is not certain the row gets twice as many edges, in
    the middle of the iteration. The messages that a new edge would carry are known: it never sent a
    positive responsibility, so its availability is that of every such edge to its target.

    Parameters
    ----------
    neighbours : Neighbours
        Where edges come from.
    preferences : (n,) float
        Similarity of each point to itself.
    count : int
        Edges from each point in the beginning, without the one to itself; at least 1.
    schedule : Schedule
        Damping and limits.

    Returns
    -------
    Propagation
        Not exact when the graph would have needed more than `GROWTH` times its first edges;
        O(`GROWTH` n count) memory.
    """
    everyone = np.arange(len(preferences), dtype=np.int32)
    width = min(count + 1, len(preferences))
    room = (GROWTH - 1) * width * len(preferences)

    def more(points: NDArray[np.int32], width: int) -> tuple[Floats, NDArray[np.int32]] | None:
        nonlocal room
        room -= len(points) * (width - width // 2)
        return None if room < 0 else neighbours.nearest(points, width)

    similarities, targets = neighbours.nearest(everyone, width)
    similarities[:, 0] = preferences
    found = _native.propagate_sparse_affinity(
        similarities,
        targets,
        schedule.damping,
        schedule.max_iter,
        schedule.convergence_iter,
        more,
    )
    return _propagation(found)


def choose_among_equals(preferences: Floats, similarity: float) -> Indices:
    """Return the exemplars that maximise the net similarity of points that are all equally similar.

    The point with the largest preference, the first among equals, and all whose preference exceeds
    the similarity. Messages between such points have no reason to prefer one to another.
    """
    chosen = preferences > similarity
    chosen[np.argmax(preferences)] = True
    return np.flatnonzero(chosen)
