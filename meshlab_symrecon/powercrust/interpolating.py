"""A closed surface through the samples: Delaunay triangles, about two a sample.

The crust's faces are walls between power cells; these are walls between the Delaunay tetrahedra
inside and outside.  A tetrahedron whose circumcentre is a pole lies on the pole's side.  Any other
takes the side of the polar ball to which its circumcentre has the least power, among those at its
samples: nearly always that of the power cell it is in.  So the triangles are those whose dual
Voronoi edges cross the crust: the Delaunay triangulation restricted to it, which is a copy of a
well sampled surface (Edelsbrunner and Shah 1997; Amenta and Bern 1999).  Flat tetrahedra on the
surface may lie on either side; those are chosen that bend it least.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from meshlab_symrecon import _native
from meshlab_symrecon.arrays import Booleans, Faces, Indices, Points
from meshlab_symrecon.geometry.triangulation import FACETS, Triangulation
from meshlab_symrecon.powercrust.labelling import SMALLEST_PIECE
from meshlab_symrecon.powercrust.pole_graph import covering_poles
from meshlab_symrecon.powercrust.poles import Poles

__all__ = ["InterpolatingSurface", "interpolating_faces"]


@dataclass(frozen=True, slots=True, eq=False)
class InterpolatingSurface:
    """A closed manifold of triangles between samples.

    Attributes
    ----------
    points : (v, 3) float
        The samples that are on the surface.
    faces : (m, 3) int
        Counter-clockwise seen from outside.
    samples : (v,) int
        The number of each point among the samples; ascending.
    left_out : int
        Samples that are not on the surface: outliers, and noise inside or outside it.
    """

    points: Points
    faces: Faces
    samples: Indices
    left_out: int


def interpolating_faces(
    voronoi: Triangulation, poles: Poles, diagram: Triangulation, inside: Booleans
) -> InterpolatingSurface:
    """Return the boundary of the inner Delaunay tetrahedra, made a manifold.

    Parameters
    ----------
    voronoi : Triangulation
        Delaunay triangulation of ``enclose(samples)``.
    poles : Poles
        Poles found in it.
    diagram : Triangulation
        Regular triangulation of the polar balls.
    inside : (p,) bool
        Poles that lie inside.

    Returns
    -------
    InterpolatingSurface
        Closed, oriented, edge- and vertex-manifold whatever the labels are; without points when
        nothing is inside.

    Notes
    -----
    Tetrahedra are turned over where the surface would touch itself, one at a time or a whole fan,
    as long as that leaves fewer such places.  Where none does, inner ones give way; that ends at
    the latest when nothing is inside.
    """
    samples = poles.sample_count
    of_poles = _sides_of_poles(poles, diagram, inside)
    sides = _native.label_cells(
        poles.sites,
        voronoi.cells,
        voronoi.neighbours,
        samples,
        poles.centres,
        poles.radii,
        poles.samples.astype(np.int32),
        of_poles,
        _poles_of_samples(poles, of_poles),
    )
    smallest = int(2 * SMALLEST_PIECE * samples)  # a closed surface has two triangles a sample
    sides = _native.settle_sides(
        poles.sites, voronoi.cells, voronoi.neighbours, samples, sides, smallest
    )
    inner = np.flatnonzero(sides)
    cell, corner = np.nonzero(sides[voronoi.neighbours[inner]] == 0)
    corners = voronoi.cells[inner[cell, None], FACETS[corner]]
    used = np.zeros(samples, dtype=bool)
    used[corners] = True
    return InterpolatingSurface(
        points=poles.sites[:samples][used],
        faces=(np.cumsum(used) - 1)[corners],
        samples=np.flatnonzero(used),
        left_out=int(np.count_nonzero(~used)),
    )


def _sides_of_poles(poles: Poles, diagram: Triangulation, inside: Booleans) -> NDArray[np.uint8]:
    """Return (p,) 1 for inner and 0 for outer poles.

    A pole without a power cell, which cannot be told apart by its own evidence, takes the side of
    the one whose ball covers it most.
    """
    sides = inside[covering_poles(poles, diagram)].astype(np.uint8)
    sides[poles.outermost] = 0
    return sides


def _poles_of_samples(poles: Poles, sides: NDArray[np.uint8]) -> NDArray[np.int32]:
    """Return (n, 2) the poles of every sample, -1 where it has none.

    A sample that lost a pole to noise has the largest ball through it on either side instead.
    """
    of_sample = np.full((len(poles.sites), 2), -1, dtype=np.int32)
    if len(poles.pairs) < poles.sample_count:
        rising = np.argsort(poles.radii, kind="stable")  # the last one assigned stays
        of_sample[poles.samples[rising], sides[rising, None]] = rising[:, None]
    of_sample[poles.pair_samples] = poles.pairs
    return of_sample[: poles.sample_count]
