"""Merit orders verified planes; confidence is the chance that a plane is a true one."""

from __future__ import annotations

import numpy as np

from meshlab_symrecon.arrays import Booleans, Floats
from meshlab_symrecon.symmetry.verification import Evidence

__all__ = ["believable", "confidence", "merit"]

# Logistic regression on 2,100 verified planes of 227 incomplete clouds: six scanned models, bunny,
# twirl, and made shapes (mirrored and unmirrored bodies of bumps and of boxes, twisted prisms,
# pinwheels, bent scans), under seven kinds of damage. The models and seeds of
# benchmarks/symmetry_success.py are not among them, unless it says so.
INTERCEPT = 3.7
PER_AGREEMENT = 1.5
PER_LOG_SUPPORT = 7.8
PER_ROUGHNESS = 2330.0  # per diagonal: noise lowers agreement and support of true planes, too
PER_LEAD = 0.59
PER_CLEANNESS = 3.5
PER_RESIDUAL = -900.0  # per diagonal
ENOUGH_SUPPORT = 0.4  # more only says that less is missing
ENOUGH_ROUGHNESS = 0.002
CONTRADICTION_SCALE = 0.015  # contradiction at which cleanness has fallen to 1 / e
RIVAL = 0.08  # agreement that a further plane may lack against the best one
NONE = 1e-3  # keeps logarithms finite


def merit(evidence: Evidence) -> Floats:
    """Return the merit by which planes are ordered before their confidence is known, (k,) floats."""
    ordering: Floats = 6.0 * evidence.agreement + 3.0 * np.log(evidence.support + NONE)
    return ordering


def confidence(evidence: Evidence, roughness: float) -> Floats:
    """Return the chance that each plane is true.

    Parameters
    ----------
    evidence : Evidence
        All planes that were verified last; how far one leads the others tells, too.
    roughness : float
        Median deviation of the cloud from its local planes, in diagonals.

    Returns
    -------
    (k,) float
        Chances, 0 to 1.
    """
    ordering = merit(evidence)
    others = max(1, len(ordering) - 1)
    lead = ordering - (ordering.sum() - ordering) / others if len(ordering) > 1 else 0.0 * ordering
    log_odds = (
        INTERCEPT
        + PER_AGREEMENT * evidence.agreement
        + PER_LOG_SUPPORT * np.log(np.minimum(evidence.support, ENOUGH_SUPPORT) + NONE)
        + PER_ROUGHNESS * min(roughness, ENOUGH_ROUGHNESS)
        + PER_LEAD * lead
        + PER_CLEANNESS * np.exp(-evidence.contradiction / CONTRADICTION_SCALE)
        + PER_RESIDUAL * evidence.residual
    )
    chances: Floats = 1.0 / (1.0 + np.exp(-log_odds))
    return chances


def believable(evidence: Evidence, chances: Floats, least: float) -> Booleans:
    """Tell which planes may be reported.

    The best one needs the least chance; a further one also has to agree with the cloud nearly as well,
    since planes near a true one, or of a nearly round body, come close to it in all else.

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
