"""A triangle surface of samples, and the simplest one: their convex hull."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshlab_symrecon.arrays import Faces, Indices, Points
from meshlab_symrecon.geometry.triangulation import FACETS, delaunay

__all__ = ["Surface", "convex_hull"]


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """Triangles, and the sample nearest to each vertex."""

    points: Points  # (v, 3)
    faces: Faces  # (m, 3)
    nearest: Indices  # (v,)


def convex_hull(samples: Points) -> Surface:
    """Return the hull of samples, (n, 3): the closed surface of those that enclose no volume.

    Raises
    ------
    GeometryError
        Samples in one plane.
    """
    cells = delaunay(samples)
    cell, corner = np.nonzero(cells.neighbours < 0)
    used, faces = np.unique(cells.cells[cell[:, None], FACETS[corner]], return_inverse=True)
    return Surface(samples[used], faces.reshape(-1, 3).astype(np.int64), used.astype(np.int64))
