"""Filling: the mirror images that lie where nothing was measured."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from meshlab_symrecon.arrays import Booleans, Floats, Indices, Points
from meshlab_symrecon.geometry.neighbours import blocks
from meshlab_symrecon.geometry.planes import reflect_directions
from meshlab_symrecon.symmetry.coverage import covered
from meshlab_symrecon.symmetry.density import as_dense_as_around
from meshlab_symrecon.symmetry.progress import Progress, silent
from meshlab_symrecon.symmetry.surroundings import Surroundings

__all__ = ["any_missing", "fill"]

SMALLEST_PATCH = 12  # images: fewer together are no hole
PATCH_REACH = 2.0  # spacings between neighbours in a patch
PATCH_NEIGHBOURS = 8
FILLING = "choosing what fills holes"


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
