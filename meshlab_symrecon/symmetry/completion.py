"""Completion: what was not measured is filled with mirror images of what was."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from meshlab_symrecon.arrays import (
    Booleans,
    Floats,
    Indices,
    Planes,
    Points,
    as_normals,
    as_planes,
    as_points,
    as_scalars,
)
from meshlab_symrecon.errors import GeometryError, ParameterError
from meshlab_symrecon.geometry.bounds import require_solid
from meshlab_symrecon.geometry.neighbours import blocks
from meshlab_symrecon.geometry.planes import reflect, reflect_directions, signed_distances
from meshlab_symrecon.one_thread import in_one_thread
from meshlab_symrecon.symmetry.filling import any_missing, fill
from meshlab_symrecon.symmetry.leaning import leaning
from meshlab_symrecon.symmetry.measured_surface import MeasuredSurface, measured_surface
from meshlab_symrecon.symmetry.open_rims import open_rims
from meshlab_symrecon.symmetry.progress import Progress, part, silent
from meshlab_symrecon.symmetry.surroundings import Surroundings, surroundings

__all__ = ["BLEND", "GAP", "CompletedPoints", "mirror_complete"]


GAP = 1.0  # local spacings: nearer mirror images add nothing to what was measured
BLEND = 0.25  # diagonals: how far the offset seen at the seam is carried at most
ENOUGH = 200_000  # points on which rims are looked for
FEWEST = 500  # points below which nothing can be said about asymmetry
SCAN_DONE, FILL_DONE = 0.35, 0.95  # shares of the time: looking at the scan, and filling
MOST_AWAY = 0.02  # diagonals: between a plane and a cloud that just reaches it


@dataclass(frozen=True, slots=True, eq=False)
class CompletedPoints:
    """A completed cloud: the measured points first, as they came, then the mirrored ones."""

    points: Points  # (n + m, 3)
    normals: Points | None  # (n + m, 3)  outward where the given ones were
    colours: Floats | None  # (n + m, c)  copied
    quality: Floats | None  # (n + m,)  copied
    mirrored: Booleans  # (n + m,)  False: measured
    source: Indices  # (n + m,)  the measured point that each point is, or is the image of
    scattered: int  # measured places that lie on no surface, and were not mirrored
    plinth: int  # measured places of a plinth that is not its own mirror image: not mirrored
    open_rims: Floats  # (k, 4)  centre and width of holes missing on both sides, widest first


@in_one_thread
def mirror_complete(  # noqa: PLR0913  # what a vertex carries, and how to fill
    points: ArrayLike,
    planes: ArrayLike,
    normals: ArrayLike | None = None,
    colours: ArrayLike | None = None,
    quality: ArrayLike | None = None,
    *,
    gap: float = GAP,
    blend: float = BLEND,
    source: ArrayLike | None = None,
    progress: Progress | None = None,
) -> CompletedPoints:
    """Fill the missing parts of a cloud with its own mirror images.

    A mirror image is added where nothing was measured: farther from every point so far than ``gap``
    times the spacing there, and over no measured surface that faces the same way (see
    ``coverage``). Clutter is not copied, nor a plinth that is not its own mirror image. The fill
    is no denser than what was measured round it. Planes are used one after the other, each on the
    cloud completed so far, so that two planes fill four quarters from one.

    Parameters
    ----------
    points : (n, 3) float
        The measured points.
    planes : (k, 4) or (4,) float
        Planes ``Ax + By + Cz + D = 0``.
    normals : (n, 3) float, optional
        Normals; mirrored by ``I - 2 n n^T``, which keeps outward normals outward.
    colours : (n, c) array, optional
        Colours; copied.
    quality : (n,) array, optional
        One number for each point; copied.
    gap : float
        Multiples of the local spacing.
    blend : float
        Diagonals over which the offset between mirror images and the measured surface is carried
        into the filled part at most (see ``asymmetry``); 0 for exact mirror images. Measured
        points never move.
    source : (n,) bool, optional
        The points that may be mirrored; all of them when left out.
    progress : callable, optional
        Called with a fraction and a message.

    Returns
    -------
    CompletedPoints
        Measured points first, bit for bit and in order.

    Raises
    ------
    GeometryError
        Arrays of the wrong shape, values that are not finite, fewer than five points or all of
        them in one plane, or a plane that misses the cloud completed so far.
    ParameterError
        ``gap`` not positive, or ``blend`` negative.
    """
    _check_lengths(gap, blend)
    measured = as_points(points)
    require_solid(measured, "mirror completion")
    mirrors = as_planes(np.atleast_2d(np.asarray(planes)))
    count = len(measured)
    directions = None if normals is None else as_normals(normals, count)
    paint = None if colours is None else _attribute(colours, count, "colours")
    worth = None if quality is None else _attribute(quality, count, "quality")
    allowed = None if source is None else as_scalars(source, count, "source") != 0.0

    report = progress or silent
    scan = measured_surface(measured, directions, allowed, part(report, 0.0, SCAN_DONE))
    whole = _filled(scan, mirrors, (gap, blend), part(report, SCAN_DONE, FILL_DONE))
    report(FILL_DONE, "collecting the completed points")
    kept = len(scan.number)
    source_of = np.concatenate([np.arange(count), scan.number[whole.origin[kept:]]])
    completed = CompletedPoints(
        points=np.concatenate([measured, whole.points[kept:]]),
        normals=None if directions is None else np.concatenate([directions, whole.facing]),
        colours=None if paint is None else paint[source_of],
        quality=None if worth is None else worth[source_of],
        mirrored=np.arange(len(source_of)) >= count,
        source=source_of,
        scattered=scan.scattered,
        plinth=int(np.count_nonzero(~scan.off_plinth(mirrors[0]))) if len(mirrors) else 0,
        open_rims=open_rims(whole.points[:: -(-len(whole.points) // ENOUGH)]),
    )
    report(1.0, "completed")
    return completed


def _check_lengths(gap: float, blend: float) -> None:
    if not (np.isfinite(gap) and gap > 0.0):
        message = f"gap must be a positive multiple of the spacing; got {gap!r}; use {GAP}"
        raise ParameterError(message)
    if not (np.isfinite(blend) and blend >= 0.0):
        raise ParameterError(f"blend must be 0 or a positive length; got {blend!r}; use {BLEND}")


def _check_reached(points: Points, plane: Floats, number: int, size: float) -> None:
    """Refuse a plane that the cloud completed so far lies beside: it cannot be one half."""
    heights = signed_distances(points, plane)
    away = max(float(heights.min()), -float(heights.max()))
    if away > MOST_AWAY * size:
        message = (
            f"a mirror plane must pass through the scan; got plane {number} at "
            f"{away / size:.2g} diagonals from it; move it, or detect planes anew"
        )
        raise GeometryError(message)


def _attribute(values: ArrayLike, count: int, what: str) -> Floats:
    rows = np.array(values)
    if rows.ndim == 0 or len(rows) != count:
        message = (
            f"{what} must have one row a point, {count}; got shape {rows.shape}; leave them out"
        )
        raise GeometryError(message)
    return rows


@dataclass(frozen=True, slots=True, eq=False)
class _Filled:
    """The measured surface, then the mirror images that fill it."""

    points: Points  # (k + m, 3)
    origin: Indices  # (k + m,)  the point of the surface that each is, or is the image of
    facing: Points  # (m, 3)  normals of the images; none when the surface has none


def _filled(
    scan: MeasuredSurface, mirrors: Planes, lengths: tuple[float, float], progress: Progress
) -> _Filled:
    """Fill the surface across one plane after the other."""
    points, origin = scan.around.points, np.arange(len(scan.number))
    facing: Points = np.zeros((0, 3))
    for step, plane in enumerate(mirrors):
        low, high = step / len(mirrors), (step + 1) / len(mirrors)
        progress(low, "filling with mirror images")
        _check_reached(points, plane, step, scan.around.diagonal)
        around = scan.around
        if step > 0:
            around = surroundings(points, scan.directions_with(facing), around.diagonal)
        of_plane = part(progress, low, high)
        images, chosen = _across(scan, around, origin, plane, lengths, of_plane)
        points = np.concatenate([points, images])
        origin = np.concatenate([origin, origin[chosen]])
        turned = scan.directions_with(facing)
        if turned is not None:
            facing = np.concatenate([facing, reflect_directions(turned[chosen], plane)])
        del turned  # before the next plane, which needs the memory
    return _Filled(points, origin, facing)


def _across(
    scan: MeasuredSurface,
    around: Surroundings,
    origin: Indices,
    plane: Floats,
    lengths: tuple[float, float],
    progress: Progress,
) -> tuple[Points, Indices]:
    """Return the mirror images that fill gaps, and the points they are images of."""
    gap, blend = lengths
    worth = scan.off_plinth(plane)
    if scan.allowed is not None:
        worth = worth & scan.allowed
    sources = np.flatnonzero(worth[origin])
    images: Points = np.zeros((len(sources), 3))
    for rows in blocks(len(sources)):
        images[rows] = reflect(around.points[sources[rows]], plane)
    if blend > 0.0 and len(scan.number) >= FEWEST:
        if not any_missing(around, images, sources, plane, gap):
            return images[:0], sources[:0]
        progress(0.1, "learning how the sides differ")
        cloud = scan.prepared
        images = leaning(cloud, images, plane, blend, part(progress, 0.3, 0.7))
    filling = fill(around, images, sources, plane, gap, part(progress, 0.7, 1.0))
    return images[filling], sources[filling]
