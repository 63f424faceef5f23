"""Planes fitted to the neighbourhood of every point of a cloud."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from meshlab_symrecon import _native
from meshlab_symrecon.arrays import Floats, Points

__all__ = ["LocalPlanes", "local_planes"]

NEIGHBOURS = (12, 24, 48)  # the point itself counts; noise needs more
ROUGH = 0.4  # thickness / width of a neighbourhood above which it is mostly noise
PROBE = 2_000  # points on which that is tried
SPACING_NEIGHBOURS = 4
CHUNK = 65_536  # points whose neighbourhoods are held at a time
LEAST_MEMBERS = 3  # points that span a plane


@dataclass(frozen=True, slots=True, eq=False)
class LocalPlanes:
    """The plane at every point of a cloud."""

    normals: Points  # (n, 3)  unit, of arbitrary sign
    spacing: Floats  # (n,)  mean distance to the nearest points, in the units of the points


def local_planes(points: Points) -> LocalPlanes:
    """Fit a plane to the neighbourhood of each point.

    As many neighbours count as the noise needs: 12, 24 or 48, the first number with which
    neighbourhoods are clearly wider than thick.

    Parameters
    ----------
    points : (n, 3) float
        The cloud, of at least three points, no two of them in one place.
    """
    order = _native.curve_order(np.ascontiguousarray(points))  # neighbours in memory, too
    cloud = points[order]
    tree = cKDTree(cloud)
    count = min(_neighbours(cloud, tree), len(cloud))
    normals, spacing = np.zeros_like(cloud), np.zeros(len(cloud))
    for start in range(0, len(cloud), CHUNK):
        rows = slice(start, start + CHUNK)
        distances, members = tree.query(cloud[rows], k=count)
        near = distances[:, 1 : 1 + SPACING_NEIGHBOURS]
        spacing[order[rows]] = near.mean(axis=1)
        normals[order[rows]] = _spread(cloud[members])[1][:, :, 0]
    return LocalPlanes(normals, spacing)


def _spread(members: Floats) -> tuple[Floats, Floats]:
    """Return variances (m, 3), rising, and axes (m, 3, 3), as columns, of neighbourhoods."""
    centred = members - members.mean(axis=1, keepdims=True)
    covariances = np.matmul(centred.transpose(0, 2, 1), centred)
    variances, axes = np.linalg.eigh(covariances)
    return np.maximum(variances, 0.0), axes


def _neighbours(cloud: Points, tree: cKDTree) -> int:
    probe = cloud[:: max(1, len(cloud) // PROBE)]
    for count in NEIGHBOURS:
        members = tree.query(probe, k=max(min(count, len(cloud)), LEAST_MEMBERS))[1]
        variances = _spread(cloud[members])[0]
        if np.median(variances[:, 0]) <= ROUGH**2 * np.median(variances[:, 1]):
            return count
    return NEIGHBOURS[-1]
