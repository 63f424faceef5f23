"""What a scan is compared with where its mirror image falls on it: the surface there, if any.

Lengths are in diagonals of the scan, areas in their squares.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from meshlab_symrecon.arrays import Booleans, Faces, Floats, Indices, Points
from meshlab_symrecon.errors import GeometryError
from meshlab_symrecon.geometry.deviation import (
    Facing,
    Heights,
    TriangleSurface,
    heights_over_cloud,
    heights_over_mesh,
)
from meshlab_symrecon.geometry.local_planes import local_planes
from meshlab_symrecon.geometry.mesh_edges import winding_conflicts
from meshlab_symrecon.geometry.planes import reflect, reflect_directions
from meshlab_symrecon.geometry.surfaces import enclosed_volume, face_normals, topology
from meshlab_symrecon.symmetry.sides import CONSISTENT, agreement_with_shape, outward_normals

__all__ = ["Measured", "over_cloud", "over_mesh"]

FACING = 0.5  # cosine of 60 degrees, between normals that face the same way
REACH_SPACINGS = 2.5  # off to the side of the nearest sample, an image is over a hole
SPACING_RANGE = (0.5, 2.0)  # medians: between them the spacing of a point is believed
RIM_REACH = 0.005  # off to the side of the border of a mesh, an image is over a hole
FEW_CONFLICTS = 0.02  # share of edges of a mesh whose faces may contradict each other
SLANT = 0.36  # tangent of 20 degrees: farther from the surface, that much more to the side
LEAST_AREA = 1e-14  # twice: below it, the area of a triangle is rounding
STEEP_SLANT = 1.73  # tangent of 60 degrees: over an edge of a mesh, places lie off to its side

Measured: TypeAlias = tuple[Floats, Booleans, bool]  # heights, which of them count, are signed


def over_cloud(
    points: Points, distinct: tuple[Indices, Indices], given: Points | None, farthest: float
) -> Callable[[Indices, Floats], Measured]:
    """Return what measures rows of a cloud against its mirror image across a plane.

    Parameters
    ----------
    points : (n, 3) float
        In their own frame, of unit diagonal.
    distinct : two arrays of int
        One point of each place, and the place of each point.
    given : (n, 3) float or None
        Normals; only their sides are used.
    farthest : float
        Where a counterpart is sought.
    """
    chosen, sample = distinct
    samples = points[chosen]
    planes = local_planes(samples)
    hints = None if given is None else given[chosen]
    normals, sided = outward_normals(samples, planes.normals, hints)
    low, high = (factor * float(np.median(planes.spacing)) for factor in SPACING_RANGE)
    reach = REACH_SPACINGS * np.clip(planes.spacing, low, high)
    facing = Facing(FACING, sided, farthest)

    def measure(rows: Indices, plane: Floats) -> Measured:
        images = reflect(points[rows], plane)
        directions = reflect_directions(normals[sample[rows]], plane)
        found = heights_over_cloud(images, directions, samples, normals, facing)
        over = found.aside <= np.maximum(reach[found.nearest], SLANT * np.abs(found.heights))
        return _signed(found, over, sided)

    return measure


def over_mesh(
    points: Points, joined: tuple[Faces, Indices], farthest: float
) -> Callable[[Indices, Floats], Measured]:
    """Return what measures vertices of a mesh against its mirror image across a plane.

    Parameters
    ----------
    points : (n, 3) float
        In their own frame, of unit diagonal.
    joined : (m, 3) int, (n,) int
        Faces with vertices that coincide joined, and the vertex that stands for each point.
    farthest : float
        Where a counterpart is sought.

    Raises
    ------
    GeometryError
        No face has an area.
    """
    faces, vertex = joined
    if np.linalg.norm(face_normals(points, faces), axis=1).max(initial=0.0) < LEAST_AREA:
        message = (
            "mirror deviation needs faces with an area; got none, once vertices that coincide are "
            "joined; leave the faces out to measure the points as a cloud"
        )
        raise GeometryError(message)
    surface = TriangleSurface(points, faces)
    outwards = _winding(points, surface.vertex_normals, faces)
    sided = outwards != 0
    if outwards < 0:
        surface = TriangleSurface(points, faces[:, ::-1])
    facing = Facing(FACING, sided, farthest)

    def measure(rows: Indices, plane: Floats) -> Measured:
        directions = reflect_directions(surface.vertex_normals[vertex[rows]], plane)
        found = heights_over_mesh(reflect(points[rows], plane), directions, surface, facing)
        slant = np.where(found.on_rim, SLANT, STEEP_SLANT)
        over = found.aside <= np.maximum(RIM_REACH, slant * np.abs(found.heights))
        return _signed(found, over, sided)

    return measure


def _winding(points: Points, normals: Points, faces: Faces) -> int:
    """Return 1 when the faces of a mesh face outwards, -1 when inwards, 0 when they contradict.

    The volume tells it of a closed mesh; the winding of an open one is believed unless its shape
    speaks clearly against it.
    """
    shape = topology(faces)
    if shape.closed and shape.oriented:
        return 1 if enclosed_volume(points, faces) >= 0.0 else -1
    used = np.unique(faces)
    agreement = agreement_with_shape(points[used], normals[used])
    if agreement is not None and agreement <= 1.0 - CONSISTENT:
        return -1
    agrees = agreement is not None and agreement >= CONSISTENT
    return 1 if agrees or winding_conflicts(faces) <= FEW_CONFLICTS else 0


def _signed(found: Heights, over: Booleans, sided: bool) -> Measured:
    heights = found.heights if sided else np.abs(found.heights)
    return heights, over & (found.nearest >= 0), sided
