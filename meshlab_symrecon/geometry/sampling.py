"""Even samples that depend on the shape, not on the order of the points or on the axes."""

from __future__ import annotations

import numpy as np

from meshlab_symrecon import _native
from meshlab_symrecon.arrays import Floats, Indices, Points

__all__ = [
    "canonical_order",
    "farthest_point_order",
    "principal_frame",
    "thin_by_voxels",
    "voxel_labels",
    "voxel_means",
]

VOXEL_SHIFT = 0.5  # of a voxel: the centre of the cloud is the middle of a voxel, not a corner


def canonical_order(points: Points) -> Indices:
    """Return the order of the points by x, then y, then z: the same for every permutation."""
    order: Indices = np.argsort(points[:, 0], kind="stable")
    sorted_x = points[order, 0]
    if (sorted_x[1:] == sorted_x[:-1]).any():
        order = np.lexsort((points[:, 2], points[:, 1], points[:, 0]))
    return order


def principal_frame(points: Points) -> tuple[Floats, Floats]:
    """Return the mean of a cloud and its principal axes.

    Each axis points to the side of the heavier tail (positive third moment), so that the frame
    turns with the cloud.

    Parameters
    ----------
    points : (n, 3) float
        Positions, at least one.

    Returns
    -------
    centre : (3,) float
        Mean.
    axes : (3, 3) float
        Orthonormal rows, longest axis first.
    """
    centre = points.mean(axis=0)
    centred = points - centre
    axes = np.linalg.eigh(centred.T @ centred)[1].T[::-1]
    along = centred @ axes.T
    third_moments = (along * along * along).sum(axis=0)  # a power would take ten times as long
    return centre, axes * np.where(third_moments < 0.0, -1.0, 1.0)[:, np.newaxis]


def voxel_labels(points: Points, size: float) -> tuple[Indices, int]:
    """Label points with the occupied voxels of a cubic grid around the origin.

    Parameters
    ----------
    points : (n, 3) float
        Positions.
    size : float
        Edge of a voxel, in the units of the points.

    Returns
    -------
    labels : (n,) int
        Voxel of each point, 0 .. count - 1.
    count : int
        Number of occupied voxels.
    """
    cells = np.floor(points / size + VOXEL_SHIFT).astype(np.int64)
    cells -= cells.min(axis=0)
    extent = cells.max(axis=0) + 1
    keys = (cells[:, 0] * extent[1] + cells[:, 1]) * extent[2] + cells[:, 2]
    occupied, labels = np.unique(keys, return_inverse=True)
    return labels.reshape(-1).astype(np.int64), len(occupied)


def voxel_means(values: Floats, labels: Indices, count: int) -> Floats:
    """Average rows over voxels.

    Parameters
    ----------
    values : (n, d) float
        One row for each point.
    labels : (n,) int
        Voxel of each point.
    count : int
        Number of voxels.

    Returns
    -------
    (count, d) float
        Mean row of each voxel.
    """
    members = np.bincount(labels, minlength=count)
    columns = [np.bincount(labels, weights=column, minlength=count) for column in values.T]
    means: Floats = np.stack(columns, axis=1) / members[:, np.newaxis]
    return means


def thin_by_voxels(points: Points, target: int, probe: int = 20_000) -> tuple[Indices, int]:
    """Group a cloud into about ``target`` occupied voxels of one size.

    A surface fills about ``size ** -2`` voxels, so a secant in the logarithms finds the size in a
    few steps. Large clouds are sized on the grid itself only after a first guess on every n-th
    point.

    Parameters
    ----------
    points : (n, 3) float
        Positions; the origin should move with them.
    target : int
        Wanted number of groups.
    probe : int
        Largest number of points used for the first guess.

    Returns
    -------
    labels : (n,) int
        Group of each point; every point is its own group when ``n <= target``.
    count : int
        Number of groups, between 0.8 and 1.1 of ``target`` where the cloud allows it.
    """
    if len(points) <= target:
        return np.arange(len(points)), len(points)
    size = float(np.linalg.norm(np.ptp(points, axis=0))) / np.sqrt(target)
    guess = min(target, probe // 8)
    stride = -(-len(points) // probe)
    for _ in range(3):
        count = voxel_labels(points[::stride], size)[1]
        size *= float(np.clip(np.sqrt(count / guess), 0.2, 5.0))
    size *= float(np.sqrt(guess / target))
    for _ in range(6):
        labels, count = voxel_labels(points, size)
        if 0.8 * target <= count <= 1.1 * target:
            break
        size *= float(np.clip(np.sqrt(count / (0.95 * target)), 0.5, 2.0))
    return labels, count


def farthest_point_order(points: Points, count: int) -> Indices:
    """Order points so that every beginning of the order is an even sample (Gonzalez 1985).

    Each point taken is the one farthest from all those taken before; the first is the one farthest
    from the mean. Time O(n count).

    Parameters
    ----------
    points : (n, 3) float
        Positions.
    count : int
        Number of points to order, at most n are returned.

    Returns
    -------
    (min(n, count),) int
        Indices into ``points``.
    """
    count = min(count, len(points))
    if count == 0:
        return np.zeros(0, dtype=np.int64)
    off_centre = ((points - points.mean(axis=0)) ** 2).sum(axis=1)
    first = int(np.argmax(off_centre))
    return _native.farthest_points(np.ascontiguousarray(points), count, first)
