"""The crust: the faces of the power diagram between inner and outer cells, as triangles.

In a valid regular triangulation every edge of the power diagram has exactly three cells and every
vertex four, so the faces between inner and outer cells form a closed manifold whatever the labels
are.  About eight polar balls pass through every sample, so its power vertices come in clusters of
(nearly) equal ones.  They are joined by contracting edges where the link condition holds: that
keeps the manifold.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from meshlab_symrecon import _native
from meshlab_symrecon.arrays import Booleans, Faces, Floats, Indices, Points
from meshlab_symrecon.geometry.triangulation import Triangulation, circumcentres
from meshlab_symrecon.powercrust.poles import Poles

__all__ = ["WELD", "Crust", "crust_faces"]

WELD = 0.1  # local spacings: shorter edges are contracted; far below what the samples resolve
REACH = 2.0  # radii of the smallest ball: a power vertex farther off comes from a flat cell


@dataclass(frozen=True, slots=True, eq=False)
class Crust:
    """A closed triangle surface.

    Attributes
    ----------
    points : (v, 3) float
    faces : (m, 3) int
        Counter-clockwise seen from outside.
    replaced : int
        Power vertices of nearly flat cells, put at the mean of the samples of their poles.
    """

    points: Points
    faces: Faces
    replaced: int


def crust_faces(poles: Poles, diagram: Triangulation, inside: Booleans) -> Crust:
    """Return the triangulated faces between inner and outer cells of the power diagram.

    Parameters
    ----------
    poles : Poles
    diagram : Triangulation
        Regular triangulation of the polar balls.
    inside : (p,) bool
    """
    offsets, corners, _, _ = _native.mixed_edge_polygons(
        diagram.cells, diagram.neighbours, inside.astype(np.uint8)
    )
    if not len(corners):
        return Crust(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64), 0)
    dual = np.zeros(len(diagram.cells), dtype=bool)
    dual[corners] = True
    used = np.flatnonzero(dual)
    shared = _shared_sample(poles, diagram.cells[used].astype(np.int64))
    vertices, replaced = _power_vertices(poles, diagram, used, shared)
    faces = _fans(offsets, (np.cumsum(dual) - 1)[corners])
    spacing = _local_spacing(poles, vertices)
    points, triangles = _native.contract_edges(
        vertices,
        faces.astype(np.int32),
        shared.astype(np.int32),
        np.ascontiguousarray(poles.sites),
        WELD * spacing,
    )
    return Crust(points, triangles.astype(np.int64), replaced)


def _shared_sample(poles: Poles, cells: Indices) -> Indices:
    """Return the sample that all four poles of a cell touch, or -1.

    Such a cell's power vertex *is* that sample: its power to all four balls is zero.
    """
    balls = poles.samples[cells]  # (k, 4 poles, 4 samples)
    shared = np.full(len(cells), -1, dtype=np.int64)
    for slot in range(4):
        candidate = balls[:, 0, slot]
        in_all = (balls[:, 1:] == candidate[:, None, None]).any(axis=2).all(axis=1)
        in_all &= candidate < poles.sample_count
        shared[in_all] = candidate[in_all]
    return shared


def _power_vertices(
    poles: Poles, diagram: Triangulation, used: Indices, shared: Indices
) -> tuple[Points, int]:
    """Return the positions of power vertices, and how many came from nearly flat cells."""
    cells = diagram.cells[used]
    vertices = circumcentres(diagram, used)
    at_sample = shared >= 0
    vertices[at_sample] = poles.sites[shared[at_sample]]

    distances = np.linalg.norm(vertices[:, None, :] - poles.centres[cells], axis=2)
    reach = (distances / poles.radii[cells]).min(axis=1)
    astray = ~(reach <= REACH) & ~at_sample  # a vertex at infinity compares as neither
    vertices[astray] = poles.sites[poles.samples[cells[astray]]].mean(axis=(1, 2))
    return vertices, int(np.count_nonzero(astray))


def _fans(offsets: Indices, corners: Indices) -> Faces:
    """Split polygons into fans of triangles from their first corners."""
    sizes = np.diff(offsets)
    polygon = np.repeat(np.arange(len(sizes)), sizes - 2)
    step = np.arange(len(polygon)) - np.repeat(np.cumsum(sizes - 2) - (sizes - 2), sizes - 2)
    first = offsets[polygon]
    return np.stack([corners[first], corners[first + step + 1], corners[first + step + 2]], axis=1)


def _local_spacing(poles: Poles, vertices: Points) -> Floats:
    """Return the distance to the next sample at the sample nearest to each vertex."""
    spacing: Floats = poles.spacing[cKDTree(poles.sites[: poles.sample_count]).query(vertices)[1]]
    return spacing
