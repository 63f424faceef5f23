"""Samples in a form that does not depend on units, place, order or repetition."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from meshlab_symrecon import _native
from meshlab_symrecon.arrays import Booleans, Floats, Indices, Points
from meshlab_symrecon.geometry.bounds import require_solid

__all__ = ["NormalCloud", "normalised"]

FEWEST = 4  # samples: a tetrahedron


@dataclass(frozen=True, slots=True, eq=False)
class NormalCloud:
    """Distinct samples in a box of about unit size.

    Attributes
    ----------
    samples : (n, 3) float
        Along a Hilbert curve, so that what is near in space is near in memory.
    source : (n,) int
        The number of each sample among the points given, the first of equal ones.
    centre : (3,) float
        Of the box of the points given.
    scale : float
        A power of two, so that scaling rounds nothing.
    """

    samples: Points
    source: Indices
    centre: Floats
    scale: float

    def to_input(self, points: Points) -> Points:
        """Return positions in the units of the points given."""
        restored: Points = points / self.scale + self.centre
        return restored

    def at_samples(self, points: Points, nearest: Indices, given: Points) -> Points:
        """Return positions in the units of the points given, samples bit for bit.

        Parameters
        ----------
        points : (v, 3) float
        nearest : (v,) int
            The sample nearest to each.
        given : (m, 3) float
            The points given.
        """
        restored = self.to_input(points)
        here = np.all(points == self.samples[nearest], axis=1)
        restored[here] = given[self.source[nearest[here]]] + 0.0  # whichever zero came first
        return restored

    def without(self, left_out: Booleans) -> NormalCloud:
        """Return the cloud without some samples."""
        return replace(self, samples=self.samples[~left_out], source=self.source[~left_out])


# Of the box: squares and cubes of distances between what is left stay within floats.
NOTHING = 1e-60


def normalised(points: Points) -> NormalCloud:
    """Return the distinct points in a box of about unit size.

    Raises
    ------
    GeometryError
        Fewer than four points, or points in one plane.
    """
    require_solid(points, "power crust", minimum=FEWEST)
    low, high = points.min(axis=0), points.max(axis=0)
    centre: Floats = 0.5 * (low + high)
    scale = float(2.0 ** -np.ceil(np.log2((high - low).max())))
    moved = (points - centre) * scale
    moved[np.abs(moved) < NOTHING] = 0.0  # of either sign
    order = _native.curve_order(moved).astype(np.int64)
    return NormalCloud(moved[order], order, centre, scale)
