"""Trimming: a closed surface opened where it spans wide holes of the scan."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from meshlab_symrecon.arrays import Booleans, Faces, Indices, Points
from meshlab_symrecon.geometry.surfaces import face_components
from meshlab_symrecon.powercrust.caps import Caps

__all__ = ["Trimmed", "trim"]

DEBRIS = 20  # faces: what a hole leaves of the surface round a stray sample in it


@dataclass(frozen=True, slots=True, eq=False)
class Trimmed:
    """A surface with boundary.

    Attributes
    ----------
    points : (v, 3) float
    faces : (m, 3) int
    vertices : (v,) int
        The number that each point had before; ascending.
    loops : int
        Closed curves that bound the surface.
    opened : int
        Caps that were removed.
    """

    points: Points
    faces: Faces
    vertices: Indices
    loops: int
    opened: int


def trim(points: Points, faces: Faces, caps: Caps, widest: float) -> Trimmed:
    """Remove the caps of holes that are wider than wanted.

    Faces that would hang on by one edge or corner, and scraps, go with them, so that what is left
    is a manifold whose boundary is closed curves.

    Parameters
    ----------
    points : (v, 3) float
    faces : (m, 3) int
        A closed manifold.
    caps : Caps
        Found on it.
    widest : float
        Width of the widest hole that stays closed, in multiples of the spacing of the samples.
    """
    wide = caps.multiples > widest
    kept = ~np.append(wide, False)[caps.region]  # region -1 is none
    across = _faces_across(faces)
    while True:
        fewer = _without_ears(kept, across)
        fewer = _without_bow_ties(faces, fewer, across)
        if wide.any():
            fewer = _without_debris(faces, fewer)
        if np.array_equal(fewer, kept):
            break
        kept = fewer
    used = np.zeros(len(points), dtype=bool)
    used[faces[kept]] = True
    return Trimmed(
        points=points[used],
        faces=(np.cumsum(used) - 1)[faces[kept]],
        vertices=np.flatnonzero(used),
        loops=_loops(faces, kept, across),
        opened=int(np.count_nonzero(wide)),
    )


def _faces_across(faces: Faces) -> Indices:
    """Return (m, 3) the face across the edge from corner k to the next; each edge has two faces."""
    start, end = faces.ravel(), faces[:, [1, 2, 0]].ravel()
    order = np.lexsort([np.maximum(start, end), np.minimum(start, end)])
    across = np.zeros(len(order), dtype=np.int64)
    across[order[0::2]], across[order[1::2]] = order[1::2] // 3, order[0::2] // 3
    return across.reshape(-1, 3)


def _open_edges(kept: Booleans, across: Indices) -> Booleans:
    """Return (m, 3) True for the edges of kept faces whose other face is gone."""
    return kept[:, None] & ~kept[across]


def _without_ears(kept: Booleans, across: Indices) -> Booleans:
    """Drop faces that hang on by one edge, or by none, until there is none."""
    while True:
        ears = _open_edges(kept, across).sum(axis=1) > 1
        if not ears.any():
            return kept
        kept = kept & ~ears


def _without_bow_ties(faces: Faces, kept: Booleans, across: Indices) -> Booleans:
    """Drop all but the largest fan of faces at vertices that have several."""
    face, corner = np.nonzero(_open_edges(kept, across))
    on_boundary = np.zeros(int(faces.max(initial=-1)) + 1, dtype=bool)
    on_boundary[faces[face, corner]] = True
    near = np.flatnonzero(kept & on_boundary[faces].any(axis=1))
    number = np.full(len(faces), -1, dtype=np.int64)
    number[near] = np.arange(len(near))
    # a graph of corners, joined through the edges between faces
    ends, others = [], []
    for k in range(3):
        other = across[near, k]
        inner = np.flatnonzero(kept[other] & (number[other] >= 0))
        for place in (k, (k + 1) % 3):
            vertex = faces[near[inner], place]
            match = faces[other[inner]] == vertex[:, None]
            ends.append(3 * inner + place)
            others.append(3 * number[other[inner]] + match.argmax(axis=1))
    size = 3 * len(near)
    joined = np.concatenate(ends), np.concatenate(others)
    graph = coo_matrix((np.ones(len(joined[0])), joined), shape=(size, size))
    count, fan = connected_components(graph, directed=False)
    vertices = faces[near].ravel()
    vertex_of_fan = np.zeros(count, dtype=np.int64)
    vertex_of_fan[fan] = vertices
    # fans by vertex, the largest of each first
    order = np.lexsort([np.arange(count), -np.bincount(fan, minlength=count), vertex_of_fan])
    surplus = np.zeros(count, dtype=bool)
    surplus[order[1:]] = vertex_of_fan[order[1:]] == vertex_of_fan[order[:-1]]
    surplus &= on_boundary[vertex_of_fan]
    fewer = kept.copy()
    fewer[near[surplus[fan].reshape(-1, 3).any(axis=1)]] = False
    return fewer


def _without_debris(faces: Faces, kept: Booleans) -> Booleans:
    """Drop pieces of a few faces."""
    left = np.flatnonzero(kept)
    count, piece = face_components(faces[left])
    fewer = kept.copy()
    fewer[left[np.bincount(piece, minlength=count)[piece] < DEBRIS]] = False
    return fewer


def _loops(faces: Faces, kept: Booleans, across: Indices) -> int:
    """Return the number of closed curves that the open edges form."""
    face, corner = np.nonzero(_open_edges(kept, across))
    ends = np.stack([faces[face, corner], faces[face, (corner + 1) % 3]])
    vertices, numbers = np.unique(ends, return_inverse=True)
    numbers = numbers.reshape(2, -1)
    graph = coo_matrix((np.ones(len(face)), tuple(numbers)), shape=(len(vertices),) * 2)
    return int(connected_components(graph, directed=False)[0]) if len(face) else 0
