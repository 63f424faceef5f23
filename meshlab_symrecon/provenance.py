"""How layers, pictures and pages mark what was measured and what was invented."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from meshlab_symrecon.arrays import Floats

__all__ = ["INVENTED", "MEASURED", "MIRRORED", "colours_by_share", "paint_by_share"]

MIRRORED = "mirrored"  # the custom scalar that a completion leaves: 1 for what it has invented
MEASURED = (222, 203, 174)  # sRGB: warm limestone
INVENTED = (58, 134, 148)  # its complement: verdigris


def colours_by_share(share_invented: Floats) -> NDArray[np.uint8]:
    """Return (n, 3) sRGB colours from measured (share 0) to invented (share 1)."""
    share = np.clip(np.asarray(share_invented, dtype=float), 0.0, 1.0)[:, None]
    mixed = (1.0 - share) * np.array(MEASURED) + share * np.array(INVENTED)
    colours: NDArray[np.uint8] = np.round(mixed).astype(np.uint8)
    return colours


def paint_by_share(share_invented: Floats) -> Floats:
    """Return the same as a layer's vertex colours: (n, 4) in 0..1, opaque."""
    colours = colours_by_share(share_invented) / 255.0
    return np.column_stack([colours, np.ones(len(colours))])
