"""A plinth under a statue has planes of its own; here it is found and left out."""

from __future__ import annotations

import numpy as np

from meshlab_symrecon.arrays import Booleans, Floats, Indices, Points
from meshlab_symrecon.geometry.neighbours import principal_normals

__all__ = ["off_plinth", "plinth_top"]

# Lengths are in diagonals of the cloud.
LANDMARKS = 1_600
SEEDS = 400  # landmarks whose tangent planes are tried
NEIGHBOURS = 30
FACE_WIDTH = 0.012  # distance from its plane within which a point lies on a face
FACE_DIRECTION = np.cos(np.radians(15.0))
LEAST_FACE = 0.035  # share of the cloud that makes a face
OUTSIDE = 0.02  # distance from the ground beyond which a point is below it
MOST_OUTSIDE = 0.03  # share of the cloud below its ground: clutter
MOST_GROUNDS = 6
LOWEST, HIGHEST = 0.02, 0.16  # of the top face above the ground
UPRIGHT = np.sin(np.radians(25.0))  # sine of the slope of the walls
MOSTLY = 0.3  # share of upright points among those between the two faces; noise tilts many
LEAST_LEFT = 0.4  # share of the cloud that stays


def off_plinth(points: Points) -> Booleans:
    """Tell which points do not belong to a plinth.

    Parameters
    ----------
    points : (n, 3) float
        A cloud with a diagonal of about 1, without much clutter.

    Returns
    -------
    (n,) bool
        False on the plinth; all true without one.
    """
    top = plinth_top(points)
    if top is None:
        return np.ones(len(points), dtype=bool)
    left: Booleans = points @ top[:3] + top[3] > FACE_WIDTH
    return left


def plinth_top(points: Points) -> Floats | None:
    """Find the face of a plinth that the statue stands on.

    A plinth is the part of the cloud between a flat ground, below which nothing lies, and a flat
    top parallel to it, with upright walls in between; most of the cloud stands above it.

    Parameters
    ----------
    points : (n, 3) float
        A cloud with a diagonal of about 1, without much clutter.

    Returns
    -------
    (4,) float or None
        The plane of the top, its normal upwards; None without a plinth.
    """
    if len(points) < LANDMARKS // 4:
        return None
    places = points[:: max(1, len(points) // LANDMARKS)]
    normals, _ = principal_normals(points, places, NEIGHBOURS)
    for ground in _grounds(places, normals):
        on_ground = _on_plane(places, normals, places[ground], normals[ground])
        origin = places[on_ground].mean(axis=0)
        upwards = np.linalg.svd(places[on_ground] - origin, full_matrices=False)[2][2]
        heights = (places - origin) @ upwards
        if heights.mean() < 0.0:
            upwards, heights = -upwards, -heights
        top = _top(heights, np.abs(normals @ upwards))
        if top is not None:
            above = (points - origin) @ upwards > top + FACE_WIDTH
            if above.mean() >= LEAST_LEFT:
                return np.append(upwards, -origin @ upwards - top)
    return None


def _on_plane(places: Points, normals: Points, origin: Floats, normal: Floats) -> Booleans:
    near = np.abs((places - origin) @ normal) < FACE_WIDTH
    on_plane: Booleans = near & (np.abs(normals @ normal) > FACE_DIRECTION)
    return on_plane


def _grounds(places: Points, normals: Points) -> Indices:
    """Return landmarks on large flat faces with nothing beyond, one a face, largest first."""
    seeds = np.arange(0, len(places), max(1, len(places) // SEEDS))
    own = np.einsum("si,si->s", places[seeds], normals[seeds])
    heights = places @ normals[seeds].T - own  # (n, s)
    flat = np.abs(heights) < FACE_WIDTH
    flat &= np.abs(normals @ normals[seeds].T) > FACE_DIRECTION
    shares = flat.mean(axis=0)
    beyond = np.minimum((heights > OUTSIDE).mean(axis=0), (heights < -OUTSIDE).mean(axis=0))
    shares[beyond > MOST_OUTSIDE] = 0.0
    chosen: list[int] = []
    while len(chosen) < MOST_GROUNDS and shares.max() >= LEAST_FACE:
        best = int(np.argmax(shares))
        chosen.append(int(seeds[best]))
        shares[flat[seeds[best]]] = 0.0  # seeds whose faces hold this landmark
        shares[best] = 0.0
    return np.array(chosen, dtype=np.int64)


def _top(heights: Floats, level: Floats) -> float | None:
    """Return the height of the largest flat top above a ground, None without upright walls.

    Parameters
    ----------
    heights : (n,) float
        Of the landmarks, above the ground.
    level : (n,) float
        Cosine between their normals and the vertical.
    """
    flat = np.sort(heights[(level > FACE_DIRECTION) & (heights > LOWEST) & (heights < HIGHEST)])
    ends = np.searchsorted(flat, flat + 2.0 * FACE_WIDTH, side="right")
    counts = ends - np.arange(len(flat))
    if len(flat) == 0 or counts.max() < LEAST_FACE * len(heights):
        return None
    first = int(np.argmax(counts))
    top = float(np.median(flat[first : ends[first]]))
    between = (heights > FACE_WIDTH) & (heights < top - FACE_WIDTH)
    upright = level[between] < UPRIGHT
    return top if len(upright) and upright.mean() >= MOSTLY else None
