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
from meshlab_symrecon.clustering.neighbour_graph import NeighbourGraph, edges_of_rows

__all__ = [
    "Propagation",
    "Schedule",
    "choose_among_equals",
    "propagate_dense",
    "propagate_graph",
    "propagate_sparse",
]


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
    iterations: int  # number of iterations done
    damping: float  # of the last one: oscillation raises it
    needed: Floats  # (n,)  an edge with less similarity would not have changed any message


def _propagation(found: tuple[NDArray[np.uint8], Floats, bool, int, float]) -> Propagation:
    chosen, needed, converged, iterations, damping = found
    return Propagation(np.flatnonzero(chosen), converged, iterations, damping, needed)


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
    return _propagation(
        _native.propagate_dense_affinity(
            np.ascontiguousarray(similarities),
            schedule.damping,
            schedule.max_iter,
            schedule.convergence_iter,
        )
    )


def propagate_graph(graph: NeighbourGraph, schedule: Schedule) -> Propagation:
    """Pass messages along the edges of a graph until the exemplars stay the same.

    Suppose that row i lacks only edges with ``s(i, k) <= needed[i]``. Then these are the exemplars
    of the graph that has those edges too, bit for bit up to rounding: ``a(i, k) <= 0``, so that a
    missing edge was never one of the two largest sums of its row, and its responsibility never
    positive.

    Parameters
    ----------
    graph : NeighbourGraph
        Similarities; the first edge of each row leads to the row itself and holds its preference.
    schedule : Schedule
        Damping and limits.

    Returns
    -------
    Propagation
        Exemplars; never empty, even when stopped early.
    """
    return _propagation(
        _native.propagate_sparse_affinity(
            graph.offsets,
            graph.targets,
            graph.similarities,
            schedule.damping,
            schedule.max_iter,
            schedule.convergence_iter,
        )
    )


def propagate_sparse(
    similarities: Floats, targets: Indices, damping: float, max_iter: int, convergence_iter: int
) -> Propagation:
    """Pass messages along the edges of a graph whose rows have equally many.

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
        Exemplars; never empty, even when stopped early.
    """
    graph = edges_of_rows(similarities, targets)
    return propagate_graph(graph, Schedule(damping, max_iter, convergence_iter))


def choose_among_equals(preferences: Floats, similarity: float) -> Indices:
    """Return the exemplars that maximise the net similarity of points that are all equally similar.

    The point with the largest preference, the first among equals, and all whose preference exceeds
    the similarity. Messages between such points have no reason to prefer one to another.
    """
    chosen = preferences > similarity
    chosen[np.argmax(preferences)] = True
    return np.flatnonzero(chosen)
