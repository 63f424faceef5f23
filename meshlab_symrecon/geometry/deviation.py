"""Distances of places to a surface: to the local planes of a cloud, or to a mesh exactly."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from meshlab_symrecon import _native
from meshlab_symrecon.arrays import Booleans, Faces, Floats, Indices, Points
from meshlab_symrecon.geometry.sampling import canonical_order
from meshlab_symrecon.geometry.surfaces import face_normals

__all__ = [
    "Facing",
    "Heights",
    "first_alike",
    "heights_over_cloud",
    "heights_over_mesh",
    "unit_rows",
    "vertex_normals",
    "welded",
]

CORNERS = 3
TINY = float(np.finfo(np.float64).tiny)


@dataclass(frozen=True, slots=True)
class Facing:
    """Which parts of a surface count for a place.

    Attributes
    ----------
    least_cosine : float
        Between the normal of the surface and the direction at the place.
    sided : bool
        The normals tell outside from inside; otherwise only their axes are compared.
    within : float
        Farther parts do not count; in the units of the points.
    """

    least_cosine: float = 0.0
    sided: bool = True
    within: float = np.inf


@dataclass(frozen=True, slots=True, eq=False)
class Heights:
    """How places lie over a surface, in the units of the points; zeros where nothing counts."""

    nearest: Indices  # (m,)  sample of the cloud or face of the mesh, -1 where none counts
    heights: Floats  # (m,)  signed distance, positive on the side that the normal faces
    aside: Floats  # (m,)  how far the place lies off to the side of what it is measured against
    on_rim: Booleans  # (m,)  measured against the border of an open mesh


def heights_over_cloud(
    places: Points, directions: Points, points: Points, normals: Points, facing: Facing
) -> Heights:
    """Measure places against the tangent plane of the nearest sample that faces the same way.

    The error is second order in the spacing of the samples: half the curvature times the square of
    ``aside``.

    Parameters
    ----------
    places, directions : (m, 3) float
        What is measured, and the unit normal there; zero where it is not known: then nothing
        counts.
    points, normals : (n, 3) float
        Samples of the surface and their unit normals.
    facing : Facing
        Which samples count.
    """
    corners = np.repeat(np.arange(len(points)), CORNERS).reshape(-1, CORNERS)
    nearest, _ = _closest(places, directions, (points, corners, normals), facing)
    known = nearest >= 0
    offsets = np.where(known[:, np.newaxis], places - points[nearest], 0.0)
    heights = np.einsum("ij,ij->i", offsets, normals[nearest])
    nowhere = np.zeros(len(places), dtype=np.bool_)
    return Heights(nearest, heights, _aside(offsets, heights), nowhere)


def heights_over_mesh(
    places: Points, directions: Points, points: Points, faces: Faces, facing: Facing
) -> Heights:
    """Measure places against the closest point of the triangles that face the same way.

    Distances are exact. The sign is that of the angle-weighted pseudonormal at the closest point
    (Baerentzen and Aanaes 2005), which is right on edges and corners too. It also decides which way
    the surface faces there, so that the tip of a needle faces along the needle. At the border of an
    open mesh the height over the plane of its border triangle counts.

    Parameters
    ----------
    places, directions : (m, 3) float
        What is measured, and the unit normal there; zero where it is not known.
    points : (n, 3) float
    faces : (k, 3) int
        Counterclockwise seen from outside.
    facing : Facing
        Which triangles count.
    """
    mesh = _Mesh(points, faces)
    anyhow = Facing(0.0, facing.sided, facing.within)
    found = mesh.feet(places, directions, anyhow)
    cosines = np.einsum("ij,ij->i", found.normals, directions)
    if not facing.sided:
        cosines = np.abs(cosines)
    turned = np.flatnonzero((found.faces >= 0) & (cosines < facing.least_cosine))
    if len(turned):
        found.replace(turned, mesh.feet(places[turned], directions[turned], facing))
    known = found.faces >= 0
    offsets = np.where(known[:, np.newaxis], places - found.places, 0.0)
    along = np.einsum("ij,ij->i", offsets, found.normals)
    over_plane = np.einsum("ij,ij->i", offsets, mesh.normals[found.faces])
    upright = np.where(found.on_rim, over_plane, along)
    distances = np.copysign(np.linalg.norm(offsets, axis=1), along)
    heights = np.where(found.on_rim, over_plane, distances)
    return Heights(
        found.faces, np.where(known, heights, 0.0), _aside(offsets, upright), found.on_rim
    )


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


def first_alike(points: Points) -> Indices:
    """Return (n,) the first point, by index, that is in the same place as each point."""
    order = canonical_order(points)
    steps = (points[order[1:]] != points[order[:-1]]).any(axis=1)
    starts = np.flatnonzero(np.append(True, steps))
    first: Indices = np.zeros(len(points), dtype=np.int64)
    least = np.minimum.reduceat(order, starts)
    first[order] = np.repeat(least, np.diff(starts, append=len(order)))
    return first


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


def _closest(
    places: Points, directions: Points, surface: tuple[Points, Faces, Points], facing: Facing
) -> tuple[Indices, Floats]:
    """Return the closest face that counts, -1 for none, and the weights of its later corners."""
    order = _nearby_order(places)
    points, faces, normals = surface
    found, shares = _native.closest_faces(
        np.ascontiguousarray(points),
        np.ascontiguousarray(faces, dtype=np.int32),
        np.ascontiguousarray(normals),
        places[order],
        directions[order],
        facing.least_cosine,
        facing.sided,
        facing.within,
    )
    nearest: Indices = np.zeros(len(places), dtype=np.int64)
    weights = np.zeros((len(places), 2))
    nearest[order], weights[order] = found, shares
    return nearest, weights


def _nearby_order(places: Points) -> Indices:
    """Order places so that the next one is near: a search begins where the last one ended."""
    order = _native.curve_order(np.ascontiguousarray(places)).astype(np.int64)
    if len(order) == len(places):
        return order
    left_out = np.ones(len(places), dtype=bool)  # a place that repeats an earlier one
    left_out[order] = False
    return np.concatenate([order, np.flatnonzero(left_out)])


def _aside(offsets: Points, heights: Floats) -> Floats:
    across: Floats = np.maximum(np.einsum("ij,ij->i", offsets, offsets) - heights**2, 0.0)
    return np.sqrt(across)


@dataclass(frozen=True, slots=True, eq=False)
class _Feet:
    """Closest points of a mesh; faces are -1, and the rest means nothing, where none counts."""

    faces: Indices  # (m,)
    places: Points  # (m, 3)
    normals: Points  # (m, 3)  pseudonormals
    on_rim: Booleans  # (m,)

    def replace(self, rows: Indices, others: _Feet) -> None:
        """Put others in the place of some."""
        for mine, new in zip(self._arrays(), others._arrays(), strict=True):
            mine[rows] = new

    def _arrays(self) -> tuple[NDArray[Any], ...]:
        return self.faces, self.places, self.normals, self.on_rim


class _Mesh:
    """Triangles, with the normals of their faces, edges and corners."""

    def __init__(self, points: Points, faces: Faces) -> None:
        self.points, self.faces = points, faces
        self.normals = unit_rows(face_normals(points, faces))
        self.vertex_normals = vertex_normals(points, faces)
        self.edges = _Edges(faces, len(points))
        self.rim_vertices = self.edges.rim_vertices()

    def feet(self, places: Points, directions: Points, facing: Facing) -> _Feet:
        """Return the closest points of the faces that count."""
        surface = (self.points, self.faces, self.normals)
        face, weights = _closest(places, directions, surface, facing)
        corners = self.points[self.faces[face]]
        shares = np.column_stack([1.0 - weights.sum(axis=1), weights])
        feet = corners[:, 0] + np.einsum("mw,mwi->mi", weights, corners[:, 1:] - corners[:, :1])
        normals, on_rim = self._at_feet(face, shares)
        return _Feet(face, feet, normals, on_rim & (face >= 0))

    def _at_feet(self, face: Indices, shares: Floats) -> tuple[Points, Booleans]:
        """Return pseudonormals of the closest points, and which lie on the border."""
        away = (shares <= 0.0).sum(axis=1)  # corners: 0 within the face, 1 on an edge, 2 at one
        normals = self.normals[face]
        on_rim = np.zeros(len(face), dtype=bool)
        on_edge = np.flatnonzero(away == 1)
        off_corner = np.argmin(shares[on_edge], axis=1)
        first, last = self.edges.around(CORNERS * face[on_edge] + (off_corner + 1) % CORNERS)
        normals[on_edge] = unit_rows(self.edges.sum_of(self.normals, first, last))
        on_rim[on_edge] = last - first == 1
        at_corner = np.flatnonzero(away == 2)
        vertices = self.faces[face[at_corner], np.argmax(shares[at_corner], axis=1)]
        normals[at_corner] = self.vertex_normals[vertices]
        on_rim[at_corner] = self.rim_vertices[vertices]
        return normals, on_rim


class _Edges:
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
