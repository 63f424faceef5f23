"""The messages of affinity propagation, dense and on a sparse neighbour graph (Frey, Dueck 2007).

Notation of the paper: similarity ``s(i, k)``, responsibility ``r(i, k)``, availability ``a(i, k)``.
The preference of point k is ``s(k, k)``. In the sparse form row i holds only the k-edges of a
neighbour graph, **itself first**; sums and maxima run over the edges there are, so that one
iteration takes O(edges) time and memory.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from meshlab_symrecon.arrays import Booleans, Floats, Indices

__all__ = [
    "Propagation",
    "dense_availabilities",
    "dense_responsibilities",
    "propagate_dense",
    "propagate_sparse",
    "sparse_availabilities",
    "sparse_responsibilities",
]


@dataclass(frozen=True, slots=True, eq=False)
class Propagation:
    """Where message passing ended."""

    exemplars: Indices  # (m,)  indices of the exemplars, ascending, at least one for any input row
    converged: bool  # False: stopped at the iteration limit
    iterations: int  # number of iterations done


def _responsibilities(similarities: Floats, availabilities: Floats) -> Floats:
    """Row-wise ``r(i, k) = s(i, k) - max over k' != k of (a(i, k') + s(i, k'))``."""
    rows = np.arange(len(similarities))
    sums = availabilities + similarities
    best = np.argmax(sums, axis=1)
    largest = sums[rows, best]
    sums[rows, best] = -np.inf
    second = sums.max(axis=1)
    found: Floats = similarities - largest[:, np.newaxis]
    found[rows, best] = similarities[rows, best] - second
    return found


def dense_responsibilities(similarities: Floats, availabilities: Floats) -> Floats:
    """Return ``r(i, k) = s(i, k) - max over k' != k of (a(i, k') + s(i, k'))``.

    Parameters
    ----------
    similarities, availabilities : (n, n) float
        ``s`` with the preferences on its diagonal, and ``a``; n at least 2.

    Returns
    -------
    (n, n) float
        Responsibilities.
    """
    return _responsibilities(similarities, availabilities)


def dense_availabilities(responsibilities: Floats) -> Floats:
    """Return ``a(i, k) = min(0, r(k, k) + sum over i' not in {i, k} of max(0, r(i', k)))``.

    On the diagonal there is neither the minimum nor r(k, k).

    Parameters
    ----------
    responsibilities : (n, n) float
        ``r``.

    Returns
    -------
    (n, n) float
        Availabilities.
    """
    own = np.diagonal(responsibilities).copy()
    received = np.maximum(responsibilities, 0.0)
    np.fill_diagonal(received, 0.0)
    totals = received.sum(axis=0)
    found: Floats = np.minimum(0.0, (own + totals)[np.newaxis, :] - received)
    np.fill_diagonal(found, totals)
    return found


def sparse_responsibilities(similarities: Floats, availabilities: Floats) -> Floats:
    """Return the responsibilities along the edges of a neighbour graph.

    Parameters
    ----------
    similarities, availabilities : (n, k) float
        ``s`` and ``a`` on the edges, the point itself first; k at least 2. An edge with ``s =
        -inf`` does not exist.

    Returns
    -------
    (n, k) float
        Responsibilities, ``-inf`` on edges that do not exist.
    """
    return _responsibilities(similarities, availabilities)


def sparse_availabilities(responsibilities: Floats, targets: Indices) -> Floats:
    """Return the availabilities along the edges of a neighbour graph.

    Parameters
    ----------
    responsibilities : (n, k) float
        ``r`` on the edges.
    targets : (n, k) int
        Where each edge ends; ``targets[i, 0] == i``.

    Returns
    -------
    (n, k) float
        Availabilities.
    """
    own = responsibilities[:, 0]
    received = np.maximum(responsibilities, 0.0)
    received[:, 0] = 0.0
    totals = np.bincount(targets.ravel(), weights=received.ravel(), minlength=len(targets))
    found: Floats = np.minimum(0.0, (own + totals)[targets] - received)
    found[:, 0] = totals
    return found


def _propagate(
    similarities: Floats,
    availability_rule: Callable[[Floats], Floats],
    self_messages: Callable[[Floats], Floats],
    schedule: tuple[float, int, int],
) -> Propagation:
    damping, max_iter, convergence_iter = schedule
    responsibilities = np.zeros_like(similarities)
    availabilities = np.zeros_like(similarities)
    chosen: Booleans = np.zeros(len(similarities), dtype=bool)
    unchanged = iteration = 0
    for iteration in range(1, max_iter + 1):  # reported
        update = _responsibilities(similarities, availabilities)
        responsibilities = damping * responsibilities + (1.0 - damping) * update
        update = availability_rule(responsibilities)
        availabilities = damping * availabilities + (1.0 - damping) * update
        before, chosen = chosen, self_messages(responsibilities + availabilities) > 0.0
        unchanged = unchanged + 1 if np.array_equal(before, chosen) else 1
        if unchanged >= convergence_iter and chosen.any():
            return Propagation(np.flatnonzero(chosen), True, iteration)
    if not chosen.any():  # stopped early: the point nearest to being an exemplar
        chosen[np.argmax(self_messages(responsibilities + availabilities))] = True
    return Propagation(np.flatnonzero(chosen), False, iteration)


def propagate_dense(
    similarities: Floats, damping: float, max_iter: int, convergence_iter: int
) -> Propagation:
    """Pass messages between all points until the exemplars stay the same.

    Parameters
    ----------
    similarities : (n, n) float
        ``s`` with preferences on the diagonal; n at least 2.
    damping : float
        Share of the old message kept, 0.5 to 1.
    max_iter : int
        Most iterations.
    convergence_iter : int
        Iterations without a change of the exemplars that count as converged.

    Returns
    -------
    Propagation
        Exemplars; never empty, even when stopped early.
    """
    return _propagate(
        similarities,
        dense_availabilities,
        lambda messages: np.diagonal(messages),
        (damping, max_iter, convergence_iter),
    )


def propagate_sparse(
    similarities: Floats, targets: Indices, damping: float, max_iter: int, convergence_iter: int
) -> Propagation:
    """Pass messages along the edges of a neighbour graph until the exemplars stay the same.

    Parameters
    ----------
    similarities : (n, k) float
        ``s`` on the edges, the preference first; k at least 2.
    targets : (n, k) int
        Where each edge ends; ``targets[i, 0] == i``.
    damping : float
        Share of the old message kept, 0.5 to 1.
    max_iter : int
        Most iterations.
    convergence_iter : int
        Iterations without a change of the exemplars that count as converged.

    Returns
    -------
    Propagation
        Exemplars; never empty, even when stopped early.
    """
    return _propagate(
        similarities,
        lambda responsibilities: sparse_availabilities(responsibilities, targets),
        lambda messages: messages[:, 0],
        (damping, max_iter, convergence_iter),
    )
