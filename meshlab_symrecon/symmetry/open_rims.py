"""What is missing on both sides: the rims that no mirror image closes."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from meshlab_symrecon.arrays import Floats, Points
from meshlab_symrecon.geometry.bounds import robust_diagonal
from meshlab_symrecon.geometry.neighbours import border_points, principal_normals
from meshlab_symrecon.geometry.sampling import farthest_point_order, thin_by_voxels, voxel_means

__all__ = ["open_rims"]

LEVEL = 8_000  # points among which rims are looked for
NORMAL_NEIGHBOURS = 16
LINK = 4.0  # spacings between neighbours on a rim
FLAT = 0.5  # spacings: thicker neighbourhoods are limbs seen whole, or sharp edges
NARROWEST = 0.03  # diagonals: holes below are closed by any reconstruction
NARROWEST_SPACINGS = 6.0
FEWEST = 12  # points of a rim
EXTREMES = 24  # points of a rim between which its width is measured


def open_rims(points: Points) -> Floats:
    """Find the holes that a completed cloud still has.

    Parameters
    ----------
    points : (n, 3) float
        The cloud, without clutter.

    Returns
    -------
    (k, 4) float
        Centre of each rim and the width across it, widest first; those below 3 % of the
        diagonal or 6 spacings are not told from uneven sampling, and left out.
    """
    labels, count = thin_by_voxels(points - points.mean(axis=0), LEVEL)
    even = points if count == len(points) else voxel_means(points, labels, count)
    if len(even) <= NORMAL_NEIGHBOURS:
        return np.zeros((0, 4))
    spacing = float(np.median(cKDTree(even).query(even, k=2)[0][:, 1]))
    normals, thickness = principal_normals(even, even, NORMAL_NEIGHBOURS)
    flat = thickness < FLAT * spacing
    rims = even[border_points(even, normals) & flat]
    narrowest = max(NARROWEST * robust_diagonal(points), NARROWEST_SPACINGS * spacing)
    found = [
        np.append(rim.mean(axis=0), _width(rim))
        for rim in _pieces(rims, LINK * spacing)
        if len(rim) >= FEWEST
    ]
    wide = sorted((rim for rim in found if rim[3] >= narrowest), key=lambda rim: -rim[3])
    return np.array(wide).reshape(-1, 4)


def _pieces(rims: Points, reach: float) -> list[Points]:
    """Return the connected pieces of the rims."""
    if len(rims) == 0:
        return []
    pairs = cKDTree(rims).query_pairs(reach, output_type="ndarray")
    links = coo_matrix((np.ones(len(pairs), dtype=bool), pairs.T), shape=(len(rims),) * 2)
    piece = connected_components(links, directed=False)[1]
    order = np.argsort(piece, kind="stable")
    return np.split(rims[order], np.flatnonzero(np.diff(piece[order])) + 1)


def _width(rim: Points) -> float:
    """Return the largest distance between points of a rim."""
    extremes = rim[farthest_point_order(rim, EXTREMES)]
    return float(np.linalg.norm(extremes[:, np.newaxis] - extremes, axis=2).max())
