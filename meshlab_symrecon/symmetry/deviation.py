"""How far a scan is from its own mirror image: wear, repairs and asymmetry."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from meshlab_symrecon.arrays import (
    Booleans,
    Floats,
    Indices,
    Points,
    as_faces,
    as_normals,
    as_planes,
    as_points,
)
from meshlab_symrecon.errors import GeometryError, ParameterError
from meshlab_symrecon.geometry.bounds import box_diagonal, require_solid, robust_diagonal
from meshlab_symrecon.geometry.mesh_edges import welded
from meshlab_symrecon.geometry.places import distinct_places
from meshlab_symrecon.geometry.sampling import principal_frame
from meshlab_symrecon.one_thread import in_one_thread
from meshlab_symrecon.symmetry.counterparts import over_cloud, over_mesh
from meshlab_symrecon.symmetry.progress import Progress, silent

__all__ = ["FARTHEST", "TOLERANCE", "MirrorDeviation", "mirror_deviation"]

# In diagonals of the scan.
TOLERANCE = 0.005  # what counts as symmetric
FARTHEST = 0.05  # a surface farther from the mirror image is another part, not its counterpart


@dataclass(frozen=True, slots=True, eq=False)
class MirrorDeviation:
    """Distances of the points of a scan to its mirror image, in the units of the points.

    The summary is over the points that have a counterpart; NaN when none has.
    """

    distances: Floats  # (n,)  positive outside the mirror image; 0 without counterpart
    has_counterpart: Booleans  # (n,)  False: nothing was measured where the mirror image falls
    signed: bool  # False: inside and outside could not be told; no distance is negative
    tolerance: float
    median: float  # of the absolute distances
    percentile_95: float  # of the absolute distances
    rms: float
    share_within: float  # share of the points that are within the tolerance


@in_one_thread
def mirror_deviation(  # noqa: PLR0913  # the scan, and what counts
    points: ArrayLike,
    plane: ArrayLike,
    faces: ArrayLike | None = None,
    normals: ArrayLike | None = None,
    *,
    chosen: ArrayLike | None = None,
    tolerance: float = TOLERANCE,
    farthest: float = FARTHEST,
    progress: Progress | None = None,
) -> MirrorDeviation:
    """Measure how far each point of a scan is from the scan's own mirror image.

    The mirror image of each point is measured against the surface that faces the same way as it
    does: exactly for a mesh, against the tangent plane of the nearest sample for a cloud. Since a
    reflection keeps lengths, this is the distance of the point to the mirrored surface.

    A point has no counterpart where its image falls into a hole or beyond a rim, and where what
    lies there is farther than ``farthest`` or faces another way: a missing part is not wear.

    Parameters
    ----------
    points : (n, 3) float
    plane : (4,) float
        ``Ax + By + Cz + D = 0``.
    faces : (m, 3) int, optional
        Triangles, counterclockwise seen from outside; without them the points are a cloud.
    normals : (n, 3) float, optional
        Of a cloud. Only their sides are used, unless they contradict each other or the shape.
    chosen : (n,) bool, optional
        Measure these points only; the others get 0 and no counterpart.
    tolerance : float
        What counts as symmetric, in diagonals of the scan.
    farthest : float
        Where a counterpart is sought, in diagonals.
    progress : callable, optional
        Called with a fraction and a message.

    Raises
    ------
    GeometryError
        Arrays of the wrong shape, values that are not finite, points in one plane, or faces none
        of which has an area.
    ParameterError
        ``tolerance`` or ``farthest`` not positive.
    """
    _check_share(tolerance, "tolerance", TOLERANCE)
    _check_share(farthest, "farthest", FARTHEST)
    scan = as_points(points)
    require_solid(scan, "mirror deviation")
    mirror = _mirror(plane)
    triangles = as_faces(np.zeros((0, 3)) if faces is None else faces, len(scan))
    hints = None if normals is None else as_normals(normals, len(scan))
    everything = np.ones(len(scan), dtype=np.bool_)
    rows = _rows(everything if chosen is None else chosen, len(scan))

    report = progress or silent
    report(0.0, "looking at the surface")
    framed, frame = _in_own_frame(scan)
    if len(triangles):
        measure = over_mesh(framed, welded(scan, triangles), farthest)
    else:
        turned = None if hints is None else hints @ frame.axes.T
        measure = over_cloud(framed, distinct_places(scan), turned, farthest)
    report(0.5, "comparing with the mirror image")
    heights, counterpart, signed = measure(rows, frame.plane(mirror))
    distances, has_counterpart = np.zeros(len(scan)), np.zeros(len(scan), dtype=bool)
    distances[rows] = frame.diagonal * np.where(counterpart, heights, 0.0)
    has_counterpart[rows] = counterpart
    report(1.0, "measured")
    return _summed(distances, has_counterpart, tolerance * frame.diagonal, signed)


def _check_share(value: float, name: str, default: float) -> None:
    if not (np.isfinite(value) and value > 0.0):
        message = f"{name} must be a positive share of the diagonal; got {value!r}; use {default}"
        raise ParameterError(message)


def _mirror(plane: ArrayLike) -> Floats:
    planes = as_planes(np.asarray(plane)[np.newaxis])
    if len(planes) != 1:
        raise GeometryError("plane must be four numbers A, B, C, D; got none; detect planes first")
    mirror: Floats = planes[0]
    return mirror


@dataclass(frozen=True, slots=True, eq=False)
class _Frame:
    """Along the principal axes, of unit size: what is done in it follows every motion."""

    centre: Floats  # (3,)
    axes: Floats  # (3, 3)  rows, right-handed: faces do not turn over
    diagonal: float

    def plane(self, plane: Floats) -> Floats:
        """Return a plane of the input in this frame."""
        offset = (plane[3] + plane[:3] @ self.centre) / self.diagonal
        return np.append(self.axes @ plane[:3], offset)


def _in_own_frame(scan: Points) -> tuple[Points, _Frame]:
    centre, axes = principal_frame(scan)
    axes[2] *= np.sign(np.linalg.det(axes))
    turned = (scan - centre) @ axes.T
    diagonal = robust_diagonal(turned) or box_diagonal(turned)  # 0: nearly all in one place
    return turned / diagonal, _Frame(centre, axes, diagonal)


def _rows(chosen: ArrayLike, count: int) -> Indices:
    flags = np.asarray(chosen)
    if flags.shape != (count,) or flags.dtype != np.bool_:
        message = (
            f"chosen must be {count} booleans, one a point; got {flags.dtype} of shape "
            f"{flags.shape}; leave it out to measure all"
        )
        raise GeometryError(message)
    return np.flatnonzero(flags)


def _summed(
    distances: Floats, has_counterpart: Booleans, tolerance: float, signed: bool
) -> MirrorDeviation:
    sizes = np.abs(distances[has_counterpart])
    known = len(sizes) > 0
    return MirrorDeviation(
        distances=distances,
        has_counterpart=has_counterpart,
        signed=signed,
        tolerance=tolerance,
        median=float(np.median(sizes)) if known else np.nan,
        percentile_95=float(np.quantile(sizes, 0.95)) if known else np.nan,
        rms=float(np.sqrt(np.mean(sizes**2))) if known else np.nan,
        share_within=float(np.mean(sizes <= tolerance)) if known else np.nan,
    )
