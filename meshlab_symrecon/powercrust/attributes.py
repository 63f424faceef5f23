"""Attributes of samples carried over to a surface."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from meshlab_symrecon.arrays import Floats, Points

__all__ = ["carry_over"]

NEIGHBOURS = 4


def carry_over(samples: Points, values: Floats, points: Points) -> Floats:
    """Average the values of the samples nearest to each point, by inverse distance.

    Parameters
    ----------
    samples : (n, 3) float
    values : (n,) or (n, c) float
        Such as colours, or 0 for measured and 1 for invented.
    points : (v, 3) float

    Returns
    -------
    (v,) or (v, c) float
        At a sample, exactly its own value.
    """
    count = min(NEIGHBOURS, len(samples))
    distance, nearest = cKDTree(samples).query(points, k=count)
    distance, nearest = distance.reshape(-1, count), nearest.reshape(-1, count)
    exact = distance[:, 0] == 0.0
    weights = 1.0 / np.where(exact[:, None], 1.0, distance)
    weights[exact] = np.arange(count) == 0
    weights /= weights.sum(axis=1, keepdims=True)
    around = values[nearest]
    carried = np.einsum("vk,vk...->v...", weights, around)
    # weights add up to one but for rounding: keep shares within 0 and 1
    within: Floats = np.clip(carried, around.min(axis=1), around.max(axis=1))
    return within
