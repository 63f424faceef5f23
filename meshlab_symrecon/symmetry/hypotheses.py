"""Hypotheses: all planes that may be reported, and the chance of each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshlab_symrecon.arrays import Floats, Indices, Planes
from meshlab_symrecon.symmetry.traits import merit
from meshlab_symrecon.symmetry.verification import Evidence

__all__ = ["VARIANT", "Hypotheses", "best_first"]

VARIANT = (np.radians(8.0), 0.06)  # angle and offset of two planes of which at most one is true


@dataclass(frozen=True, slots=True, eq=False)
class Hypotheses:
    """Planes, in the coordinates of the prepared cloud; `best_first` orders them."""

    planes: Planes  # (k, 4)
    evidence: Evidence
    chances: Floats  # (k,)

    def take(self, rows: Indices) -> Hypotheses:
        """Return some of them."""
        return Hypotheses(self.planes[rows], self.evidence.take(rows), self.chances[rows])


def best_first(found: Hypotheses) -> Hypotheses:
    """Order planes by chance; those equally likely, by merit.

    Parameters
    ----------
    found : Hypotheses

    Returns
    -------
    Hypotheses
        The same planes.
    """
    return found.take(np.lexsort((-merit(found.evidence), -found.chances)))
