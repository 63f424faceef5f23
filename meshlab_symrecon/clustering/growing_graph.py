"""Affinity propagation on a neighbour graph that grows until more edges would change nothing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from meshlab_symrecon.arrays import Booleans, Floats
from meshlab_symrecon.clustering.messages import Propagation, Schedule, propagate_graph
from meshlab_symrecon.clustering.neighbour_graph import Block, joined, nearest

__all__ = ["GROWTH", "Grown", "propagate_neighbours"]

GROWTH = 16  # edges in the end / edges in the beginning, at most


@dataclass(frozen=True, slots=True, eq=False)
class Grown:
    """Where message passing ended, and on what graph."""

    propagation: Propagation
    edges: int  # edges of the last graph
    exact: bool  # the exemplars are those of messages between all points


def propagate_neighbours(
    rows: Floats, preferences: Floats, neighbours: int, schedule: Schedule
) -> Grown:
    """Pass messages between neighbours, as many as it takes to choose as if between all.

    After a run `Propagation.needed` tells which rows lack edges that could have had a say. Those
    get twice as many, and messages start anew, until none lacks any or the graph would have more
    than `GROWTH` times the edges it began with.

    Parameters
    ----------
    rows : (n, d) float
        Positions.
    preferences : (n,) float
        Similarity of each row to itself.
    neighbours : int
        Edges from each row in the beginning, at least 1.
    schedule : Schedule
        Damping and limits.

    Returns
    -------
    Grown
        O(GROWTH n neighbours) memory.
    """
    tree = cKDTree(rows)
    count = min(neighbours + 1, len(rows))
    blocks = [nearest(tree, np.arange(len(rows)), count)]
    most = GROWTH * count * len(rows)
    while True:
        graph = joined(blocks, preferences)
        found = propagate_graph(graph, schedule)
        short = [_lacks_edges(block, found, len(rows)) for block in blocks]
        edges = len(graph.targets)
        if not any(lacks.any() for lacks in short):
            return Grown(found, edges, exact=True)
        added = sum(
            np.count_nonzero(lacks) * (_larger(block, len(rows)) - block.targets.shape[1])
            for block, lacks in zip(blocks, short, strict=True)
        )
        if edges + added > most:
            return Grown(found, edges, exact=False)
        blocks = _grown(tree, blocks, short)


def _larger(block: Block, most: int) -> int:
    return min(2 * block.targets.shape[1], most)


def _lacks_edges(block: Block, found: Propagation, most: int) -> Booleans:
    """Tell which rows miss an edge that may be more similar than needed."""
    if block.targets.shape[1] == most:
        return np.zeros(len(block.members), dtype=bool)
    lacks: Booleans = block.similarities[:, -1] > found.needed[block.members]
    return lacks


def _grown(tree: cKDTree, blocks: list[Block], short: list[Booleans]) -> list[Block]:
    grown = []
    for block, lacks in zip(blocks, short, strict=True):
        if not lacks.all():
            grown.append(Block(*(part[~lacks] for part in block)))
        if lacks.any():
            grown.append(nearest(tree, block.members[lacks], _larger(block, tree.n)))
    return grown
