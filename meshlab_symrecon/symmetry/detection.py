"""Detection of reflection planes: the recipe, step by step."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from meshlab_symrecon.arrays import Floats, Planes, as_normals, as_planes, as_points
from meshlab_symrecon.errors import ParameterError
from meshlab_symrecon.geometry.bounds import require_solid
from meshlab_symrecon.geometry.planes import canonical_planes
from meshlab_symrecon.one_thread import in_one_thread
from meshlab_symrecon.symmetry.candidates import vote
from meshlab_symrecon.symmetry.cascade import KEPT, QUERIES
from meshlab_symrecon.symmetry.confidence import believable
from meshlab_symrecon.symmetry.exemplars import choose_exemplars
from meshlab_symrecon.symmetry.judgement import judge, judge_again, judge_drawn
from meshlab_symrecon.symmetry.preparation import PreparedCloud, prepare
from meshlab_symrecon.symmetry.progress import Progress, silent
from meshlab_symrecon.symmetry.verification import Evidence

__all__ = [
    "LIMITS",
    "DetectionOptions",
    "ReflectionPlanes",
    "Verified",
    "detect_reflection_planes",
    "refine_reflection_planes",
    "verified_planes",
]

MOST_CANDIDATES = 30_000  # votes that are clustered

LIMITS: dict[str, tuple[int, int]] = {
    "max_planes": (1, KEPT),
    "min_confidence": (0, 1),
    "sample_count": (50, QUERIES),
}


@dataclass(frozen=True, slots=True)
class DetectionOptions:
    """What to look for.

    Attributes
    ----------
    max_planes : int
        Most planes returned, 1 to 32.
    min_confidence : float
        Planes with less confidence are not returned, 0 to 1.
    sample_count : int
        Even samples whose pairs vote, 50 to 2500; O(sample_count^2) time and memory.
    """

    max_planes: int = 8
    min_confidence: float = 0.6
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
    """All planes that may be reported, the likeliest first, in the coordinates of the input."""

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
        Normals. Directions are fitted anew; these tell the outside from the inside, unless they
        contradict the shape in many places.
    options : DetectionOptions, optional
        What to look for.
    rng : numpy.random.Generator, optional
        Chooses among too many candidates; a fixed seed by default.
    progress : callable, optional
        Called with a fraction and a message.

    Returns
    -------
    ReflectionPlanes
        The likeliest first; ``planes`` has shape (0, 4) when there is no symmetry.

    Raises
    ------
    GeometryError
        Fewer than 5 points, points in one plane, or arrays of the wrong shape or not finite.
    """
    options = DetectionOptions() if options is None else options
    found = verified_planes(points, normals, options=options, rng=rng, progress=progress)
    accepted = believable(found.evidence.agreement, found.confidence, options.min_confidence)
    chosen = np.flatnonzero(accepted)[: options.max_planes]
    return ReflectionPlanes(
        planes=found.planes[chosen],
        support=found.evidence.support[chosen],
        residual=found.evidence.residual[chosen],
        confidence=found.confidence[chosen],
        converged=found.converged,
    )


@in_one_thread
def refine_reflection_planes(
    points: ArrayLike,
    planes: ArrayLike,
    normals: ArrayLike | None = None,
    *,
    rng: np.random.Generator | None = None,
    progress: Progress | None = None,
) -> ReflectionPlanes:
    """Move planes that somebody has drawn to where the cloud fits its mirror image best.

    Nothing is left out, since somebody has said where the planes are; their confidence tells what
    the cloud says to that.

    Parameters
    ----------
    points : (n, 3) float
        The scan; at least 5 points, not in one plane.
    planes : (k, 4) float
        Planes, right to about ten degrees and a twentieth of the diagonal.
    normals : (n, 3) float, optional
        Outward normals.
    rng : numpy.random.Generator, optional
        As for `detect_reflection_planes`, whose search provides the planes' rivals.
    progress : callable, optional
        Called with a fraction and a message.

    Returns
    -------
    ReflectionPlanes
        In the order of the planes given.

    Raises
    ------
    GeometryError
        As for `detect_reflection_planes`; planes that are none.
    """
    drawn = as_planes(planes)
    cloud, exemplars, converged = _search(points, normals, DetectionOptions(), rng, progress)
    found = judge_drawn(cloud, exemplars, cloud.from_input(drawn))
    _report_end(progress, len(found.planes))
    return ReflectionPlanes(
        planes=canonical_planes(cloud.to_input(found.planes)),
        support=found.evidence.support,
        residual=found.evidence.residual,
        confidence=found.chances,
        converged=converged,
    )


@in_one_thread
def verified_planes(
    points: ArrayLike,
    normals: ArrayLike | None = None,
    *,
    options: DetectionOptions,
    rng: np.random.Generator | None = None,
    progress: Progress | None = None,
) -> Verified:
    """Return the best planes whatever their confidence, for studies of the detector.

    Parameters
    ----------
    points, normals, rng, progress
        As for `detect_reflection_planes`, which chooses among these planes.
    options : DetectionOptions
        Only its ``sample_count`` matters.

    Returns
    -------
    Verified
        Planes that differ, the likeliest first.

    Raises
    ------
    GeometryError
        As for `detect_reflection_planes`.
    """
    cloud, exemplars, converged = _search(points, normals, options, rng, progress)
    found = judge(cloud, exemplars)
    if cloud.on_plinth:
        found = judge_again(found, cloud, _prepared(points, normals, plinth=True))
    _report_end(progress, len(found.planes))
    planes = canonical_planes(cloud.to_input(found.planes))
    return Verified(planes, found.evidence, found.chances, converged)


def _prepared(points: ArrayLike, normals: ArrayLike | None, *, plinth: bool) -> PreparedCloud:
    cloud_points = as_points(points)
    sides = None if normals is None else as_normals(normals, len(cloud_points))
    require_solid(cloud_points, "detection of reflection planes")
    return prepare(cloud_points, sides, QUERIES, plinth=plinth)


def _search(
    points: ArrayLike,
    normals: ArrayLike | None,
    options: DetectionOptions,
    rng: np.random.Generator | None,
    progress: Progress | None,
) -> tuple[PreparedCloud, Planes, bool]:
    """Return the prepared cloud, exemplars among its candidate planes, and their convergence."""
    rng = np.random.default_rng(0) if rng is None else rng
    report = progress or silent
    report(0.0, "preparing the cloud")
    cloud = _prepared(points, normals, plinth=False)
    report(0.35, "collecting votes of point pairs")
    candidates = vote(cloud, options.sample_count, MOST_CANDIDATES, rng)
    report(0.4, "clustering the votes")
    exemplars, converged = choose_exemplars(cloud, candidates.planes)
    report(0.55, "refining and verifying planes")
    return cloud, exemplars, converged


def _report_end(progress: Progress | None, count: int) -> None:
    if progress is not None:
        progress(1.0, f"{count} planes verified")
