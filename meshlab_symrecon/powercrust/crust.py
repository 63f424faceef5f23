"""The crust: the faces of the power diagram between inner and outer cells, as triangles.

In a valid regular triangulation every edge of the power diagram has exactly three cells and every
vertex four, so the faces between inner and outer cells form a closed manifold whatever the labels
are.  About eight polar balls pass through every sample, so its power vertices come in clusters of
(nearly) equal ones: a cluster that forms a disc becomes one vertex.  Then edges are contracted
where the link condition holds: that keeps the manifold.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from meshlab_symrecon import _native
from meshlab_symrecon.arrays import Booleans, Faces, Floats, Indices, Points
from meshlab_symrecon.geometry.triangulation import Triangulation
from meshlab_symrecon.powercrust.poles import Poles

__all__ = ["FLAT", "REACH", "WELD", "Crust", "crust_faces"]

WELD = 0.1  # local spacings: shorter edges are contracted; far below what the samples resolve
FLAT = 0.015  # local spacings: a vertex goes when its removal moves the surface by less
REACH = 2.0  # radii of the smallest ball: a power vertex farther off comes from a flat cell


@dataclass(frozen=True, slots=True, eq=False)
class Crust:
    """A closed triangle surface.

    Attributes
    ----------
    points : (v, 3) float
    faces : (m, 3) int
        Counter-clockwise seen from outside.
    nearest : (v,) int
        The sample nearest to each vertex, among those on the polar balls that meet there.
    gap : (v,) float
        Distance of each vertex to that sample; zero for a vertex that is a sample.
    replaced : int
        Power vertices of nearly flat cells, put at the mean of the samples of their poles.
    """

    points: Points
    faces: Faces
    nearest: Indices
    gap: Floats
    replaced: int


def crust_faces(
    poles: Poles,
    diagram: Triangulation,
    inside: Booleans,
    *,
    progress: Callable[[float], object] | None = None,
) -> Crust:
    """Return the triangulated faces between inner and outer cells of the power diagram.

    Parameters
    ----------
    poles : Poles
    diagram : Triangulation
        Regular triangulation of the polar balls.
    inside : (p,) bool
    progress : callable, optional
        Called with the share done, 0 to 1.
    """
    samples = np.ascontiguousarray(poles.sites[: poles.sample_count])
    spacing = np.nan_to_num(poles.spacing, posinf=0.0)  # of a sample without neighbours
    cells, offsets, corners = _native.mixed_edge_polygons(
        diagram.cells, diagram.neighbours, inside.astype(np.uint8), _part(progress, 0.0, 0.25)
    )
    vertices, nearest, replaced = _native.power_vertices(
        poles.centres,
        poles.radii,
        np.ascontiguousarray(poles.samples, dtype=np.int32),
        poles.sites,
        poles.sample_count,
        diagram.cells,
        cells,
        REACH,
        _part(progress, 0.25, 0.5),
    )
    del cells
    points, faces, nearest = _native.join_at_samples(
        vertices, nearest, offsets, corners, samples, _part(progress, 0.5, 0.7)
    )
    del vertices, offsets, corners
    points, faces, nearest = _native.contract_edges(
        points, faces, nearest, samples, spacing, WELD, FLAT, _part(progress, 0.7, 1.0)
    )
    gap = np.linalg.norm(points - samples[nearest], axis=1)
    return Crust(points, faces.astype(np.int64), nearest.astype(np.int64), gap, replaced)


def _part(
    progress: Callable[[float], object] | None, low: float, high: float
) -> Callable[[float], object] | None:
    """Return a callback that reports the progress of one step as a part of the whole."""
    if progress is None:
        return None
    return lambda fraction: progress(low + (high - low) * fraction)
