"""Density: what is filled in is as dense as what was measured round it."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from meshlab_symrecon.arrays import Booleans, Floats, Indices, Points
from meshlab_symrecon.geometry.neighbours import blocks

__all__ = ["as_dense_as_around"]

SURROUNDINGS = 64  # measured points round a place of the rim whose spacing counts
SAME = 1.3  # ratio of spacings up to which the fill is left as it is


def as_dense_as_around(
    images: Points,
    own: Floats,
    points: Points,
    spacing: Floats,
    rim: Indices,
) -> Booleans:
    """Choose which mirror images to keep, so that the fill is no denser than its surroundings.

    Parameters
    ----------
    images : (m, 3) float
        What fills holes, along a space-filling curve, so that every n-th is an even part.
    own : (m,) float
        Spacing of the points they are images of.
    points : (n, 3) float
        What was measured.
    spacing : (n,) float
        Of each.
    rim : (m,) int
        The measured point nearest to each image.

    Returns
    -------
    (m,) bool
        Every image where the spacings are alike, else such a share that they become alike.
    """
    if len(images) == 0:
        return np.zeros(0, dtype=bool)
    places, place = np.unique(rim, return_inverse=True)
    count = min(SURROUNDINGS, len(points))
    tree, usual = cKDTree(points), np.zeros(len(places))
    for rows in blocks(len(places)):
        around = tree.query(points[places[rows]], k=count)[1].reshape(-1, count)
        usual[rows] = np.median(spacing[around], axis=1)
    outside = usual[place.reshape(-1)]
    inside = _smoothed(own)
    ratio = outside / np.maximum(inside, np.finfo(np.float64).tiny)
    share = np.where(ratio > SAME, ratio**-2.0, 1.0)
    summed = np.cumsum(share)
    kept: Booleans = np.floor(summed + 0.5) > np.floor(summed - share + 0.5)
    return kept


def _smoothed(own: Floats) -> Floats:
    """Return the median of the spacing, by blocks along the curve."""
    rest = -len(own) % SURROUNDINGS
    blocks = np.append(own, np.full(rest, own[-1])).reshape(-1, SURROUNDINGS)
    smoothed: Floats = np.repeat(np.median(blocks, axis=1), SURROUNDINGS)[: len(own)]
    return smoothed
