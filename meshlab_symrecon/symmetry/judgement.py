"""Judgement: what votes, holes and handles suggest is weighed together."""

from __future__ import annotations

import numpy as np

from meshlab_symrecon.arrays import Floats, Planes
from meshlab_symrecon.geometry.planes import distinct_planes, near_plane, plane_angles
from meshlab_symrecon.symmetry.cascade import (
    TOLERANCE,
    refine_and_verify,
    refine_drawn,
    refine_nearby,
    settle,
)
from meshlab_symrecon.symmetry.confidence import (
    confidence,
    half_confidence,
    meridian_confidence,
)
from meshlab_symrecon.symmetry.groups import LIKELY, consistent, group_images, not_parallel
from meshlab_symrecon.symmetry.hypotheses import VARIANT, Hypotheses, best_first
from meshlab_symrecon.symmetry.open_halves import examine_halves, rim_planes
from meshlab_symrecon.symmetry.preparation import PreparedCloud
from meshlab_symrecon.symmetry.revolution import meridians, on_axis, revolution_axis
from meshlab_symrecon.symmetry.traits import TRAITS, merit, traits
from meshlab_symrecon.symmetry.verification import Evidence, examine

__all__ = ["judge", "judge_again", "judge_drawn"]

DRAWN = (np.radians(12.0), 0.06)  # of a plane from where somebody has drawn it
FINE_SHARE = 6.0  # of fine agreement in the choice between variants
LEAST_SUPPORT = 0.1  # the rim of a half says more than what little matches
PURE = 0.03  # share off a body of revolution below which all its meridians are alike
NEARLY_BEST = 0.8  # of the best meridian's handle: another handle's plane
APART = np.radians(15.0)  # between meridians that are not the same one


def judge(cloud: PreparedCloud, starts: Planes) -> Hypotheses:
    """Refine planes, and judge them beside what holes and handles suggest.

    Parameters
    ----------
    cloud : PreparedCloud
        The cloud.
    starts : (k, 4) float
        Where to begin.

    Returns
    -------
    Hypotheses
        Planes that differ, the likeliest first.
    """
    planes, evidence = refine_and_verify(cloud, starts)
    found = _judged(cloud, planes, evidence)
    group = group_images(cloud, found)
    if len(group):
        joined = evidence.joined(examine(group, cloud, len(cloud.samples), TOLERANCE, exact=True))
        found = _judged(cloud, np.concatenate([planes, group]), joined)
    found = best_first(_with_halves(cloud, _with_meridians(cloud, found)))
    found = best_first(consistent(cloud, found.take(not_parallel(found.planes))))
    return _polished(cloud, found)


def judge_again(found: Hypotheses, cloud: PreparedCloud, whole: PreparedCloud) -> Hypotheses:
    """Raise the chances of planes that a cloud confirms together with what looked like its plinth.

    A broad base of the statue itself can look like a plinth. Without it a true plane may have lost
    its evidence; a real plinth has planes of its own, which were never found here.

    Parameters
    ----------
    found : Hypotheses
        Planes of the cloud.
    cloud : PreparedCloud
        The cloud without the plinth.
    whole : PreparedCloud
        The same with it.

    Returns
    -------
    Hypotheses
        The same planes, likeliest first.
    """
    planes = whole.from_input(cloud.to_input(found.planes))
    evidence = examine(planes, whole, len(whole.samples), TOLERANCE, exact=True)
    measured = traits(planes, evidence, whole, TOLERANCE)
    chances = confidence(measured, evidence, len(whole.samples), broken=whole.broken)
    better = np.maximum(found.chances, chances)
    raised = best_first(Hypotheses(found.planes, found.evidence, better))
    return best_first(consistent(cloud, raised))


def _polished(cloud: PreparedCloud, found: Hypotheses) -> Hypotheses:
    """Let the likely planes settle, so that they do not depend on where the search began."""
    likely = np.flatnonzero((found.chances >= LIKELY) & (found.evidence.support >= LEAST_SUPPORT))
    planes = found.planes.copy()
    planes[likely] = settle(cloud, planes[likely], found.evidence.residual[likely])
    evidence = examine(planes, cloud, len(cloud.samples), TOLERANCE, exact=True)
    return Hypotheses(planes, evidence, found.chances)


def _judged(cloud: PreparedCloud, planes: Planes, evidence: Evidence) -> Hypotheses:
    """Give each plane its chance, and choose among variants of a plane."""
    measured = traits(planes, evidence, cloud, TOLERANCE)
    chances = confidence(measured, evidence, len(cloud.samples), broken=cloud.broken)
    # The one that fits best is right, whatever its surroundings say.
    best_fit = merit(evidence) + FINE_SHARE * measured[:, TRAITS.index("fine agreement")]
    kept = distinct_planes(planes, best_fit, VARIANT)
    return Hypotheses(planes[kept], evidence.take(kept), chances[kept])


def judge_drawn(cloud: PreparedCloud, starts: Planes, drawn: Planes) -> Hypotheses:
    """Refine planes that somebody has drawn, and judge them beside all others.

    Parameters
    ----------
    cloud : PreparedCloud
        The cloud.
    starts : (k, 4) float
        Where the search for their rivals begins.
    drawn : (m, 4) float
        Nearly right planes.

    Returns
    -------
    Hypotheses
        The m planes, in their order.
    """
    rivals, _ = refine_and_verify(cloud, starts)
    planes = refine_drawn(cloud, drawn)
    everything = np.concatenate([planes, rivals])
    evidence = examine(everything, cloud, len(cloud.samples), TOLERANCE, exact=True)
    measured = traits(everything, evidence, cloud, TOLERANCE)
    chances = confidence(measured, evidence, len(cloud.samples), broken=cloud.broken)
    chances = chances[: len(planes)]
    rows = np.arange(len(planes))
    return _at_rims(cloud, drawn, Hypotheses(planes, evidence.take(rows), chances))


def _at_rims(cloud: PreparedCloud, drawn: Planes, found: Hypotheses) -> Hypotheses:
    """Put planes that were drawn where the cloud ends on its rim, if that is likelier.

    Half of something has no mirror partners that could hold a plane where it belongs.
    """
    planes, chances = found.planes.copy(), found.chances.copy()
    for rim in rim_planes(cloud):
        chance = half_confidence(examine_halves(rim[np.newaxis], cloud))[0]
        meant = near_plane(drawn, rim, DRAWN) & (chance > chances)
        planes[meant], chances[meant] = rim, chance
    evidence = examine(planes, cloud, len(cloud.samples), TOLERANCE, exact=True)
    return Hypotheses(planes, evidence, chances)


def _with_meridians(cloud: PreparedCloud, found: Hypotheses) -> Hypotheses:
    """Let the handle choose among the planes through an axis of revolution."""
    axis = revolution_axis(found.planes, found.evidence.agreement)
    around = None if axis is None else meridians(axis, cloud, TOLERANCE)
    if axis is None or around is None:
        return found
    through = on_axis(found.planes, axis)
    if around.off_body < PURE:  # all are as true as the likeliest, or as false: one is enough
        through[np.argmax(np.where(through, found.chances, -1.0))] = False
        return found.take(np.flatnonzero(~through))
    best = int(np.argmax(around.handle))
    order = np.argsort(-around.handle, kind="stable")
    order = order[around.handle[order] >= NEARLY_BEST * around.handle[best]]
    chosen: list[int] = []
    for row in order:
        apart = [plane_angles(around.planes[[row]], around.planes[k])[0] for k in chosen]
        if min(apart, default=np.inf) > APART:
            chosen.append(int(row))
    beside = np.ones(len(around.planes), dtype=bool)
    for row in chosen:
        beside &= plane_angles(around.planes, around.planes[row]) > APART
    rival = around.handle[beside].max(initial=0.0)
    planes = refine_nearby(cloud, around.planes[chosen])
    chances = meridian_confidence(around.handle[chosen], float(rival))
    return _joined(found.take(np.flatnonzero(~through)), cloud, planes, chances)


def _with_halves(cloud: PreparedCloud, found: Hypotheses) -> Hypotheses:
    """Add the plane in which the cloud ends, if it is one half of something."""
    planes = rim_planes(cloud)
    chances = half_confidence(examine_halves(planes, cloud))
    # Who has a plane of its own needs no missing half.
    return _joined(found, cloud, planes, chances * (1.0 - found.chances.max(initial=0.0)))


def _joined(found: Hypotheses, cloud: PreparedCloud, planes: Planes, chances: Floats) -> Hypotheses:
    evidence = examine(planes, cloud, len(cloud.samples), TOLERANCE, exact=True)
    return Hypotheses(
        np.concatenate([found.planes, planes]),
        found.evidence.joined(evidence),
        np.concatenate([found.chances, chances]),
    )
