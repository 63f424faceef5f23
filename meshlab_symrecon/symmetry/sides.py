"""Normals of a whole scan, turned outwards: those that came with it where they can be trusted."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from meshlab_symrecon.arrays import Booleans, Floats, Indices, Points
from meshlab_symrecon.geometry.sampling import thin_by_voxels, voxel_means
from meshlab_symrecon.symmetry.orientation import orient

__all__ = ["agreement_with_shape", "outward_normals"]

BASE_COUNT = 8_000  # points on which sides are told
ENOUGH_CLEAR = 0.05  # share of them whose surroundings tell the outside; below it the shape is mute
CONSISTENT = 0.85  # share of those in which given normals have to agree, or all be turned round
SMOOTH = 0.95  # share of neighbours whose given normals agree where the surface hardly bends
HARDLY_BENT = 0.7  # cosine between the axes of the normals of neighbours
NEIGHBOURS = 8
SHEETS = 4  # base points among which the one on the same sheet of the surface is sought
BEND = 1e-6  # least length of a step from neighbour to neighbour, so that few steps are preferred


def outward_normals(points: Points, axes: Points, given: Points | None) -> tuple[Points, bool]:
    """Turn the normals of a cloud outwards.

    Given normals tell the side when neighbours agree and when they all point outwards or all
    inwards, as far as the shape can tell (`orientation.orient`). Otherwise the shape tells it
    where it can, and elsewhere the side is carried along the surface, by the way that bends least
    (after Hoppe et al. 1992).

    Parameters
    ----------
    points : (n, 3) float
        A cloud with a diagonal of about 1.
    axes : (n, 3) float
        Its unit normals, of either sign.
    given : (n, 3) float or None
        Normals that came with it, perhaps inconsistent.

    Returns
    -------
    normals : (n, 3) float
        The normals, some of them turned.
    known : bool
        False when nothing tells inside from outside: then the signs mean nothing.
    """
    base = _base(points)
    graph = cKDTree(points[base]).query(points[base], k=min(NEIGHBOURS + 1, len(base)))[1][:, 1:]
    if given is not None and _smooth(axes[base], given[base], graph):
        agreement = agreement_with_shape(points[base], given[base])
        if agreement is None or agreement >= CONSISTENT:
            return _turned(axes, given), True
        if agreement <= 1.0 - CONSISTENT:
            return _turned(axes, -given), True
    directions, clear = orient(points[base], axes[base], None)
    if clear.mean() < ENOUGH_CLEAR:
        return axes, False
    directions = _carried(directions, clear, graph)
    return _from_base(points, axes, (points[base], directions)), True


def agreement_with_shape(points: Points, normals: Points) -> float | None:
    """Return the share of normals that point outwards where the shape tells, None if it does not.

    Parameters
    ----------
    points, normals : (n, 3) float
        A cloud with a diagonal of about 1, and its unit normals.
    """
    base = _base(points)
    outwards, clear = orient(points[base], normals[base], None)
    if len(base) == 0 or clear.mean() < ENOUGH_CLEAR:
        return None
    along = np.einsum("ij,ij->i", outwards[clear], normals[base][clear])
    return float(np.mean(along > 0.0))


def _base(points: Points) -> Indices:
    """Choose from each voxel the point nearest to the mean of its points."""
    labels, count = thin_by_voxels(points, BASE_COUNT)
    off_centre = ((points - voxel_means(points, labels, count)[labels]) ** 2).sum(axis=1)
    order = np.lexsort((off_centre, labels))
    chosen: Indices = order[np.flatnonzero(np.diff(labels[order], prepend=-1))]
    return chosen


def _turned(axes: Points, towards: Points) -> Points:
    signs = np.where(np.einsum("ij,ij->i", axes, towards) < 0.0, -1.0, 1.0)
    turned: Points = axes * signs[:, np.newaxis]
    return turned


def _smooth(axes: Points, given: Points, graph: Indices) -> bool:
    """Tell whether the given normals of neighbours point to the same side."""
    between = np.einsum("ij,ikj->ik", axes, axes[graph])
    hardly_bent = np.abs(between) > HARDLY_BENT
    signs = np.sign(np.einsum("ij,ij->i", axes, given))
    same = signs[:, np.newaxis] * signs[graph] * between > 0.0
    return bool(hardly_bent.any() and same[hardly_bent].mean() >= SMOOTH)


def _carried(directions: Points, clear: Booleans, graph: Indices) -> Points:
    """Carry the side from clear places along the surface, by the way that bends least."""
    count, width = graph.shape
    begins, ends = np.repeat(np.arange(count), width), graph.ravel()
    cosines = np.einsum("ij,ij->i", directions[begins], directions[ends])
    steps = coo_matrix((BEND + 1.0 - np.abs(cosines), (begins, ends)), shape=(count, count)).tocsr()
    lengths, before, _ = dijkstra(
        steps,
        directed=False,
        indices=np.flatnonzero(clear),
        min_only=True,
        return_predecessors=True,
    )
    carried = directions.copy()
    reached = np.flatnonzero(~clear & np.isfinite(lengths))
    for place in reached[np.argsort(lengths[reached], kind="stable")]:
        if carried[before[place]] @ carried[place] < 0.0:
            carried[place] *= -1.0
    return carried


def _from_base(points: Points, axes: Points, base: tuple[Points, Points]) -> Points:
    """Turn every normal to the side of the base point on the same sheet of the surface."""
    places, directions = base
    near = cKDTree(places).query(points, k=min(SHEETS, len(places)))[1].reshape(len(points), -1)
    least = np.full(len(points), np.inf)
    towards: Floats = np.zeros_like(points)
    for column in near.T:
        offsets = places[column] - points
        off_sheet = np.abs(np.einsum("ij,ij->i", offsets, axes))
        off_sheet += np.abs(np.einsum("ij,ij->i", offsets, directions[column]))
        nearer = off_sheet < least
        least[nearer] = off_sheet[nearer]
        towards[nearer] = directions[column[nearer]]
    return _turned(axes, towards)
