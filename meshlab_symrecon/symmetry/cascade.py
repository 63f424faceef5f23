"""The cascade: few planes go on from each stage, and are looked at more closely in the next."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshlab_symrecon.arrays import Floats, Planes
from meshlab_symrecon.geometry.neighbours import tangent_bases
from meshlab_symrecon.geometry.planes import distinct_planes
from meshlab_symrecon.symmetry.preparation import PreparedCloud
from meshlab_symrecon.symmetry.refinement import Schedule, refine_planes
from meshlab_symrecon.symmetry.traits import merit
from meshlab_symrecon.symmetry.verification import Evidence, examine

__all__ = [
    "KEPT",
    "QUERIES",
    "TOLERANCE",
    "refine_and_verify",
    "refine_drawn",
    "refine_nearby",
    "settle",
]

# Lengths are in diagonals of the prepared cloud.
TOLERANCE = 0.006  # of a match in verification
FINEST = 0.006  # last tolerance of the refinement, but at least one spacing,
BROADEST = 0.025  # and never more than this
QUERIES = 2_500
KEPT = 32  # planes at the end
SAME = (np.radians(3.0), 0.02)  # angle and offset of planes that nearly repeat each other
SETTLING = 40  # most steps until refined planes stay
RESTARTED = 8  # best planes that are started again
TILT, SHIFT = np.radians(4.0), 0.015  # from here and there beside them


@dataclass(frozen=True, slots=True)
class _Stage:
    queries: int
    steps: int
    first: float  # tolerance of the refinement at its start
    last: float  # and at its end,
    breadth: float  # or this many residuals of the plane, whichever is larger
    kept: int  # planes that go on
    exact: bool  # partners are exact, not from the table alone


WIDE = _Stage(400, steps=6, first=0.04, last=0.015, breadth=0.0, kept=96, exact=False)
CLOSER = _Stage(1_000, steps=12, first=0.03, last=FINEST, breadth=0.0, kept=KEPT, exact=False)
DRAWN = _Stage(1_000, steps=20, first=0.06, last=FINEST, breadth=0.0, kept=8, exact=False)
AGAIN = _Stage(1_000, steps=10, first=0.02, last=FINEST, breadth=0.0, kept=KEPT, exact=False)
# A shape that is symmetric only to some extent is fitted that much more broadly.
FINAL = _Stage(QUERIES, steps=12, first=0.015, last=FINEST, breadth=6.0, kept=KEPT, exact=True)


def refine_and_verify(cloud: PreparedCloud, planes: Planes) -> tuple[Planes, Evidence]:
    """Refine planes against the cloud and verify them, and keep the best that differ.

    Parameters
    ----------
    cloud : PreparedCloud
        The cloud.
    planes : (k, 4) float
        Where to start, in its coordinates.

    Returns
    -------
    planes : (m, 4) float
        At most 32, best first.
    evidence : Evidence
        What was found of them.
    """
    evidence = examine(planes, cloud, 1, TOLERANCE, exact=False)
    for stage in (WIDE, CLOSER):
        planes, evidence = _pass(cloud, planes, evidence, stage)
    # Near a true plane of a shape that is not quite symmetric there are several optima.
    planes = np.concatenate([planes, *(_beside(plane) for plane in planes[:RESTARTED])])
    evidence = examine(planes, cloud, 1, TOLERANCE, exact=False)
    for stage in (AGAIN, FINAL):
        planes, evidence = _pass(cloud, planes, evidence, stage)
    return planes, evidence


def refine_drawn(cloud: PreparedCloud, planes: Planes) -> Planes:
    """Refine planes that were drawn by hand, from there and from some places beside them.

    Parameters
    ----------
    cloud : PreparedCloud
        The cloud.
    planes : (k, 4) float
        Right to about ten degrees and a twentieth of the diagonal, in its coordinates.

    Returns
    -------
    (k, 4) float
        In the same order.
    """
    found = []
    for plane in planes:
        starts = np.concatenate([plane[np.newaxis], _beside(plane)])
        evidence = examine(starts, cloud, 1, TOLERANCE, exact=False)
        for stage in (DRAWN, FINAL):
            starts, evidence = _pass(cloud, starts, evidence, stage)
        found.append(starts[0])
    return np.array(found).reshape(len(planes), 4)


def refine_nearby(cloud: PreparedCloud, planes: Planes) -> Planes:
    """Refine planes that are nearly right.

    Parameters
    ----------
    cloud : PreparedCloud
        The cloud.
    planes : (k, 4) float
        Where to start, in its coordinates.

    Returns
    -------
    (k, 4) float
        In the same order.
    """
    last = max(FINAL.last, cloud.spacing)
    schedule = Schedule(FINAL.steps, max(FINAL.first, last), last)
    return refine_planes(planes, cloud.samples, cloud, schedule, exact=True)


def settle(cloud: PreparedCloud, planes: Planes, residuals: Floats) -> Planes:
    """Refine planes at the last tolerance until they stay.

    Parameters
    ----------
    cloud : PreparedCloud
        The cloud.
    planes : (k, 4) float
        Refined planes, in its coordinates.
    residuals : (k,) float
        Their residuals.

    Returns
    -------
    (k, 4) float
        In the same order.
    """
    last = np.clip(FINAL.breadth * residuals, max(FINAL.last, cloud.spacing), BROADEST)
    schedule = Schedule(SETTLING, last, last)
    return refine_planes(planes, cloud.samples, cloud, schedule, exact=True)


def _pass(
    cloud: PreparedCloud, planes: Planes, evidence: Evidence, stage: _Stage
) -> tuple[Planes, Evidence]:
    """Refine planes, verify them, and keep the best that differ; best first."""
    queries = cloud.samples[: stage.queries]
    last = np.clip(stage.breadth * evidence.residual, max(stage.last, cloud.spacing), BROADEST)
    schedule = Schedule(stage.steps, np.maximum(stage.first, last), last)
    planes = refine_planes(planes, queries, cloud, schedule, exact=stage.exact)
    evidence = examine(planes, cloud, stage.queries, TOLERANCE, exact=stage.exact)
    kept = distinct_planes(planes, merit(evidence), SAME)[: stage.kept]
    return planes[kept], evidence.take(kept)


def _beside(plane: Planes) -> Planes:
    """Return planes tilted a little both ways about two axes, and shifted."""
    normal, offset = plane[:3], plane[3]
    first, second = tangent_bases(normal[np.newaxis])
    tilted = [
        normal + np.tan(TILT) * sign * axis[0] for axis in (first, second) for sign in (-1.0, 1.0)
    ]
    normals = np.stack([*tilted, normal, normal])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    offsets = np.array([offset] * len(tilted) + [offset - SHIFT, offset + SHIFT])
    return np.column_stack([normals, offsets])
