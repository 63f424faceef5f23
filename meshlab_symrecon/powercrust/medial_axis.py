"""The medial axis: inner poles joined as in the power diagram (the paper's *power shape*)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshlab_symrecon.arrays import Booleans, Faces, Floats, Points
from meshlab_symrecon.geometry.triangulation import Triangulation
from meshlab_symrecon.powercrust.poles import Poles

__all__ = ["MedialAxis", "medial_axis"]


@dataclass(frozen=True, slots=True, eq=False)
class MedialAxis:
    """Inner poles, their ball radii and the triangles between them.

    Attributes
    ----------
    points : (q, 3) float
    radii : (q,) float
    faces : (t, 3) int
    """

    points: Points
    radii: Floats
    faces: Faces


def medial_axis(poles: Poles, diagram: Triangulation, inside: Booleans) -> MedialAxis:
    """Return the part of the regular triangulation whose vertices are all inner poles.

    Parameters
    ----------
    poles : Poles
    diagram : Triangulation
    inside : (p,) bool
    """
    cells = diagram.cells[np.count_nonzero(inside[diagram.cells], axis=1) >= 3]
    triangles = np.concatenate(
        [np.sort(cells[:, [k for k in range(4) if k != left_out]], axis=1) for left_out in range(4)]
    )
    triangles = np.unique(triangles[inside[triangles].all(axis=1)], axis=0)
    kept = np.zeros(len(inside), dtype=bool)
    kept[diagram.cells.ravel()] = True
    kept &= inside
    number = np.cumsum(kept) - 1
    return MedialAxis(
        points=poles.centres[kept],
        radii=poles.radii[kept],
        faces=number[triangles].astype(np.int64).reshape(-1, 3),
    )
