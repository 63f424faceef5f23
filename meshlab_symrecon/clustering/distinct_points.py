"""A cloud as distinct points that stand for others, in a frame and order of its own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshlab_symrecon import _native
from meshlab_symrecon.arrays import Floats, Indices, Points
from meshlab_symrecon.clustering.assignment import nearest_exemplars
from meshlab_symrecon.geometry.bounds import box_diagonal
from meshlab_symrecon.geometry.sampling import canonical_order

__all__ = ["WeightedPoints", "distinct_points"]


@dataclass(frozen=True, slots=True, eq=False)
class WeightedPoints:
    """Points that stand for those of a cloud.

    Attributes
    ----------
    points : (n, 3) float
        Distinct positions.
    mass : (n,) float
        Number of points of the cloud that each stands for.
    source : (n,) int
        Which points of the cloud they are.
    """

    points: Points
    mass: Floats
    source: Indices

    def reduced(self, exemplars: Indices) -> WeightedPoints:
        """Return the exemplars, each with the mass of the points that it is nearest to."""
        label = nearest_exemplars(self.points, self.points[exemplars])
        mass: Floats = np.zeros(len(exemplars))
        np.add.at(mass, label, self.mass)
        return WeightedPoints(self.points[exemplars], mass, self.source[exemplars])


def distinct_points(points: Points) -> WeightedPoints:
    """Merge equal points, with the origin at the middle of the cloud and the unit its diagonal.

    Parameters
    ----------
    points : (n, 3) float
        The cloud, at least one point.

    Returns
    -------
    WeightedPoints
        Of equal points the first; neighbours in space follow each other, in an order that does not
        depend on the order given.
    """
    order = canonical_order(points)
    centre, diagonal = points[order].mean(axis=0), box_diagonal(points)
    moved = points - centre
    if diagonal > 0.0:
        moved /= diagonal
    order = np.lexsort(moved.T)
    sorted_points = moved[order]
    starts = np.flatnonzero(
        np.concatenate([[True], (sorted_points[1:] != sorted_points[:-1]).any(axis=1)])
    )
    mass = np.diff(starts, append=len(points)).astype(np.float64)
    source = np.minimum.reduceat(order, starts)
    distinct = moved[source]
    along = _native.curve_order(np.ascontiguousarray(distinct)).astype(np.int64)
    return WeightedPoints(distinct[along], mass[along], source[along])
