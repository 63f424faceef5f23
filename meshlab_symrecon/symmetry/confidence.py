"""Confidence: the chance that a plane is a true one."""

from __future__ import annotations

import numpy as np

from meshlab_symrecon.arrays import Booleans, Floats
from meshlab_symrecon.symmetry.open_halves import HalfEvidence
from meshlab_symrecon.symmetry.traits import TRAITS
from meshlab_symrecon.symmetry.verification import Evidence

__all__ = ["believable", "confidence", "half_confidence", "meridian_confidence"]

# Logistic regressions whose weights may not contradict their meaning (on what: docs/detection.md).
# Traits without a weight say nothing that the others do not.
CONSTANT = -1.84
WEIGHTS = {
    "cleanness": 5.52,
    "near misses": -0.48,
    "residual": -6.76,
    "relief": 1.03,
    "coarse relief": 2.56,
    "worst regions": 0.51,
    "excused": -5.89,
    "rim excused": -9.38,
    "lead": 0.34,
    "roughness": 2.17,
}
# Clouds that end at a flat break: what is missing is known, and little is left to compare.
BROKEN_CONSTANT = -6.12
BROKEN_WEIGHTS = {
    "cleanness": 0.96,
    "near misses": -0.66,
    "residual": -7.50,
    "fine relief": 0.50,
    "relief": 1.12,
    "coarse relief": 0.22,
    "worst regions": 0.80,
    "excused": -9.71,
    "broken off": -3.78,
    "rim agreement": 0.59,
    "rim excused": -2.40,
    "lead": 1.00,
    "roughness": 9.15,
}
ENOUGH_SAMPLES = 100  # fewer match by chance: confidence falls in proportion
CLEAR_AGREEMENT = 0.85
ENOUGH_UNCLEAR = 1500  # samples needed where agreement is not clear: smooth bodies look alike
RIVAL = 0.2  # agreement that a further plane may lack against the best one


def confidence(traits: Floats, evidence: Evidence, count: int, *, broken: bool) -> Floats:
    """Return the chance that each plane is true.

    Parameters
    ----------
    traits : (k, 17) float
        Columns as in `TRAITS`.
    evidence : Evidence
        Of the same planes.
    count : int
        Number of samples that were compared.
    broken : bool
        The cloud ends at a flat break.

    Returns
    -------
    (k,) float
        Chances, 0 to 1.
    """
    constant, weights = (BROKEN_CONSTANT, BROKEN_WEIGHTS) if broken else (CONSTANT, WEIGHTS)
    log_odds = constant + traits @ np.array([weights.get(name, 0.0) for name in TRAITS])
    enough = np.where(evidence.agreement >= CLEAR_AGREEMENT, ENOUGH_SAMPLES, ENOUGH_UNCLEAR)
    chances: Floats = np.minimum(1.0, count / enough) * _logistic(log_odds)
    return chances


# Half a statue: the rim has to lie on the plane, the surface has to meet it squarely, and the half
# must not be thicker than it is wide (a torso cut off flat at the waist is no half).
LEAST_RIM_SHARE = 0.48
MOST_BEYOND = 0.02
THICKEST = 0.95
SQUARE, SQUARE_RANGE = 0.125, 0.012  # crossing at even odds, and what changes them by a factor e


def half_confidence(halves: HalfEvidence) -> Floats:
    """Return the chance that each plane is where the missing half begins.

    Parameters
    ----------
    halves : HalfEvidence
        Of k planes.

    Returns
    -------
    (k,) float
        Chances, 0 to 1.
    """
    possible = (halves.rim_share >= LEAST_RIM_SHARE) & (halves.beyond <= MOST_BEYOND)
    possible &= halves.thickness <= THICKEST
    found: Floats = possible * _logistic((SQUARE - halves.crossing) / SQUARE_RANGE)
    return found


# Handles of bodies of revolution.
HANDLE, HANDLE_RANGE = 0.36, 0.03  # match at even odds, and what changes them by a factor e
RIVAL_SHARE, RIVAL_RANGE = 0.8, 0.06  # the same for the match of the best other plane / its own


def meridian_confidence(handle: Floats, rival: float) -> Floats:
    """Return the chance that each plane through an axis of revolution is the one of the handle.

    Parameters
    ----------
    handle : (k,) float
        How much of the handle each plane matches.
    rival : float
        The same for the best plane that is none of them.

    Returns
    -------
    (k,) float
        Chances, 0 to 1.
    """
    matched = _logistic((handle - HANDLE) / HANDLE_RANGE)
    ahead = _logistic((RIVAL_SHARE - rival / np.maximum(handle, 1e-9)) / RIVAL_RANGE)
    found: Floats = matched * ahead
    return found


def believable(agreement: Floats, chances: Floats, least: float) -> Booleans:
    """Tell which planes may be reported.

    The best one needs the least confidence; a further one also has to agree with the cloud nearly
    as well, since planes near a true one, or of a nearly round body, come close to it in all else.

    Parameters
    ----------
    agreement : (k,) float
        Of the planes, best first.
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
    accepted: Booleans = (chances >= least) & (agreement >= agreement[0] - RIVAL)
    return accepted


def _logistic(log_odds: Floats) -> Floats:
    found: Floats = 1.0 / (1.0 + np.exp(-np.clip(log_odds, -50.0, 50.0)))
    return found
