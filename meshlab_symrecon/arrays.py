"""Array aliases, and the checks that every array passes at the border of the package."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from meshlab_symrecon.errors import GeometryError

__all__ = [
    "Booleans",
    "Faces",
    "Floats",
    "Indices",
    "Planes",
    "Points",
    "as_faces",
    "as_normals",
    "as_planes",
    "as_points",
    "as_scalars",
]

LARGEST_NORMAL = 1e60  # only directions count: squares and cubes of lengths stay within floats

Floats: TypeAlias = NDArray[np.float64]
Indices: TypeAlias = NDArray[np.int64]
Booleans: TypeAlias = NDArray[np.bool_]
Points: TypeAlias = NDArray[np.float64]  # (n, 3)
Faces: TypeAlias = NDArray[np.int64]  # (m, 3)
Planes: TypeAlias = NDArray[np.float64]  # (k, 4)  unit normal A, B, C and offset D


def _as_floats(values: ArrayLike, what: str, shape: str) -> Floats:
    if _is_sealed(values):
        return np.asarray(values)
    try:
        return np.array(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        message = f"{what} must be numbers in an array of shape {shape}; got {values!r:.60}"
        raise GeometryError(message) from error


def _is_sealed(values: ArrayLike) -> bool:
    """Tell whether an array can be passed on as it is: nobody writes to it, or to what is below."""
    return (
        type(values) is np.ndarray
        and values.dtype == np.float64
        and values.flags.owndata
        and not values.flags.writeable
    )


def _check_finite(values: Floats, what: str, unit: str) -> None:
    if not np.isfinite(values).all():
        finite = np.isfinite(values).all(axis=tuple(range(1, values.ndim)))
        message = (
            f"{what} must be finite; got {np.count_nonzero(~finite)} {unit} with NaN or infinity, "
            f"the first at index {np.argmin(finite)}; remove them first"
        )
        raise GeometryError(message)


def _as_rows(values: ArrayLike, width: int, what: str) -> Floats:
    rows = _as_floats(values, what, f"(n, {width})")
    if rows.size == 0:
        rows = rows.reshape(0, width)
    if rows.ndim != 2 or rows.shape[1] != width:
        message = f"{what} must have shape (n, {width}); got {rows.shape}; reshape the array"
        raise GeometryError(message)
    _check_finite(rows, what, "rows")
    rows.setflags(write=False)
    return rows


def as_points(values: ArrayLike, minimum: int = 0) -> Points:
    """Return a read-only (n, 3) float64 copy of finite positions.

    An array of such numbers that is read-only already is returned itself.

    Raises
    ------
    GeometryError
        Wrong shape, a coordinate that is not finite, or fewer than ``minimum`` points.
    """
    points = _as_rows(values, 3, "points")
    if len(points) < minimum:
        message = f"at least {minimum} points are needed; got {len(points)}; load a fuller scan"
        raise GeometryError(message)
    return points


def as_normals(values: ArrayLike, count: int) -> Points:
    """Return a read-only (count, 3) float64 copy of finite normals, one for each point.

    An array of such numbers that is read-only already is returned itself.

    Raises
    ------
    GeometryError
        Wrong shape or count, or a component that is not finite or beyond `LARGEST_NORMAL`.
    """
    normals = _as_rows(values, 3, "normals")
    if len(normals) != count:
        message = f"{count} normals are needed, one a point; got {len(normals)}; estimate them anew"
        raise GeometryError(message)
    largest = float(np.abs(normals).max(initial=0.0))
    if largest > LARGEST_NORMAL:
        message = (
            f"normals must be no longer than {LARGEST_NORMAL:g}; got {largest:.3g}; "
            "scale them to unit length"
        )
        raise GeometryError(message)
    return normals


def as_scalars(values: ArrayLike, count: int, what: str) -> Floats:
    """Return a read-only (count,) float64 copy of finite numbers, one for each point.

    An array of such numbers that is read-only already is returned itself.

    ``what`` they are is the subject of the error's sentence, such as ``weights``.

    Raises
    ------
    GeometryError
        Wrong shape or count, or a number that is not finite.
    """
    scalars = _as_floats(values, what, f"({count},)")
    if scalars.shape != (count,):
        message = (
            f"{what} must have shape ({count},), one a point; got {scalars.shape}; "
            "take them from the same step as the points"
        )
        raise GeometryError(message)
    _check_finite(scalars, what, "values")
    scalars.setflags(write=False)
    return scalars


def as_planes(values: ArrayLike) -> Planes:
    """Return a read-only (k, 4) copy of planes ``Ax + By + Cz + D = 0``, scaled to unit normals.

    Raises
    ------
    GeometryError
        Wrong shape, a coefficient that is not finite, or a normal of zero length.
    """
    rows = _as_rows(values, 4, "planes")
    lengths = np.linalg.norm(rows[:, :3], axis=1, keepdims=True)
    if not (lengths > 0.0).all():
        message = (
            f"planes need a normal (A, B, C) that is not zero; got {rows[np.argmin(lengths)]}; "
            "give the direction in which the plane faces"
        )
        raise GeometryError(message)
    planes: Planes = rows / lengths
    planes.setflags(write=False)
    return planes


def as_faces(values: ArrayLike, vertex_count: int) -> Faces:
    """Return a read-only (m, 3) int64 copy of triangles whose indices are all in range.

    Raises
    ------
    GeometryError
        Wrong shape, indices that are not whole numbers, or out of ``0 .. vertex_count - 1``.
    """
    rows = _as_rows(values, 3, "faces")
    faces = rows.astype(np.int64)
    if not np.array_equal(faces, rows):
        raise GeometryError("faces must be whole vertex indices; got fractions; pass integers")
    if faces.size and (faces.min() < 0 or faces.max() >= vertex_count):
        message = (
            f"face indices must lie in 0 .. {vertex_count - 1}; "
            f"got {faces.min()} .. {faces.max()}; repair the mesh first"
        )
        raise GeometryError(message)
    faces.setflags(write=False)
    return faces
