"""The measured surface that mirror images are made of: a scan without scatter and copies."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from meshlab_symrecon import _native
from meshlab_symrecon.arrays import Booleans, Floats, Indices, Points
from meshlab_symrecon.geometry.bounds import robust_diagonal
from meshlab_symrecon.geometry.sampling import principal_frame
from meshlab_symrecon.symmetry.copying import off_lopsided_plinth, on_surface, standing_plane
from meshlab_symrecon.symmetry.preparation import PreparedCloud, prepare
from meshlab_symrecon.symmetry.progress import Progress, part, share_of
from meshlab_symrecon.symmetry.surroundings import Surroundings, neighbours, surroundings

__all__ = ["MeasuredSurface", "measured_surface"]

ENOUGH = 200_000  # points on which the statue's asymmetry and its plinth are looked for
SAMPLES = 16  # of the prepared cloud; they are for detection


@dataclass(frozen=True, eq=False)
class MeasuredSurface:
    """A scan without scatter and copies, and what is found out about it on demand."""

    number: Indices  # (k,)  of each point in the input
    allowed: Booleans | None  # (k,)  may be mirrored; None: all of them
    around: Surroundings
    scattered: int  # points left out
    directions: Points | None  # of the input

    def directions_with(self, others: Points) -> Points | None:
        """Return the normals of these points, then others; made when asked for, to save memory."""
        if self.directions is None:
            return None
        return np.concatenate([self.directions[self.number], others])

    @cached_property
    def _even(self) -> slice:
        """Every n-th point along the curve: an even part of a large scan."""
        return slice(None, None, -(-len(self.number) // ENOUGH))

    @cached_property
    def prepared(self) -> PreparedCloud:
        """The form of it in which asymmetry is looked for."""
        sides = self.around.directions[self._even] if self.around.outward else None
        return prepare(self.around.points[self._even], sides, SAMPLES)

    @cached_property
    def _standing(self) -> Floats | None:
        return standing_plane(self.around.points[self._even])

    def off_plinth(self, plane: Floats) -> Booleans:
        """Tell which points are not on a plinth that lacks the mirror plane."""
        if self._standing is None:
            return np.ones(len(self.number), dtype=bool)
        around = self.around
        return off_lopsided_plinth(around.points, around.field, around.usual, self._standing, plane)


def measured_surface(
    points: Points, normals: Points | None, allowed: Booleans | None, progress: Progress
) -> MeasuredSurface:
    """Order a cloud along a space-filling curve, which makes searches fast, without scatter.

    Of points that coincide, the curve passes the first only.
    """
    progress(0.0, "ordering the points")
    centre, axes = principal_frame(points)
    framed = points - centre
    framed = framed @ axes.T  # so that all that follows turns with the scan
    order = _native.curve_order(framed).astype(np.int64)
    diagonal = robust_diagonal(framed[order])  # without those that coincide
    del framed
    ordered = points[order]
    looking = part(progress, 0.2, 0.8)
    known = neighbours(ordered, share_of(looking, "looking at neighbourhoods"))
    progress(0.8, "looking for the surface")
    together = on_surface(ordered, known.width, known.nearest)
    number = order[together]
    sides = None if normals is None else normals[order]
    return MeasuredSurface(
        number=number,
        allowed=None if allowed is None else allowed[number],
        around=surroundings(ordered, sides, diagonal, known, together),
        scattered=int(np.count_nonzero(~together)),
        directions=normals,
    )
