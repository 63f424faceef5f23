"""Cleaning: what the statue is not, clutter in the air and a plinth under it."""

from __future__ import annotations

from meshlab_symrecon.arrays import Points
from meshlab_symrecon.geometry.bounds import robust_diagonal
from meshlab_symrecon.geometry.neighbours import without_outliers
from meshlab_symrecon.geometry.sampling import thin_by_voxels, voxel_means
from meshlab_symrecon.symmetry.plinth import off_plinth

__all__ = ["without_clutter", "without_plinth"]

DENSE_COUNT = 40_000  # points of the level on which clutter is found and normals are fitted
CLUTTER_LIMIT = 2.0  # multiple of the median neighbour distance
CLUTTER_ROUNDS = 2


def without_clutter(points: Points, sides: Points | None) -> tuple[Points, Points | None]:
    """Thin a cloud to a dense level, and leave out clutter.

    Parameters
    ----------
    points : (n, 3) float
        The cloud.
    sides : (n, 3) float or None
        Outward normals.

    Returns
    -------
    points : (m, 3) float
        At most 40,000, means of voxels where there are more.
    sides : (m, 3) float or None
        Means of their normals.
    """
    labels, count = thin_by_voxels(points, DENSE_COUNT)
    if count < len(points):
        points = voxel_means(points, labels, count)
        sides = None if sides is None else voxel_means(sides, labels, count)
    kept = without_outliers(points, CLUTTER_LIMIT, CLUTTER_ROUNDS)
    return points[kept], None if sides is None else sides[kept]


def without_plinth(points: Points, sides: Points | None) -> tuple[Points, Points | None]:
    """Leave out a plinth.

    Parameters
    ----------
    points : (n, 3) float
        The cloud, without much clutter.
    sides : (n, 3) float or None
        Outward normals.

    Returns
    -------
    points, sides
        Those above the plinth; all of them without one.
    """
    diagonal = robust_diagonal(points)
    if diagonal == 0.0:  # nearly all points in one place
        return points, sides
    left = off_plinth(points / diagonal)
    return points[left], None if sides is None else sides[left]
