"""Detection of reflection planes: the recipe, step by step."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from meshlab_symrecon.arrays import Floats, Planes, as_normals, as_points
from meshlab_symrecon.clustering.messages import propagate_sparse
from meshlab_symrecon.clustering.neighbour_graph import neighbour_graph
from meshlab_symrecon.errors import ParameterError
from meshlab_symrecon.geometry.bounds import require_solid
from meshlab_symrecon.geometry.planes import canonical_planes, distinct_planes
from meshlab_symrecon.symmetry.candidates import vote
from meshlab_symrecon.symmetry.confidence import (
    believable,
    confidence,
    family_sizes,
    merit,
)
from meshlab_symrecon.symmetry.embedding import embed_planes
from meshlab_symrecon.symmetry.preparation import PreparedCloud, prepare
from meshlab_symrecon.symmetry.refinement import Schedule, refine_planes
from meshlab_symrecon.symmetry.verification import Evidence, examine

__all__ = [
    "LIMITS",
    "DetectionOptions",
    "ReflectionPlanes",
    "Verified",
    "detect_reflection_planes",
    "verified_planes",
]

Progress: TypeAlias = Callable[[float, str], None]

# Lengths are in diagonals of the prepared cloud.
MOST_CANDIDATES = 30_000
QUICK_QUERIES = 96  # enough to put candidates in an order
QUICK_TOLERANCE = 0.025
BANDWIDTH = 0.02  # H: planes whose mirror images differ less vote for the same symmetry
THINNING = 0.5  # H: edge of the cells of which only the best candidate is clustered
MOST_CLUSTERED = 2_500
NEIGHBOURS = 32
LONGEST_EDGE = 6.0  # H
PREFERENCE = 10.0  # H^2: an exemplar stands for planes up to about 3 H away
DAMPING = 0.7
MOST_ITERATIONS = 200
CALM_ITERATIONS = 15
MOST_EXEMPLARS = 500
SAME = (np.radians(3.0), 0.02)  # angle and offset of planes that nearly repeat each other
VARIANT = (np.radians(8.0), 0.06)  # and of two of which at most one is true
TOLERANCE = 0.006  # of a match in verification
FINEST = 0.006  # last tolerance of the refinement, but at least one spacing
BROADEST = 0.025  # and never more than this
QUERIES = 2_500


@dataclass(frozen=True, slots=True)
class _Stage:
    """One stage of the cascade: fewer planes, looked at more closely."""

    queries: int
    steps: int
    first: float  # tolerance of the refinement at its start
    last: float  # and at its end,
    breadth: float  # or this many residuals of the plane, whichever is larger
    kept: int  # planes that go on
    exact: bool  # partners are exact, not from the table alone


CASCADE = (
    _Stage(400, steps=6, first=0.04, last=0.015, breadth=0.0, kept=96, exact=False),
    _Stage(1_000, steps=12, first=0.03, last=FINEST, breadth=0.0, kept=32, exact=False),
    # A shape that is symmetric only to some extent is fitted that much more broadly.
    _Stage(QUERIES, steps=12, first=0.015, last=FINEST, breadth=6.0, kept=32, exact=True),
)


LIMITS: dict[str, tuple[int, int]] = {
    "max_planes": (1, CASCADE[-1].kept),
    "min_confidence": (0, 1),
    "sample_count": (50, QUERIES),
}


@dataclass(frozen=True, slots=True)
class DetectionOptions:
    """What to look for.

    Attributes
    ----------
    max_planes : int
        Most planes returned, 1 to 24.
    min_confidence : float
        Planes with less confidence are not returned, 0 to 1.
    sample_count : int
        Even samples whose pairs vote, 50 to 2500; O(sample_count^2) time and memory.
    """

    max_planes: int = 8
    min_confidence: float = 0.85
    sample_count: int = 1_200

    def __post_init__(self) -> None:
        for name, (low, high) in LIMITS.items():
            value = getattr(self, name)
            if not low <= value <= high:
                message = f"{name} must lie between {low} and {high}; got {value!r}; change it"
                raise ParameterError(message)


@dataclass(frozen=True, slots=True, eq=False)
class ReflectionPlanes:
    """Planes found, best first; possibly none."""

    planes: Planes  # (k, 4)  unit normal A, B, C and D; the largest normal component is positive
    support: Floats  # (k,)  share of the points with a mirror partner, away from the plane; 0..1
    residual: Floats  # (k,)  RMS distance of partners from the tangent plane / diagonal
    confidence: Floats  # (k,)  chance that the plane is true, 0..1
    converged: bool  # False: clustering stopped at its iteration limit


@dataclass(frozen=True, slots=True, eq=False)
class Verified:
    """All planes that came through the cascade, best first, in the coordinates of the input."""

    planes: Planes  # (k, 4)
    evidence: Evidence
    confidence: Floats  # (k,)
    converged: bool


def detect_reflection_planes(
    points: ArrayLike,
    normals: ArrayLike | None = None,
    *,
    options: DetectionOptions | None = None,
    rng: np.random.Generator | None = None,
    progress: Progress | None = None,
) -> ReflectionPlanes:
    """Find the planes across which an incomplete cloud is its own mirror image.

    Pairs of even samples vote for planes, affinity propagation chooses exemplars among the
    candidates in a space where distances are lengths, and each exemplar is refined against the
    cloud and verified by it. The result follows every motion, scaling and permutation of the
    points.

    Parameters
    ----------
    points : (n, 3) float
        The scan; at least 5 points, not in one plane.
    normals : (n, 3) float, optional
        Outward normals. Directions are fitted anew; these tell the outside from the inside.
    options : DetectionOptions, optional
        What to look for.
    rng : numpy.random.Generator, optional
        Chooses among too many candidates; a fixed seed by default.
    progress : callable, optional
        Called with a fraction and a message.

    Returns
    -------
    ReflectionPlanes
        Best first; ``planes`` has shape (0, 4) when there is no symmetry.

    Raises
    ------
    GeometryError
        Fewer than 5 points, points in one plane, or arrays of the wrong shape or not finite.
    """
    options = DetectionOptions() if options is None else options
    found = verified_planes(points, normals, options=options, rng=rng, progress=progress)
    accepted = believable(found.evidence, found.confidence, options.min_confidence)
    chosen = np.flatnonzero(accepted)[: options.max_planes]
    return ReflectionPlanes(
        planes=found.planes[chosen],
        support=found.evidence.support[chosen],
        residual=found.evidence.residual[chosen],
        confidence=found.confidence[chosen],
        converged=found.converged,
    )


def verified_planes(
    points: ArrayLike,
    normals: ArrayLike | None = None,
    *,
    options: DetectionOptions,
    rng: np.random.Generator | None = None,
    progress: Progress | None = None,
) -> Verified:
    """Return the best planes whatever their confidence; `detect_reflection_planes` judges them."""
    cloud_points = as_points(points)
    sides = None if normals is None else as_normals(normals, len(cloud_points))
    require_solid(cloud_points, "detection of reflection planes")
    rng = np.random.default_rng(0) if rng is None else rng
    report = _silent if progress is None else progress
    report(0.0, "preparing the cloud")
    cloud = prepare(cloud_points, sides, QUERIES)
    report(0.4, "collecting votes of point pairs")
    candidates = vote(cloud, options.sample_count, MOST_CANDIDATES, rng)
    report(0.5, "clustering the votes")
    planes, converged = _exemplars(cloud, candidates.planes)
    evidence = examine(planes, cloud, 1, TOLERANCE, exact=False)
    for number, stage in enumerate(CASCADE):
        report(0.7 + 0.1 * number, "refining and verifying planes")
        planes, evidence = _pass_stage(cloud, planes, evidence, stage)
    report(1.0, f"{len(planes)} planes verified")
    sizes = family_sizes(planes, evidence)
    chances = confidence(evidence, sizes, cloud.roughness, len(cloud.samples))
    order = distinct_planes(planes, merit(evidence), VARIANT)
    order = order[np.argsort(-chances[order], kind="stable")]
    planes = canonical_planes(_to_input(cloud, planes[order]))
    return Verified(planes, evidence.take(order), chances[order], converged)


def _silent(fraction: float, message: str) -> None:
    """Report nothing."""


def _exemplars(cloud: PreparedCloud, planes: Planes) -> tuple[Planes, bool]:
    """Cluster candidates by affinity propagation; the most convincing exemplars come first.

    The preference of a candidate is its support in a quick look, so that exemplars sit where the
    cloud confirms them.
    """
    quick = examine(planes, cloud, QUICK_QUERIES, QUICK_TOLERANCE, exact=False)
    votes = quick.support - quick.contradiction
    order = np.argsort(-votes, kind="stable")
    places = embed_planes(planes[order], cloud.root_covariance)
    cells = np.floor(places / (THINNING * BANDWIDTH)).astype(np.int64)
    first = np.sort(np.unique(cells, axis=0, return_index=True)[1])[:MOST_CLUSTERED]
    places, planes, votes = places[first], planes[order][first], votes[order][first]
    if len(planes) < 3:  # messages need a choice
        return planes, True
    similarities, targets = neighbour_graph(places, NEIGHBOURS)
    similarities[similarities < -((LONGEST_EDGE * BANDWIDTH) ** 2)] = -np.inf
    likely = np.clip(votes / max(float(votes.max()), 1e-9), 0.0, 1.0)
    similarities[:, 0] = -PREFERENCE * BANDWIDTH**2 * (1.0 - 0.5 * likely)
    found = propagate_sparse(similarities, targets, DAMPING, MOST_ITERATIONS, CALM_ITERATIONS)
    best = found.exemplars[np.argsort(-votes[found.exemplars], kind="stable")]
    return planes[best[:MOST_EXEMPLARS]], found.converged


def _pass_stage(
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


def _to_input(cloud: PreparedCloud, planes: Planes) -> Planes:
    offsets = planes[:, 3] * cloud.scale - planes[:, :3] @ cloud.centre
    return np.column_stack([planes[:, :3], offsets])
