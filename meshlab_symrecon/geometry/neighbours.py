"""Neighbourhoods of points: spacing, normals, outliers, borders, and fast nearest-point lookups."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from scipy.ndimage import distance_transform_edt
from scipy.spatial import cKDTree

from meshlab_symrecon._native import NearestField
from meshlab_symrecon.arrays import Booleans, Floats, Indices, Points

__all__ = [
    "FREE_ANGLE",
    "NearestField",
    "blocks",
    "border_points",
    "free_angles",
    "local_spacing",
    "nearest_field",
    "principal_normals",
    "tangent_bases",
    "voted_border",
    "without_outliers",
]

FREE_ANGLE = np.radians(105.0)  # a straight rim leaves 180, an even interior at most about 60
VOTERS, ENOUGH_VOTES = 9, 4  # the point itself counts
BLOCK = 1 << 17  # rows that are worked on at once, so that what is in between stays small


def blocks(count: int, report: Callable[[float], None] | None = None) -> Iterator[slice]:
    """Yield the rows of a large array in blocks, for work that needs much memory a row, or time.

    Before each, ``report`` is told the share that is done.
    """
    for start in range(0, count, BLOCK):
        if report is not None:
            report(start / count)
        yield slice(start, min(start + BLOCK, count))


def local_spacing(points: Points, neighbours: int = 4) -> Floats:
    """Return the mean distance of each point to its nearest neighbours.

    Parameters
    ----------
    points : (n, 3) float
        Positions.
    neighbours : int
        Number of neighbours, fewer where the cloud has fewer.

    Returns
    -------
    (n,) float
        Mean distances, 0 for a lone point.
    """
    nearest = min(neighbours, len(points) - 1)
    if nearest < 1:
        return np.zeros(len(points))
    tree = cKDTree(points)
    spacing = np.zeros(len(points))
    for rows in blocks(len(points)):
        spacing[rows] = tree.query(points[rows], k=nearest + 1)[0][:, 1:].mean(axis=1)
    return spacing


def without_outliers(points: Points, limit: float, rounds: int = 1, neighbours: int = 8) -> Indices:
    """Return the points that are not isolated.

    A point is isolated when the mean distance to its neighbours exceeds ``limit`` times the median
    of that distance. Scattered clutter makes its own neighbours, so the test may be repeated.

    Parameters
    ----------
    points : (n, 3) float
        Positions.
    limit : float
        Multiple of the median.
    rounds : int
        Number of repetitions.
    neighbours : int
        Number of neighbours.

    Returns
    -------
    (m,) int
        Indices of the points that stay, in order.
    """
    kept: Indices = np.arange(len(points))
    for _ in range(rounds):
        spacing = local_spacing(points[kept], neighbours)
        kept = kept[spacing <= limit * np.median(spacing)]
    return kept


def principal_normals(points: Points, places: Points, neighbours: int) -> tuple[Floats, Floats]:
    """Fit a plane to the neighbourhood of each place.

    Parameters
    ----------
    points : (n, 3) float
        The cloud.
    places : (m, 3) float
        Where to fit.
    neighbours : int
        Points in each neighbourhood.

    Returns
    -------
    normals : (m, 3) float
        Unit normals of arbitrary sign.
    roughness : (m,) float
        Standard deviation of the neighbourhood along its normal.
    """
    nearest = min(neighbours, len(points))
    members = points[cKDTree(points).query(places, k=nearest)[1].reshape(len(places), nearest)]
    centred = members - members.mean(axis=1, keepdims=True)
    covariances = np.einsum("mki,mkj->mij", centred, centred) / nearest
    variances, axes = np.linalg.eigh(covariances)
    return axes[:, :, 0].copy(), np.sqrt(np.maximum(variances[:, 0], 0.0))


def tangent_bases(normals: Points) -> tuple[Floats, Floats]:
    """Return two unit vectors that complete each unit normal to an orthonormal basis.

    Parameters
    ----------
    normals : (m, 3) float
        Unit normals.

    Returns
    -------
    first, second : (m, 3) float
        Tangents.
    """
    rows = np.arange(len(normals))
    helpers = np.zeros_like(normals)
    helpers[rows, np.argmin(np.abs(normals), axis=1)] = 1.0
    first: Points = np.asarray(np.cross(normals, helpers), dtype=np.float64)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return first, np.asarray(np.cross(normals, first), dtype=np.float64)


def free_angles(points: Points, normals: Points, neighbours: int = 24) -> tuple[Floats, Indices]:
    """Return the widest angle without neighbours round each point, seen in its tangent plane.

    Parameters
    ----------
    points : (n, 3) float
        The cloud.
    normals : (n, 3) float
        Unit normals of either sign.
    neighbours : int
        Neighbours looked at.

    Returns
    -------
    angles : (n,) float
        Radians; 0 for a lone point.
    nearest : (n, k) int
        The point itself, or one that coincides with it, and its neighbours, nearest first.
    """
    count = min(neighbours + 1, len(points))
    members = cKDTree(points).query(points, k=count)[1].reshape(len(points), count)
    offsets = points[members[:, 1:]] - points[:, np.newaxis]
    first, second = tangent_bases(normals)
    along = np.einsum("nki,ni->nk", offsets, first)
    across = np.einsum("nki,ni->nk", offsets, second)
    angles = np.sort(np.arctan2(across, along), axis=1)
    gaps = np.diff(angles, axis=1, append=angles[:, :1] + 2.0 * np.pi)
    return gaps.max(axis=1, initial=0.0), members


def border_points(points: Points, normals: Points, neighbours: int = 24) -> Booleans:
    """Find the points on the border of an open surface, such as the rim of a hole.

    Seen in the tangent plane, the neighbours of a border point leave an angle free. A vote among
    nearby points removes chance gaps.

    Parameters
    ----------
    points : (n, 3) float
        The cloud.
    normals : (n, 3) float
        Unit normals of either sign.
    neighbours : int
        Neighbours looked at.

    Returns
    -------
    (n,) bool
        True on the border.
    """
    return voted_border(*free_angles(points, normals, neighbours))


def voted_border(angles: Floats, nearest: Indices) -> Booleans:
    """Tell which points are on a border by their free angles and those of their neighbours.

    Parameters
    ----------
    angles, nearest : (n,) float, (n, k) int
        As ``free_angles`` returns them.

    Returns
    -------
    (n,) bool
        True on the border.
    """
    votes = (angles > FREE_ANGLE)[nearest[:, :VOTERS]].sum(axis=1)
    border: Booleans = votes >= ENOUGH_VOTES
    return border


def nearest_field(points: Points, cell: float, margin: float, most_cells: int) -> NearestField:
    """Tabulate the nearest points of a cloud by an exact distance transform.

    Parameters
    ----------
    points : (n, 3) float
        The cloud.
    cell : float
        Wanted edge of a cell; made larger where the grid would have more than ``most_cells``.
    margin : float
        Width of the rim around the box of the cloud; places beyond it use the rim's cells.
    most_cells : int
        Largest number of cells.

    Returns
    -------
    NearestField
        ``lookup(places)`` gives a point near each of the places (m, 3), right to about a cell;
        ``closest(places)`` the closest one.
    """
    low = points.min(axis=0) - margin
    widths = points.max(axis=0) + margin - low
    cell = max(cell, float(np.cbrt(np.prod(widths) / most_cells)))
    shape = np.ceil(widths / cell).astype(np.int64) + 1
    occupants = np.full(int(np.prod(shape)), -1, dtype=np.int64)
    for rows in blocks(len(points)):
        cells = np.rint((points[rows] - low) / cell).astype(np.int64)
        keys = (cells[:, 0] * shape[1] + cells[:, 1]) * shape[2] + cells[:, 2]
        occupants[keys] = np.arange(rows.start, rows.stop)
    empty = (occupants < 0).reshape(tuple(shape))
    a, b, c = distance_transform_edt(empty, return_distances=False, return_indices=True)
    nearest = occupants[(a.astype(np.int64) * shape[1] + b) * shape[2] + c]
    return NearestField(np.ascontiguousarray(points), nearest.astype(np.int32), low, cell)
