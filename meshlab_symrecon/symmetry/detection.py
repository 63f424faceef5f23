"""Detection of reflection planes: the recipe."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from meshlab_symrecon.arrays import Booleans, Floats, Indices, Planes, as_normals, as_points
from meshlab_symrecon.clustering.messages import propagate_sparse
from meshlab_symrecon.clustering.neighbour_graph import neighbour_graph
from meshlab_symrecon.errors import ParameterError
from meshlab_symrecon.geometry.bounds import require_solid
from meshlab_symrecon.geometry.planes import canonical_planes, plane_angles
from meshlab_symrecon.symmetry.candidates import Candidates, vote
from meshlab_symrecon.symmetry.embedding import embed_planes
from meshlab_symrecon.symmetry.preparation import PreparedCloud, prepare
from meshlab_symrecon.symmetry.refinement import Schedule, refine_planes
from meshlab_symrecon.symmetry.verification import Evidence, examine, score

__all__ = ["DetectionOptions", "Progress", "ReflectionPlanes", "detect_reflection_planes"]

Progress: TypeAlias = Callable[[float, str], None]

BANDWIDTH = 0.02  # H, diagonals: planes whose mirror images differ less vote for the same symmetry
QUICK_QUERIES = 96
MOST_CANDIDATES = 16_000
MOST_VOTERS = 2_500
SAME_ANGLE = np.radians(3.0)
SAME_OFFSET = 0.02  # diagonals


@dataclass(frozen=True, slots=True)
class DetectionOptions:
    """What to look for.

    Attributes
    ----------
    max_planes : int
        Most planes returned.
    min_confidence : float
        Planes less likely than this are not returned, 0 to 1.
    sample_count : int
        Even samples whose pairs vote.
    """

    max_planes: int = 8
    min_confidence: float = 0.5
    sample_count: int = 1_200

    def __post_init__(self) -> None:
        if not 1 <= self.max_planes <= 64:
            message = f"max_planes must lie between 1 and 64; got {self.max_planes}; change it"
            raise ParameterError(message)
        if not 0.0 <= self.min_confidence <= 1.0:
            message = f"min_confidence must lie between 0 and 1; got {self.min_confidence}"
            raise ParameterError(message + "; change it")
        if not 50 <= self.sample_count <= 4_000:
            message = f"sample_count must lie between 50 and 4000; got {self.sample_count}"
            raise ParameterError(message + "; change it")


@dataclass(frozen=True, slots=True, eq=False)
class ReflectionPlanes:
    """Planes found, best first; possibly none."""

    planes: Planes
    support: Floats
    residual: Floats
    confidence: Floats
    converged: bool


def _cluster(cloud, candidates):
    planes = candidates.planes
    if len(planes) < 3:
        return planes, True
    evidence = examine(planes, cloud, cloud.samples[:QUICK_QUERIES], cloud.field.lookup, 0.03)
    votes = evidence.support - evidence.contradiction
    order = np.argsort(-votes, kind="stable")
    places = embed_planes(planes[order], cloud.root_covariance)
    cells = np.floor(places / (0.5 * BANDWIDTH)).astype(np.int64)
    keep = np.sort(np.unique(cells, axis=0, return_index=True)[1])[:MOST_VOTERS]
    places, planes, votes = places[keep], planes[order][keep], votes[order][keep]
    similarities, targets = neighbour_graph(places, 32)
    similarities[similarities < -((6 * BANDWIDTH) ** 2)] = -np.inf
    similarities[:, 0] = -10 * BANDWIDTH**2 * (1 - 0.5 * votes / votes.max())
    found = propagate_sparse(similarities, targets, 0.7, 200, 15)
    ex = found.exemplars
    ex = ex[np.argsort(-votes[ex], kind="stable")]
    return planes[ex], found.converged


def _suppress(planes, scores, count):
    order = np.argsort(-scores, kind="stable")
    kept = []
    for i in order:
        if len(kept) == count:
            break
        k = planes[kept]
        if len(kept):
            s = np.sign(k[:, :3] @ planes[i, :3])
            if ((plane_angles(k, planes[i]) < SAME_ANGLE) & (abs(k[:, 3] * s - planes[i, 3]) < SAME_OFFSET)).any():
                continue
        kept.append(i)
    return np.array(kept, int)


def _refine(cloud, planes, queries, nearest, schedule):
    return refine_planes(planes, (cloud.points[queries], cloud.normals[queries]), (cloud.points, cloud.normals), nearest, schedule)


def search(points, normals=None, options=DetectionOptions(), rng=None, times=None):
    import time
    t0 = time.process_time()
    def tick(s):
        nonlocal t0
        if times is not None:
            times[s] = time.process_time() - t0
        t0 = time.process_time()
    cloud = prepare(points, normals, 2500)
    tick('prepare')
    cand = vote(cloud, options.sample_count, MOST_CANDIDATES, rng or np.random.default_rng(0))
    tick('vote')
    planes, converged = _cluster(cloud, cand)
    tick('cluster')
    ncand = len(planes)
    S = cloud.samples
    h = cloud.spacing
    planes = planes[:300]
    planes = _refine(cloud, planes, S[:250], cloud.field.lookup, Schedule(6, 0.04, 0.015))
    ev = examine(planes, cloud, S[:500], cloud.field.lookup, max(0.012, 1.5 * h))
    planes = planes[_suppress(planes, score(ev), 24)]
    tick('stage1')
    planes = _refine(cloud, planes, S[:800], cloud.field.lookup, Schedule(12, 0.03, max(0.006, h)))
    ev = examine(planes, cloud, S[:1500], cloud.field.closest, max(0.008, 1.5 * h))
    planes = planes[_suppress(planes, score(ev), 8)]
    tick('stage2')
    planes = _refine(cloud, planes, S[:2500], cloud.field.closest, Schedule(10, 0.015, max(0.006, h)))
    ev = examine(planes, cloud, S, cloud.field.closest, max(0.008, 1.5 * h))
    k = _suppress(planes, score(ev), 8)
    ev = Evidence(*(getattr(ev, f)[k] for f in ('support', 'contradiction', 'residual', 'judged')))
    tick('stage3')
    return cloud, planes[k], ev, converged, ncand
