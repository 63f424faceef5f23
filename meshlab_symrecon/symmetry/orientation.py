"""Which side of the surface is outside."""

from __future__ import annotations

import numpy as np

from meshlab_symrecon.arrays import Booleans, Points
from meshlab_symrecon.geometry.sampling import farthest_point_order

__all__ = ["orient"]

RADIUS = 0.22  # diagonals: of the ball whose centroid tells the inside from the outside
CLEAR = 0.12  # of that radius: a smaller offset of the centroid tells nothing
LANDMARKS = 600  # even samples that stand for all


def orient(points: Points, normals: Points, hints: Points | None) -> tuple[Points, Booleans]:
    """Turn normals away from the centroid of their surroundings, or to the side of the hints.

    Parameters
    ----------
    points, normals : (m, 3) float
        A cloud with a diagonal of about 1, and unit normals of either sign.
    hints : (m, 3) float or None
        Outward directions, the longer the more certain.

    Returns
    -------
    normals : (m, 3) float
        The normals, some of them turned.
    oriented : (m,) bool
        Where the side is known; elsewhere the sign means nothing.
    """
    if hints is not None:
        along = np.einsum("mi,mi->m", normals, hints)
        clear = np.abs(along) > 0.5 * np.linalg.norm(hints, axis=1)
    else:
        landmarks = points[farthest_point_order(points, LANDMARKS)]
        squares = ((points**2).sum(axis=1)[:, np.newaxis] + (landmarks**2).sum(axis=1)) - (
            2.0 * points @ landmarks.T
        )
        near = (squares < RADIUS**2).astype(np.float64)
        centroids = near @ landmarks / np.maximum(near.sum(axis=1), 1.0)[:, np.newaxis]
        along = -np.einsum("mi,mi->m", centroids - points, normals)
        clear = np.abs(along) > CLEAR * RADIUS
    return normals * np.where(along < 0.0, -1.0, 1.0)[:, np.newaxis], clear
