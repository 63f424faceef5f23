"""Nearest-neighbour graphs with negative squared distances as similarities."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from meshlab_symrecon.arrays import Floats, Indices

__all__ = ["Block", "NeighbourGraph", "edges_of_rows", "joined", "nearest", "neighbour_graph"]


@dataclass(frozen=True, slots=True, eq=False)
class NeighbourGraph:
    """Edges in rows of any length, each beginning with the edge of the row to itself."""

    offsets: Indices  # (n + 1,)  edges of row i are offsets[i] .. offsets[i + 1] - 1
    targets: NDArray[np.int32]  # (e,)  where each edge ends
    similarities: Floats  # (e,)  those to itself are the preferences


class Block(NamedTuple):
    """Edges of some rows that have equally many, by falling similarity after the own one."""

    members: Indices  # (m,)  the rows
    similarities: Floats  # (m, k)
    targets: NDArray[np.int32]  # (m, k)


def nearest(tree: cKDTree, members: Indices, count: int) -> Block:
    """Connect rows with themselves, which comes first, and with their nearest other rows.

    Parameters
    ----------
    tree : cKDTree
        All rows.
    members : (m,) int
        Those to connect.
    count : int
        Edges of each, the one to itself included; at most all rows.

    Returns
    -------
    Block
        Negative squared distances, 0 to itself.
    """
    distances, targets = tree.query(tree.data[members], k=count)
    distances = distances.reshape(len(members), count)
    targets = targets.reshape(len(members), count).astype(np.int32)
    own = np.arange(len(members))
    # Among duplicates the row itself may come later, or not at all: move it to the front.
    place = np.argmax(targets == members[:, np.newaxis], axis=1)
    present = targets[own, place] == members
    place = np.where(present, place, count - 1)
    targets[own, place] = targets[:, 0]
    distances[own, place] = distances[:, 0]
    targets[:, 0] = members
    distances[:, 0] = 0.0
    return Block(members, -(distances**2), targets)


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
    everyone = np.arange(len(rows))
    block = nearest(cKDTree(rows), everyone, min(neighbours + 1, len(rows)))
    return block.similarities, block.targets.astype(np.int64)


def edges_of_rows(similarities: Floats, targets: Indices) -> NeighbourGraph:
    """Return (n, k) edges as a graph, without those whose similarity is minus infinity."""
    present = similarities > -np.inf
    offsets = np.concatenate([[0], np.cumsum(np.count_nonzero(present, axis=1))])
    return NeighbourGraph(offsets, targets[present].astype(np.int32), similarities[present])


def joined(blocks: list[Block], preferences: Floats) -> NeighbourGraph:
    """Return the graph of all rows, each in one of the blocks."""
    sizes = np.zeros(len(preferences), dtype=np.int64)
    for block in blocks:
        sizes[block.members] = block.targets.shape[1]
    offsets = np.concatenate([[0], np.cumsum(sizes)])
    targets = np.zeros(offsets[-1], dtype=np.int32)
    similarities = np.zeros(offsets[-1])
    for block in blocks:
        places = offsets[block.members, np.newaxis] + np.arange(block.targets.shape[1])
        targets[places] = block.targets
        similarities[places] = block.similarities
    similarities[offsets[:-1]] = preferences
    return NeighbourGraph(offsets, targets, similarities)
