"""Samples that belong to no surface: far from all others, with round Voronoi cells.

A sample of a surface has neighbours on all sides of it about as near as its neighbours have theirs,
and a long, thin Voronoi cell.  An outlier is far from the surface for its spacing, and where
outliers are near each other their cells are round, since they fill a volume.  A sparse part of a
surface has long cells and is linked to denser parts, so it stays.
"""

from __future__ import annotations

import numpy as np

from meshlab_symrecon import _native
from meshlab_symrecon.arrays import Booleans, Floats
from meshlab_symrecon.geometry.triangulation import SmallIndices, Triangulation
from meshlab_symrecon.powercrust.poles import Poles

__all__ = ["outliers"]

FEWEST = 50  # samples; fewer show no usual spacing
REACH = 2.0  # spacings at both ends: how far samples of one surface are linked
FAR = 2.6  # times the usual spacing: how far apart samples of a scattered piece are
MANY = (
    1e5  # samples, for which FAR holds; the largest of random gaps grows with the root of their log
)
ALONE = 4.0  # times the usual spacing: a sample so far from others counts by itself
ROUND = 1.8  # smaller polar ball / spacing: less in nearly all cells of points in a volume
ROUNDISH = 3.0  # the same for one near a surface; less in few cells of a surface
SCATTERED = 10  # samples; a smaller piece needs no quite round cells to be scattered


def outliers(delaunay: Triangulation, poles: Poles) -> Booleans:
    """Tell the samples that belong to no surface.

    Parameters
    ----------
    delaunay : Triangulation
        Delaunay triangulation of ``enclose(samples)``.
    poles : Poles
        Of all samples.

    Returns
    -------
    (n,) bool
    """
    room = poles.room
    if len(room) < FEWEST:
        return np.zeros(len(room), dtype=bool)
    usual = float(np.median(room))
    far = FAR * usual * float(np.sqrt(np.log(len(room)) / np.log(MANY)))
    if not np.any(room > far):
        return np.zeros(len(room), dtype=bool)
    length = np.zeros(len(room))  # samples without two poles say nothing of a surface
    length[poles.pair_samples] = poles.radii[poles.pairs].min(axis=1) / room[poles.pair_samples]
    alone = (room > ALONE * usual) & (length < ROUND)
    piece = _native.linked_pieces(
        delaunay.sites, delaunay.cells, room, alone.astype(np.uint8), REACH
    )
    return alone | _scattered(piece, room, length, far, ALONE * usual)


def _scattered(
    piece: SmallIndices, room: Floats, length: Floats, far: float, alone: float
) -> Booleans:
    """Return (n,) True in pieces whose samples are far apart, and few or with round cells."""
    size = np.bincount(piece)
    middle = (np.cumsum(size) - size) + size // 2
    typical_room = room[np.lexsort((room, piece))][middle]
    typical_length = length[np.lexsort((length, piece))][middle]
    few = (size < SCATTERED) & ((typical_length < ROUNDISH) | (typical_room > alone))
    scattered = (typical_room > far) & (few | (typical_length < ROUND))
    scattered[np.argmax(size)] = False
    told: Booleans = scattered[piece]
    return told
