"""Planes as a mesh that people can see and move: one rectangle a plane, and back."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from meshlab_symrecon.arrays import Faces, Floats, Planes, Points, as_points
from meshlab_symrecon.errors import GeometryError

__all__ = ["PLANES_LABEL", "planes_as_quads", "planes_of_pieces"]

PLANES_LABEL = "reflection planes"  # of the layer in which planes travel from filter to filter
UNEVEN = 1e-2  # of a piece's size: a thicker piece is no plane that somebody moved or drew
NEEDLE = 1e-9  # of a piece's size: a narrower piece has no direction to face


def planes_as_quads(planes: Planes, points: Points) -> tuple[Points, Faces]:
    """Return a rectangle of two triangles for each plane, spanning the box of the points.

    Parameters
    ----------
    planes : (k, 4) float
        Rows (A, B, C, D) with unit normal and ``Ax + By + Cz + D = 0``.
    points : (n, 3) float

    Returns
    -------
    points : (4 k, 3) float
    faces : (2 k, 3) int
        Facing along the normal.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]) * (high - low)
    longest = np.eye(3)[np.argsort(low - high)]
    quads = [_quad(plane, low, corners, longest) for plane in planes]
    faces = np.arange(len(planes))[:, None, None] * 4 + np.array([[0, 1, 2], [0, 2, 3]])
    return np.reshape(quads, (-1, 3)).astype(float), faces.reshape(-1, 3)


def _quad(plane: Floats, low: Floats, corners: Points, longest: Points) -> Points:
    normal = plane[:3]
    sideways = np.cross(longest, normal)
    first = sideways[np.argmax(np.linalg.norm(sideways, axis=1))]
    first /= np.linalg.norm(first)
    second = np.cross(normal, first)
    foot = -(plane[3] + low @ normal) * normal  # of the box's low corner, seen from there
    u, v = corners @ first, corners @ second
    along = np.array(
        [[u.min(), v.min()], [u.max(), v.min()], [u.max(), v.max()], [u.min(), v.max()]]
    )
    quad: Points = low + foot + along @ np.stack([first, second])
    return quad


def planes_of_pieces(points: Points, faces: Faces) -> Planes:
    """Return the plane of every connected piece of a mesh, in the order of first appearance.

    Parameters
    ----------
    points : (n, 3) float
    faces : (m, 3) int
        Rectangles as ``planes_as_quads`` makes them, moved, edited or drawn by hand.

    Returns
    -------
    (k, 4) float
        Facing as the piece's first face does.

    Raises
    ------
    GeometryError
        There are no faces; a piece is not flat, or has no area; a corner is not finite.
    """
    points = as_points(points)
    if not len(faces):
        message = (
            f"planes need a rectangle or triangle each; got a layer of {len(points)} points that "
            "has no faces; detect planes first, or draw one"
        )
        raise GeometryError(message)
    sides = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]]])
    links = coo_matrix((np.ones(len(sides)), sides.T), shape=(len(points), len(points)))
    piece = connected_components(links, directed=False)[1][faces[:, 0]]
    _, first, sizes = np.unique(piece, return_index=True, return_counts=True)
    members = np.split(np.argsort(piece, kind="stable"), np.cumsum(sizes)[:-1])
    planes = [
        _fitted(points[np.unique(faces[members[label]])], points[faces[first[label]]], number)
        for number, label in enumerate(np.argsort(first))
    ]
    return np.reshape(planes, (-1, 4)).astype(float)


def _fitted(corners: Points, first_face: Points, number: int) -> Floats:
    centre = corners.mean(axis=0)
    _, spread, axes = np.linalg.svd(corners - centre, full_matrices=False)
    if len(spread) < 3 or spread[1] <= NEEDLE * spread[0] or spread[2] > UNEVEN * spread[0]:
        message = (
            f"piece {number} of the planes layer must be a flat patch; got {len(corners)} corners "
            f"with spreads {', '.join(f'{value:.3g}' for value in spread)}; "
            "keep one rectangle a plane"
        )
        raise GeometryError(message)
    normal = axes[2]
    facing = np.cross(first_face[1] - first_face[0], first_face[2] - first_face[0])
    if normal @ facing < 0.0:
        normal = -normal
    return np.append(normal, -normal @ centre)
