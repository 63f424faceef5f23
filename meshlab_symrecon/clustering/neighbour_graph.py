"""Nearest-neighbour graphs with negative squared distances as similarities."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from meshlab_symrecon.arrays import Floats, Indices

__all__ = ["Neighbours", "neighbour_graph"]


class Neighbours:
    """Nearest rows among given ones."""

    def __init__(self, rows: Floats) -> None:
        self._tree = cKDTree(rows)

    def nearest(self, members: NDArray[np.int32], count: int) -> tuple[Floats, NDArray[np.int32]]:
        """Connect rows with themselves, which comes first, and with their nearest other rows.

        Parameters
        ----------
        members : (m,) int
            Rows to connect.
        count : int
            Edges of each, the one to itself included; at most all rows.

        Returns
        -------
        similarities : (m, count) float
            Negative squared distances, falling, 0 to itself.
        targets : (m, count) int
            Where each edge ends.
        """
        distances, targets = self._tree.query(self._tree.data[members], k=count)
        distances = distances.reshape(len(members), count)
        targets = targets.reshape(len(members), count).astype(np.int32)
        # Among duplicates the row itself may come later, or not at all: move it to the front.
        own = np.arange(len(members))
        place = np.argmax(targets == members[:, np.newaxis], axis=1)
        place = np.where(targets[own, place] == members, place, count - 1)
        targets[own, place] = targets[:, 0]
        distances[own, place] = distances[:, 0]
        targets[:, 0] = members
        distances[:, 0] = 0.0
        return -(distances**2), targets


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
    everyone = np.arange(len(rows), dtype=np.int32)
    similarities, targets = Neighbours(rows).nearest(everyone, min(neighbours + 1, len(rows)))
    return similarities, targets.astype(np.int64)
