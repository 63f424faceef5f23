"""Traits of a verified plane: all that tells a true plane from one that fits by chance."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from meshlab_symrecon.arrays import Booleans, Floats, Indices, Planes
from meshlab_symrecon.geometry.planes import near_plane
from meshlab_symrecon.symmetry.preparation import PreparedCloud
from meshlab_symrecon.symmetry.relief import NEAR, NEAR_SPACINGS, relief_agreement
from meshlab_symrecon.symmetry.verification import (
    BEYOND,
    RIM_REACH,
    Evidence,
    Landings,
    examine,
    land,
)

__all__ = ["TRAITS", "merit", "traits", "whole_symmetry"]

TRAITS = (
    "support",  # logarithm of the share of samples with a partner
    "agreement",  # share of the samples that no hole excuses
    "fine agreement",  # the same at the finest tolerance
    "cleanness",  # 1 without contradictions, falling with them
    "near misses",  # logarithm of the share just off the surface, no hole to explain it
    "residual",  # RMS distance of partners, % of the diagonal
    "fine relief",  # correlation of bumps and hollows, by the radius of the ball
    "relief",
    "coarse relief",
    "worst regions",  # agreement in the region at the lower fifth
    "turn",  # median angle between the normals of partners, degrees
    "excused",  # share of the samples whose image may be in a hole
    "broken off",  # share of the samples whose image is known to be missing
    "rim agreement",  # share of rim points whose image lies on the surface
    "rim excused",  # and of those whose image is near another rim
    "lead",  # merit ahead of other planes
    "roughness",  # of the cloud, % of the diagonal
)

FINE_TOLERANCE = 0.0025  # diagonals
RIM_TOLERANCE = 0.008
FEWEST_RIM, MOST_RIM = 15, 400  # rim points mirrored
FEW_EXCUSED = 0.25  # fewer only say that little is missing
ENOUGH_SUPPORT = 0.4  # more only says that less is missing
CONTRADICTION_SCALE = 0.02  # contradiction at which cleanness has fallen to 1 / e
NEAR_MISS, NEAR_MISS_SPACINGS = 0.02, 3.0  # off the surface: diagonals, and at least spacings
OFF_PLANE = 0.999  # weight of samples that do not match themselves
LARGEST_TURN = 45.0
REGIONS = 40
ENOUGH_JUDGED, FEWEST_JUDGED = 0.25, 8.0  # share and number of a region's samples
LOWER_FIFTH = 0.2
ENOUGH_ROUGHNESS = 0.4
MOST_LEAD, RIVALS, CHANCE_MERIT = 3.0, 9, -3.0
VARIANT = (np.radians(12.0), 0.08)  # planes nearer than this are no rivals of each other
WHOLE_AGREEMENT = 0.9  # sampling keeps exact planes of boxes at .92 to .95
WHOLE_CONTRADICTION = 0.003  # a handle of a vase contradicts more
NONE = 1e-3  # keeps logarithms finite
TINY = float(np.finfo(np.float64).tiny)


def merit(evidence: Evidence) -> Floats:
    """Return the merit (k,) by which planes are ordered before their confidence is known."""
    ordering: Floats = 6.0 * evidence.agreement + 3.0 * np.log(evidence.support + NONE)
    return ordering


def whole_symmetry(evidence: Evidence) -> Booleans:
    """Tell which planes mirror the whole shape onto itself, with next to nothing against it.

    Parameters
    ----------
    evidence : Evidence
        Of k planes.

    Returns
    -------
    (k,) bool
        True where agreement is high, support sufficient and contradiction next to none.
    """
    whole: Booleans = (
        (evidence.agreement >= WHOLE_AGREEMENT)
        & (evidence.support >= ENOUGH_SUPPORT)
        & (evidence.contradiction <= WHOLE_CONTRADICTION)
    )
    return whole


def traits(planes: Planes, evidence: Evidence, cloud: PreparedCloud, tolerance: float) -> Floats:
    """Measure the traits of planes.

    Parameters
    ----------
    planes : (k, 4) float
        Planes that differ, in the coordinates of the prepared cloud.
    evidence : Evidence
        What verification found of them.
    cloud : PreparedCloud
        The cloud.
    tolerance : float
        Of a match, in diagonals.

    Returns
    -------
    (k, 17) float
        Columns as in `TRAITS`.
    """
    if len(planes) == 0:
        return np.zeros((0, len(TRAITS)))
    queries = cloud.samples
    landings = land(planes, cloud, queries, tolerance)
    total = np.maximum(landings.weights.sum(axis=1), TINY)
    fine = examine(planes, cloud, len(queries), FINE_TOLERANCE, exact=True)
    relief = relief_agreement(landings, cloud, queries)
    rim, rim_excused = _rim_agreement(planes, evidence.agreement, cloud)
    columns = (
        np.log(np.minimum(evidence.support, ENOUGH_SUPPORT) + NONE),
        evidence.agreement,
        fine.agreement,
        np.exp(-evidence.contradiction / CONTRADICTION_SCALE),
        np.log(_near_misses(landings, cloud) / total + 2.0 * NONE),
        100.0 * evidence.residual,
        *relief.T,
        _worst_regions(landings, cloud.points[queries]),
        _turn(landings, cloud.spacing),
        _excused(landings, cloud),
        (landings.weights * landings.broken_off).sum(axis=1) / total,
        rim,
        rim_excused,
        np.clip(_lead(planes, evidence), 0.0, MOST_LEAD),
        np.full(len(planes), min(100.0 * cloud.roughness, ENOUGH_ROUGHNESS)),
    )
    return np.stack(columns, axis=1)


def _excused(landings: Landings, cloud: PreparedCloud) -> Floats:
    """Share of the images that may have fallen into holes, among those not known to be missing."""
    uncertain = landings.weights * ~landings.broken_off
    total = np.maximum(uncertain.sum(axis=1), 1.0)
    shares: Floats = (uncertain * landings.excused).sum(axis=1) / total
    return shares if cloud.broken else np.maximum(shares, FEW_EXCUSED)


def _near_misses(landings: Landings, cloud: PreparedCloud) -> Floats:
    least = max(NEAR_MISS, NEAR_MISS_SPACINGS * cloud.spacing)
    missed = (landings.distances > least) & (landings.distances < BEYOND) & ~landings.broken_off
    missed &= cloud.border_distance[landings.partners] > RIM_REACH * landings.distances
    found: Floats = (landings.weights * missed).sum(axis=1)
    return found


def _worst_regions(landings: Landings, places: Floats) -> Floats:
    """Agreement in the region of the lower fifth: true planes agree everywhere."""
    regions = cKDTree(places[:REGIONS]).query(places)[1]
    member = np.zeros((len(places), REGIONS))
    member[np.arange(len(places)), regions] = 1.0
    blamed = landings.weights * ~(landings.excused | landings.broken_off)
    judged, matched = blamed @ member, (blamed * landings.worth) @ member
    whole = np.maximum(landings.weights @ member, FEWEST_JUDGED)
    shares = np.where(judged > ENOUGH_JUDGED * whole, matched / np.maximum(judged, TINY), np.nan)
    enough = ~np.isnan(shares)
    lower = np.zeros(len(shares))
    for row in np.flatnonzero(enough.any(axis=1)):
        lower[row] = np.quantile(shares[row, enough[row]], LOWER_FIFTH)
    return lower


def _turn(landings: Landings, spacing: float) -> Floats:
    close = landings.distances < max(NEAR, NEAR_SPACINGS * spacing)
    close &= ~landings.excused & ~landings.broken_off & (landings.weights > OFF_PLANE)
    angles = np.degrees(np.arccos(np.clip(np.abs(landings.cosines), 0.0, 1.0)))
    turns = np.full(len(angles), LARGEST_TURN)
    for row, rows in enumerate(close):
        if rows.any():
            turns[row] = min(LARGEST_TURN, float(np.median(angles[row, rows])))
    return turns


def _rim_agreement(
    planes: Planes, agreement: Floats, cloud: PreparedCloud
) -> tuple[Floats, Floats]:
    """Mirror the rims of holes: what fills a hole has to meet its rim. Without holes, all agree."""
    rim: Indices = np.flatnonzero(cloud.border)
    if len(rim) < FEWEST_RIM:
        return agreement, np.full(len(planes), FEW_EXCUSED)
    rim = rim[np.linspace(0, len(rim) - 1, min(len(rim), MOST_RIM)).astype(np.int64)]
    landings = land(planes, cloud, rim, RIM_TOLERANCE)
    uncertain = landings.weights * ~landings.broken_off
    matched = (uncertain * landings.worth).sum(axis=1)
    return matched / np.maximum(uncertain.sum(axis=1), 1.0), _excused(landings, cloud)


def _lead(planes: Planes, evidence: Evidence) -> Floats:
    """Return how far each plane leads the mean of the nine best others, chance filling up.

    Variants of a plane are no rivals of it, nor are the true planes of a box of each other.
    """
    ordering, whole = merit(evidence), whole_symmetry(evidence)
    filling = np.full(RIVALS, CHANCE_MERIT)
    lead = np.zeros(len(planes))
    for row, plane in enumerate(planes):
        other = ~near_plane(planes, plane, VARIANT) & ~(whole[row] & whole)
        rivals = np.sort(np.append(ordering[other], filling))[-RIVALS:]
        lead[row] = ordering[row] - rivals.mean()
    return lead
