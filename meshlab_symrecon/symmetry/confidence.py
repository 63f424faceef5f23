"""Merit orders verified planes; confidence is the chance that a plane is a true one."""

from __future__ import annotations

import numpy as np

from meshlab_symrecon.arrays import Booleans, Floats, Planes
from meshlab_symrecon.geometry.planes import plane_angles
from meshlab_symrecon.symmetry.verification import Evidence

__all__ = ["believable", "confidence", "family_sizes", "merit", "whole_symmetry"]

# Logistic regression on verified planes of 292 incomplete clouds under seven kinds of damage: six
# scanned models, bunny and twirl (without a plane), and made shapes (bodies of bumps and of boxes,
# nearly symmetric bodies, vases, all with and without a mirror plane; twisted prisms, pinwheels,
# bent scans). Planes that leave less than 2 % of the diagonal (95th percentile) on the complete
# shape counted neither way; true ones of nefertiti, squirrel, max_planck and column counted twice.
# benchmarks/symmetry_success.py measures the outcome.
INTERCEPT = -5.4
PER_LOG_SUPPORT = 2.45
PER_ROUGHNESS = 200.0  # per diagonal: noise lowers agreement and support of true planes, too
PER_LEAD = 1.41
PER_CLEANNESS = 6.8
PER_LOG_FAMILY = -2.34
ENOUGH_SUPPORT = 0.4  # more only says that less is missing
ENOUGH_ROUGHNESS = 0.002
CONTRADICTION_SCALE = 0.02  # contradiction at which cleanness has fallen to 1 / e
MOST_LEAD = 3.0
RIVALS = 9
CHANCE_MERIT = -3.0  # of a plane that mirrors a fifth of the cloud onto itself
FAMILY_ANGLES = np.radians([8.0, 20.0])  # nearer ones are variants of the same plane
FAMILY_SUPPORT = 0.8
WHOLE_AGREEMENT = 0.9  # sampling keeps exact planes of boxes at .92 to .95
WHOLE_CONTRADICTION = 0.003  # a handle of a vase contradicts more
RIVAL = 0.05  # agreement that a further plane may lack against the best one
ENOUGH_SAMPLES = 100  # fewer match by chance: confidence falls in proportion
CLEAR_AGREEMENT = 0.85
ENOUGH_UNCLEAR = 1500  # samples needed where agreement is not clear: smooth bodies look alike
NONE = 1e-3  # keeps logarithms finite


def merit(evidence: Evidence) -> Floats:
    """Return the merit by which planes are ordered before their confidence is known."""
    ordering: Floats = 6.0 * evidence.agreement + 3.0 * np.log(evidence.support + NONE)
    return ordering


def confidence(evidence: Evidence, sizes: Floats, roughness: float, count: int) -> Floats:
    """Return the chance that each plane is true.

    Parameters
    ----------
    evidence : Evidence
        All planes that were verified last; how far one leads the others tells, too.
    sizes : (k,) float
        Sizes of their families.
    roughness : float
        Median deviation of the cloud from its local planes, in diagonals.
    count : int
        Number of samples that were compared.

    Returns
    -------
    (k,) float
        Chances, 0 to 1.
    """
    ordering = merit(evidence)
    # A box or a ball has several true planes: they are no rivals of each other.
    whole = whole_symmetry(evidence)
    lead = np.where(whole, _lead(ordering, rivals=~whole), _lead(ordering, rivals=None))
    log_odds = (
        INTERCEPT
        + PER_LOG_SUPPORT * np.log(np.minimum(evidence.support, ENOUGH_SUPPORT) + NONE)
        + PER_ROUGHNESS * min(roughness, ENOUGH_ROUGHNESS)
        + PER_LEAD * np.clip(lead, 0.0, MOST_LEAD)
        + PER_CLEANNESS * np.exp(-evidence.contradiction / CONTRADICTION_SCALE)
        + PER_LOG_FAMILY * np.log(sizes)
    )
    enough = np.where(evidence.agreement >= CLEAR_AGREEMENT, ENOUGH_SAMPLES, ENOUGH_UNCLEAR)
    chances: Floats = np.minimum(1.0, count / enough) / (1.0 + np.exp(-log_odds))
    return chances


def family_sizes(planes: Planes, evidence: Evidence) -> Floats:
    """Count the planes among which a plane cannot be told from its neighbours.

    A vase with a handle is nearly a body of revolution: planes through its axis agree with it
    nearly as well as the one through the handle. Where all is in agreement they are true planes,
    and do not count.

    Parameters
    ----------
    planes : (k, 4) float
        Planes that differ.
    evidence : Evidence
        What speaks for them.

    Returns
    -------
    (k,) float
        1 for a plane that stands alone.
    """
    sizes = np.ones(len(planes))
    whole = whole_symmetry(evidence)
    for row, plane in enumerate(planes):
        if not whole[row]:
            angles = plane_angles(planes, plane)
            beside = (angles > FAMILY_ANGLES[0]) & (angles < FAMILY_ANGLES[1])
            beside &= evidence.agreement >= evidence.agreement[row] - RIVAL
            beside &= evidence.support >= FAMILY_SUPPORT * evidence.support[row]
            sizes[row] += np.count_nonzero(beside)
    return sizes


def whole_symmetry(evidence: Evidence) -> Booleans:
    """Tell which planes mirror the whole shape onto itself, with next to nothing against it.

    Parameters
    ----------
    evidence : Evidence

    Returns
    -------
    (k,) bool
    """
    whole: Booleans = (
        (evidence.agreement >= WHOLE_AGREEMENT)
        & (evidence.support >= ENOUGH_SUPPORT)
        & (evidence.contradiction <= WHOLE_CONTRADICTION)
    )
    return whole


def _lead(ordering: Floats, rivals: Booleans | None) -> Floats:
    """Return how far each plane leads the mean of the nine best others, chance filling up.

    ``rivals`` leaves out planes that are none; a plane is never its own rival.
    """
    filling = np.full(RIVALS, CHANCE_MERIT)
    if rivals is not None:
        ahead: Floats = ordering - np.sort(np.append(ordering[rivals], filling))[-RIVALS:].mean()
        return ahead
    best = np.sort(np.append(ordering, filling))[::-1][: RIVALS + 1]
    inside = ordering >= best[-1]
    lead: Floats = ordering - (best.sum() - np.where(inside, ordering, best[-1])) / RIVALS
    return lead


def believable(evidence: Evidence, chances: Floats, least: float) -> Booleans:
    """Tell which planes may be reported.

    The best one needs the least confidence; a further one also has to agree with the cloud nearly
    as well, since planes near a true one, or of a nearly round body, come close to it in all else.

    Parameters
    ----------
    evidence : Evidence
        The planes, best first.
    chances : (k,) float
        Their confidence.
    least : float
        Least confidence.

    Returns
    -------
    (k,) bool
        True for planes to report.
    """
    if len(chances) == 0:
        return np.zeros(0, dtype=bool)
    accepted: Booleans = chances >= least
    accepted &= evidence.agreement >= evidence.agreement[0] - RIVAL
    return accepted
