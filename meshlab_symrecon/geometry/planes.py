"""Planes ``Ax + By + Cz + D = 0`` and reflections across them."""

from __future__ import annotations

import numpy as np

from meshlab_symrecon.arrays import Booleans, Floats, Indices, Planes, Points

__all__ = [
    "canonical_planes",
    "distinct_planes",
    "near_plane",
    "plane_angles",
    "reflect",
    "reflect_directions",
    "signed_distances",
]


def signed_distances(points: Points, plane: Floats) -> Floats:
    """Return the distances of points from a plane, positive on the side its normal faces.

    Parameters
    ----------
    points : (n, 3) float
        Positions.
    plane : (4,) float
        Unit normal A, B, C and offset D.

    Returns
    -------
    (n,) float
        Signed distances, in the units of the points.
    """
    distances: Floats = points @ plane[:3] + plane[3]
    return distances


def reflect(points: Points, plane: Floats) -> Points:
    """Mirror points across a plane.

    Parameters
    ----------
    points : (n, 3) float
        Positions.
    plane : (4,) float
        Unit normal A, B, C and offset D.

    Returns
    -------
    (n, 3) float
        ``x - 2 (n . x + D) n`` for every point x.

    Examples
    --------
    >>> reflect(np.array([[1.0, 2.0, 3.0]]), np.array([1.0, 0.0, 0.0, -4.0]))
    array([[7., 2., 3.]])
    """
    mirrored: Points = points - 2.0 * np.outer(signed_distances(points, plane), plane[:3])
    return mirrored


def reflect_directions(directions: Points, plane: Floats) -> Points:
    """Mirror directions, such as normals, by ``I - 2 n n^T``.

    A reflection maps the outward normal of a surface to the outward normal of its mirror image, so
    orientation is kept; only the winding of triangles has to be turned round.

    Parameters
    ----------
    directions : (n, 3) float
        Directions of any length.
    plane : (4,) float
        Unit normal A, B, C and offset D.

    Returns
    -------
    (n, 3) float
        Directions of the same lengths.
    """
    normal = plane[:3]
    mirrored: Points = directions - 2.0 * np.outer(directions @ normal, normal)
    return mirrored


def canonical_planes(planes: Planes) -> Planes:
    """Choose between the two ways to write each plane: its largest normal component is positive.

    Of components equal in size, the first one decides.

    Parameters
    ----------
    planes : (k, 4) float
        Unit normals and offsets.

    Returns
    -------
    (k, 4) float
        The same planes.

    Examples
    --------
    >>> canonical_planes(np.array([[0.0, -1.0, 0.0, 2.0]]))
    array([[0., 1., 0., -2.]])
    """
    rows = np.arange(len(planes))
    largest = np.argmax(np.abs(planes[:, :3]), axis=1)
    signs = np.where(planes[rows, largest] < 0.0, -1.0, 1.0)
    return planes * signs[:, np.newaxis] + 0.0  # + 0.0 turns -0.0 into 0.0


def plane_angles(planes: Planes, plane: Floats) -> Floats:
    """Return the angles between planes and one plane, 0 to pi/2, exact near zero too.

    Parameters
    ----------
    planes : (k, 4) float
        Unit normals and offsets.
    plane : (4,) float
        Unit normal and offset.

    Returns
    -------
    (k,) float
        Angles in radians.
    """
    sines = np.linalg.norm(np.cross(planes[:, :3], plane[:3]), axis=1)
    angles: Floats = np.arctan2(sines, np.abs(planes[:, :3] @ plane[:3]))
    return angles


def near_plane(planes: Planes, plane: Floats, limits: tuple[float, float]) -> Booleans:
    """Tell which planes nearly repeat one plane.

    Parameters
    ----------
    planes : (k, 4) float
        Unit normals and offsets; the origin near the middle of the cloud.
    plane : (4,) float
        Unit normal and offset.
    limits : pair of float
        Angle in radians and difference of offsets, both of which have to be smaller.

    Returns
    -------
    (k,) bool
    """
    signs = np.where(planes[:, :3] @ plane[:3] < 0.0, -1.0, 1.0)
    shifts = np.abs(signs * planes[:, 3] - plane[3])
    near: Booleans = (plane_angles(planes, plane) < limits[0]) & (shifts < limits[1])
    return near


def distinct_planes(planes: Planes, scores: Floats, same: tuple[float, float]) -> Indices:
    """Return the planes without those that nearly repeat a better one.

    Parameters
    ----------
    planes : (k, 4) float
        Unit normals and offsets; the origin near the middle of the cloud.
    scores : (k,) float
        Higher is better.
    same : pair of float
        Planes repeat each other below this angle in radians and this difference of offsets.

    Returns
    -------
    (m,) int
        Rows that stay, best first.
    """
    kept: list[int] = []
    for row in np.argsort(-scores, kind="stable"):
        if not near_plane(planes[kept], planes[row], same).any():
            kept.append(int(row))
    return np.array(kept, dtype=np.int64)
