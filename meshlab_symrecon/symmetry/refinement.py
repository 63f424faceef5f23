"""Refinement: the mirrored cloud is fitted to the cloud itself, point to plane, by Gauss-Newton."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from meshlab_symrecon.arrays import Floats, Indices, Planes, Points
from meshlab_symrecon.geometry.neighbours import tangent_bases

__all__ = ["Lookup", "Schedule", "refine_planes"]

Lookup: TypeAlias = Callable[[Floats], Indices]  # places (..., 3) -> index of a nearest point (...)

REACH = 2.5  # tolerances within which a partner counts
POINT_SHARE = 0.05  # of point-to-point distance: holds flat and rotational parts against sliding
NORMALS_BEGIN, NORMALS_RANGE = 0.7, 0.25  # cosine from which partners count, and until fully
LARGEST_TURN = 0.2  # radians a step
RIDGE = 1e-9  # of the trace
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
    planes: Planes,
    queries: tuple[Points, Points],
    cloud: tuple[Points, Points],
    nearest: Lookup,
    schedule: Schedule,
) -> Planes:
    """Move planes to where the mirrored queries fit the cloud best.

    Unknowns are two turns of the normal and the offset. The residual is the distance of a mirrored
    query from the tangent plane at its partner, weighted by distance and by agreement of the
    normals.

    Parameters
    ----------
    planes : (k, 4) float
        Starting planes; the origin near the middle of the cloud.
    queries : pair of (q, 3) float
        Points that are mirrored, and their unit normals.
    cloud : pair of (n, 3) float
        Points they are fitted to, and their unit normals.
    nearest : callable
        Finds partners in the cloud.
    schedule : Schedule
        Number of steps and tolerances.

    Returns
    -------
    (k, 4) float
        Refined planes. A plane with fewer than 20 partners stays where it is.
    """
    normals, offsets = planes[:, :3].copy(), -planes[:, 3].copy()
    for step in range(schedule.steps):
        system, gradient, partners = _normal_equations(
            (normals, offsets), queries, cloud, nearest, schedule.tolerances(step)
        )
        ridge = RIDGE * np.trace(system, axis1=1, axis2=2) + np.finfo(float).tiny
        system += ridge[:, np.newaxis, np.newaxis] * np.eye(3)
        moves = -np.linalg.solve(system, gradient[..., np.newaxis])[..., 0]
        moves[partners < FEWEST] = 0.0
        turns = np.linalg.norm(moves[:, :2], axis=1, keepdims=True)
        moves *= np.minimum(1.0, LARGEST_TURN / np.maximum(turns, LARGEST_TURN))
        first, second = tangent_bases(normals)
        normals = normals + moves[:, :1] * first + moves[:, 1:2] * second
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        offsets = offsets + moves[:, 2]
        if step >= 0.6 * schedule.steps and np.abs(moves).max(initial=0.0) < SETTLED:
            break
    return np.column_stack([normals, -offsets])


def _normal_equations(
    planes: tuple[Floats, Floats],
    queries: tuple[Points, Points],
    cloud: tuple[Points, Points],
    nearest: Lookup,
    tolerances: Floats,
) -> tuple[Floats, Floats, Indices]:
    """Return the Gauss-Newton systems (k, 3, 3), gradients (k, 3) and numbers of partners (k,)."""
    normals, offsets = planes
    points, directions = queries
    first, second = tangent_bases(normals)
    heights = normals @ points.T - offsets[:, np.newaxis]  # (k, q)
    mirrored = points - 2.0 * heights[..., np.newaxis] * normals[:, np.newaxis]
    partners = nearest(mirrored)
    gaps = mirrored - cloud[0][partners]
    partner_normals = cloud[1][partners]
    squares = np.einsum("kqi,kqi->kq", gaps, gaps)
    along = np.einsum("kqi,ki->kq", partner_normals, normals)
    agreement = np.einsum("kqi,qi->kq", partner_normals, directions)
    agreement = np.abs(agreement - 2.0 * along * (normals @ directions.T))
    relative = squares / tolerances[..., np.newaxis] ** 2
    weights = np.exp(-0.5 * relative)
    weights *= np.clip((agreement - NORMALS_BEGIN) / NORMALS_RANGE, 0.0, 1.0)
    weights[relative > REACH**2] = 0.0
    residuals = np.einsum("kqi,kqi->kq", gaps, partner_normals)

    def slopes(targets: Floats, towards: Floats) -> Floats:
        """Derive ``targets . mirrored`` by the turns and the offset, (k, q, 3)."""
        columns = [
            -2.0 * (heights * np.einsum("kqi,ki->kq", targets, axis) + (axis @ points.T) * towards)
            for axis in (first, second)
        ]
        return np.stack([*columns, 2.0 * towards], axis=-1)

    jacobian = slopes(partner_normals, along)
    weighted = weights[..., np.newaxis] * jacobian
    system = np.einsum("kqi,kqj->kij", weighted, jacobian)
    gradient = np.einsum("kqi,kq->ki", weighted, residuals)
    # Point to point: by turns  -2 (t u + (p . u) n), by the offset  2 n; u, v, n are orthonormal.
    rows = np.stack([-2.0 * (axis @ points.T) for axis in (first, second)], axis=-1)
    rows = np.concatenate([rows, np.full((*heights.shape, 1), 2.0)], axis=-1)  # along n
    along_gap = np.einsum("kqi,ki->kq", gaps, normals)
    share = POINT_SHARE * weights
    system += np.einsum("kqi,kqj,kq->kij", rows, rows, share)
    spread = 4.0 * np.einsum("kq,kq->k", heights**2, share)
    system[:, 0, 0] += spread
    system[:, 1, 1] += spread
    gradient += np.einsum("kqi,kq->ki", rows, share * along_gap)
    for column, axis in enumerate((first, second)):
        sideways = np.einsum("kqi,ki->kq", gaps, axis)
        gradient[:, column] -= 2.0 * np.einsum("kq,kq->k", heights * sideways, share)
    return system, gradient, (weights > 0.0).sum(axis=1)
