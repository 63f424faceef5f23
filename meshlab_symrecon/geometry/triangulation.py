"""Delaunay and regular (weighted Delaunay) triangulation of points in space, exact."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from meshlab_symrecon import _native
from meshlab_symrecon.arrays import Booleans, Floats, Indices, Points, as_points, as_scalars
from meshlab_symrecon.errors import GeometryError
from meshlab_symrecon.geometry.bounds import SPACE

__all__ = [
    "FACETS",
    "Progress",
    "SmallIndices",
    "Triangulation",
    "circumcentres",
    "delaunay",
    "regular_triangulation",
]

# Cells of two million sites fit 32-bit indices at half the memory of 64-bit ones.
SmallIndices: TypeAlias = NDArray[np.int32]
Progress: TypeAlias = Callable[[float], object]

# At about 8 cells a site, more sites would need more cells than 32-bit indices can number.
MAXIMUM_SITES = 2**28 - 1
FACETS = np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]])  # outward, opposite each corner


@dataclass(frozen=True, slots=True, eq=False)
class Triangulation:
    """Cells that fill the convex hull of weighted sites.

    Every cell's ball orthogonal to its four sites has power at least zero to all other sites, and
    every facet belongs to exactly two cells, or to one cell and the outside.
    """

    sites: Points  # (n, 3)
    weights: Floats  # (n,)  squared radii; zero for a Delaunay triangulation
    cells: SmallIndices  # (m, 4)  sites, positively oriented
    neighbours: SmallIndices  # (m, 4)  neighbour k lies opposite vertex k; -1 outside the hull
    representative: SmallIndices  # (n,)  the site itself, or the one at its position that is used
    hidden: Booleans  # (n,)  in no cell, because heavier sites around it cover it
    hidden_cell: SmallIndices  # (n,)  for a hidden site the cell that contains it, else -1


def delaunay(points: ArrayLike, *, progress: Progress | None = None) -> Triangulation:
    """Triangulate points such that no ball through the four of a cell contains another one.

    Parameters
    ----------
    points : (n, 3) float
        Positions, in any unit; they are used exactly as given.
    progress : callable, optional
        Called with the share of points inserted, 0 to 1.

    Returns
    -------
    Triangulation
        With zero weights; no point is hidden.

    Raises
    ------
    GeometryError
        Positions that are not finite, or that do not span three dimensions.

    Notes
    -----
    Of points at one position the first is used. Balls through five or more points are divided as
    if the points had infinitesimal weights, larger for positions that come first in lexicographic
    order (Devillers and Teillaud 2003), so the cells do not depend on the order of the points.
    """
    positions = as_points(points)
    return _triangulate(positions, np.zeros(len(positions)), progress)


def regular_triangulation(
    points: ArrayLike, weights: ArrayLike, *, progress: Progress | None = None
) -> Triangulation:
    """Triangulate weighted points: the dual of their power diagram.

    Parameters
    ----------
    points : (n, 3) float
        Centres of balls, in any unit; they are used exactly as given.
    weights : (n,) float
        Squared radii of the balls, of any sign.
    progress : callable, optional
        Called with the share of points inserted, 0 to 1.

    Returns
    -------
    Triangulation
        Sites whose power cell is empty are marked as hidden.

    Raises
    ------
    GeometryError
        Positions or weights that are not finite, positions that do not span three dimensions, or
        not one weight for each position.

    Notes
    -----
    Of points at one position the first of the largest weight is used. Ties are broken as in
    `delaunay`.
    """
    positions = as_points(points)
    return _triangulate(positions, as_scalars(weights, len(positions), "weights"), progress)


def circumcentres(triangulation: Triangulation, chosen: Indices | None = None) -> Points:
    """Return the centre of the ball through (orthogonal to) the four sites of every cell.

    Parameters
    ----------
    triangulation : Triangulation
    chosen : (k,) int, optional
        The cells wanted; all m without it.

    Returns
    -------
    (m, 3) float
        Circumcentres of a Delaunay triangulation, else the vertices of the power diagram. Their
        offset from the first site of the cell is accurate to 1e-12 of its length however flat the
        cell is; very flat cells are evaluated in integers. A coordinate too large for a float is
        infinite.
    """
    cells = triangulation.cells if chosen is None else triangulation.cells[chosen]
    return _native.orthocentres(triangulation.sites, triangulation.weights, cells)


def _triangulate(sites: Points, weights: Floats, progress: Progress | None) -> Triangulation:
    if len(sites) > MAXIMUM_SITES:
        message = (
            f"a triangulation takes at most {MAXIMUM_SITES} points; got {len(sites)}; thin them out"
        )
        raise GeometryError(message)
    rank, cells, neighbours, representative, hidden_cell = _native.regular_triangulation(
        sites, weights, progress
    )
    if rank < SPACE:
        message = (
            "a triangulation needs at least 4 points that are not in one plane; "
            f"got {len(sites)} points of rank {rank}; add points off their plane"
        )
        raise GeometryError(message)
    hidden = hidden_cell >= 0
    for array in (cells, neighbours, representative, hidden, hidden_cell):
        array.setflags(write=False)
    return Triangulation(sites, weights, cells, neighbours, representative, hidden, hidden_cell)
