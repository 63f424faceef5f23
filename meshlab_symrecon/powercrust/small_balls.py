"""Small polar balls: what noise makes, told by their size beside the spacing of the samples.

A sample of a surface has at least one polar ball much larger than the distance to the next
samples: both in a thick part, the outer one in a thin part.  Noise makes samples with two small
balls, inside the band that it spreads the surface to.  Such balls bend the surface and, between two
sheets, pierce it (Mederos, Amenta, Velho, Figueiredo, "Surface reconstruction from noisy point
clouds", 2005, keep large balls alone).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshlab_symrecon.arrays import Booleans, Floats
from meshlab_symrecon.powercrust.poles import Poles

__all__ = ["NoiseLimits", "drop_small_balls", "noise_limits", "relative_sizes"]

ROUND = 3.0  # spacings: the larger ball of a sample of a surface is larger
SOME_NOISE = 0.12  # share of samples with two small balls; finely detailed clean clouds reach 0.11
UNEVEN = 1.5  # times the usual spacing of the samples on a ball: more says nothing of the ball
THIN, THICK = 1.0, 1.5  # a handle needs a ball of this size: of clean samples, of noisy ones
MUCH_NOISE = 0.5  # the same where the noise is as wide as the spacing


@dataclass(frozen=True, slots=True)
class NoiseLimits:
    """What is too small to be trusted, in multiples of the local spacing.

    Attributes
    ----------
    ball : float
        Smaller polar balls are dropped.
    handle : float
        A handle needs a ball of this size on its narrowest way.
    """

    ball: float
    handle: float


def relative_sizes(poles: Poles) -> Floats:
    """Return (p,) the radius of each polar ball in multiples of the local spacing.

    The spacing is the largest mean distance to neighbours among the samples on the ball, but at
    most `UNEVEN` times the mean of the middle two, since an outlier may be among them; balls that
    touch no sample are infinitely large.
    """
    rooms = np.append(poles.room, 0.0)[np.minimum(poles.samples, poles.sample_count)]
    rooms.sort(axis=1)
    room = np.minimum(rooms[:, 3], 0.5 * UNEVEN * (rooms[:, 1] + rooms[:, 2]))
    sizes: Floats = np.full(len(room), np.inf)
    with np.errstate(over="ignore"):
        np.divide(poles.radii, room, out=sizes, where=room > 0.0)
    return sizes


def noise_limits(poles: Poles) -> NoiseLimits:
    """Return the limits that suit the samples; clean ones keep all balls."""
    larger = poles.radii[poles.pairs].max(axis=1, initial=0.0)
    noisy = np.count_nonzero(larger < ROUND * poles.room[poles.pair_samples])
    if noisy > MUCH_NOISE * len(larger):
        return NoiseLimits(ball=1.0, handle=THICK)
    return NoiseLimits(ball=0.0, handle=THICK if noisy > SOME_NOISE * len(larger) else THIN)


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
    kept = poles.only(keep, number[poles.pairs[paired]], poles.pair_samples[paired])
    return kept, int(np.count_nonzero(~keep))
