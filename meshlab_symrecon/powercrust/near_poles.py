"""Poles that are nearly at one place, joined.

The inner poles of an exact sphere, cylinder or torus crowd at a point or on a curve, much denser
than the samples.  Their balls are nearly equal, so one serves for all that are near; the surface
moves by less than their distance.  On free-form surfaces hardly any poles are that near.
"""

from __future__ import annotations

import numpy as np

from meshlab_symrecon import _native
from meshlab_symrecon.arrays import Floats
from meshlab_symrecon.powercrust.poles import Poles

__all__ = ["join_near_poles"]

NEAR = 0.1  # local spacings: what the samples cannot tell apart
FARTHEST = 2.0**62  # blocks, which 64-bit numbers still count
CROWDED = 0.8  # share of blocks of that size among the poles, below which poles crowd


def join_near_poles(poles: Poles) -> Poles:
    """Return poles of which none are nearly at one place.

    The pole with the largest ball stands for those round it, and takes their place in the pairs of
    samples.  Poles that are outside for certain stay, and so do all poles where few are near
    others.

    Parameters
    ----------
    poles : Poles
    """
    spacing = np.append(poles.room, np.inf)[np.minimum(poles.samples, poles.sample_count)]
    reach: Floats = NEAR * spacing.min(axis=1)
    widest = float(np.median(reach))
    if not 0.0 < widest < np.inf or not _crowd(poles, widest):
        return poles
    movable = np.flatnonzero(~poles.outermost)
    order = movable[np.argsort(-poles.radii[movable], kind="stable")]
    keeper = _native.nearest_kept(
        poles.centres, np.minimum(reach, widest), order.astype(np.int32), widest
    )
    keep = (keeper == np.arange(len(keeper))) | poles.outermost
    number = np.cumsum(keep) - 1
    number = np.where(keep, number, number[keeper])
    pairs = number[poles.pairs]
    apart = pairs[:, 0] != pairs[:, 1]
    return poles.only(keep, pairs[apart], poles.pair_samples[apart])


def _crowd(poles: Poles, widest: float) -> bool:
    """Say whether many poles share a block of the given width with others."""
    inner = poles.centres[~poles.outermost]
    steps = np.clip(np.floor(inner / widest), -FARTHEST, FARTHEST)
    blocks = steps.astype(np.int64) & 0x1FFFFF  # 21 bits a coordinate
    keys = np.sort((blocks[:, 0] << 42) | (blocks[:, 1] << 21) | blocks[:, 2])
    return bool(1 + np.count_nonzero(np.diff(keys)) < CROWDED * len(keys))
