"""Nearest-neighbour graphs with negative squared distances as similarities."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from meshlab_symrecon.arrays import Floats, Indices

__all__ = ["best_members", "dense_similarities", "nearest_exemplars", "neighbour_graph"]


def neighbour_graph(rows: Floats, neighbours: int) -> tuple[Floats, Indices]:
    """Connect each row with itself and its nearest other rows.

    Parameters
    ----------
    rows : (n, d) float
        Positions in any number of dimensions.
    neighbours : int
        Edges from each row besides the one to itself; at most n - 1 are possible.

    Returns
    -------
    similarities : (n, k) float
        Negative squared distances, 0 to itself, which comes first.
    targets : (n, k) int
        Where each edge ends.
    """
    count = min(neighbours + 1, len(rows))
    distances, targets = cKDTree(rows).query(rows, k=count)
    distances = distances.reshape(len(rows), count)
    targets = targets.reshape(len(rows), count).astype(np.int64)
    own = np.arange(len(rows))
    # Among duplicates the row itself may come later, or not at all: swap it to the front.
    place = np.argmax(targets == own[:, np.newaxis], axis=1)
    present = targets[own, place] == own
    place = np.where(present, place, count - 1)
    targets[own, place] = targets[:, 0]
    distances[own, place] = distances[:, 0]
    targets[:, 0] = own
    distances[:, 0] = 0.0
    return -(distances**2), targets


def dense_similarities(rows: Floats) -> Floats:
    """Return the negative squared distances between all rows, (n, n) floats."""
    squares = (rows**2).sum(axis=1)
    similarities: Floats = 2.0 * (rows @ rows.T) - squares[:, np.newaxis] - squares[np.newaxis, :]
    np.minimum(similarities, 0.0, out=similarities)
    np.fill_diagonal(similarities, 0.0)
    return similarities


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
