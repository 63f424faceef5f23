"""Attributes of samples carried over to a surface."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.spatial import cKDTree

from meshlab_symrecon.arrays import Floats, Points
from meshlab_symrecon.geometry.neighbours import blocks

__all__ = ["carry_over"]

NEIGHBOURS = 4


def carry_over(
    samples: Points,
    values: Floats,
    points: Points,
    *,
    progress: Callable[[float], None] | None = None,
) -> Floats:
    """Average the values of the samples nearest to each point, by inverse distance.

    Parameters
    ----------
    samples : (n, 3) float
    values : (n,) or (n, c) float
        Such as colours, or 0 for measured and 1 for invented.
    points : (v, 3) float
    progress : callable, optional
        Called with the share done, 0 to 1.

    Returns
    -------
    (v,) or (v, c) float
        At a sample, exactly its own value.
    """
    count = min(NEIGHBOURS, len(samples))
    tree = cKDTree(samples)
    carried = np.zeros((len(points), *values.shape[1:]))
    for rows in blocks(len(points), progress):
        distance, nearest = tree.query(points[rows], k=count)
        carried[rows] = _averaged(distance.reshape(-1, count), values[nearest.reshape(-1, count)])
    return carried


def _averaged(distance: Floats, around: Floats) -> Floats:
    """Return the means of values (v, k) or (v, k, c), by inverse distance (v, k)."""
    exact = distance[:, 0] == 0.0
    weights = 1.0 / np.where(exact[:, None], 1.0, distance)
    weights[exact] = np.arange(distance.shape[1]) == 0
    weights /= weights.sum(axis=1, keepdims=True)
    carried = np.einsum("vk,vk...->v...", weights, around)
    # weights add up to one but for rounding: keep shares within 0 and 1
    within: Floats = np.clip(carried, around.min(axis=1), around.max(axis=1))
    return within
