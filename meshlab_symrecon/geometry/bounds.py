"""How large a cloud is, and whether it fills space at all."""

from __future__ import annotations

import numpy as np

from meshlab_symrecon.arrays import Points
from meshlab_symrecon.errors import GeometryError

__all__ = [
    "SPACE",
    "box_diagonal",
    "is_solid",
    "require_extent",
    "require_solid",
    "robust_diagonal",
]

SMALLEST, LARGEST = 1e-60, 1e60  # units: squares and cubes of lengths stay within floats
SPACE = 3  # dimensions
FLATNESS = 1e-7  # thickness / diagonal below which a cloud is flat; float32 files round at 6e-8
ROUNDING = 8.0 * np.finfo(np.float64).eps  # relative error of a coordinate after a few operations


def box_diagonal(points: Points) -> float:
    """Return the diagonal of the axis-aligned box of a cloud, 0 for an empty one."""
    if len(points) == 0:
        return 0.0
    return float(np.linalg.norm(np.ptp(points, axis=0)))


def robust_diagonal(points: Points, share: float = 0.005) -> float:
    """Return the box diagonal without the outermost points.

    Parameters
    ----------
    points : (n, 3) float
        Positions, at least one.
    share : float
        Share of the points left out at either end of each axis.

    Returns
    -------
    float
        Diagonal, in the units of the points.
    """
    ends = [np.quantile(points[:, axis], [share, 1.0 - share]) for axis in range(SPACE)]
    low, high = np.transpose(ends)
    return float(np.linalg.norm(high - low))


def require_extent(points: Points, purpose: str) -> None:
    """Check that floats can square and cube the lengths of a cloud; equal points are no cloud.

    Parameters
    ----------
    points : (n, 3) float
        Positions, at least one.
    purpose : str
        What the points are for: the subject of the error's sentence.

    Raises
    ------
    GeometryError
        The longest side of the box is too small, but not 0, or too large.
    """
    with np.errstate(over="ignore"):
        extent = float(np.ptp(points, axis=0).max())
    if 0.0 < extent < SMALLEST or extent > LARGEST:
        message = (
            f"{purpose} needs points that extend over {SMALLEST:g} to {LARGEST:g} units; "
            f"got an extent of {extent:.3g}; change the units"
        )
        raise GeometryError(message)


def require_solid(points: Points, purpose: str, minimum: int = 5) -> None:
    """Check that a cloud has enough points, and that they do not lie in one plane.

    Parameters
    ----------
    points : (n, 3) float
        Positions.
    purpose : str
        What the points are for: the subject of the error's sentence.
    minimum : int
        Number of points needed.

    Raises
    ------
    GeometryError
        Too few points, an extent beyond what floats can square, or points that coincide or lie on
        one line or in one plane.
    """
    if len(points) < minimum:
        message = (
            f"{purpose} needs at least {minimum} points not in one plane; "
            f"got {len(points)} points; load a fuller scan"
        )
        raise GeometryError(message)
    require_extent(points, purpose)
    rank = _rank(points)
    if rank < SPACE:
        shape = ("that all coincide", "on one line", "in one plane")[rank]
        message = (
            f"{purpose} needs at least {minimum} points not in one plane; "
            f"got {len(points)} points {shape}; scan the object from more sides"
        )
        raise GeometryError(message)


def is_solid(points: Points, minimum: int = 4) -> bool:
    """Say whether a cloud has enough points, not all of them in one plane."""
    return len(points) >= minimum and _rank(points) == SPACE


def _rank(points: Points) -> int:
    """Return how many dimensions points span, but for rounding."""
    centred = points - points.mean(axis=0)
    axes = np.linalg.eigh(centred.T @ centred)[1]
    widths = np.sort([np.ptp(centred @ axis) for axis in axes.T])[::-1]
    diagonal = float(np.linalg.norm(widths))
    limit = max(FLATNESS * diagonal, ROUNDING * float(np.abs(points).max()))
    return int(np.count_nonzero(widths > limit))
