"""How much a cloud bends round each point, and how dense it is there."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from meshlab_symrecon.arrays import Floats, Points

__all__ = ["bending", "point_density", "surface_variation"]

CHUNK = 65_536  # points looked at together, which bounds the memory
BENDING = 24.0  # (radius / radius of curvature)^2 over surface variation, for a paraboloid
TINY = float(np.finfo(np.float64).tiny)


def surface_variation(points: Points, targets: NDArray[np.int32]) -> Floats:
    """Return the share of the variance of each neighbourhood that is across its tangent plane.

    Parameters
    ----------
    points : (n, 3) float
        Positions.
    targets : (m, k) int
        Which points are in each neighbourhood.

    Returns
    -------
    (m,) float
        Least eigenvalue of the covariance over the sum of the three: 0 in a plane, at most 1/3.

    Notes
    -----
    M. Pauly, M. Gross, L. P. Kobbelt, "Efficient simplification of point-sampled surfaces", IEEE
    Visualization 2002, section 2.
    """
    found: Floats = np.zeros(len(targets))
    for first in range(0, len(targets), CHUNK):
        members = points[targets[first : first + CHUNK]]
        members -= members.mean(axis=1, keepdims=True)
        variances = np.linalg.eigvalsh(np.einsum("nki,nkj->nij", members, members))
        least, total = np.maximum(variances[:, 0], 0.0), variances.sum(axis=1)
        found[first : first + CHUNK] = np.divide(
            least, total, out=np.zeros_like(total), where=total > TINY
        )
    return found


def bending(variation: Floats) -> Floats:
    """Return the radius of each neighbourhood over the radius of curvature there.

    A disc of radius r on a paraboloid of curvature c has surface variation (c r)^2 / 24 when c r is
    small.
    """
    found: Floats = np.sqrt(BENDING * variation)
    return found


def point_density(
    similarities: Floats, targets: NDArray[np.int32], mass: Floats
) -> tuple[Floats, Floats]:
    """Return how many points, and how much mass, lie on the unit of area round each point.

    Parameters
    ----------
    similarities : (n, k) float
        Negative squared distances to the nearest points, falling; the first is the point itself.
    targets : (n, k) int
        These points.
    mass : (n,) float
        Mass of each point.

    Returns
    -------
    points, mass : (n,) float
        Over the disc that the neighbours fill; the farthest of them lies on its border and the
        point itself is there for certain, so that neither counts in full.
    """
    count = targets.shape[1]
    area = np.maximum(-np.pi * similarities[:, -1], TINY)
    within = np.zeros(len(mass))
    for column in targets.T:
        within += mass[column]
    points: Floats = (count - 1) / area
    return points, within * (points / count)
