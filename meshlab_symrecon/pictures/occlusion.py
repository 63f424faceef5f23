"""Ambient occlusion: how much of the sky each pixel sees, from the depths around it."""

from __future__ import annotations

import numpy as np

from meshlab_symrecon.arrays import Floats
from meshlab_symrecon.pictures.relief import shifted

__all__ = ["GOLDEN_ANGLE", "ambient_light"]

TAPS = 40
GOLDEN_ANGLE = np.pi * (3.0 - np.sqrt(5.0))  # spreads taps evenly over a disc
REACH = 0.07  # of the picture's height: as far as hollows are felt
BIAS = 0.12  # sine below which a neighbour is taken for the surface itself
STRENGTH = 1.9  # chosen by eye


def ambient_light(depth: Floats, normal: Floats) -> Floats:
    """Return (height, width) shares of ambient light, 1 on a convex or flat surface.

    Parameters
    ----------
    depth : (height, width) float
        In pixels; infinite where nothing is.
    normal : (height, width, 3) float
        Unit normals (right, up, towards the viewer).

    Notes
    -----
    Every tap takes away the sine of its height above the tangent plane, fading with distance,
    after McGuire et al., The Alchemy screen-space ambient obscurance algorithm (HPG 2011), eq. 9.
    """
    reach = REACH * depth.shape[0]
    blocked = np.zeros_like(depth)
    for tap in range(TAPS):
        distance = reach * (tap + 0.5) / TAPS  # denser towards the middle than by area
        angle = tap * GOLDEN_ANGLE
        columns, rows = (int(round(distance * turn)) for turn in (np.cos(angle), np.sin(angle)))
        if rows == columns == 0:
            continue
        with np.errstate(invalid="ignore"):
            nearer = depth - shifted(depth, rows, columns, np.inf)
        nearer = np.where(np.isfinite(nearer), nearer, -np.inf)
        beside = columns * normal[..., 0] - rows * normal[..., 1]
        with np.errstate(invalid="ignore"):
            above = beside + nearer * normal[..., 2]
            length = np.sqrt(columns**2 + rows**2 + nearer**2)
            sine = np.where(np.isfinite(nearer), above / length, 0.0)
        fade = np.clip(1.0 - (length / (2.0 * reach)) ** 2, 0.0, 1.0)
        blocked += np.clip(sine - BIAS, 0.0, None) * np.where(np.isfinite(fade), fade, 0.0)
    light: Floats = 1.0 / (1.0 + STRENGTH * blocked * 2.0 / TAPS) ** 2
    return light
