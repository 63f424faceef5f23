"""Labels by the greedy queue of the paper (Amenta, Choi, Kolluri 2001, section 4).

A labelled pole offers its own label to the balls that intersect its ball, with the cosine of the
angle as confidence, and the other label to its opposite poles, with the flatness of the angle
between the two.  Confidences multiply along the way.  The pole with the most confident offer is
labelled next; those with contradictory offers come last.
"""

from __future__ import annotations

import numpy as np

from meshlab_symrecon import _native
from meshlab_symrecon.arrays import Booleans, Floats
from meshlab_symrecon.powercrust.pole_graph import Intersections, Opposites
from meshlab_symrecon.powercrust.progress import Progress

__all__ = ["propagated"]

OFFERED = 0.0  # least cosine with which a ball offers its label; the original's default theta
ACCEPTED = 0.0  # least cosine with which one that was offered none takes a label; its default deep
OUTSIDE, INSIDE = 1, 2  # labels of the native code; 0 is none


def propagated(
    near: Intersections,
    across: Opposites,
    radii: Floats,
    outer: Booleans,
    *,
    progress: Progress | None = None,
) -> tuple[Booleans, Booleans]:
    """Return which poles lie inside, and which ones were labelled at all, (p,) bool each.

    Parameters
    ----------
    near : Intersections
    across : Opposites
    radii : (p,) float
        Of the balls; of equally confident offers that to the largest ball comes first.
    outer : (p,) bool
        Poles that lie outside for certain, where the labels start.
    progress : callable, optional
        Called with the share done, 0 to 1; what it raises stops the work.

    Notes
    -----
    Deviations: balls that meet in a sample offer each other labels also where rounding keeps the
    triangulation from joining them, and labels start from every pole that lies outside for certain.
    """
    labels = _native.propagate_labels(
        near.offsets,
        near.ends,
        near.cost,
        across.first,
        across.second,
        across.flatness,
        radii,
        outer.view(np.uint8),
        OFFERED,
        ACCEPTED,
        progress,
    )
    return labels == INSIDE, labels != 0
