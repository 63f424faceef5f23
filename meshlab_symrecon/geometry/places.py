"""Which places of a cloud coincide, and an order in which neighbours follow each other."""

from __future__ import annotations

import numpy as np

from meshlab_symrecon import _native
from meshlab_symrecon.arrays import Indices, Points
from meshlab_symrecon.geometry.sampling import canonical_order

__all__ = ["distinct_places", "first_alike", "nearby_order"]


def first_alike(points: Points) -> Indices:
    """Return (n,) the first point, by index, that is in the same place as each point."""
    order = canonical_order(points)
    steps = (points[order[1:]] != points[order[:-1]]).any(axis=1)
    starts = np.flatnonzero(np.append(True, steps))
    first: Indices = np.zeros(len(points), dtype=np.int64)
    least = np.minimum.reduceat(order, starts)
    first[order] = np.repeat(least, np.diff(starts, append=len(order)))
    return first


def nearby_order(places: Points) -> Indices:
    """Return (n,) an order of places in which the next one is near."""
    order = _native.curve_order(np.ascontiguousarray(places)).astype(np.int64)
    if len(order) == len(places):
        return order
    left_out = np.ones(len(places), dtype=bool)  # a place that repeats an earlier one
    left_out[order] = False
    return np.concatenate([order, np.flatnonzero(left_out)])


def distinct_places(points: Points) -> tuple[Indices, Indices]:
    """Choose one point from each place.

    Parameters
    ----------
    points : (n, 3) float

    Returns
    -------
    chosen : (m,) int
        The first point of each place, in an order in which the next one is near.
    place : (n,) int
        The row of ``chosen`` that is in the same place as each point.
    """
    chosen = _native.curve_order(np.ascontiguousarray(points)).astype(np.int64)
    place = np.zeros(len(points), dtype=np.int64)
    place[chosen] = np.arange(len(chosen))
    return chosen, place if len(chosen) == len(points) else place[first_alike(points)]
