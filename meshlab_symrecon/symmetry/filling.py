"""Filling: the mirror images that lie where nothing was measured."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from meshlab_symrecon.arrays import Booleans, Floats, Indices, Points
from meshlab_symrecon.geometry.neighbours import (
    NearestField,
    blocks,
    nearest_field,
    principal_normals,
)
from meshlab_symrecon.geometry.planes import reflect_directions
from meshlab_symrecon.symmetry.coverage import covered
from meshlab_symrecon.symmetry.density import as_dense_as_around
from meshlab_symrecon.symmetry.progress import Progress, silent

__all__ = ["Neighbours", "Surroundings", "any_missing", "fill", "neighbours", "surroundings"]

SmallIndices: TypeAlias = NDArray[np.int32]

NEIGHBOURS = 8
SPACING_NEIGHBOURS = 4
SPACING_RANGE = (0.5, 2.0)  # medians: between them the spacing of a point is believed
SMALLEST_PATCH = 12  # images: fewer together are no hole
FIELD_CELL, FIELD_MARGIN = 0.008, 0.12  # diagonals: cells and rim of the table of nearest points
FIELD_CELLS = 500_000
PATCH_REACH = 2.0  # spacings between neighbours in a patch
PATCH_NEIGHBOURS = 8
NORMAL_NEIGHBOURS = 16
CONSISTENT = 0.9  # share of the points whose normal faces as that of the nearest point does
FILLING = "choosing what fills holes"
FITTED = 60_000  # points to which normals are fitted


@dataclass(frozen=True, slots=True, eq=False)
class Surroundings:
    """A cloud as its holes see it."""

    points: Points  # (n, 3)  along a space-filling curve, which makes searches fast
    directions: Points  # (n, 3)  unit normals
    outward: bool  # they tell inside from outside
    field: NearestField
    spacing: Floats  # (n,)  mean distance to the four nearest
    usual: float  # its median in the scan
    diagonal: float

    def believed(self, chosen: SmallIndices) -> Floats:
        """Return the spacing of some points, within a factor of two of the usual one."""
        low, high = SPACING_RANGE
        within: Floats = np.clip(self.spacing[chosen], low * self.usual, high * self.usual)
        return within


@dataclass(frozen=True, slots=True, eq=False)
class Neighbours:
    """The points nearest to each point of a cloud, itself left out."""

    nearest: SmallIndices  # (n, k)  nearest first
    spacing: Floats  # (n,)  mean distance to the first four
    width: Floats  # (n,)  mean distance to all


def neighbours(points: Points, report: Callable[[float], None] | None = None) -> Neighbours:
    """Look up the eight points nearest to each of the points (n, 3), n at least 2.

    ``report`` is told the share that is done.
    """
    count = min(NEIGHBOURS + 1, len(points))
    tree = cKDTree(points)
    nearest = np.zeros((len(points), count - 1), dtype=np.int32)
    spacing, width = np.zeros(len(points)), np.zeros(len(points))
    for rows in blocks(len(points), report):
        distances, members = tree.query(points[rows], k=count)
        nearest[rows] = members[:, 1:]
        spacing[rows] = distances[:, 1 : SPACING_NEIGHBOURS + 1].mean(axis=1)
        width[rows] = distances[:, 1:].mean(axis=1)
    return Neighbours(nearest, spacing, width)


def surroundings(
    points: Points,
    normals: Points | None,
    diagonal: float,
    known: Neighbours | None = None,
    kept: Booleans | None = None,
) -> Surroundings:
    """Look up the neighbourhood of every point (n, 3), n at least 2, along a space-filling curve.

    Where no normals (n, 3) are given, or where neighbours contradict each other, planes are
    fitted. The diagonal is that of the scan; the neighbours may be known already. Points that are
    not ``kept`` (n,) are left out; the spacing of the others is that in the whole.
    """
    known = neighbours(points) if known is None else known
    given = None if normals is None else _consistent(normals, known.nearest[:, 0])
    directions = _fitted(points) if given is None else given
    spacing, usual = known.spacing, float(np.median(known.spacing))
    if kept is not None and not kept.all():
        points, directions, spacing = points[kept], directions[kept], spacing[kept]
    return Surroundings(
        points=points,
        directions=directions,
        outward=given is not None,
        field=_field(points, diagonal),
        spacing=spacing,
        usual=usual,
        diagonal=diagonal,
    )


def _field(points: Points, diagonal: float) -> NearestField:
    return nearest_field(points, FIELD_CELL * diagonal, FIELD_MARGIN * diagonal, FIELD_CELLS)


def _consistent(normals: Points, nearest: SmallIndices) -> Points | None:
    """Return unit normals, or None when those of points and the nearest (n,) contradict."""
    unit = _unit(normals)
    alike = 0
    for rows in blocks(len(unit)):
        agreement = np.einsum("ni,ni->n", unit[rows], unit[nearest[rows]])
        alike += int(np.count_nonzero(agreement > 0.0))
    return unit if alike / len(unit) >= CONSISTENT else None


def _unit(normals: Points) -> Points:
    unit = np.zeros(normals.shape)
    for rows in blocks(len(normals)):
        largest = np.abs(normals[rows]).max(axis=1, keepdims=True)
        scaled = normals[rows] / np.where(largest > 0.0, largest, 1.0)  # whose squares are floats
        lengths = np.linalg.norm(scaled, axis=1, keepdims=True)
        unit[rows] = scaled / np.where(lengths > 0.0, lengths, 1.0)
    return unit


def _fitted(points: Points) -> Points:
    """Fit normals to an even part of a cloud along a curve; every point gets the nearest one."""
    even = points[:: -(-len(points) // FITTED)]
    normals = principal_normals(even, even, NORMAL_NEIGHBOURS)[0]
    if len(even) == len(points):
        return normals
    tree = cKDTree(even)
    fitted = np.zeros((len(points), 3))
    for rows in blocks(len(points)):
        fitted[rows] = normals[tree.query(points[rows])[1]]
    return fitted


def any_missing(
    around: Surroundings, images: Points, origin: Indices, plane: Floats, gap: float
) -> bool:
    """Tell whether any mirror images lie where nothing was measured; see ``fill``."""
    chosen, nearest, reach = _open(around, images, gap)
    hovering = _hovering(around, images[chosen], origin[chosen], nearest, plane, reach)
    return bool((~hovering).any())


def fill(
    around: Surroundings,
    images: Points,
    origin: Indices,
    plane: Floats,
    gap: float,
    progress: Progress = silent,
) -> Booleans:
    """Choose the mirror images that fill holes.

    Parameters
    ----------
    around : Surroundings
        What was measured, and filled in before.
    images : (m, 3) float
        Mirror images, along a space-filling curve.
    origin : (m,) int
        The points they are images of.
    plane : (4,) float
        The mirror plane.
    gap : float
        Multiples of the local spacing: an image nearer to a point fills nothing.
    progress : callable
        Called with a fraction and a message.

    Returns
    -------
    (m,) bool
        True for those farther than the gap from every point, over no surface that faces the same
        way, together with others, and no denser than the points round them.
    """
    progress(0.0, FILLING)
    chosen, nearest, reach = _open(around, images, gap)
    free = ~_hovering(around, images[chosen], origin[chosen], nearest, plane, reach)
    chosen, nearest = chosen[free], nearest[free]
    progress(0.4, FILLING)
    joined = _in_patches(images[chosen], around.usual)
    chosen, nearest = chosen[joined], nearest[joined]
    progress(0.7, FILLING)
    even = as_dense_as_around(
        images[chosen], around.spacing[origin[chosen]], around.points, around.spacing, nearest
    )
    filling = np.zeros(len(images), dtype=bool)
    filling[chosen[even]] = True
    return filling


def _open(around: Surroundings, images: Points, gap: float) -> tuple[Indices, Indices, Floats]:
    """Return the images that are farther than the gap from every point.

    Returns
    -------
    chosen : (o,) int
        Which of the images.
    nearest : (o,) int
        The point nearest to each.
    reach : (o,) float
        The gap there.
    """
    chosen, nearest, reach = [], [], []
    for rows in blocks(len(images)):
        closest = around.field.closest(images[rows])
        gaps = gap * around.believed(closest)
        distances = np.linalg.norm(images[rows] - around.points[closest], axis=1)
        far = np.flatnonzero(distances > gaps)
        chosen.append(far + rows.start)
        nearest.append(closest[far].astype(np.int64))
        reach.append(gaps[far])
    if not chosen:
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64), np.zeros(0)
    return np.concatenate(chosen), np.concatenate(nearest), np.concatenate(reach)


def _hovering(
    around: Surroundings,
    images: Points,
    origin: Indices,
    nearest: Indices,
    plane: Floats,
    reach: Floats,
) -> Booleans:
    """Tell which open images hover over a measured surface."""
    upright = around.directions[nearest]
    turned = reflect_directions(around.directions[origin], plane)
    return covered(
        images - around.points[nearest],
        upright,
        np.einsum("ij,ij->i", turned, upright),
        reach,
        around.diagonal,
        outward=around.outward,
    )


def _in_patches(images: Points, spacing: float) -> Booleans:
    """Tell which images hang together in patches; a few stray ones are scatter, not a hole."""
    smallest = min(SMALLEST_PATCH, max(1, len(images) // 100))
    if smallest == 1:
        return np.ones(len(images), dtype=bool)
    count = len(images)
    tree, first, second = cKDTree(images), [], []
    for rows in blocks(count):
        nearest = tree.query(
            images[rows], k=PATCH_NEIGHBOURS + 1, distance_upper_bound=PATCH_REACH * spacing
        )[1][:, 1:]
        place, rank = np.nonzero(nearest < count)
        first.append((place + rows.start).astype(np.int32))
        second.append(nearest[place, rank].astype(np.int32))
    ends = np.concatenate(first), np.concatenate(second)
    links = coo_matrix((np.ones(len(ends[0]), dtype=bool), ends), shape=(count, count))
    del tree, first, second, ends
    patch = connected_components(links, directed=False)[1]
    joined: Booleans = np.bincount(patch)[patch] >= smallest
    return joined
