"""Handles of the size of noise, kept out of the labels.

Noise joins two sheets of a thin part by a bridge of small inner balls, or pierces it by a tunnel of
small outer ones.  Both are handles of the surface that no deep ball carries.  Inner poles therefore
join the inside from the largest ball to the smallest, and a small one only where it closes no loop
round itself; then outer poles do the same.  A handle with a ball larger than the limit on its
narrowest way stays, so the limit is the size below which samples tell nothing.  (Simple points of
digital topology, carried over to cells of the power diagram.)
"""

from __future__ import annotations

import numpy as np

from meshlab_symrecon import _native
from meshlab_symrecon.arrays import Booleans, Floats
from meshlab_symrecon.geometry.triangulation import Triangulation
from meshlab_symrecon.powercrust.pole_graph import shown_poles

__all__ = ["without_small_handles"]


def without_small_handles(
    diagram: Triangulation, inside: Booleans, outer: Booleans, sizes: Floats, smallest: float
) -> Booleans:
    """Return labels without handles that only balls smaller than the limit carry.

    Parameters
    ----------
    diagram : Triangulation
        Regular triangulation of the polar balls.
    inside, outer : (p,) bool
        Inner poles; poles that are outside for certain.
    sizes : (p,) float
        Of the balls, such as their radii in multiples of the local spacing.
    smallest : float
        The least size that may carry a handle.

    Returns
    -------
    (p,) bool
        Inner poles.  Poles in no cell of the diagram are outside.
    """
    shown = shown_poles(diagram)
    large = sizes >= smallest
    inner = inside & shown
    inner = _grown(diagram, inner, inner & large, sizes)
    around = shown & ~inner
    return shown & ~_grown(diagram, around, around & (large | outer), sizes)


def _grown(diagram: Triangulation, wanted: Booleans, certain: Booleans, sizes: Floats) -> Booleans:
    """Return (p,) the wanted poles that join the certain ones without closing small loops."""
    grown: Booleans = _native.grow_without_loops(
        diagram.cells, wanted.astype(np.uint8), certain.astype(np.uint8), sizes
    ).astype(bool)
    return grown
