"""What a user chooses of a reconstruction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshlab_symrecon.errors import GeometryError
from meshlab_symrecon.powercrust.labelling import METHODS

__all__ = ["SURFACES", "Recipe"]

SURFACES = ("power crust", "interpolating")


@dataclass(frozen=True, slots=True)
class Recipe:
    """How to reconstruct; lengths are multiples of the local spacing of the samples.

    Attributes
    ----------
    surface : str
        One of `SURFACES`: ``power crust``, the faces of the power diagram between inner and outer
        poles, or ``interpolating``, triangles between samples.
    labelling : str
        One of `METHODS`: how inner poles are told from outer ones.
    smallest_ball : float or None
        Smaller polar balls are dropped; None chooses by the noise of the samples.
    keep_outliers : bool
        Samples that belong to no surface count like all others.
    widest_cap : float
        Holes of the samples wider than this are left open; 0 closes all.
    with_axis, with_outer_axis : bool
        Also return the medial axis, and its part outside the surface.
    axis_noise, axis_redundancy : float
        Thresholds that simplify the medial axis; see `medial_axis`.
    """

    surface: str = SURFACES[0]
    labelling: str = METHODS[0]
    smallest_ball: float | None = None
    keep_outliers: bool = False
    widest_cap: float = 0.0
    with_axis: bool = True
    with_outer_axis: bool = False
    axis_noise: float = 0.0
    axis_redundancy: float = 0.0

    def __post_init__(self) -> None:
        """Check the recipe.

        Raises
        ------
        GeometryError
            A surface that does not exist, or a negative length.
        """
        if self.surface not in SURFACES:
            names = " or ".join(map(repr, SURFACES))
            raise GeometryError(f"a surface is {names}; got {self.surface!r}; choose one of these")
        lengths = {
            "smallest_ball": self.smallest_ball or 0.0,
            "widest_cap": self.widest_cap,
            "axis_noise": self.axis_noise,
            "axis_redundancy": self.axis_redundancy,
        }
        for name, length in lengths.items():
            if not 0.0 <= length < np.inf:
                message = f"{name} is a multiple of the spacing, 0 or more; got {length}; change it"
                raise GeometryError(message)
