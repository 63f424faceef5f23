"""Confidence: the chance that a verified plane is a true one."""

from __future__ import annotations

import numpy as np

from meshlab_symrecon.arrays import Floats
from meshlab_symrecon.symmetry.verification import Evidence

__all__ = ["log_odds", "probability"]

# Logistic regression on verified planes; benchmarks/symmetry_success.py says how it was fitted.
INTERCEPT = -8.0
PER_AGREEMENT = 9.0
PER_LOG_SUPPORT = 0.8
PER_CONTRADICTION = -6.0


def log_odds(evidence: Evidence) -> Floats:
    """Return the logarithm of the odds that each plane is true, (k,) floats."""
    odds: Floats = (
        INTERCEPT
        + PER_AGREEMENT * evidence.agreement
        + PER_LOG_SUPPORT * np.log(evidence.support + 1e-3)
        + PER_CONTRADICTION * evidence.contradiction
    )
    return odds


def probability(odds: Floats) -> Floats:
    """Return probabilities for logarithms of odds, (k,) floats."""
    chances: Floats = 1.0 / (1.0 + np.exp(-odds))
    return chances
