"""What was measured already, although a mirror image does not fall on it to the point.

No statue is exactly symmetric: mirror images of a surface that was measured on both sides hover a
little over or under it, and a fill that judges by distance alone would lay a second skin there.
An image counts as covered when a measured surface that faces the same way lies straight below or
above it; beyond the rim of a hole the nearest measured point lies off to the side.
"""

from __future__ import annotations

import numpy as np

from meshlab_symrecon.arrays import Booleans, Floats, Points

__all__ = ["covered"]

HOVER = 0.03  # diagonals: how far two sides of a statue may differ
HOVER_UNFACED = 0.015  # the same without outward normals, since thin parts have two sides
SLANT = 0.36  # tangent of 20 degrees: how far off the vertical still counts as straight below
FACING = 0.5  # cosine of 60 degrees between normals that face the same way


def covered(
    offsets: Points,
    upright: Points,
    facing: Floats,
    reach: Floats,
    diagonal: float,
    *,
    outward: bool,
) -> Booleans:
    """Tell which mirror images hover over a measured surface.

    Parameters
    ----------
    offsets : (m, 3) float
        From the nearest measured point to the image.
    upright : (m, 3) float
        Unit normal of the measured surface there, of any sign.
    facing : (m,) float
        Cosine between the measured normal and the image's.
    reach : (m,) float
        How far off to the side the nearest point may be in any case: the gap that is left open.
    diagonal : float
        Of the cloud's box.
    outward : bool
        The normals behind ``facing`` tell inside from outside.

    Returns
    -------
    (m,) bool
        True where the image hovers; lengths are in the units of the points.
    """
    heights = np.einsum("ij,ij->i", offsets, upright)
    aside = np.sqrt(np.maximum(np.einsum("ij,ij->i", offsets, offsets) - heights**2, 0.0))
    height = np.abs(heights)
    hover = (HOVER if outward else HOVER_UNFACED) * diagonal
    alike = (facing if outward else np.abs(facing)) > FACING
    below: Booleans = alike & (height <= hover) & (aside <= np.maximum(reach, SLANT * height))
    return below
