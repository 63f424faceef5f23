"""Planes fitted to the neighbourhood of every point of a cloud."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from meshlab_symrecon.arrays import Floats, Points
from meshlab_symrecon.geometry.places import nearby_order

__all__ = ["LocalPlanes", "local_planes"]

NEIGHBOURS = (12, 24, 48)  # the point itself counts; noise needs more
ROUGH = 0.4  # thickness / width of a neighbourhood above which it is mostly noise
PROBE = 2_000  # points on which that is tried
SPACING_NEIGHBOURS = 4
CHUNK = 16_384  # points whose neighbourhoods are held at a time
SHORT = 1e-3  # product of two rows / their size: below it rounding has taken the last digits
TINY = float(np.finfo(np.float64).tiny)
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
        The cloud, of at least three points, no two of them in one place but for rounding.
    """
    order = nearby_order(points)  # neighbours in memory, too
    cloud = points[order]
    tree = cKDTree(cloud)
    count = min(_neighbours(cloud, tree), len(cloud))
    normals, spacing = np.zeros_like(cloud), np.zeros(len(cloud))
    for start in range(0, len(cloud), CHUNK):
        rows = slice(start, start + CHUNK)
        distances, members = tree.query(cloud[rows], k=count)
        near = distances[:, 1 : 1 + SPACING_NEIGHBOURS]
        spacing[order[rows]] = near.mean(axis=1)
        normals[order[rows]] = _least_axes(_covariances(cloud[members]))
    return LocalPlanes(normals, spacing)


def _covariances(members: Floats) -> Floats:
    """Return (m, 3, 3) sums of squares and products of neighbourhoods (m, k, 3)."""
    centred = members - members.mean(axis=1, keepdims=True)
    covariances: Floats = np.matmul(centred.transpose(0, 2, 1), centred)
    return covariances


def _least_axes(matrices: Floats) -> Points:
    """Return (m, 3) unit eigenvectors of the least eigenvalues of symmetric matrices.

    In closed form, a sixth of the time of ``eigh``: the eigenvalue by the cosine of a third of an
    angle (Smith 1961), its vector as the longest product of two rows of what is left. Where two
    eigenvalues nearly coincide these products are short, and ``eigh`` is asked.
    """
    trace = np.trace(matrices, axis1=1, axis2=2)
    level = matrices - (trace / 3.0)[:, np.newaxis, np.newaxis] * np.eye(3)
    size = np.sqrt(np.einsum("mij,mij->m", level, level) / 6.0)
    third = np.linalg.det(level) / np.maximum(2.0 * size**3, TINY)
    angle = (np.arccos(np.clip(third, -1.0, 1.0)) + 2.0 * np.pi) / 3.0
    level -= (2.0 * size * np.cos(angle))[:, np.newaxis, np.newaxis] * np.eye(3)
    first, second, last = level[:, 0], level[:, 1], level[:, 2]
    products = np.stack([np.cross(first, second), np.cross(second, last), np.cross(last, first)], 1)
    lengths = np.linalg.norm(products, axis=2)
    longest = np.argmax(lengths, axis=1)
    rows = np.arange(len(matrices))
    length = lengths[rows, longest]
    axes: Points = products[rows, longest] / np.maximum(length, TINY)[:, np.newaxis]
    unclear = np.flatnonzero(~(length > SHORT * size**2))
    axes[unclear] = np.linalg.eigh(matrices[unclear])[1][:, :, 0]
    return axes


def _neighbours(cloud: Points, tree: cKDTree) -> int:
    probe = cloud[:: max(1, len(cloud) // PROBE)]
    for count in NEIGHBOURS:
        members = tree.query(probe, k=max(min(count, len(cloud)), LEAST_MEMBERS))[1]
        variances = np.linalg.eigvalsh(_covariances(cloud[members]))
        if np.median(variances[:, 0]) <= ROUGH**2 * np.median(variances[:, 1]):
            return count
    return NEIGHBOURS[-1]
