"""Small polar balls: what noise makes, told by their size beside the spacing of the samples.

On a clean surface both polar balls of a sample are much larger than the distance to the next
samples.  Noise makes poles inside the band of the samples, whose balls are about as large as the
spacing.  They bend the surface and, between two sheets, pierce it (Mederos, Amenta, Velho,
Figueiredo, "Surface reconstruction from noisy point clouds", 2005, keep large balls alone).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from meshlab_symrecon.arrays import Booleans, Floats
from meshlab_symrecon.powercrust.poles import Poles

__all__ = ["AUTOMATIC_SMALLEST", "drop_small_balls", "relative_sizes", "smallest_ball"]

NOISY = 1.3  # spacings: the median smaller ball of a sample where noise is as wide as the spacing
AUTOMATIC_SMALLEST = 1.0  # spacings: smaller balls of so noisy samples are dropped


def relative_sizes(poles: Poles) -> Floats:
    """Return (p,) the radius of each polar ball in multiples of the local spacing.

    The spacing is the largest mean distance to neighbours among the samples on the ball; balls that
    touch no sample are infinitely large.
    """
    room = np.append(poles.room, 0.0)[np.minimum(poles.samples, poles.sample_count)].max(axis=1)
    with np.errstate(divide="ignore"):
        sizes: Floats = poles.radii / room
    return sizes


def smallest_ball(poles: Poles) -> float:
    """Return the least size of balls to keep that suits the samples, in multiples of the spacing.

    Zero unless most samples have a ball hardly larger than the spacing, the mark of noise.
    """
    if not len(poles.pairs):
        return 0.0
    smaller = poles.radii[poles.pairs].min(axis=1) / poles.room[poles.pair_samples]
    return AUTOMATIC_SMALLEST if float(np.median(smaller)) < NOISY else 0.0


def drop_small_balls(poles: Poles, smallest: float) -> tuple[Poles, int]:
    """Return the poles without those whose balls are small, and how many those are.

    Samples that lose a pole keep the other one, but are no pair any more.

    Parameters
    ----------
    poles : Poles
    smallest : float
        In multiples of the local spacing; 0 keeps all.
    """
    keep: Booleans = (relative_sizes(poles) >= smallest) | poles.outermost
    if keep.all():
        return poles, 0
    number = np.cumsum(keep) - 1
    paired = keep[poles.pairs].all(axis=1)
    kept = replace(
        poles,
        centres=poles.centres[keep],
        radii=poles.radii[keep],
        samples=poles.samples[keep],
        pairs=number[poles.pairs[paired]],
        pair_samples=poles.pair_samples[paired],
        outermost=poles.outermost[keep],
    )
    return kept, int(np.count_nonzero(~keep))
