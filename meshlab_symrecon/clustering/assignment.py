"""Which exemplar stands for each point, and which point stands best for each cluster."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from meshlab_symrecon.arrays import Floats, Indices

__all__ = ["best_members", "nearest_exemplars"]


def nearest_exemplars(rows: Floats, centres: Floats) -> Indices:
    """Return the index of the centre nearest to each row."""
    found: Indices = cKDTree(centres).query(rows)[1].astype(np.int64)
    return found


def best_members(rows: Floats, preferences: Floats, exemplars: Indices) -> Indices:
    """Elect in each cluster the member with the largest sum of similarities.

    The sum of squared distances to the members of a cluster needs only their number, mean and
    spread, so that this takes O(n) time and memory.

    Parameters
    ----------
    rows : (n, d) float
        Positions.
    preferences : (n,) float
        Similarity of each row to itself.
    exemplars : (m,) int
        Exemplars; each row belongs to the nearest one.

    Returns
    -------
    (m,) int
        Elected members, ascending.
    """
    labels = nearest_exemplars(rows, rows[exemplars])
    labels[exemplars] = np.arange(len(exemplars))
    sizes = np.bincount(labels, minlength=len(exemplars))
    sums = [np.bincount(labels, weights=column) for column in rows.T]
    means = np.stack(sums, axis=1) / sizes[:, np.newaxis]
    # Sum of squares about a member = the same about the mean + size times the distance to the mean.
    losses = sizes[labels] * ((rows - means[labels]) ** 2).sum(axis=1) - preferences
    order = np.lexsort((losses, labels))
    first = np.flatnonzero(np.diff(labels[order], prepend=-1))
    return np.sort(order[first])
