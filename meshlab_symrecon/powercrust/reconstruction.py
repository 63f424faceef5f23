"""The Power Crust: a closed surface and a medial axis from samples.

N. Amenta, S. Choi, R. K. Kolluri, "The power crust", ACM Symposium on Solid Modeling 2001.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from meshlab_symrecon import _native
from meshlab_symrecon.arrays import Faces, Floats, Points, as_points
from meshlab_symrecon.geometry.bounds import require_solid
from meshlab_symrecon.geometry.surfaces import Topology, topology
from meshlab_symrecon.geometry.triangulation import delaunay, regular_triangulation
from meshlab_symrecon.powercrust.crust import crust_faces
from meshlab_symrecon.powercrust.labelling import label_poles
from meshlab_symrecon.powercrust.medial_axis import MedialAxis, medial_axis
from meshlab_symrecon.powercrust.poles import enclose, find_poles

__all__ = ["PowerCrust", "reconstruct"]

NO_AXIS = MedialAxis(np.zeros((0, 3)), np.zeros(0), np.zeros((0, 3), dtype=np.int64))
FEWEST = 5  # samples; four bound a tetrahedron that says nothing about a shape


@dataclass(frozen=True, slots=True, eq=False)
class PowerCrust:
    """A closed surface with its medial axis, in the units of the samples.

    Attributes
    ----------
    points : (v, 3) float
    faces : (m, 3) int
        Counter-clockwise seen from outside.
    axis : MedialAxis
    topology : Topology
    poles : int
        Distinct poles.
    unreached_poles : int
        Poles that no evidence labels; they count as outside.
    flipped_poles : int
        Poles of islands and bubbles too small to belong to the shape.
    hull : bool
        The samples were too sparse or too flat to tell inside from outside, so the surface is
        their convex hull.
    """

    points: Points
    faces: Faces
    axis: MedialAxis
    topology: Topology
    poles: int
    unreached_poles: int
    flipped_poles: int
    hull: bool


def reconstruct(
    points: Points,
    *,
    with_axis: bool = True,
    progress: Callable[[float, str], None] | None = None,
) -> PowerCrust:
    """Reconstruct a closed surface and its medial axis from samples.

    Parameters
    ----------
    points : (n, 3) float
        Samples; at least five that are not in one plane.
    with_axis : bool
        Also return the medial axis; it is empty otherwise.
    progress : callable, optional
        Told the fraction done and the step.

    Raises
    ------
    GeometryError
        Wrong shape, a coordinate that is not finite, fewer than five samples, or samples in one
        plane.

    Notes
    -----
    Steps as in section 3 of the paper.  Deviations: labels come from a minimum cut (see
    ``labelling``), and clusters of coincident power vertices are joined (see ``crust``).
    """
    report = progress or (lambda fraction, message: None)
    samples, centre, scale = _normalised(as_points(points))
    voronoi = delaunay(
        enclose(samples), progress=_part(report, 0.0, 0.15, "triangulating the samples")
    )
    report(0.15, "finding poles")
    poles = find_poles(voronoi, len(samples))
    if poles.rank < 3:
        return _convex_hull(samples, centre, scale, len(poles.centres))
    diagram = regular_triangulation(
        poles.centres,
        poles.radii**2,
        progress=_part(report, 0.2, 0.55, "building the power diagram"),
    )
    report(0.55, "labelling poles")
    labels = label_poles(poles, diagram)
    if not labels.inside.any():
        return _convex_hull(samples, centre, scale, len(poles.centres))
    report(0.8, "extracting the surface")
    crust = crust_faces(poles, diagram, labels.inside)
    axis = medial_axis(poles, diagram, labels.inside) if with_axis else NO_AXIS
    report(1.0, "done")
    return PowerCrust(
        points=crust.points / scale + centre,
        faces=crust.faces,
        axis=MedialAxis(axis.points / scale + centre, axis.radii / scale, axis.faces),
        topology=topology(crust.faces),
        poles=len(poles.centres),
        unreached_poles=labels.unreached,
        flipped_poles=labels.flipped,
        hull=False,
    )


def _part(
    report: Callable[[float, str], None], low: float, high: float, step: str
) -> Callable[[float], None]:
    """Return a callback that reports the progress of one step as a part of the whole."""
    return lambda fraction: report(low + (high - low) * fraction, step)


def _convex_hull(samples: Points, centre: Floats, scale: float, poles: int) -> PowerCrust:
    """Return the hull of the samples: the closed surface of those that enclose no volume."""
    cells = delaunay(samples)
    sides = np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]])  # outward, opposite each corner
    cell, corner = np.nonzero(cells.neighbours < 0)
    used, faces = np.unique(cells.cells[cell[:, None], sides[corner]], return_inverse=True)
    faces = faces.reshape(-1, 3).astype(np.int64)
    surface = samples[used] / scale + centre
    return PowerCrust(surface, faces, NO_AXIS, topology(faces), poles, 0, 0, hull=True)


def _normalised(points: Points) -> tuple[Points, Floats, float]:
    """Return distinct points in a box of about unit size, the box's centre and the scale.

    The scale is a power of two, so that scaling rounds nothing.  Lexicographic order makes the
    result the same, to the last bit, for any order of the points and any repetition.
    """
    require_solid(points, "power crust", minimum=FEWEST)
    low, high = points.min(axis=0), points.max(axis=0)
    centre: Floats = 0.5 * (low + high)
    scale = float(2.0 ** -np.ceil(np.log2((high - low).max())))
    moved = (points - centre) * scale + 0.0  # no negative zeros
    return moved[_native.lexicographic_order(moved)], centre, scale
