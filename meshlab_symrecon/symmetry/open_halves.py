"""Half a statue: nothing is left beyond the plane, and the surface meets it at right angles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from meshlab_symrecon.arrays import Floats, Indices, Planes
from meshlab_symrecon.symmetry.breaks import FEWEST_RIM, rim_reach
from meshlab_symrecon.symmetry.preparation import PreparedCloud

__all__ = ["HalfEvidence", "examine_halves", "rim_planes"]

# Lengths are in diagonals of the prepared cloud.
RIM_INSIDE = 1.0  # spacings: the outermost samples end that far before the cut
AROUND = 8.0  # spacings about a rim point in which the surface's turning is followed,
WHOLE = 2.0  # by normals at least so many spacings from the rim: nearer ones are one-sided
SAME_SIDE = 0.3  # cosine between normals of the same sheet
FEWEST_AROUND = 8  # of those points
MOSTLY = 0.6  # share of the rim points that has to tell
TINY = float(np.finfo(np.float64).tiny)


@dataclass(frozen=True, slots=True, eq=False)
class HalfEvidence:
    """What says that a plane is where the missing half begins."""

    rim_share: Floats  # (k,)  share of all rim points that lie on the plane
    beyond: Floats  # (k,)  share of the cloud that lies beyond it
    crossing: Floats  # (k,)  median |cosine| between normals of surface and plane where they meet
    thickness: Floats  # (k,)  extent of the cloud across the plane / its smaller one along it


def rim_planes(cloud: PreparedCloud) -> Planes:
    """Return the plane on which the cloud's rims lie, moved to where the cloud ends.

    A mirror plane cuts a smooth symmetric surface at right angles, and where one half is missing
    the rim of what is left is that cut.

    Parameters
    ----------
    cloud : PreparedCloud
        The cloud.

    Returns
    -------
    (k, 4) float
        One plane, or none.
    """
    if cloud.rim_plane is None:
        return np.zeros((0, 4))
    outwards = np.array([0.0, 0.0, 0.0, RIM_INSIDE * cloud.spacing])
    return (cloud.rim_plane + outwards)[np.newaxis]


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
    reach = rim_reach(cloud.spacing) + RIM_INSIDE * cloud.spacing
    rim = np.flatnonzero(cloud.border)
    rows = [_half(plane, cloud, rim, reach) for plane in planes]
    columns = np.array(rows, dtype=np.float64).reshape(len(planes), 4).T
    return HalfEvidence(*columns)


def _half(
    plane: Floats, cloud: PreparedCloud, rim: Indices, reach: float
) -> tuple[float, float, float, float]:
    normal = plane[:3]
    heights = cloud.points @ normal + plane[3]
    on_plane = rim[np.abs(heights[rim]) < reach]
    beyond = min(float((heights > reach).mean()), float((heights < -reach).mean()))
    if len(on_plane) < FEWEST_RIM:
        return 0.0, beyond, 1.0, np.inf
    flat = cloud.points - heights[:, np.newaxis] * normal
    axes = np.linalg.svd(flat - flat.mean(axis=0), full_matrices=False)[2][:2]
    narrow = min(float(np.ptp(flat @ axis)) for axis in axes)
    thickness = float(np.ptp(heights)) / max(narrow, np.finfo(float).tiny)
    return len(on_plane) / len(rim), beyond, _crossing(cloud, normal, heights, on_plane), thickness


def _crossing(cloud: PreparedCloud, normal: Floats, heights: Floats, rim: Indices) -> float:
    """Follow the surface's normals to the plane.

    Their cosine with the plane's normal is proportional to the height in a round cross-section, and
    vanishes on a mirror plane.
    """
    cosines = cloud.normals @ normal
    to_rim = cKDTree(cloud.points[cloud.border]).query(cloud.points)[0]
    usable = to_rim > WHOLE * cloud.spacing
    surroundings = cKDTree(cloud.points).query_ball_point(cloud.points[rim], AROUND * cloud.spacing)
    found = []
    for point, around in zip(rim, surroundings, strict=True):
        near = np.array(around)
        near = near[usable[near] & (cloud.normals[near] @ cloud.normals[point] > SAME_SIDE)]
        if len(near) >= FEWEST_AROUND:
            rise, run = cosines[near], heights[near]
            spread = run - run.mean()
            slope = (spread @ rise) / max(float(spread @ spread), TINY)
            found.append(abs(float(rise.mean() - slope * run.mean())))
    return float(np.median(found)) if len(found) >= MOSTLY * len(rim) else 1.0
