"""The medial axis: poles of one side joined as in the power diagram (the paper's *power shape*).

Poles near the surface and poles of nearly equal balls say nothing new about the shape; two
thresholds leave them out, as in the original program: small balls are noise, and a ball that hardly
sticks out of a larger one joined to it is redundant.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from meshlab_symrecon import _native
from meshlab_symrecon.arrays import Booleans, Faces, Floats, Indices, Points
from meshlab_symrecon.geometry.triangulation import Triangulation
from meshlab_symrecon.powercrust.poles import Poles

__all__ = ["MedialAxis", "medial_axis"]

INNER, OUTER = 1, 2  # parts of the axis


@dataclass(frozen=True, slots=True, eq=False)
class MedialAxis:
    """Poles, the radii of their balls, and how they are joined.

    Attributes
    ----------
    points : (q, 3) float
    radii : (q,) float
    faces : (t, 3) int
        Triangles, each once.
    edges : (e, 2) int
        Edges, each once: those of the triangles, and those of curves that have none.
    outer : (q,) bool
        The pole lies outside the surface.
    """

    points: Points
    radii: Floats
    faces: Faces
    edges: Indices = field(default_factory=lambda: np.zeros((0, 2), dtype=np.int64))
    outer: Booleans = field(default_factory=lambda: np.zeros(0, dtype=bool))


def medial_axis(
    poles: Poles,
    diagram: Triangulation,
    inside: Booleans,
    *,
    noise: float = 0.0,
    redundancy: float = 0.0,
    outer: bool = False,
) -> MedialAxis:
    """Return the edges and triangles of the regular triangulation between poles of one side.

    Parameters
    ----------
    poles : Poles
    diagram : Triangulation
        Regular triangulation of the polar balls.
    inside : (p,) bool
    noise : float
        Poles with smaller balls are left out; a length in the units of the samples.
    redundancy : float
        A ball that sticks out of a larger one joined to it by less is absorbed: its pole goes, and
        the larger ball's pole takes over its connections.  A length in the units of the samples;
        at 0 nothing is absorbed.
    outer : bool
        Also return the axis of the outside, as far as it is near the samples.

    Returns
    -------
    MedialAxis
        Empty when no pole is left.

    Notes
    -----
    Poles absorb in the order of falling radius, and one that has absorbed others is absorbed by
    none.  So every ball of at least the size of ``noise`` sticks out of one that is kept by less
    than ``redundancy``: the union of the balls that are kept is as near as that to the whole.
    """
    part = np.zeros(len(inside), dtype=np.uint8)
    part[inside] = INNER
    if outer:
        part[~inside & ~poles.outermost] = OUTER
    part[(poles.radii < noise) | diagram.hidden] = 0
    absorber, edges, faces = _native.power_shape(
        diagram.cells, diagram.neighbours, part, poles.centres, poles.radii, redundancy
    )
    kept = (part > 0) & (absorber == np.arange(len(absorber)))
    number = np.cumsum(kept) - 1
    return MedialAxis(
        points=poles.centres[kept],
        radii=poles.radii[kept],
        faces=number[faces].reshape(-1, 3),
        edges=number[edges].reshape(-1, 2),
        outer=part[kept] == OUTER,
    )
