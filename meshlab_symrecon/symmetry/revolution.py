"""Bodies of revolution: all planes through the axis nearly fit, and a handle tells the true one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshlab_symrecon.arrays import Booleans, Floats, Planes
from meshlab_symrecon.symmetry.preparation import PreparedCloud
from meshlab_symrecon.symmetry.verification import examine, land

__all__ = ["Axis", "Meridians", "meridians", "on_axis", "revolution_axis"]

# Lengths are in diagonals of the prepared cloud.
NEARLY_BEST = 0.8  # of the best agreement: planes that may be meridians
LEAST_CROSSING = np.sin(np.radians(20.0))  # between two planes that define an axis
ON_AXIS = (np.sin(np.radians(5.0)), 0.02)  # tilt and distance of a plane through the axis
FEWEST_PLANES = 4
POLISHING = 3
COUNT = 60  # meridians that are tried
CONTINUOUS = 0.7  # share of them that has to fit
FEWEST_JUDGED = 10  # meridians that can judge a sample
OFF_BODY = (0.6, 0.3)  # of the usual share of meridians that match a sample: from body to handle
TOP = 4  # meridians under which a sample fits best
LEAST_FIT = 0.2  # and how well it has to fit there, to be no clutter


@dataclass(frozen=True, slots=True, eq=False)
class Axis:
    """An axis of revolution."""

    point: Floats  # (3,)
    direction: Floats  # (3,)  unit


@dataclass(frozen=True, slots=True, eq=False)
class Meridians:
    """Planes through an axis of revolution, evenly turned."""

    planes: Planes  # (k, 4)
    handle: Floats  # (k,)  how much of what is off the body of revolution each plane matches
    off_body: float  # share of the cloud that is off the body of revolution


def revolution_axis(planes: Planes, agreement: Floats) -> Axis | None:
    """Find the line that most of the good planes pass through.

    Parameters
    ----------
    planes : (k, 4) float
        Verified planes, in the coordinates of the prepared cloud.
    agreement : (k,) float
        Their agreement.

    Returns
    -------
    Axis or None
        None when fewer than four planes share a line.
    """
    good = planes[agreement >= NEARLY_BEST * agreement.max(initial=0.0)]
    best: Booleans = np.zeros(len(good), dtype=bool)
    for row, plane in enumerate(good):
        for other in good[row + 1 :]:
            if np.linalg.norm(np.cross(plane[:3], other[:3])) > LEAST_CROSSING:
                through = on_axis(good, _common_line(np.stack([plane, other])))
                best = through if through.sum() > best.sum() else best
    if best.sum() < FEWEST_PLANES:
        return None
    for _ in range(POLISHING):
        axis = _common_line(good[best])
        best = on_axis(good, axis)
        if best.sum() < FEWEST_PLANES:
            return None
    return axis


def on_axis(planes: Planes, axis: Axis) -> Booleans:
    """Tell which planes pass through an axis.

    Parameters
    ----------
    planes : (k, 4) float
        Unit normals and offsets, in the coordinates of the axis.
    axis : Axis
        The axis.

    Returns
    -------
    (k,) bool
        True up to a tilt of 5 degrees and a distance of 0.02 diagonals.
    """
    tilt = np.abs(planes[:, :3] @ axis.direction)
    apart = np.abs(planes[:, :3] @ axis.point + planes[:, 3])
    through: Booleans = (tilt < ON_AXIS[0]) & (apart < ON_AXIS[1])
    return through


def meridians(axis: Axis, cloud: PreparedCloud, tolerance: float) -> Meridians | None:
    """Try all planes through an axis, and see under which ones the handles match.

    Points of the body of revolution match under every plane and tell nothing. What matches under
    few planes only is off the body, such as a handle or a spout.

    Parameters
    ----------
    axis : Axis
        The axis.
    cloud : PreparedCloud
        The cloud.
    tolerance : float
        Of a match, in diagonals.

    Returns
    -------
    Meridians or None
        None when the cloud is no body of revolution: most planes through the axis do not fit.
    """
    planes = _planes_through(axis)
    agreement = examine(planes, cloud, len(cloud.samples), tolerance, exact=False).agreement
    if (agreement >= NEARLY_BEST * agreement.max()).mean() < CONTINUOUS:
        return None
    landings = land(planes, cloud, cloud.samples, tolerance)
    judged = landings.weights * ~(landings.excused | landings.broken_off)
    times = judged.sum(axis=0)
    usual = (landings.weights * landings.worth).sum(axis=0) / np.maximum(times, 1.0)
    on_body = float(np.median(usual[usual > 0.0])) if (usual > 0.0).any() else 1.0
    most, least = OFF_BODY
    off = np.clip((most - usual / on_body) / (most - least), 0.0, 1.0) * (times > FEWEST_JUDGED)
    fit = np.maximum(np.sort(landings.worth, axis=0)[-TOP:].mean(axis=0), LEAST_FIT)
    possible = (landings.weights * (off * fit)).sum(axis=1)
    matched = (landings.weights * landings.worth) @ off
    return Meridians(planes, matched / np.maximum(possible, 1.0), float(off.mean()))


def _common_line(planes: Planes) -> Axis:
    """Return the line nearest to lying in all planes."""
    direction = np.linalg.svd(planes[:, :3], full_matrices=True)[2][2]
    rows = np.concatenate([planes[:, :3], direction[np.newaxis]])
    point = np.linalg.lstsq(rows, np.append(-planes[:, 3], 0.0), rcond=None)[0]
    return Axis(point, direction)


def _planes_through(axis: Axis) -> Planes:
    across = np.linalg.svd(axis.direction[np.newaxis], full_matrices=True)[2][1:]
    turns = np.arange(COUNT) * (np.pi / COUNT)
    normals = np.cos(turns)[:, np.newaxis] * across[0] + np.sin(turns)[:, np.newaxis] * across[1]
    return np.column_stack([normals, -normals @ axis.point])
