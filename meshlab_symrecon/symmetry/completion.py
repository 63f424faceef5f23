"""Completion: what was not measured is filled with mirror images of what was."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from meshlab_symrecon import _native
from meshlab_symrecon.arrays import (
    Booleans,
    Floats,
    Indices,
    Points,
    as_normals,
    as_planes,
    as_points,
    as_scalars,
)
from meshlab_symrecon.errors import GeometryError, ParameterError
from meshlab_symrecon.geometry.bounds import require_solid, robust_diagonal
from meshlab_symrecon.geometry.neighbours import blocks
from meshlab_symrecon.geometry.planes import reflect, reflect_directions, signed_distances
from meshlab_symrecon.geometry.sampling import principal_frame
from meshlab_symrecon.one_thread import in_one_thread
from meshlab_symrecon.symmetry.asymmetry import asymmetry_field
from meshlab_symrecon.symmetry.copying import off_lopsided_plinth, on_surface, standing_plane
from meshlab_symrecon.symmetry.filling import (
    Surroundings,
    any_missing,
    fill,
    neighbours,
    surroundings,
)
from meshlab_symrecon.symmetry.open_rims import open_rims
from meshlab_symrecon.symmetry.preparation import PreparedCloud, prepare
from meshlab_symrecon.symmetry.progress import Progress, part, share_of, silent

__all__ = ["BLEND", "GAP", "CompletedPoints", "mirror_complete"]


GAP = 1.0  # local spacings: nearer mirror images add nothing to what was measured
BLEND = 0.25  # diagonals: how far the offset seen at the seam is carried at most
ENOUGH = 200_000  # points on which the statue's asymmetry, its plinth and its rims are looked for
FEWEST = 500  # points below which nothing can be said about asymmetry
SAMPLES = 16  # of the prepared cloud; they are for detection
NODES = 4  # places between which an offset is interpolated
LEANING = "following how the sides differ"
SCAN_DONE, FILL = 0.35, 0.6  # shares of the time: looking at the scan, and filling
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
    scan = _scan(measured, directions, allowed, part(report, 0.0, SCAN_DONE))
    kept = len(scan.number)
    positions, origin = scan.around.points, np.arange(kept)
    facing = np.zeros((0, 3))  # the normals of the images
    for step, plane in enumerate(mirrors):
        low, high = (SCAN_DONE + FILL * number / len(mirrors) for number in (step, step + 1))
        report(low, "filling with mirror images")
        _check_reached(positions, plane, step, scan.around.diagonal)
        around = scan.around
        if step > 0:
            turned = scan.directions_with(facing)
            around = surroundings(positions, turned, scan.around.diagonal)
        of_plane = part(report, low, high)
        images, chosen = _across(scan, around, origin, plane, (gap, blend), of_plane)
        positions = np.concatenate([positions, images])
        origin = np.concatenate([origin, origin[chosen]])
        turned = scan.directions_with(facing)
        if turned is not None:
            facing = np.concatenate([facing, reflect_directions(turned[chosen], plane)])
        del turned
    report(SCAN_DONE + FILL, "collecting the completed points")
    source_of = np.concatenate([np.arange(count), scan.number[origin[kept:]]])
    mirrored_normals = None if directions is None else np.concatenate([directions, facing])
    completed = CompletedPoints(
        points=np.concatenate([measured, positions[kept:]]),
        normals=mirrored_normals,
        colours=None if paint is None else paint[source_of],
        quality=None if worth is None else worth[source_of],
        mirrored=np.arange(len(source_of)) >= count,
        source=source_of,
        scattered=scan.scattered,
        plinth=int(np.count_nonzero(~scan.off_plinth(mirrors[0]))) if len(mirrors) else 0,
        open_rims=open_rims(positions[:: -(-len(positions) // ENOUGH)]),
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


@dataclass(frozen=True, eq=False)
class _Scan:
    """The measured surface, without scatter, and what is found out about it on demand."""

    number: Indices  # (k,)  of each point in the input
    allowed: Booleans | None  # (k,)  may be mirrored; None: all of them
    around: Surroundings
    scattered: int  # points left out
    directions: Points | None  # of the input

    def directions_with(self, others: Points) -> Points | None:
        """Return the normals of these points, then others; made when asked for, to save memory."""
        if self.directions is None:
            return None
        return np.concatenate([self.directions[self.number], others])

    @cached_property
    def _even(self) -> slice:
        """Every n-th point along the curve: an even part of a large scan."""
        return slice(None, None, -(-len(self.number) // ENOUGH))

    @cached_property
    def prepared(self) -> PreparedCloud:
        sides = self.around.directions[self._even] if self.around.outward else None
        return prepare(self.around.points[self._even], sides, SAMPLES)

    @cached_property
    def _standing(self) -> Floats | None:
        return standing_plane(self.around.points[self._even])

    def off_plinth(self, plane: Floats) -> Booleans:
        """Tell which points are not on a plinth that lacks the mirror plane."""
        if self._standing is None:
            return np.ones(len(self.number), dtype=bool)
        around = self.around
        return off_lopsided_plinth(around.points, around.field, around.usual, self._standing, plane)


def _scan(
    points: Points, normals: Points | None, allowed: Booleans | None, progress: Progress
) -> _Scan:
    """Order a cloud along a space-filling curve, which makes searches fast, without scatter.

    Of points that coincide, the curve passes the first only.
    """
    progress(0.0, "ordering the points")
    centre, axes = principal_frame(points)
    framed = points - centre
    framed = framed @ axes.T  # so that all that follows turns with the scan
    order = _native.curve_order(framed).astype(np.int64)
    diagonal = robust_diagonal(framed[order])  # without those that coincide
    del framed
    ordered = points[order]
    looking = part(progress, 0.2, 0.8)
    known = neighbours(ordered, share_of(looking, "looking at neighbourhoods"))
    progress(0.8, "looking for the surface")
    together = on_surface(ordered, known.width, known.nearest)
    number = order[together]
    sides = None if normals is None else normals[order]
    return _Scan(
        number=number,
        allowed=None if allowed is None else allowed[number],
        around=surroundings(ordered, sides, diagonal, known, together),
        scattered=int(np.count_nonzero(~together)),
        directions=normals,
    )


def _across(
    scan: _Scan,
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
    images = np.zeros((len(sources), 3))
    for rows in blocks(len(sources)):
        images[rows] = reflect(around.points[sources[rows]], plane)
    if blend > 0.0 and len(scan.number) >= FEWEST:
        if not any_missing(around, images, sources, plane, gap):
            return images[:0], sources[:0]
        progress(0.1, "learning how the sides differ")
        cloud = scan.prepared
        images = _leaning(cloud, images, plane, blend, part(progress, 0.3, 0.7))
    filling = fill(around, images, sources, plane, gap, part(progress, 0.7, 1.0))
    return images[filling], sources[filling]


def _leaning(
    cloud: PreparedCloud, images: Points, plane: Floats, blend: float, progress: Progress
) -> Points:
    """Move mirror images by what is known of the statue's asymmetry."""
    progress(0.0, LEANING)
    field = asymmetry_field(cloud, plane, blend)
    if field is None:
        return images
    nodes = reflect(cloud.points @ cloud.axes * cloud.scale + cloud.centre, plane)
    offsets = field.offsets(nodes)
    tree = cKDTree(nodes)
    leaning = np.zeros(images.shape)
    for rows in blocks(len(images), share_of(part(progress, 0.5, 1.0), LEANING)):
        distances, nearest = tree.query(images[rows], k=NODES)
        weights = np.exp(-((distances / np.maximum(distances[:, -1:], 1e-300)) ** 2))
        weights /= weights.sum(axis=1, keepdims=True)
        leaning[rows] = images[rows] + np.einsum("nk,nki->ni", weights, offsets[nearest])
    return leaning
