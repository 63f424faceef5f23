"""What of a scan is worth copying: the statue, not clutter in the air or a plinth under it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from meshlab_symrecon.arrays import Booleans, Floats, Points
from meshlab_symrecon.geometry.bounds import robust_diagonal
from meshlab_symrecon.geometry.neighbours import NearestField, blocks, principal_normals
from meshlab_symrecon.geometry.planes import reflect, signed_distances
from meshlab_symrecon.symmetry.cleaning import without_clutter
from meshlab_symrecon.symmetry.plinth import FACE_WIDTH, plinth_top

__all__ = ["off_lopsided_plinth", "on_surface", "standing_plane"]

ALONE = 3.0  # times the usual distance to the neighbours
USUAL = 0.25  # quantile of it; clutter is the sparser part, and may be half
APART = 2.0  # times the distance that is usual among its neighbours
FLAT_NEIGHBOURS = 16
FLAT = 0.15  # thickness / width of a neighbourhood: sparsely measured surface, not scatter
PLINTH_SPACINGS = 2.0  # above the top of a plinth, where the statue begins
PROBES = 4_000  # points of a plinth that are mirrored to see whether it has the plane, too
ON_ITSELF = 2.5  # spacings between the image of a plinth's point and the plinth
LEAST_ON_ITSELF = 0.25  # share of such images; a hole takes some away, on one side of the plane
TURNED = 0.02  # share of the others on either side: a plinth turned against the statue has both


def on_surface(points: Points, width: Floats, nearest: NDArray[np.integer[Any]]) -> Booleans:
    """Tell the points on measured surfaces from those scattered in space.

    Parameters
    ----------
    points : (n, 3) float
        The scan.
    width : (n,) float
        Mean distance of each to the nearest other points.
    nearest : (n, k) int
        Which those are.

    Returns
    -------
    (n,) bool
        False for a point much farther from its neighbours than they are from theirs, and for one
        far from all others where they form no surface.
    """
    apart = np.zeros(len(points), dtype=bool)
    for rows in blocks(len(points)):
        apart[rows] = width[rows] > APART * np.median(width[nearest[rows]], axis=1)
    alone = np.flatnonzero((width > ALONE * np.quantile(width, USUAL)) & ~apart)
    if len(alone):
        thickness = principal_normals(points, points[alone], FLAT_NEIGHBOURS)[1]
        apart[alone] = thickness > FLAT * width[alone]
    together: Booleans = ~apart
    return together


def standing_plane(points: Points) -> Floats | None:
    """Find the top of a plinth in a scan, with a margin for the scatter of its points.

    Parameters
    ----------
    points : (n, 3) float
        The scan, or an even part of it.

    Returns
    -------
    (4,) float or None
        What lies on or below this plane is plinth, in the coordinates of the scan; None without a
        plinth.
    """
    centre, size = points.mean(axis=0), robust_diagonal(points)
    if size <= 0.0:
        return None
    framed = without_clutter((points - centre) / size, None)[0]
    top = plinth_top(framed)
    if top is None:
        return None
    spacing = float(np.median(cKDTree(framed).query(framed, k=2)[0][:, 1]))
    margin = min(PLINTH_SPACINGS * spacing, FACE_WIDTH)
    return np.append(top[:3], (top[3] - margin) * size - top[:3] @ centre)


def off_lopsided_plinth(
    points: Points, field: NearestField, spacing: float, standing: Floats, plane: Floats
) -> Booleans:
    """Tell which points may be mirrored although the statue stands on a plinth.

    Parameters
    ----------
    points : (n, 3) float
        The scan.
    field : NearestField
        Of these points.
    spacing : float
        Of these points.
    standing : (4,) float
        The plane that the statue stands on.
    plane : (4,) float
        The mirror plane.

    Returns
    -------
    (n,) bool
        False on a plinth that is not its own mirror image; all true where it is.
    """
    above = signed_distances(points, standing) > 0.0
    plinth = np.flatnonzero(~above)
    probes = plinth[:: max(1, len(plinth) // PROBES)]
    if len(probes) == 0:
        return above
    images = reflect(points[probes], plane)
    partners = field.closest(images)
    near = np.linalg.norm(points[partners] - images, axis=1) < ON_ITSELF * spacing
    beside = ~near | above[partners]
    left = signed_distances(points[probes], plane) < 0.0
    turned = min((beside & left).mean(), (beside & ~left).mean())
    on_itself = beside.mean() <= 1.0 - LEAST_ON_ITSELF and turned < TURNED
    return np.ones(len(points), dtype=bool) if on_itself else above
