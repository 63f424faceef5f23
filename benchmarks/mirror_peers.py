"""Ways to the reflection planes of a cloud, judged by the detector's own verification.

The only benchmark module that knows the detector's steps.  All methods share its preparation of the
cloud, its verification and its confidence; they differ in where planes come from and how they are
fitted.  (Confidence rests on the lead over rivals, too: a method with three planes has few.)

- ``ours``: votes of point pairs, affinity propagation, the cascade of refinements, rims, handles;
- ``mean-shift``: the same with mean-shift in place of affinity propagation;
- ``multistart``: 200 even directions through the middle of the cloud, mirror ICP;
- ``pca``: the three principal planes through the middle, mirror ICP.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from mirror_icp import fibonacci_normals, mirror_icp
from scipy.spatial import cKDTree

from meshlab_symrecon.geometry.planes import canonical_planes, distinct_planes
from meshlab_symrecon.symmetry import cascade, detection, hypotheses
from meshlab_symrecon.symmetry.candidates import vote
from meshlab_symrecon.symmetry.confidence import believable, confidence
from meshlab_symrecon.symmetry.embedding import embed_planes
from meshlab_symrecon.symmetry.preparation import PreparedCloud, prepare
from meshlab_symrecon.symmetry.traits import merit, traits
from meshlab_symrecon.symmetry.verification import examine

OPTIONS = detection.DetectionOptions()
STARTS = 200
MEAN_SHIFT_STARTS = 300
MEAN_SHIFT_CANDIDATES = 8_000
MEAN_SHIFT_STEPS = 15
KERNEL = 0.03  # radius of the flat kernel, in diagonals


@dataclass(frozen=True, eq=False)
class Found:
    """What a method says of a cloud."""

    ranked: np.ndarray  # (k, 4)  all verified planes, best first
    reported: np.ndarray  # (m, 4)  those with enough confidence
    seconds: float  # CPU


def _through_middle(cloud: PreparedCloud, normals: np.ndarray) -> np.ndarray:
    middle = np.median(cloud.points[cloud.samples[:1000]], axis=0)
    return np.column_stack([normals, -normals @ middle])


def _fitted(cloud: PreparedCloud, starts: np.ndarray) -> np.ndarray:
    """Mirror ICP from all starts coarsely, then from the best that differ."""
    surface, tree = (cloud.points, cloud.normals), cKDTree(cloud.points)

    def fit(planes, count, tolerances):
        chosen = cloud.samples[:count]
        queries = cloud.points[chosen], cloud.normals[chosen]
        return np.array([mirror_icp(queries, surface, tree, plane, tolerances) for plane in planes])

    planes = fit(starts, 250, np.geomspace(0.06, 0.02, 12))
    evidence = examine(planes, cloud, 400, cascade.TOLERANCE, exact=True)
    kept = distinct_planes(planes, merit(evidence), cascade.SAME)[:40]
    last = max(cascade.FINEST, cloud.spacing)
    return fit(planes[kept], 1500, np.r_[np.geomspace(max(0.03, last), last, 12), [last] * 6])


# ------------------------------------------------------------------------- candidates and judgement


def _judged(cloud: PreparedCloud, planes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Verify fitted planes as the last stage of the detector does; ranked, and those reported."""
    evidence = examine(planes, cloud, cascade.QUERIES, cascade.TOLERANCE, exact=True)
    kept = distinct_planes(planes, merit(evidence), cascade.SAME)[: cascade.KEPT]
    planes, evidence = planes[kept], evidence.take(kept)
    measured = traits(planes, evidence, cloud, cascade.TOLERANCE)
    chances = confidence(measured, evidence, len(cloud.samples), broken=cloud.broken)
    order = distinct_planes(planes, chances, hypotheses.VARIANT)
    planes, evidence, chances = planes[order], evidence.take(order), chances[order]
    reported = believable(evidence.agreement, chances, OPTIONS.min_confidence)
    return planes, planes[reported][: OPTIONS.max_planes]


def _mean_shift(places: np.ndarray) -> np.ndarray:
    """Indices of the candidates nearest to the modes, most votes first."""
    steps = max(1, len(places) // MEAN_SHIFT_STARTS)
    tree, modes = cKDTree(places), places[::steps].copy()
    for _ in range(MEAN_SHIFT_STEPS):
        around = tree.query_ball_point(modes, KERNEL)
        modes = np.array(
            [places[m].mean(axis=0) if m else mode for m, mode in zip(around, modes, strict=True)]
        )
    votes = tree.query_ball_point(modes, KERNEL, return_length=True)
    chosen: list[int] = []
    for row in np.argsort(-votes, kind="stable"):
        gaps = np.linalg.norm(modes[chosen] - modes[row], axis=1)
        if not (gaps < KERNEL / 2).any():
            chosen.append(int(row))
    return tree.query(modes[chosen])[1]


def _by_mean_shift(cloud: PreparedCloud) -> np.ndarray:
    rng = np.random.default_rng(0)
    planes = vote(cloud, OPTIONS.sample_count, detection.MOST_CANDIDATES, rng).planes
    if len(planes) > MEAN_SHIFT_CANDIDATES:
        planes = planes[np.sort(rng.choice(len(planes), MEAN_SHIFT_CANDIDATES, replace=False))]
    if len(planes) == 0:
        return planes
    planes = planes[_mean_shift(embed_planes(planes, cloud.root_covariance))]
    return cascade.refine_and_verify(cloud, planes)[0]


def _by_multistart(cloud: PreparedCloud) -> np.ndarray:
    return _fitted(cloud, _through_middle(cloud, fibonacci_normals(STARTS)))


def _by_pca(cloud: PreparedCloud) -> np.ndarray:
    chosen = cloud.points[cloud.samples[:2000]]
    axes = np.linalg.eigh(np.cov(chosen.T))[1].T
    return _fitted(cloud, _through_middle(cloud, axes))


def ours(points: np.ndarray) -> Found:
    start = time.process_time()
    found = detection.verified_planes(points, options=OPTIONS)
    reported = believable(found.evidence.agreement, found.confidence, OPTIONS.min_confidence)
    planes = found.planes[reported][: OPTIONS.max_planes]
    return Found(found.planes, planes, time.process_time() - start)


def _peer(planes_of):
    def method(points: np.ndarray) -> Found:
        start = time.process_time()
        cloud = prepare(points, None, cascade.QUERIES)
        planes = planes_of(cloud)
        if len(planes) == 0:
            return Found(planes, planes, time.process_time() - start)
        ranked, reported = _judged(cloud, planes)
        seconds = time.process_time() - start
        ranked, reported = (canonical_planes(cloud.to_input(some)) for some in (ranked, reported))
        return Found(ranked, reported, seconds)

    return method


METHODS = {
    "ours": ours,
    "mean-shift": _peer(_by_mean_shift),
    "multistart": _peer(_by_multistart),
    "pca": _peer(_by_pca),
}


def refined(points: np.ndarray, planes: np.ndarray) -> np.ndarray:
    """Where planes (k, 4) end when the detector's finest refinement starts from them."""
    if len(planes) == 0:
        return planes
    cloud = prepare(points, None, cascade.QUERIES)
    moved = cascade.refine_nearby(cloud, cloud.from_input(planes))
    return canonical_planes(cloud.to_input(moved))
