"""Edges and corners of triangle meshes: normals, borders, conflicts, and vertices to be joined."""

from __future__ import annotations

import numpy as np

from meshlab_symrecon.arrays import Booleans, Faces, Indices, Points
from meshlab_symrecon.geometry.places import first_alike
from meshlab_symrecon.geometry.surfaces import face_normals

__all__ = [
    "Edges",
    "unit_rows",
    "vertex_normals",
    "welded",
    "winding_conflicts",
]

CORNERS = 3
TINY = float(np.finfo(np.float64).tiny)


def unit_rows(vectors: Points) -> Points:
    """Scale rows to length one; zero stays zero."""
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    scaled: Points = vectors / np.maximum(lengths, TINY)
    return scaled


def vertex_normals(points: Points, faces: Faces) -> Points:
    """Return (n, 3) unit normals of vertices, means of their faces' weighted by the angles there.

    Vertices without a face that has an area get zeros.
    """
    normals = unit_rows(face_normals(points, faces))
    sums = np.zeros_like(points)
    for corner in range(CORNERS):
        here, after, before = (faces[:, (corner + turn) % CORNERS] for turn in range(CORNERS))
        first, second = points[after] - points[here], points[before] - points[here]
        sines = np.linalg.norm(np.cross(first, second), axis=1)
        angles = np.arctan2(sines, np.einsum("ij,ij->i", first, second))
        for axis in range(3):
            sums[:, axis] += np.bincount(here, angles * normals[:, axis], minlength=len(points))
    return unit_rows(sums)


def welded(points: Points, faces: Faces) -> tuple[Faces, Indices]:
    """Join the vertices of a mesh that coincide to the last bit, as along the seam of a texture.

    Parameters
    ----------
    points : (n, 3) float
    faces : (m, 3) int

    Returns
    -------
    faces : (k, 3) int
        Those that still have three corners, by the first one of the vertices that coincide.
    vertex : (n,) int
        That first vertex of each.
    """
    vertex = first_alike(points)
    joined = vertex[faces]
    whole = (joined != np.roll(joined, 1, axis=1)).all(axis=1)
    return joined[whole], vertex


def winding_conflicts(faces: Faces) -> float:
    """Return the share of the edges with two faces that both run through in the same direction."""
    begins, ends = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    keys = np.minimum(begins, ends) * (int(faces.max(initial=0)) + 1) + np.maximum(begins, ends)
    order = np.argsort(keys, kind="stable")
    starts = np.flatnonzero(np.diff(keys[order], prepend=-1))
    shared = np.diff(starts, append=len(keys)) == 2
    if not shared.any():
        return 0.0
    sums = np.add.reduceat(np.where(begins < ends, 1, -1)[order], starts)
    return float(np.mean(sums[shared] != 0))


class Edges:
    """The half-edges of a mesh, sorted so that those of one edge follow each other."""

    def __init__(self, faces: Faces, vertex_count: int) -> None:
        begins, ends = faces.ravel(), np.roll(faces, -1, axis=1).ravel()  # half-edge 3 f + corner
        self.keys = np.minimum(begins, ends) * vertex_count + np.maximum(begins, ends)
        self.order = np.argsort(self.keys, kind="stable")
        self.sorted_keys = self.keys[self.order]
        self.vertex_count = vertex_count

    def around(self, half_edges: Indices) -> tuple[Indices, Indices]:
        """Return the range, in the order, of all half-edges on the edges of some of them."""
        keys = self.keys[half_edges]
        return (
            np.searchsorted(self.sorted_keys, keys, side="left"),
            np.searchsorted(self.sorted_keys, keys, side="right"),
        )

    def sum_of(self, normals: Points, first: Indices, last: Indices) -> Points:
        """Return sums of the normals of the faces in ranges of the order."""
        sums = np.zeros((len(first), 3))
        for turn in range(int((last - first).max(initial=0))):
            rows = np.flatnonzero(first + turn < last)
            sums[rows] += normals[self.order[first[rows] + turn] // CORNERS]
        return sums

    def rim_vertices(self) -> Booleans:
        """Return (n,) which vertices lie on an edge of a single face."""
        edges, counts = np.unique(self.sorted_keys, return_counts=True)
        rim = np.zeros(self.vertex_count, dtype=bool)
        single = edges[counts == 1]
        rim[single // self.vertex_count] = True
        rim[single % self.vertex_count] = True
        return rim
