"""Completion: what was not measured is filled with mirror images of what was."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from meshlab_symrecon.arrays import (
    Booleans,
    Floats,
    Indices,
    Points,
    as_normals,
    as_planes,
    as_points,
)
from meshlab_symrecon.errors import GeometryError, ParameterError
from meshlab_symrecon.geometry.bounds import require_solid, robust_diagonal
from meshlab_symrecon.geometry.neighbours import principal_normals
from meshlab_symrecon.geometry.planes import reflect, reflect_directions
from meshlab_symrecon.symmetry.coverage import covered

__all__ = ["GAP", "CompletedPoints", "mirror_complete"]

Progress: TypeAlias = Callable[[float, str], None]

GAP = 1.0  # local spacings: nearer mirror images add nothing to what was measured
SPACING_NEIGHBOURS = 4
SPACING_RANGE = (0.5, 2.0)  # medians: between them the spacing of a point is believed
SMALLEST_PATCH = 12  # images: fewer together are no hole
PATCH_REACH = 2.0  # spacings between neighbours in a patch
ISOLATION_NEIGHBOURS = 8
ISOLATED = 3.0  # medians of the mean distance to them: farther points are not copied
BLEND_OVERLAP = 0.5  # reaches of the blend: nearer mirror images show the offset
BESIDE = 1.0  # spacings: a mirror image farther along the surface from its partner shows nothing
NORMAL_NEIGHBOURS = 16
BLEND_NEIGHBOURS = 32  # whose median offset counts
BLEND_SOURCES = 24  # overlap points that move a filled point


@dataclass(frozen=True, slots=True, eq=False)
class CompletedPoints:
    """A completed cloud: the measured points first, as they came, then the mirrored ones."""

    points: Points  # (n + m, 3)
    normals: Points | None  # (n + m, 3)  outward where the given ones were
    colours: Floats | None  # (n + m, c)  copied
    quality: Floats | None  # (n + m,)  copied
    mirrored: Booleans  # (n + m,)  False: measured
    source: Indices  # (n + m,)  the measured point that each point is, or is the image of


def mirror_complete(  # noqa: PLR0913  # what a vertex carries, and how to fill
    points: ArrayLike,
    planes: ArrayLike,
    normals: ArrayLike | None = None,
    colours: ArrayLike | None = None,
    quality: ArrayLike | None = None,
    *,
    gap: float = GAP,
    blend: float = 0.0,
    progress: Progress | None = None,
) -> CompletedPoints:
    """Fill the missing parts of a cloud with its own mirror images.

    A mirror image is added where nothing was measured: farther from every point so far than ``gap``
    times the spacing there, and over no measured surface that faces the same way (see
    ``coverage``). Isolated points are not copied. Planes are used one after the other, each
    on the cloud completed so far, so that two planes fill four quarters from one.

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
        Diagonals over which the filled part leans towards the measured surface at the seam; 0 for
        exact mirror images. Measured points never move.
    progress : callable, optional
        Called with a fraction and a message.

    Returns
    -------
    CompletedPoints
        Measured points first, bit for bit and in order.

    Raises
    ------
    GeometryError
        Arrays of the wrong shape, values that are not finite, or fewer than two points.
    ParameterError
        ``gap`` not positive, or ``blend`` negative.
    """
    if not (np.isfinite(gap) and gap > 0.0):
        message = f"gap must be a positive multiple of the spacing; got {gap!r}; use {GAP}"
        raise ParameterError(message)
    if not (np.isfinite(blend) and blend >= 0.0):
        raise ParameterError(f"blend must be 0 or a positive length; got {blend!r}; use 0.06")
    measured = as_points(points)
    require_solid(measured, "mirror completion")
    mirrors = as_planes(np.atleast_2d(np.asarray(planes, dtype=np.float64)))
    count = len(measured)
    directions = None if normals is None else as_normals(normals, count)
    paint = None if colours is None else _attribute(colours, count, "colours")
    worth = None if quality is None else _attribute(quality, count, "quality")

    positions, source = measured, np.arange(count)
    for step, plane in enumerate(mirrors):
        if progress is not None:
            progress(step / len(mirrors), "filling with mirror images")
        added, origin = _fill(positions, directions, plane, gap, blend)
        positions = np.concatenate([positions, added])
        source = np.concatenate([source, source[origin]])
        if directions is not None:
            turned = reflect_directions(directions[origin], plane)
            directions = np.concatenate([directions, turned])
    if progress is not None:
        progress(1.0, "completed")
    return CompletedPoints(
        points=positions,
        normals=directions,
        colours=None if paint is None else paint[source],
        quality=None if worth is None else worth[source],
        mirrored=np.arange(len(positions)) >= count,
        source=source,
    )


def _attribute(values: ArrayLike, count: int, what: str) -> Floats:
    rows = np.array(values)
    if rows.ndim == 0 or len(rows) != count:
        message = (
            f"{what} must have one row a point, {count}; got shape {rows.shape}; leave them out"
        )
        raise GeometryError(message)
    return rows


def _fill(
    points: Points, normals: Points | None, plane: Floats, gap: float, blend: float
) -> tuple[Points, Indices]:
    """Return the mirror images that fill gaps, and the points they are images of."""
    size = robust_diagonal(points)
    tree = cKDTree(points)
    around = tree.query(points, k=min(ISOLATION_NEIGHBOURS + 1, len(points)))[0][:, 1:]
    isolation = around.mean(axis=1)
    origin = np.flatnonzero(isolation <= ISOLATED * np.median(isolation))
    images = reflect(points[origin], plane)
    spacing = around[:, :SPACING_NEIGHBOURS].mean(axis=1)
    low, high = (factor * float(np.median(spacing)) for factor in SPACING_RANGE)
    distances, nearest = tree.query(images)
    if blend > 0.0:
        images = _lean(images, points, (distances, nearest), spacing[nearest], blend * size)
        distances, nearest = tree.query(images)
    reach = gap * np.clip(spacing[nearest], low, high)
    missing = np.flatnonzero(distances > reach)
    upright = principal_normals(points, points, NORMAL_NEIGHBOURS)[0]
    directions = upright if normals is None else normals
    facing = np.einsum(
        "ij,ij->i",
        reflect_directions(directions[origin[missing]], plane),
        directions[nearest[missing]],
    )
    hovering = covered(
        images[missing] - points[nearest[missing]],
        upright[nearest[missing]],
        facing,
        reach[missing],
        size,
        outward=normals is not None,
    )
    missing = missing[~hovering]
    missing = missing[_in_patches(images[missing], float(np.median(spacing)))]
    return images[missing], origin[missing]


def _in_patches(images: Points, spacing: float) -> Booleans:
    """Tell which images hang together in patches; a few stray ones are scatter, not a hole."""
    smallest = min(SMALLEST_PATCH, max(1, len(images) // 100))
    if smallest == 1:
        return np.ones(len(images), dtype=bool)
    pairs = cKDTree(images).query_pairs(PATCH_REACH * spacing, output_type="ndarray")
    links = coo_matrix((np.ones(len(pairs), dtype=bool), pairs.T), shape=(len(images),) * 2)
    patch = connected_components(links, directed=False)[1]
    joined: Booleans = np.bincount(patch)[patch] >= smallest
    return joined


def _lean(
    images: Points,
    points: Points,
    partners: tuple[Floats, Indices],
    spacing: Floats,
    reach: float,
) -> Points:
    """Move mirror images by the offset seen where they overlap what was measured, fading out.

    Only the offset across the surface counts: along it, samples differ by chance, and at the rim of
    a hole by how far the image lies beyond the rim.
    """
    distances, nearest = partners
    near = np.flatnonzero(distances < BLEND_OVERLAP * reach)
    normals = principal_normals(points, points[nearest[near]], NORMAL_NEIGHBOURS)[0]
    gaps = points[nearest[near]] - images[near]
    heights = np.einsum("ni,ni->n", gaps, normals)
    beside = np.maximum(distances[near] ** 2 - heights**2, 0.0) < (BESIDE * spacing[near]) ** 2
    overlap, offsets = near[beside], (heights[:, np.newaxis] * normals)[beside]
    if len(overlap) < BLEND_NEIGHBOURS:
        return images
    tree = cKDTree(images[overlap])
    around = tree.query(images[overlap], k=BLEND_NEIGHBOURS)[1]
    offsets = np.median(offsets[around], axis=1)
    separations, sources = tree.query(images, k=min(BLEND_SOURCES, len(overlap)))
    extra = separations - separations[:, :1]  # the farther from the seam, the wider the average
    weights = np.exp(-0.5 * (extra / (0.3 * reach)) ** 2)
    weights /= weights.sum(axis=1, keepdims=True)
    fading = np.exp(-0.5 * (separations[:, 0] / reach) ** 2)
    leaning = np.einsum("nk,nki->ni", weights, offsets[sources])
    moved: Points = images + fading[:, np.newaxis] * leaning
    return moved
