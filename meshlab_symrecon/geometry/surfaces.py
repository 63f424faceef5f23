"""Topology and measure of triangle surfaces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from meshlab_symrecon import _native
from meshlab_symrecon.arrays import Faces, Indices, Points

__all__ = [
    "Topology",
    "enclosed_volume",
    "face_components",
    "face_normals",
    "surface_area",
    "topology",
]


@dataclass(frozen=True, slots=True)
class Topology:
    """What kind of surface a set of triangles is.

    Attributes
    ----------
    closed : bool
        No boundary edge, and at least one face.
    edge_manifold, vertex_manifold : bool
        Every edge has at most two faces; the faces round every vertex form one fan.
    oriented : bool
        Faces that share an edge run through it in opposite directions.
    components : int
        Pieces connected through edges.
    genus : int
        Number of handles, summed over the pieces; -1 unless closed and manifold.
    euler : int
        Vertices used - edges + faces.
    boundary_edges, non_manifold_edges : int
    """

    closed: bool
    edge_manifold: bool
    vertex_manifold: bool
    oriented: bool
    components: int
    genus: int
    euler: int
    boundary_edges: int
    non_manifold_edges: int


def face_normals(points: Points, faces: Faces) -> Points:
    """Return (m, 3) normals of triangles, as long as twice the triangle's area."""
    a, b, c = (points[faces[:, corner]] for corner in range(3))
    return np.asarray(np.cross(b - a, c - a), dtype=np.float64)


def surface_area(points: Points, faces: Faces) -> float:
    """Return the area of a triangle surface, in squared units of the points."""
    return float(0.5 * np.linalg.norm(face_normals(points, faces), axis=1).sum())


def enclosed_volume(points: Points, faces: Faces) -> float:
    """Return the signed volume inside a closed surface; positive when normals point outward."""
    if not len(faces):
        return 0.0
    shifted = points - points[faces[0, 0]]
    return float(np.einsum("ij,ij->", shifted[faces[:, 0]], face_normals(shifted, faces)) / 6.0)


def face_components(faces: Faces) -> tuple[int, Indices]:
    """Return how many pieces the faces form through shared edges, and (m,) the piece of each."""
    *_, count, piece = _counted(faces)
    return count, piece.astype(np.int64)


def topology(faces: Faces) -> Topology:
    """Return the topology of triangles given by vertex indices.

    Parameters
    ----------
    faces : (m, 3) int
    """
    vertices, edges, boundary, crowded, misoriented, fans, components, _ = _counted(faces)
    euler = vertices - edges + len(faces)
    closed = boundary == 0 and len(faces) > 0
    manifold = crowded == 0 and fans == vertices
    return Topology(
        closed=closed,
        edge_manifold=crowded == 0,
        vertex_manifold=manifold,
        oriented=crowded == 0 and misoriented == 0,
        components=components,
        genus=components - euler // 2 if closed and manifold else -1,
        euler=euler,
        boundary_edges=boundary,
        non_manifold_edges=crowded,
    )


def _counted(faces: Faces) -> tuple[int, int, int, int, int, int, int, NDArray[np.int32]]:
    count = int(faces.max()) + 1 if len(faces) else 0
    return _native.surface_topology(np.ascontiguousarray(faces, dtype=np.int32), count)
