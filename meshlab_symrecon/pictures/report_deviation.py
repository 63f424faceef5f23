"""The colours of deviations in a report: blue inside, pale where both sides agree, red outside."""

from __future__ import annotations

import numpy as np

from meshlab_symrecon.arrays import Booleans, Floats

__all__ = ["STOPS", "UNKNOWN", "colour_limit"]

STOPS = (
    (-1.0, (33, 82, 140)),
    (-0.5, (120, 165, 205)),
    (0.0, (236, 231, 222)),
    (0.5, (222, 150, 94)),
    (1.0, (158, 62, 18)),
)  # shares of the limit, and their sRGB colours
UNKNOWN = (132, 130, 127)  # nothing to compare with
COMMON = 0.98  # share of the deviations that the colours tell apart


def colour_limit(deviation: Floats, known: Booleans) -> float:
    """Return the deviation that has the deepest colour; 1 when all are 0."""
    limit = float(np.quantile(np.abs(deviation[known]), COMMON))
    return limit if limit > 0.0 else 1.0
