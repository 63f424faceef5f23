"""Refinement: the mirrored cloud is fitted to the cloud itself, point to plane, by Gauss-Newton."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshlab_symrecon import _native
from meshlab_symrecon.arrays import Floats, Indices, Planes
from meshlab_symrecon.symmetry.preparation import PreparedCloud

__all__ = ["Schedule", "refine_planes"]

REACH = 2.5  # tolerances within which a partner counts
DIRECTION_RAMP = (0.7, 0.95)  # cosine of normals: no partner .. counts fully
POINT_SHARE = 0.05  # of point-to-point distance: holds flat and round parts against sliding
RIDGE = 1e-9  # of the trace
LARGEST_TURN = 0.2  # radians a step
SETTLED = 1e-10  # turn and shift, in radians and units of the cloud
FEWEST = 20  # partners


@dataclass(frozen=True, slots=True, eq=False)
class Schedule:
    """How the tolerance shrinks: geometrically over the first 60 % of the steps."""

    steps: int
    first: Floats | float  # tolerance of the first step, in the units of the cloud; (k,) or one
    last: Floats | float  # tolerance at the end

    def tolerances(self, step: int) -> Floats:
        """Return the tolerances of a step, (k,) or one number."""
        share = min(1.0, step / max(1.0, 0.6 * self.steps))
        first = np.asarray(self.first, dtype=np.float64)
        found: Floats = np.asarray(first * (self.last / first) ** share)
        return found


def refine_planes(
    planes: Planes, queries: Indices, cloud: PreparedCloud, schedule: Schedule, *, exact: bool
) -> Planes:
    """Move planes to where the mirrored queries fit the cloud best.

    Unknowns are two turns of the normal and the offset. The residual is the distance of a mirrored
    query from the tangent plane at its partner, weighted by distance and by agreement of the
    normals.

    Parameters
    ----------
    planes : (k, 4) float
        Starting planes.
    queries : (q,) int
        Points of the cloud that are mirrored.
    cloud : PreparedCloud
        The cloud.
    schedule : Schedule
        Number of steps and tolerances.
    exact : bool
        Partners are the closest points; otherwise they come from the table, right to about a cell.

    Returns
    -------
    (k, 4) float
        Refined planes. A plane stays where it is once it has fewer than 20 partners.
    """
    steps = [schedule.tolerances(step) for step in range(schedule.steps)]
    tolerances = np.stack([np.broadcast_to(step, len(planes)) for step in steps], axis=1)
    found: Planes = _native.refine_planes(
        np.ascontiguousarray(planes),
        queries.astype(np.int32),
        tolerances.reshape(-1),
        cloud.field,
        cloud.normals,
        exact,
        _rules(),
    )
    return found


def _rules() -> _native.RefinementRules:
    none, full = DIRECTION_RAMP
    return _native.RefinementRules(
        reach=REACH,
        no_direction=none,
        full_direction=full,
        point_share=POINT_SHARE,
        ridge=RIDGE,
        largest_turn=LARGEST_TURN,
        settled=SETTLED,
        fewest=FEWEST,
    )
