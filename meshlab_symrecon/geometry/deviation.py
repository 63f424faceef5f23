"""Distances of places to a surface: to the local planes of a cloud, or to a mesh exactly."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from meshlab_symrecon import _native
from meshlab_symrecon.arrays import Booleans, Faces, Floats, Indices, Points
from meshlab_symrecon.geometry.mesh_edges import Edges, unit_rows, vertex_normals
from meshlab_symrecon.geometry.places import nearby_order
from meshlab_symrecon.geometry.surfaces import face_normals

__all__ = [
    "Facing",
    "Heights",
    "TriangleSurface",
    "heights_over_cloud",
    "heights_over_mesh",
]

CORNERS = 3


@dataclass(frozen=True, slots=True)
class Facing:
    """Which parts of a surface count for a place.

    Attributes
    ----------
    least_cosine : float
        Between the normal of the surface and the direction at the place, 0..1. A zero vector, for
        what is not known, is at a right angle to everything: it counts only with 0.
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
        counts, unless ``facing.least_cosine`` is 0.
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
    places: Points, directions: Points, mesh: TriangleSurface, facing: Facing
) -> Heights:
    """Measure places against the closest point of the triangles that face the same way.

    Distances are exact. The sign is that of the angle-weighted pseudonormal at the closest point
    (Baerentzen and Aanaes 2005), which is right on edges and corners too. It also decides which way
    the surface faces there, so that the tip of a needle faces along the needle. At the border of an
    open mesh the height over the plane of its border triangle counts.

    Parameters
    ----------
    places, directions : (m, 3) float
        What is measured, and the unit normal there; zero where it is not known, as above.
    mesh : TriangleSurface
        Its triangles counterclockwise seen from outside.
    facing : Facing
        Which triangles count.
    """
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


def _closest(
    places: Points, directions: Points, surface: tuple[Points, Faces, Points], facing: Facing
) -> tuple[Indices, Floats]:
    """Return the closest face that counts, -1 for none, and the weights of its later corners."""
    order = nearby_order(places)  # a search begins where the last one ended
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


class TriangleSurface:
    """Triangles (k, 3), with the normals of their faces, edges and corners."""

    def __init__(self, points: Points, faces: Faces) -> None:
        self.points, self.faces = points, faces
        self.normals = unit_rows(face_normals(points, faces))
        self.vertex_normals = vertex_normals(points, faces)
        self.edges = Edges(faces, len(points))
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
