"""Which side of the surface is outside."""

from __future__ import annotations

import numpy as np

from meshlab_symrecon.arrays import Booleans, Points
from meshlab_symrecon.geometry.sampling import farthest_point_order

__all__ = ["orient"]

RADIUS = 0.22  # diagonals: of the ball whose centroid tells the inside from the outside
CLEAR = 0.12  # of that radius: a smaller offset of the centroid tells nothing
ENOUGH_CLEAR = 0.05  # share of the cloud below which its shape contradicts no hint
CERTAIN = 0.5  # cosine between a hint and a normal that tells its side
CONSISTENT = 0.85  # share of the clear places in which hints have to agree with the centroids
TINY = float(np.finfo(np.float64).tiny)
LANDMARKS = 600  # even samples that stand for all


def orient(points: Points, normals: Points, hints: Points | None) -> tuple[Points, Booleans]:
    """Turn normals away from the centroid of their surroundings, or to the side of the hints.

    Hints that all point inwards are turned round. Those that contradict the centroids in many
    places are guesses, such as normals of a cloud often are, and are not used.

    Parameters
    ----------
    points, normals : (m, 3) float
        A cloud with a diagonal of about 1, and unit normals of either sign.
    hints : (m, 3) float or None
        Outward directions.

    Returns
    -------
    normals : (m, 3) float
        The normals, some of them turned.
    oriented : (m,) bool
        Where the side is known; elsewhere the sign means nothing.
    """
    landmarks = points[farthest_point_order(points, LANDMARKS)]
    squares = ((points**2).sum(axis=1)[:, np.newaxis] + (landmarks**2).sum(axis=1)) - (
        2.0 * points @ landmarks.T
    )
    near = (squares < RADIUS**2).astype(np.float64)
    centroids = near @ landmarks / np.maximum(near.sum(axis=1), 1.0)[:, np.newaxis]
    along = -np.einsum("mi,mi->m", centroids - points, normals)
    clear = np.abs(along) > CLEAR * RADIUS
    if hints is not None:
        given = np.einsum("mi,mi->m", normals, hints)
        certain = np.abs(given) > CERTAIN * np.maximum(np.linalg.norm(hints, axis=1), TINY)
        both = clear & certain
        outwards = np.sign(given[both]) == np.sign(along[both])
        if both.mean() < ENOUGH_CLEAR or outwards.mean() >= CONSISTENT:
            along, clear = given, certain
        elif outwards.mean() <= 1.0 - CONSISTENT:
            along, clear = -given, certain
    return normals * np.where(along < 0.0, -1.0, 1.0)[:, np.newaxis], clear
