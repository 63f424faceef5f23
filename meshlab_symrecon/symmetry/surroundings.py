"""What lies round each point of a cloud: its neighbours, their spacing, its normal."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from meshlab_symrecon.arrays import Booleans, Floats, Points
from meshlab_symrecon.geometry.neighbours import (
    NearestField,
    blocks,
    nearest_field,
    principal_normals,
)

__all__ = ["Neighbours", "Surroundings", "neighbours", "surroundings"]

SmallIndices: TypeAlias = NDArray[np.int32]

NEIGHBOURS = 8
SPACING_NEIGHBOURS = 4
SPACING_RANGE = (0.5, 2.0)  # medians: between them the spacing of a point is believed
FIELD_CELL, FIELD_MARGIN = 0.008, 0.12  # diagonals: cells and rim of the table of nearest points
FIELD_CELLS = 500_000
NORMAL_NEIGHBOURS = 16
CONSISTENT = 0.9  # share of the points whose normal faces as that of the nearest point does
FITTED = 60_000  # points to which normals are fitted


@dataclass(frozen=True, slots=True, eq=False)
class Surroundings:
    """A cloud as its holes see it."""

    points: Points  # (n, 3)  along a space-filling curve, which makes searches fast
    directions: Points  # (n, 3)  unit normals
    outward: bool  # they tell inside from outside
    field: NearestField
    spacing: Floats  # (n,)  mean distance to the four nearest
    usual: float  # its median in the scan
    diagonal: float

    def believed(self, chosen: SmallIndices) -> Floats:
        """Return the spacing of some points, within a factor of two of the usual one."""
        low, high = SPACING_RANGE
        within: Floats = np.clip(self.spacing[chosen], low * self.usual, high * self.usual)
        return within


@dataclass(frozen=True, slots=True, eq=False)
class Neighbours:
    """The points nearest to each point of a cloud, itself left out."""

    nearest: SmallIndices  # (n, k)  nearest first
    spacing: Floats  # (n,)  mean distance to the first four
    width: Floats  # (n,)  mean distance to all


def neighbours(points: Points, report: Callable[[float], None] | None = None) -> Neighbours:
    """Look up the eight points nearest to each of the points (n, 3), n at least 2.

    ``report`` is told the share that is done.
    """
    count = min(NEIGHBOURS + 1, len(points))
    tree = cKDTree(points)
    nearest = np.zeros((len(points), count - 1), dtype=np.int32)
    spacing, width = np.zeros(len(points)), np.zeros(len(points))
    for rows in blocks(len(points), report):
        distances, members = tree.query(points[rows], k=count)
        nearest[rows] = members[:, 1:]
        spacing[rows] = distances[:, 1 : SPACING_NEIGHBOURS + 1].mean(axis=1)
        width[rows] = distances[:, 1:].mean(axis=1)
    return Neighbours(nearest, spacing, width)


def surroundings(
    points: Points,
    normals: Points | None,
    diagonal: float,
    known: Neighbours | None = None,
    kept: Booleans | None = None,
) -> Surroundings:
    """Look up the neighbourhood of every point (n, 3), n at least 2, along a space-filling curve.

    Where no normals (n, 3) are given, or where neighbours contradict each other, planes are
    fitted. The diagonal is that of the scan; the neighbours may be known already. Points that are
    not ``kept`` (n,) are left out; the spacing of the others is that in the whole.
    """
    known = neighbours(points) if known is None else known
    given = None if normals is None else _consistent(normals, known.nearest[:, 0])
    directions = _fitted(points) if given is None else given
    spacing, usual = known.spacing, float(np.median(known.spacing))
    if kept is not None and not kept.all():
        points, directions, spacing = points[kept], directions[kept], spacing[kept]
    return Surroundings(
        points=points,
        directions=directions,
        outward=given is not None,
        field=_field(points, diagonal),
        spacing=spacing,
        usual=usual,
        diagonal=diagonal,
    )


def _field(points: Points, diagonal: float) -> NearestField:
    return nearest_field(points, FIELD_CELL * diagonal, FIELD_MARGIN * diagonal, FIELD_CELLS)


def _consistent(normals: Points, nearest: SmallIndices) -> Points | None:
    """Return unit normals, or None when those of points and the nearest (n,) contradict."""
    unit = _unit(normals)
    alike = 0
    for rows in blocks(len(unit)):
        agreement = np.einsum("ni,ni->n", unit[rows], unit[nearest[rows]])
        alike += int(np.count_nonzero(agreement > 0.0))
    return unit if alike / len(unit) >= CONSISTENT else None


def _unit(normals: Points) -> Points:
    unit = np.zeros(normals.shape)
    for rows in blocks(len(normals)):
        largest = np.abs(normals[rows]).max(axis=1, keepdims=True)
        scaled = normals[rows] / np.where(largest > 0.0, largest, 1.0)  # whose squares are floats
        lengths = np.linalg.norm(scaled, axis=1, keepdims=True)
        unit[rows] = scaled / np.where(lengths > 0.0, lengths, 1.0)
    return unit


def _fitted(points: Points) -> Points:
    """Fit normals to an even part of a cloud along a curve; every point gets the nearest one."""
    even = points[:: -(-len(points) // FITTED)]
    normals = principal_normals(even, even, NORMAL_NEIGHBOURS)[0]
    if len(even) == len(points):
        return normals
    tree = cKDTree(even)
    fitted = np.zeros((len(points), 3))
    for rows in blocks(len(points)):
        fitted[rows] = normals[tree.query(points[rows])[1]]
    return fitted
