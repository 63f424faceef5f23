"""Topology and measure of triangle surfaces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from meshlab_symrecon.arrays import Booleans, Faces, Indices, Points

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
    normals: Points = np.cross(b - a, c - a)
    return normals


def surface_area(points: Points, faces: Faces) -> float:
    """Return the area of a triangle surface, in squared units of the points."""
    return float(0.5 * np.linalg.norm(face_normals(points, faces), axis=1).sum())


def enclosed_volume(points: Points, faces: Faces) -> float:
    """Return the signed volume inside a closed surface; positive when normals point outward."""
    if not len(faces):
        return 0.0
    shifted = points - points[faces[0, 0]]
    return float(np.einsum("ij,ij->", shifted[faces[:, 0]], face_normals(shifted, faces)) / 6.0)


@dataclass(frozen=True, slots=True, eq=False)
class _Sides:
    """The three sides of every face, sorted so that those of one edge stand together.

    Side 3 f + k of face f runs from its corner k to the next one.
    """

    order: Indices  # (3 m,)  sides, edge by edge
    edge: Indices  # (3 m,)  the edge of each of them, counted from 0
    uses: Indices  # (e,)  faces at each edge
    forward: Booleans  # (3 m,)  whether each of them runs from the smaller vertex to the larger


def _sides(faces: Faces) -> _Sides:
    start, end = faces.ravel(), faces[:, [1, 2, 0]].ravel()
    keys = (np.minimum(start, end) << 32) | np.maximum(start, end)
    order = np.argsort(keys, kind="stable")
    edge = np.cumsum(np.diff(keys[order], prepend=-1) != 0) - 1
    uses = np.bincount(edge) if len(edge) else np.zeros(0, dtype=np.int64)
    return _Sides(order, edge, uses, (start < end)[order])


def _pieces(left: Indices, right: Indices, count: int) -> tuple[int, Indices]:
    graph = coo_matrix((np.ones(len(left), dtype=bool), (left, right)), shape=(count, count))
    pieces, piece = connected_components(graph, directed=False)
    return int(pieces), piece.astype(np.int64)


def face_components(faces: Faces) -> tuple[int, Indices]:
    """Return how many pieces the faces form through shared edges, and (m,) the piece of each."""
    if not len(faces):
        return 0, np.zeros(0, dtype=np.int64)
    return _face_pieces(_sides(faces), len(faces))


def _face_pieces(sides: _Sides, count: int) -> tuple[int, Indices]:
    joined = sides.edge[1:] == sides.edge[:-1]
    return _pieces(sides.order[:-1][joined] // 3, sides.order[1:][joined] // 3, count)


def topology(faces: Faces) -> Topology:
    """Return the topology of triangles given by vertex indices.

    Parameters
    ----------
    faces : (m, 3) int
    """
    if not len(faces):
        return Topology(
            closed=False,
            edge_manifold=True,
            vertex_manifold=True,
            oriented=True,
            components=0,
            genus=-1,
            euler=0,
            boundary_edges=0,
            non_manifold_edges=0,
        )
    sides = _sides(faces)
    balance = np.bincount(sides.edge, weights=np.where(sides.forward, 1.0, -1.0))
    boundary = int(np.count_nonzero(sides.uses == 1))
    crowded = int(np.count_nonzero(sides.uses > 2))
    vertices = int(np.count_nonzero(np.bincount(faces.ravel())))
    components, _ = _face_pieces(sides, len(faces))
    euler = vertices - len(sides.uses) + len(faces)
    fans = crowded == 0 and _fan_count(faces, sides) == vertices
    return Topology(
        closed=boundary == 0,
        edge_manifold=crowded == 0,
        vertex_manifold=fans,
        oriented=crowded == 0 and bool((balance[sides.uses == 2] == 0.0).all()),
        components=components,
        genus=components - euler // 2 if boundary == 0 and fans else -1,
        euler=euler,
        boundary_edges=boundary,
        non_manifold_edges=crowded,
    )


def _fan_count(faces: Faces, sides: _Sides) -> int:
    """Return how many fans of faces there are round all vertices together.

    Two corners at one vertex are joined when their faces share an edge there; a surface is a
    manifold at its vertices when there are as many groups of corners as vertices.
    """
    joined = sides.edge[1:] == sides.edge[:-1]
    here, there = sides.order[:-1][joined], sides.order[1:][joined]
    next_corner = np.arange(faces.size).reshape(-1, 3)[:, [1, 2, 0]].ravel()
    start = faces.ravel()
    opposed = start[here] != start[there]
    left = np.concatenate([here, next_corner[here]])
    right = np.concatenate(
        [
            np.where(opposed, next_corner[there], there),
            np.where(opposed, there, next_corner[there]),
        ]
    )
    return _pieces(left, right, faces.size)[0]
