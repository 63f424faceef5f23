"""Flat breaks: the plane that the rims of a cloud lie on, beyond which all is missing."""

from __future__ import annotations

import numpy as np

from meshlab_symrecon.arrays import Booleans, Floats, Points

__all__ = ["FEWEST_RIM", "NOT_BROKEN", "broken_off", "on_plane", "rim_plane", "rim_reach"]

# Lengths are in diagonals of the cloud.
RIM_SPACINGS, LEAST_RIM = 1.5, 0.008  # distance from the plane within which a rim point is on it
FEWEST_RIM = 30  # points
TRIPLES = 2_000  # of rim points that are tried
POLISHING = 5  # rounds of fitting to the rim points on the plane
LEAST_SPREAD = 0.01  # sine between the sides of a triple: collinear points span no plane
LEAST_SHARE = 0.5  # of the rim on the plane of a break
MOST_BEYOND = 0.01  # share of the cloud beyond it
RAGGED = 2.0  # spacings over which a break ends
NOT_BROKEN = np.array([0.0, 0.0, 0.0, 1.0])  # everything lies above this plane
NOT_BROKEN.setflags(write=False)


def rim_reach(spacing: float) -> float:
    """Return the distance from a plane within which rim points are on it, in diagonals."""
    return max(RIM_SPACINGS * spacing, LEAST_RIM)


def on_plane(points: Points, plane: Floats, spacing: float) -> Booleans:
    """Tell which rim points (n, 3) lie on a plane."""
    near: Booleans = np.abs(points @ plane[:3] + plane[3]) < rim_reach(spacing)
    return near


def rim_plane(points: Points, rim: Booleans, spacing: float) -> Floats | None:
    """Fit a plane to the rims of a cloud's holes.

    Parameters
    ----------
    points : (m, 3) float
        The cloud.
    rim : (m,) bool
        Its points on rims.
    spacing : float
        Of its points, in diagonals.

    Returns
    -------
    (4,) float or None
        The plane with most rim points on it, its normal towards the cloud; None with fewer than
        30 rim points, or when they lie on one line.
    """
    rims = points[rim]
    if len(rims) < FEWEST_RIM:
        return None
    triples = np.random.default_rng(0).integers(0, len(rims), (TRIPLES, 3))
    sides = rims[triples[:, 1:]] - rims[triples[:, :1]]
    normals = np.cross(sides[:, 0], sides[:, 1])
    lengths = np.linalg.norm(normals, axis=1)
    spread = lengths > LEAST_SPREAD * np.prod(np.linalg.norm(sides, axis=2), axis=1)
    if not spread.any():
        return None
    normals = normals[spread] / lengths[spread, np.newaxis]
    offsets = -np.einsum("ti,ti->t", normals, rims[triples[spread, 0]])
    heights = np.abs(normals @ rims.T + offsets[:, np.newaxis])
    best = int(np.argmax((heights < rim_reach(spacing)).sum(axis=1)))
    plane = np.append(normals[best], offsets[best])
    for _ in range(POLISHING):
        inside = rims[on_plane(rims, plane, spacing)]
        centre = inside.mean(axis=0)
        normal = np.linalg.svd(inside - centre, full_matrices=False)[2][2]
        plane = np.append(normal, -normal @ centre)
    towards = np.sign(np.median(points @ plane[:3] + plane[3]))
    return plane if towards >= 0.0 else -plane


def broken_off(points: Points, rim: Booleans, plane: Floats | None, spacing: float) -> Floats:
    """Tell where a cloud is known to end.

    A break is ragged: the plane lies where it begins, two spacings inside the cloud.

    Parameters
    ----------
    points : (m, 3) float
        The cloud.
    rim : (m,) bool
        Its points on rims.
    plane : (4,) float or None
        Of its rims.
    spacing : float
        Of its points.

    Returns
    -------
    (4,) float
        What lies below this plane is missing; `NOT_BROKEN` when the cloud ends at no plane.
    """
    if plane is None:
        return NOT_BROKEN
    share = on_plane(points[rim], plane, spacing).mean()
    beyond = (points @ plane[:3] + plane[3] < -rim_reach(spacing)).mean()
    if share < LEAST_SHARE or beyond > MOST_BEYOND:
        return NOT_BROKEN
    return plane - np.array([0.0, 0.0, 0.0, RAGGED * spacing])
