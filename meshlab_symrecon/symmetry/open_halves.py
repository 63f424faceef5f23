"""Half a statue: nothing is left beyond the plane, but the rim lies on it and the surface meets it squarely."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshlab_symrecon.arrays import Floats, Indices, Planes
from meshlab_symrecon.symmetry.preparation import PreparedCloud

__all__ = ["HalfEvidence", "examine_halves", "rim_planes"]

# Lengths are in diagonals of the prepared cloud.
RIM_SPACINGS, LEAST_RIM = 1.5, 0.008  # distance from the plane within which a rim point is on it
FEWEST_RIM = 30  # points
TRIPLES = 2_000  # of rim points that are tried
POLISHING = 5  # rounds of fitting to the rim points on the plane
LEAST_SPREAD = 0.01  # sine between the sides of a triple: collinear points span no plane


@dataclass(frozen=True, slots=True, eq=False)
class HalfEvidence:
    """What says that a plane is where the missing half begins."""

    rim_share: Floats  # (k,)  share of all rim points that lie on the plane
    beyond: Floats  # (k,)  share of the cloud that lies beyond it
    crossing: Floats  # (k,)  median |cosine| between the surface's normals there and the plane's
    thickness: Floats  # (k,)  extent of the cloud across the plane / its smaller one along it


def rim_planes(cloud: PreparedCloud, rng: np.random.Generator) -> Planes:
    """Fit a plane to the rims of the cloud's holes.

    A mirror plane cuts a smooth symmetric surface at right angles, and where one half is missing
    the rim of what is left is that cut.

    Parameters
    ----------
    cloud : PreparedCloud
        The cloud.
    rng : numpy.random.Generator
        Chooses triples of rim points.

    Returns
    -------
    (k, 4) float
        The plane with most rim points on it; none with fewer than 30 rim points.
    """
    rim = cloud.points[cloud.border]
    if len(rim) < FEWEST_RIM:
        return np.zeros((0, 4))
    reach = _reach(cloud)
    corners = rim[rng.integers(0, len(rim), (TRIPLES, 3))]
    sides = corners[:, 1:] - corners[:, :1]
    normals = np.cross(sides[:, 0], sides[:, 1])
    lengths = np.linalg.norm(normals, axis=1)
    spread = lengths > LEAST_SPREAD * np.prod(np.linalg.norm(sides, axis=2), axis=1)
    if not spread.any():
        return np.zeros((0, 4))
    normals = normals[spread] / lengths[spread, np.newaxis]
    offsets = -np.einsum("ti,ti->t", normals, corners[spread, 0])
    counts = (np.abs(normals @ rim.T + offsets[:, np.newaxis]) < reach).sum(axis=1)
    best = int(np.argmax(counts))
    normal, offset = normals[best], float(offsets[best])
    for _ in range(POLISHING):
        inside = rim[np.abs(rim @ normal + offset) < reach]
        centre = inside.mean(axis=0)
        normal = np.linalg.svd(inside - centre, full_matrices=False)[2][2]
        offset = float(-normal @ centre)
    return np.append(normal, offset)[np.newaxis]


def examine_halves(planes: Planes, cloud: PreparedCloud) -> HalfEvidence:
    """Measure how well each plane explains the cloud as one half of a symmetric shape.

    Parameters
    ----------
    planes : (k, 4) float
        Planes in the coordinates of the prepared cloud.
    cloud : PreparedCloud
        The cloud.

    Returns
    -------
    HalfEvidence
        Rows in the order of the planes.
    """
    reach = _reach(cloud)
    rim = np.flatnonzero(cloud.border)
    rows = [_half(plane, cloud, rim, reach) for plane in planes]
    columns = np.array(rows, dtype=np.float64).reshape(len(planes), 4).T
    return HalfEvidence(*columns)


def _reach(cloud: PreparedCloud) -> float:
    return max(RIM_SPACINGS * cloud.spacing, LEAST_RIM)


def _half(
    plane: Floats, cloud: PreparedCloud, rim: Indices, reach: float
) -> tuple[float, float, float, float]:
    normal = plane[:3]
    heights = cloud.points @ normal + plane[3]
    on_plane = rim[np.abs(heights[rim]) < reach]
    beyond = min(float((heights > reach).mean()), float((heights < -reach).mean()))
    if len(on_plane) < FEWEST_RIM:
        return 0.0, beyond, 1.0, np.inf
    crossing = float(np.median(np.abs(cloud.normals[on_plane] @ normal)))
    flat = cloud.points - heights[:, np.newaxis] * normal
    axes = np.linalg.svd(flat - flat.mean(axis=0), full_matrices=False)[2][:2]
    narrow = min(float(np.ptp(flat @ axis)) for axis in axes)
    thickness = float(np.ptp(heights)) / max(narrow, np.finfo(float).tiny)
    return len(on_plane) / len(rim), beyond, crossing, thickness
