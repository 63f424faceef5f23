"""What a completion has left alone: holes missing on both sides, clutter, a plinth."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from meshlab_symrecon.arrays import Floats

__all__ = ["holes", "left_alone", "place", "width"]

WORTH_TELLING = 0.005  # of the measured points: fewer, and every scan has some
PARTS = {
    "scattered": "scattered points on no surface",
    "plinth": "points of a plinth that is not its own mirror image",
}


def holes(completed: Mapping[str, Any]) -> Floats:
    """Return centre and width of the holes that no mirror image fills, (k, 4), widest first."""
    return np.reshape(np.asarray(completed.get("open_rims", ()), dtype=np.float64), (-1, 4))


def left_alone(completed: Mapping[str, Any], form: str = "d") -> list[str]:
    """Say which measured points were not mirrored, one phrase a reason, if they are many."""
    fewest = WORTH_TELLING * completed["measured"]
    counts = {name: int(completed.get(name, 0)) for name in PARTS}
    return [f"{count:{form}} {PARTS[name]}" for name, count in counts.items() if count > fewest]


def width(hole: Iterable[float]) -> str:
    """Write how wide a hole is."""
    wide = list(hole)[3]
    return f"{wide:.2g}" if wide < 99.5 else f"{wide:.0f}"  # never 4.1e+02


def place(hole: Iterable[float]) -> str:
    """Write where a hole is, to a tenth of its width, however far the scan is from the origin."""
    *centre, wide = hole
    digits = max(0, 1 - math.floor(math.log10(wide)))
    return f"({', '.join(f'{number:.{digits}f}' for number in centre)})"
