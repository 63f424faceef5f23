"""Verification of a plane: what the mirror image confirms, and what nothing can excuse."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshlab_symrecon.arrays import Floats, Indices, Planes
from meshlab_symrecon.symmetry.preparation import PreparedCloud
from meshlab_symrecon.symmetry.refinement import Lookup

__all__ = ["Evidence", "examine", "score"]

CONTRADICTION_WEIGHT = 4.0
SAME_DIRECTION = np.cos(np.radians(30.0))  # between a normal and the mirror image of its partner's
NEAR_PLANE = 4.0  # tolerances: points nearer to the plane match themselves, and count less
FAR = 3.0  # tolerances beyond which a mirror image without partner is a contradiction
BEYOND = 0.25  # diagonals beyond which nothing can be said
RIM_REACH = 1.5  # a rim nearer than this multiple of the distance to the surface excuses it
CHUNK = 400_000  # plane-query pairs examined at once: about 100 MB


@dataclass(frozen=True, slots=True, eq=False)
class Evidence:
    """What speaks for and against each plane; shares of the queries."""

    support: Floats  # (k,)  mirror image lies on the surface
    contradiction: Floats  # (k,)  mirror image lies off the surface, and no hole explains it
    residual: Floats  # (k,)  RMS distance of partners from the tangent plane, in diagonals
    judged: Floats  # (k,)  weight of all queries, mostly those away from the plane


def score(evidence: Evidence) -> Floats:
    """Return support less four times contradiction: the order in which planes are ranked."""
    ranking: Floats = evidence.support - CONTRADICTION_WEIGHT * evidence.contradiction
    return ranking


def examine(
    planes: Planes, cloud: PreparedCloud, queries: Indices, nearest: Lookup, tolerance: float
) -> Evidence:
    """Mirror query points across each plane and compare them with the cloud.

    Parameters
    ----------
    planes : (k, 4) float
        Planes in the coordinates of the prepared cloud.
    cloud : PreparedCloud
        The cloud.
    queries : (q,) int
        Points of the cloud that are mirrored.
    nearest : callable
        Finds nearest points of the cloud.
    tolerance : float
        Distance at which a match is worth ``exp(-1/2)``, in diagonals.

    Returns
    -------
    Evidence
        Rows in the order of the planes.
    """
    size = max(1, CHUNK // max(1, len(queries)))
    parts = [
        _examine(planes[start : start + size], cloud, queries, nearest, tolerance)
        for start in range(0, max(1, len(planes)), size)
    ]
    return Evidence(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def _examine(
    planes: Planes, cloud: PreparedCloud, queries: Indices, nearest: Lookup, tolerance: float
) -> tuple[Floats, Floats, Floats, Floats]:
    points, directions = cloud.points[queries], cloud.normals[queries]
    normals = planes[:, :3]
    heights = normals @ points.T + planes[:, 3:]
    mirrored = points - 2.0 * heights[..., np.newaxis] * normals[:, np.newaxis]
    partners = nearest(mirrored)
    gaps = mirrored - cloud.points[partners]
    distances = np.sqrt(np.einsum("kqi,kqi->kq", gaps, gaps))
    partner_normals = cloud.normals[partners]
    agreement = np.einsum("kqi,qi->kq", partner_normals, directions)
    along = np.einsum("kqi,ki->kq", partner_normals, normals)
    agreement = agreement - 2.0 * along * (normals @ directions.T)
    signed = cloud.oriented[queries] & cloud.oriented[partners]
    agreement = np.where(signed, agreement, np.abs(agreement))
    weights = np.minimum(1.0, np.abs(heights) / (NEAR_PLANE * tolerance))
    matches = np.exp(-0.5 * (distances / tolerance) ** 2) * (agreement > SAME_DIRECTION)
    excused = cloud.border_distance[partners] <= RIM_REACH * distances
    contradicted = (distances > FAR * tolerance) & (distances < BEYOND) & ~excused
    heights_off = np.einsum("kqi,kqi->kq", gaps, partner_normals)
    worth = weights * matches
    total = worth.sum(axis=1)
    residual = np.sqrt((worth * heights_off**2).sum(axis=1) / np.maximum(total, 1e-12))
    count = len(queries)
    return (
        total / count,
        (weights * contradicted).sum(axis=1) / count,
        residual,
        weights.sum(axis=1) / count,
    )
