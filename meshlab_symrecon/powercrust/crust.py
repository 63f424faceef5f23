"""The crust: the faces of the power diagram between inner and outer cells, as triangles.

In a valid regular triangulation every edge of the power diagram has exactly three cells and every
vertex four, so the faces between inner and outer cells form a closed manifold whatever the labels
are.  About eight polar balls pass through every sample, so its power vertices come in clusters of
(nearly) equal ones: a cluster that forms a disc becomes one vertex.  Then edges are contracted
where the link condition holds: that keeps the manifold.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshlab_symrecon import _native
from meshlab_symrecon.arrays import Booleans, Faces, Indices, Points
from meshlab_symrecon.geometry.triangulation import SmallIndices, Triangulation
from meshlab_symrecon.powercrust.poles import Poles
from meshlab_symrecon.powercrust.progress import Progress, part

__all__ = [
    "FLAT",
    "JOINS_DONE",
    "REACH",
    "WALLS_DONE",
    "WELD",
    "Crust",
    "WallTriangles",
    "Walls",
    "contracted",
    "crust_faces",
    "crust_walls",
    "joined_at_samples",
]

WELD = 0.1  # local spacings: shorter edges are contracted; far below what the samples resolve
FLAT = 0.015  # local spacings: a vertex goes when its removal moves the surface by less
WALLS_DONE, JOINS_DONE = 0.4, 0.65  # shares of the time
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
    """

    points: Points
    faces: Faces
    nearest: Indices


@dataclass(frozen=True, slots=True, eq=False)
class Walls:
    """The faces between inner and outer power cells, as polygons."""

    vertices: Points  # (k, 3)
    nearest: SmallIndices  # (k,)  the sample nearest to each
    offsets: SmallIndices  # (w + 1,)  wall i has the corners offsets[i] to offsets[i + 1]
    corners: SmallIndices  # (c,)  vertices, counter-clockwise seen from outside


@dataclass(frozen=True, slots=True, eq=False)
class WallTriangles:
    """Walls cut into triangles, with one vertex a sample where that keeps the manifold."""

    points: Points  # (k, 3)
    faces: SmallIndices  # (t, 3)
    nearest: SmallIndices  # (k,)


def crust_faces(
    poles: Poles,
    diagram: Triangulation,
    inside: Booleans,
    *,
    progress: Progress | None = None,
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
    walls = crust_walls(poles, diagram, inside, progress=part(progress, 0.0, WALLS_DONE))
    joined = joined_at_samples(walls, poles, progress=part(progress, WALLS_DONE, JOINS_DONE))
    return contracted(joined, poles, progress=part(progress, JOINS_DONE, 1.0))


def crust_walls(
    poles: Poles,
    diagram: Triangulation,
    inside: Booleans,
    *,
    progress: Progress | None = None,
) -> Walls:
    """Return the faces between inner and outer cells: the first step of `crust_faces`.

    The steps are apart so that the diagram, and then the walls, can be let go between them.
    """
    cells, offsets, corners = _native.mixed_edge_polygons(
        diagram.cells, diagram.neighbours, inside.astype(np.uint8), part(progress, 0.0, 0.5)
    )
    vertices, nearest = _native.power_vertices(
        poles.centres,
        poles.radii,
        np.ascontiguousarray(poles.samples, dtype=np.int32),
        poles.sites,
        poles.sample_count,
        diagram.cells,
        cells,
        REACH,
        part(progress, 0.5, 1.0),
    )
    return Walls(vertices, nearest, offsets, corners)


def joined_at_samples(
    walls: Walls, poles: Poles, *, progress: Progress | None = None
) -> WallTriangles:
    """Return walls as triangles, joined at samples: the second step of `crust_faces`."""
    points, faces, nearest = _native.join_at_samples(
        walls.vertices, walls.nearest, walls.offsets, walls.corners, _samples(poles), progress
    )
    return WallTriangles(points, faces, nearest)


def contracted(walls: WallTriangles, poles: Poles, *, progress: Progress | None = None) -> Crust:
    """Return walls without short edges, thinned out in flat places: the third step."""
    samples = _samples(poles)
    spacing = np.nan_to_num(poles.spacing, posinf=0.0)  # of a sample without neighbours
    points, faces, nearest = _native.contract_edges(
        walls.points, walls.faces, walls.nearest, samples, spacing, WELD, FLAT, progress
    )
    return Crust(points, faces.astype(np.int64), nearest.astype(np.int64))


def _samples(poles: Poles) -> Points:
    return np.ascontiguousarray(poles.sites[: poles.sample_count])
