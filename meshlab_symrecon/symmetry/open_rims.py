"""What is missing on both sides: the rims that no mirror image closes."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from meshlab_symrecon.arrays import Booleans, Floats, Indices, Points
from meshlab_symrecon.geometry.bounds import robust_diagonal
from meshlab_symrecon.geometry.neighbours import (
    FREE_ANGLE,
    free_angles,
    local_spacing,
    principal_normals,
    voted_border,
)
from meshlab_symrecon.geometry.sampling import (
    farthest_point_order,
    principal_frame,
    thin_by_voxels,
    voxel_means,
)

__all__ = ["open_rims"]

MOST, LEAST = 8_000, 400  # points of the level on which rims are looked for
POINTS_A_PLACE = 2  # of the cloud: chance gaps of random samples close on an even level
NORMAL_NEIGHBOURS = 16
LINK = 4.0  # spacings between neighbours on a rim
FLAT = 0.3  # spacings: thicker neighbourhoods are limbs seen whole, or sharp edges
NARROWEST = 0.03  # diagonals: holes below are closed by any reconstruction
NARROWEST_SPACINGS = 4.0
FEWEST, FEWEST_CERTAIN = 12, 3  # points of a rim, and those beyond doubt among them
EXTREMES = 24  # even points of a rim, of which its centre and width are taken


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
        diagonal or 4 spacings are not told from uneven sampling, and left out.
    """
    places = _even_level(points)
    if len(places) <= NORMAL_NEIGHBOURS:
        return np.zeros((0, 4))
    spacing = float(np.median(local_spacing(places)))
    normals, thickness = principal_normals(places, places, NORMAL_NEIGHBOURS)
    angles, nearest = free_angles(places, normals)
    certain = voted_border(angles, nearest)
    on_rim = np.flatnonzero((certain | (angles > FREE_ANGLE)) & (thickness < FLAT * spacing))
    narrowest = max(NARROWEST * robust_diagonal(points), NARROWEST_SPACINGS * spacing)
    found = [
        _centre_and_width(places[rim])
        for rim in _pieces(places, on_rim, LINK * spacing)
        if _is_rim(certain[rim])
    ]
    wide = sorted((rim for rim in found if rim[3] >= narrowest), key=lambda rim: -rim[3])
    return np.array(wide).reshape(-1, 4)


def _even_level(points: Points) -> Points:
    """Return means of voxels that turn with the cloud."""
    target = int(np.clip(len(points) // POINTS_A_PLACE, LEAST, MOST))
    centre, axes = principal_frame(points)
    labels, count = thin_by_voxels((points - centre) @ axes.T, target)
    return points if count == len(points) else voxel_means(points, labels, count)


def _is_rim(certain: Booleans) -> bool:
    """Tell a rim from a few chance gaps; a vote of neighbours finds most of it, but not all."""
    return len(certain) >= FEWEST and int(np.count_nonzero(certain)) >= FEWEST_CERTAIN


def _pieces(places: Points, on_rim: Indices, reach: float) -> list[Indices]:
    """Return the connected pieces of the rims."""
    if len(on_rim) == 0:
        return []
    pairs = cKDTree(places[on_rim]).query_pairs(reach, output_type="ndarray")
    links = coo_matrix((np.ones(len(pairs), dtype=bool), pairs.T), shape=(len(on_rim),) * 2)
    piece = connected_components(links, directed=False)[1]
    order = np.argsort(piece, kind="stable")
    return np.split(on_rim[order], np.flatnonzero(np.diff(piece[order])) + 1)


def _centre_and_width(rim: Points) -> Floats:
    """Return the mean of even points of a rim, and the largest distance between them."""
    extremes = rim[farthest_point_order(rim, EXTREMES)]
    width = np.linalg.norm(extremes[:, np.newaxis] - extremes, axis=2).max()
    return np.append(extremes.mean(axis=0), width)
