"""The Power Crust: a closed surface and a medial axis from samples.

N. Amenta, S. Choi, R. K. Kolluri, "The power crust", ACM Symposium on Solid Modeling 2001.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from meshlab_symrecon.arrays import Faces, Floats, Points, as_points
from meshlab_symrecon.errors import GeometryError
from meshlab_symrecon.geometry.surfaces import Topology, topology
from meshlab_symrecon.geometry.triangulation import delaunay, regular_triangulation
from meshlab_symrecon.powercrust.crust import crust_faces
from meshlab_symrecon.powercrust.labelling import label_poles
from meshlab_symrecon.powercrust.medial_axis import MedialAxis, medial_axis
from meshlab_symrecon.powercrust.poles import enclose, find_poles

__all__ = ["PowerCrust", "reconstruct"]

FLAT = 1e-9  # diagonals; a thinner cloud has no inside that rounding would not drown


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
    """

    points: Points
    faces: Faces
    axis: MedialAxis
    topology: Topology
    poles: int
    unreached_poles: int
    flipped_poles: int


def reconstruct(
    points: Points, *, progress: Callable[[float, str], None] | None = None
) -> PowerCrust:
    """Reconstruct a closed surface and its medial axis from samples.

    Parameters
    ----------
    points : (n, 3) float
        Samples; at least four that are not in one plane.
    progress : callable, optional
        Told the fraction done and the step.

    Raises
    ------
    GeometryError
        Wrong shape, a coordinate that is not finite, samples in one plane, or samples that
        enclose no volume.

    Notes
    -----
    Steps as in section 3 of the paper.  Deviations: labels come from a minimum cut (see
    ``labelling``), and clusters of coincident power vertices are joined (see ``crust``).
    """
    report = progress or (lambda fraction, message: None)
    samples, centre, scale = _normalised(as_points(points))
    report(0.0, "triangulating the samples")
    voronoi = delaunay(enclose(samples))
    report(0.2, "finding poles")
    poles = find_poles(voronoi, len(samples))
    report(0.3, "building the power diagram")
    diagram = regular_triangulation(poles.centres, poles.radii**2)
    report(0.6, "labelling poles")
    labels = label_poles(poles, diagram)
    report(0.8, "extracting the surface")
    crust = crust_faces(poles, diagram, labels.inside)
    if not len(crust.faces):
        message = (
            "the samples enclose no volume that the power crust could bound; "
            f"got {len(samples)} points; use a denser or more complete cloud"
        )
        raise GeometryError(message)
    axis = medial_axis(poles, diagram, labels.inside)
    report(1.0, "done")
    return PowerCrust(
        points=crust.points / scale + centre,
        faces=crust.faces,
        axis=MedialAxis(axis.points / scale + centre, axis.radii / scale, axis.faces),
        topology=topology(crust.faces),
        poles=len(poles.centres),
        unreached_poles=labels.unreached,
        flipped_poles=labels.flipped,
    )


def _normalised(points: Points) -> tuple[Points, Floats, float]:
    """Return the points moved and scaled into a box of about unit size, the centre and scale.

    The scale is a power of two, so that scaling rounds nothing.
    """
    low, high = (points.min(axis=0), points.max(axis=0)) if len(points) else (0.0, 0.0)
    extent = float(np.max(np.subtract(high, low)))
    rank, thickness = 0, 0.0
    if extent > 0.0:
        spread = np.linalg.svd((points - points.mean(axis=0)) / extent, compute_uv=False)
        spread = np.append(spread / np.sqrt(len(points)), np.zeros(3))[:3]
        rank, thickness = int(np.count_nonzero(spread > FLAT)), float(spread[2])
    if rank < 3:
        message = (
            "power crust needs at least 4 points that are not in one plane; "
            f"got {len(points)} points of rank {rank} (thickness {thickness:.1g} of the box); "
            "check the scan's units and selection"
        )
        raise GeometryError(message)
    centre = 0.5 * (low + high)
    scale = float(2.0 ** -np.ceil(np.log2(extent)))
    return (points - centre) * scale, centre, scale
