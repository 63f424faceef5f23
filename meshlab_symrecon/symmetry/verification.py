"""Verification of a plane: what the mirror image confirms, and what nothing can excuse."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshlab_symrecon import _native
from meshlab_symrecon.arrays import Booleans, Floats, Indices, Planes
from meshlab_symrecon.symmetry.preparation import PreparedCloud

__all__ = ["Evidence", "Landings", "examine", "land"]

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
HOLE, BROKEN_OFF = 1, 2  # excuses
BEYOND = 0.25  # diagonals beyond which nothing can be said


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

    def joined(self, other: Evidence) -> Evidence:
        """Return this evidence and another one's after it."""
        return Evidence(
            np.concatenate([self.support, other.support]),
            np.concatenate([self.agreement, other.agreement]),
            np.concatenate([self.contradiction, other.contradiction]),
            np.concatenate([self.residual, other.residual]),
        )


@dataclass(frozen=True, slots=True, eq=False)
class Landings:
    """Where the mirror image of each query falls; a row a plane, a column a query."""

    partners: Indices  # (k, q)  points of the cloud
    weights: Floats  # (k, q)  of the queries: those near the plane count less
    distances: Floats  # (k, q)  to the partners, in diagonals
    cosines: Floats  # (k, q)  between the normals; |cosine| where a side is not known
    worth: Floats  # (k, q)  of the match, 0 to 1
    excused: Booleans  # (k, q)  the image may have fallen into a hole,
    broken_off: Booleans  # (k, q)  or is known to be missing


def examine(
    planes: Planes, cloud: PreparedCloud, count: int, tolerance: float, *, exact: bool
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
    tolerance : float
        Distance from the tangent plane at which a match is worth ``exp(-1/2)``, in diagonals;
        larger in sparse clouds.
    exact : bool
        Partners are the closest points; otherwise they come from the table, right to about a cell.

    Returns
    -------
    Evidence
        Rows in the order of the planes.
    """
    columns = _native.examine(
        np.ascontiguousarray(planes),
        cloud.samples[:count].astype(np.int32),
        cloud.distinctness[:count],
        cloud.field,
        cloud.normals,
        cloud.oriented.view(np.uint8),
        cloud.border_distance,
        exact,
        _rules(cloud, tolerance),
    ).T
    return Evidence(*(np.ascontiguousarray(column) for column in columns))


def land(planes: Planes, cloud: PreparedCloud, queries: Indices, tolerance: float) -> Landings:
    """Mirror query points across each plane and tell where each image falls.

    Parameters
    ----------
    planes : (k, 4) float
        Planes in the coordinates of the prepared cloud.
    cloud : PreparedCloud
        The cloud.
    queries : (q,) int
        Points of the cloud that are mirrored.
    tolerance : float
        As for `examine`, whose sums are made of these terms.

    Returns
    -------
    Landings
        Rows in the order of the planes.
    """
    partners, weights, distances, cosines, worth, excuses = _native.landings(
        np.ascontiguousarray(planes),
        queries.astype(np.int32),
        cloud.field,
        cloud.normals,
        cloud.oriented.view(np.uint8),
        cloud.border_distance,
        True,
        _rules(cloud, tolerance),
    )
    shape = (len(planes), len(queries))
    return Landings(
        partners=partners.reshape(shape).astype(np.int64),
        weights=weights.reshape(shape),
        distances=distances.reshape(shape),
        cosines=cosines.reshape(shape),
        worth=worth.reshape(shape),
        excused=excuses.reshape(shape) == HOLE,
        broken_off=excuses.reshape(shape) == BROKEN_OFF,
    )


def _rules(cloud: PreparedCloud, tolerance: float) -> _native.EvidenceRules:
    none, full = DIRECTION_RAMP
    spacing = cloud.spacing
    return _native.EvidenceRules(
        tolerance=max(tolerance, TOLERANCE_SPACINGS * spacing),
        no_direction=none,
        full_direction=full,
        sideways=min(max(SIDEWAYS * spacing, LEAST_SIDEWAYS), MOST_SIDEWAYS),
        near_plane=NEAR_PLANE,
        no_match=NO_MATCH,
        rim_reach=RIM_REACH,
        least_gap=LEAST_GAP * spacing,
        far=max(FAR, FAR_SPACINGS * spacing),
        beyond=BEYOND,
        broken_off=cloud.broken_off,
    )
