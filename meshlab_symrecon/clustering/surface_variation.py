"""How much a cloud bends round each point, and how dense it is there."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from meshlab_symrecon.arrays import Floats, Points

__all__ = ["bending", "point_density", "surface_variation", "wanted_density"]

CHUNK = 65_536  # points looked at together, which bounds the memory
BENDING = 24.0  # (radius / radius of curvature)^2 over surface variation, for a paraboloid
EDGE = 0.0852  # surface variation of a right angle between two planes
STEEPNESS = 2.0  # density that such an edge adds to what its bending adds
LEAST = 0.65  # density of flat parts / the mean over the area
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


def wanted_density(variation: Floats, area: Floats, detail: float) -> Floats:
    """Return how densely exemplars should stand, 1 where it is least.

    ``1 + detail (b + 2 (v / v')^2)`` with surface variation v, that of a right-angled edge v', and
    the bending b. The distance of a surface from triangles between points of spacing h is
    proportional to h^2 over the radius of curvature, whence the term b; the other one raises what
    is about as thin as the spacing, where a reconstruction would lose its end. Flat parts keep a
    share of the mean density, since what is flat may be thin as well.

    Parameters
    ----------
    variation : (n,) float
        Surface variation.
    area : (n,) float
        Area that each point stands for.
    detail : float
        0 for the same density everywhere.

    Returns
    -------
    (n,) float
    """
    density = 1.0 + detail * (bending(variation) + STEEPNESS * (variation / EDGE) ** 2)
    density = np.maximum(density, LEAST * np.average(density, weights=area))
    found: Floats = density / density.min()
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
    if count == 1:  # a lone point
        return np.ones(len(mass)), mass
    area = np.maximum(-np.pi * similarities[:, -1], TINY)
    within = np.zeros(len(mass))
    for column in targets.T:
        within += mass[column]
    points: Floats = (count - 1) / area
    return points, within * (points / count)
