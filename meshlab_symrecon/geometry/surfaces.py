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


def face_components(faces: Faces) -> tuple[int, Indices]:
    """Return how many pieces the faces form through shared edges, and (m,) the piece of each."""
    if not len(faces):
        return 0, np.zeros(0, dtype=np.int64)
    keys, owners = _edges(faces)[:2]
    order = np.argsort(keys, kind="stable")
    same = keys[order][1:] == keys[order][:-1]
    left, right = owners[order][:-1][same], owners[order][1:][same]
    graph = coo_matrix((np.ones(len(left)), (left, right)), shape=(len(faces), len(faces)))
    count, labels = connected_components(graph, directed=False)
    return int(count), labels.astype(np.int64)


def topology(faces: Faces) -> Topology:
    """Return the topology of triangles given by vertex indices.

    Parameters
    ----------
    faces : (m, 3) int
    """
    keys, _, forward = _edges(faces)
    unique, inverse, uses = np.unique(keys, return_inverse=True, return_counts=True)
    balance = np.bincount(inverse, weights=np.where(forward, 1.0, -1.0), minlength=len(unique))
    boundary = int(np.count_nonzero(uses == 1))
    crowded = int(np.count_nonzero(uses > 2))
    components, _ = face_components(faces)
    vertices = int(len(np.unique(faces)))
    euler = vertices - len(unique) + len(faces)
    closed = boundary == 0 and len(faces) > 0
    fans = bool(crowded == 0 and len(faces) > 0 and _single_fans(faces))
    genus = components - euler // 2 if closed and crowded == 0 and fans else -1
    oriented = bool((balance[uses == 2] == 0.0).all()) and crowded == 0
    return Topology(
        closed, crowded == 0, fans, oriented, components, genus, euler, boundary, crowded
    )


def _edges(faces: Faces) -> tuple[Indices, Indices, Booleans]:
    """Return a key, the face and the direction of every side of every face."""
    start = faces.ravel()
    end = faces[:, [1, 2, 0]].ravel()
    keys = (np.minimum(start, end) << 32) | np.maximum(start, end)
    return keys, np.repeat(np.arange(len(faces)), 3), start < end


def _single_fans(faces: Faces) -> bool:
    """Tell whether the corners at every vertex hang together through edges.

    A corner is (face, vertex).  Two corners at one vertex are joined when their faces share an
    edge at that vertex, so the surface is a manifold at its vertices when there are as many
    groups of corners as vertices.
    """
    corners = np.arange(3 * len(faces)).reshape(-1, 3)
    start, end = faces, faces[:, [1, 2, 0]]
    low = np.where(start < end, corners, corners[:, [1, 2, 0]]).ravel()
    high = np.where(start < end, corners[:, [1, 2, 0]], corners).ravel()
    keys = ((np.minimum(start, end) << 32) | np.maximum(start, end)).ravel()
    order = np.argsort(keys, kind="stable")
    same = keys[order][1:] == keys[order][:-1]
    here, there = order[:-1][same], order[1:][same]
    left = np.concatenate([low[here], high[here]])
    right = np.concatenate([low[there], high[there]])
    graph = coo_matrix((np.ones(len(left)), (left, right)), shape=(corners.size, corners.size))
    groups, _ = connected_components(graph, directed=False)
    return bool(groups == len(np.unique(faces)))
