"""Verification of a plane: what the mirror image confirms, and what nothing can excuse."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshlab_symrecon.arrays import Floats, Indices, Planes
from meshlab_symrecon.symmetry.preparation import PreparedCloud
from meshlab_symrecon.symmetry.refinement import Lookup

__all__ = ["Evidence", "examine"]

DIRECTION_RAMP = (np.cos(np.radians(40.0)), np.cos(np.radians(15.0)))  # no match .. full match
SIDEWAYS = 2.5  # spacings: a partner farther along the surface than that is none
LEAST_SIDEWAYS, MOST_SIDEWAYS = 0.012, 0.05  # diagonals
NEAR_PLANE = 0.035  # diagonals: points nearer to the plane match themselves, and count less
NO_MATCH = 0.05  # worth of a match below which a rim may excuse it
RIM_REACH = 1.5  # a rim nearer than this multiple of the distance to the surface excuses it
LEAST_GAP = 2.0  # spacings to the surface below which there is no hole to speak of
FAR = 0.03  # diagonals off the surface that make a contradiction,
FAR_SPACINGS = 4.0  # but at least this many spacings: gaps of a sparse cloud contradict nothing
TOLERANCE_SPACINGS = 0.4  # a sparse cloud's tangent planes are that much coarser
BEYOND = 0.25  # diagonals beyond which nothing can be said
TINY = float(np.finfo(np.float64).tiny)
CHUNK = 400_000  # plane-query pairs examined at once: about 100 MB


@dataclass(frozen=True, slots=True, eq=False)
class Evidence:
    """What speaks for and against each plane; queries near the plane count less."""

    support: Floats  # (k,)  share of the queries whose mirror image lies on the surface
    agreement: Floats  # (k,)  the same share of the queries that no hole excuses
    contradiction: Floats  # (k,)  share that lies far off the surface, no hole to explain it
    residual: Floats  # (k,)  RMS distance of partners from the tangent plane, in diagonals

    def take(self, rows: Indices) -> Evidence:
        """Return the evidence of some of the planes."""
        return Evidence(
            self.support[rows],
            self.agreement[rows],
            self.contradiction[rows],
            self.residual[rows],
        )


def examine(
    planes: Planes, cloud: PreparedCloud, count: int, nearest: Lookup, tolerance: float
) -> Evidence:
    """Mirror query points across each plane and compare them with the cloud.

    Parameters
    ----------
    planes : (k, 4) float
        Planes in the coordinates of the prepared cloud.
    cloud : PreparedCloud
        The cloud.
    count : int
        Number of even samples that are mirrored.
    nearest : callable
        Finds nearest points of the cloud.
    tolerance : float
        Distance from the tangent plane at which a match is worth ``exp(-1/2)``, in diagonals;
        larger in sparse clouds.

    Returns
    -------
    Evidence
        Rows in the order of the planes.
    """
    size = max(1, CHUNK // max(1, count))
    parts = [
        _examine(planes[start : start + size], cloud, count, nearest, tolerance)
        for start in range(0, max(1, len(planes)), size)
    ]
    return Evidence(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def _examine(
    planes: Planes, cloud: PreparedCloud, count: int, nearest: Lookup, tolerance: float
) -> tuple[Floats, Floats, Floats, Floats]:
    queries = cloud.samples[:count]
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
    off_squares = np.einsum("kqi,kqi->kq", gaps, partner_normals) ** 2
    sideways = np.maximum(distances**2 - off_squares, 0.0)
    none, full = DIRECTION_RAMP
    tolerance = max(tolerance, TOLERANCE_SPACINGS * cloud.spacing)
    matches = np.exp(-0.5 * off_squares / tolerance**2)
    matches *= np.clip((agreement - none) / (full - none), 0.0, 1.0)
    reach = np.clip(SIDEWAYS * cloud.spacing, LEAST_SIDEWAYS, MOST_SIDEWAYS)
    matches[sideways > reach**2] = 0.0
    weights = np.minimum(1.0, np.abs(heights) / NEAR_PLANE)
    rim_near = cloud.border_distance[partners] <= RIM_REACH * distances
    far = (distances > max(FAR, FAR_SPACINGS * cloud.spacing)) & (distances < BEYOND) & ~rim_near
    excused = rim_near & (distances > LEAST_GAP * cloud.spacing) & (matches < NO_MATCH)
    total = np.maximum(weights.sum(axis=1), TINY)
    judged = (weights * ~excused).sum(axis=1)
    worth = weights * matches
    matched = worth.sum(axis=1)
    return (
        matched / total,
        matched / np.maximum(judged, TINY),
        (weights * far) @ cloud.distinctness[:count] / total,
        np.sqrt((worth * off_squares).sum(axis=1) / np.maximum(matched, TINY)),
    )
