"""What can be drawn: clouds of points, meshes of triangles and translucent planes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from meshlab_symrecon.arrays import (
    Faces,
    Floats,
    Points,
    as_faces,
    as_normals,
    as_planes,
    as_points,
)
from meshlab_symrecon.errors import GeometryError, ParameterError
from meshlab_symrecon.provenance import INVENTED, MEASURED, colours_by_share

__all__ = [
    "INVENTED",
    "MEASURED",
    "PLANE",
    "Colours",
    "Item",
    "PlaneSheet",
    "PointCloud",
    "TriangleMesh",
    "colours_by_share",
    "plane_sheet",
]

Colours: TypeAlias = NDArray[np.uint8]  # (n, 3)  sRGB

PLANE = (214, 120, 84)  # terracotta


def as_colours(values: ArrayLike, count: int) -> Colours:
    """Return a read-only (count, 3) uint8 copy; one colour is given to all.

    Raises
    ------
    ParameterError
        Not one colour or ``count`` colours of three whole numbers from 0 to 255.
    """
    colours = np.asarray(values)
    whole = colours.dtype.kind in "iu" or bool(np.all(colours == np.round(colours)))
    if colours.shape not in {(3,), (count, 3)} or not whole:
        message = (
            f"colours must be one or {count} rows of three whole numbers; got {colours.dtype} of "
            f"shape {colours.shape}; give red, green and blue"
        )
        raise ParameterError(message)
    if colours.size and not (colours.min() >= 0 and colours.max() <= 255):
        message = (
            f"colours must lie in 0 .. 255; got {colours.min()} .. {colours.max()}; "
            "scale them first"
        )
        raise ParameterError(message)
    rows: Colours = np.array(np.broadcast_to(colours, (count, 3)), dtype=np.uint8)
    rows.setflags(write=False)
    return rows


@dataclass(frozen=True, slots=True, eq=False)
class PointCloud:
    """Points, drawn as round discs.

    Parameters
    ----------
    points : (n, 3) float
        Positions.
    colours : (3,) or (n, 3) whole numbers
        sRGB, 0 to 255.
    normals : (n, 3) float, optional
        Outward normals; without them the discs are shaded by the relief that they form together.
    radius : float
        Of a disc, in pixels of the picture.

    Raises
    ------
    GeometryError
        Points or normals of the wrong shape, or not finite.
    ParameterError
        Colours of the wrong shape or range, or a radius that is not positive.
    """

    points: Points
    colours: Colours = MEASURED  # type: ignore[assignment]
    normals: Points | None = None
    radius: float = 2.0

    def __post_init__(self) -> None:
        points = as_points(self.points)
        object.__setattr__(self, "points", points)
        object.__setattr__(self, "colours", as_colours(self.colours, len(points)))
        if self.normals is not None:
            object.__setattr__(self, "normals", as_normals(self.normals, len(points)))
        if not (np.isfinite(self.radius) and self.radius > 0.0):
            message = f"the radius of a disc must be positive; got {self.radius}; give pixels"
            raise ParameterError(message)


@dataclass(frozen=True, slots=True, eq=False)
class TriangleMesh:
    """Triangles, counterclockwise seen from outside; their backs are drawn darker.

    Parameters
    ----------
    points : (n, 3) float
        Vertices.
    faces : (m, 3) int
        Vertex indices.
    colours : (3,) or (n, 3) whole numbers
        sRGB of the vertices, 0 to 255.

    Raises
    ------
    GeometryError
        Points or faces of the wrong shape, not finite or out of range.
    ParameterError
        Colours of the wrong shape or range.
    """

    points: Points
    faces: Faces
    colours: Colours = MEASURED  # type: ignore[assignment]

    def __post_init__(self) -> None:
        points = as_points(self.points)
        object.__setattr__(self, "points", points)
        object.__setattr__(self, "faces", as_faces(self.faces, len(points)))
        object.__setattr__(self, "colours", as_colours(self.colours, len(points)))


@dataclass(frozen=True, slots=True, eq=False)
class PlaneSheet:
    """A translucent parallelogram with a crisp border.

    Parameters
    ----------
    corners : (4, 3) float
        In order round the sheet; the fourth closes the parallelogram of the first three.
    colour : three whole numbers
        sRGB, 0 to 255.
    opacity : float
        Of the sheet between its borders, 0 to 1.
    border : float
        Width of the border and of the line in which the sheet cuts the object, in pixels.

    Raises
    ------
    GeometryError
        Not four corners of a parallelogram.
    ParameterError
        A colour, opacity or border out of range.
    """

    corners: Points
    colour: tuple[int, int, int] = PLANE
    opacity: float = 0.28
    border: float = 2.0

    def __post_init__(self) -> None:
        corners = as_points(self.corners)
        object.__setattr__(self, "corners", corners)
        if len(corners) != 4:
            message = f"a plane sheet has four corners; got {len(corners)}; use plane_sheet()"
            raise GeometryError(message)
        gap = np.abs(corners[0] - corners[1] + corners[2] - corners[3]).max()
        if not gap <= 1e-6 * np.ptp(corners, axis=0).max():
            message = f"a plane sheet is a parallelogram; got {corners.tolist()}; use plane_sheet()"
            raise GeometryError(message)
        as_colours(self.colour, 1)
        if not (0.0 <= self.opacity <= 1.0 and 0.0 <= self.border < np.inf):
            message = (
                "opacity must lie in 0 .. 1 and border must not be negative; got "
                f"{self.opacity} and {self.border}; correct them"
            )
            raise ParameterError(message)


Item: TypeAlias = PointCloud | TriangleMesh | PlaneSheet


def plane_sheet(
    plane: ArrayLike, points: Points, up: ArrayLike, margin: float = 0.04
) -> PlaneSheet:
    """Cut a sheet out of a plane, upright and large enough for the points.

    Parameters
    ----------
    plane : (4,) float
        ``Ax + By + Cz + D = 0``.
    points : (n, 3) float
        What the sheet must span.
    up : (3,) float
        Two borders run along this, as nearly as the plane allows.
    margin : float
        How far the sheet stands out, as a share of its longer side.

    Raises
    ------
    GeometryError
        A plane without normal, no points, or an ``up`` along the normal.
    """
    normal, offset = np.split(as_planes(np.asarray(plane)[None])[0], [3])
    cloud = as_points(points, minimum=1)
    upward = np.asarray(up, dtype=float) - (np.asarray(up, dtype=float) @ normal) * normal
    length = np.linalg.norm(upward)
    if not length > 1e-9 * np.linalg.norm(up):
        message = f"up must not run along the plane's normal; got {up!r}; give another direction"
        raise GeometryError(message)
    axes = np.array([np.cross(upward / length, normal), upward / length])
    seen = cloud @ axes.T
    room = margin * np.ptp(seen, axis=0).max()
    low, high = seen.min(axis=0) - room, seen.max(axis=0) + room
    ring = np.array([low, [high[0], low[1]], high, [low[0], high[1]]])
    return PlaneSheet(ring @ axes - offset * normal)
