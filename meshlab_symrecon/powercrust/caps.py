"""Caps: where a closed surface spans a hole of the scan.

A reconstruction closes what the scanner never saw.  Such a region lies farther from every sample
than the sampling explains; how far, at most, is half the width of the hole.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from meshlab_symrecon import _native
from meshlab_symrecon.arrays import Faces, Floats, Indices, Points
from meshlab_symrecon.geometry.surfaces import face_components

__all__ = ["Caps", "farthest_points", "find_caps"]

EXPLAINED = 1.5  # spacings: about one in a hundred triangles of random samples is farther off
FLAT = 1e-12  # height of a triangle over its longest side, squared
STEPS = 4  # of the grid over a large triangle


@dataclass(frozen=True, slots=True, eq=False)
class Caps:
    """Regions of a surface that span holes.

    Attributes
    ----------
    region : (m,) int
        The region of each face, -1 for faces near the samples.
    widths : (k,) float
        Diameter of the largest ball with its centre on each region that holds no sample, in the
        units of the points: the diameter of a round hole, the width of a slit.
    spacings : (k,) float
        Mean spacing of the samples round each region.
    """

    region: Indices
    widths: Floats
    spacings: Floats

    @property
    def multiples(self) -> Floats:
        """(k,) widths in multiples of the spacing there; randomness alone reaches about six."""
        return self.widths / self.spacings

    @property
    def largest(self) -> float:
        """The width of the widest region in multiples of the spacing there; 0 without any."""
        return float(self.multiples.max(initial=0.0))


def find_caps(
    points: Points, faces: Faces, nearest: Indices, samples: Points, spacing: Floats
) -> Caps:
    """Find the regions of a surface that are farther from the samples than the sampling explains.

    Parameters
    ----------
    points : (v, 3) float
    faces : (m, 3) int
    nearest : (v,) int
        The sample nearest to each point, or nearly.
    samples : (n, 3) float
        What the surface was made from; its vertices need not be among them.
    spacing : (n,) float
        Distance from each sample to those round it, positive: the mean of a few neighbours.
    """
    far = _native.far_faces(
        points,
        faces.astype(np.int32),
        nearest.astype(np.int32),
        samples,
        spacing,
        EXPLAINED,
    )
    local = spacing[nearest[faces[far]]].max(axis=1, initial=0.0)
    gaps = _gaps(points, faces[far], samples)
    explained = gaps <= EXPLAINED * local  # another sample is nearer
    far, local, gaps = far[~explained], local[~explained], gaps[~explained]
    count, piece = face_components(faces[far])
    region = np.full(len(faces), -1, dtype=np.int64)
    region[far] = piece
    widest = np.zeros(count)
    np.maximum.at(widest, piece, gaps)
    members = np.bincount(piece, minlength=count)
    return Caps(region, 2.0 * widest, np.bincount(piece, local, minlength=count) / members)


def _gaps(points: Points, faces: Faces, samples: Points) -> Floats:
    """Return (m,) the largest distance to the samples that is met on each triangle."""
    if not len(faces):
        return np.zeros(0)
    tree = cKDTree(samples, balanced_tree=False, compact_nodes=False)
    places = np.concatenate(
        [points[faces], farthest_points(points, faces)[0][:, None], _grid(points[faces])], axis=1
    )
    gaps: Floats = tree.query(places)[0].max(axis=1)
    return gaps


def farthest_points(points: Points, faces: Faces) -> tuple[Points, Floats]:
    """Return the point of each triangle that is farthest from its corners, and how far.

    It is the circumcentre unless an angle is obtuse; then it is where the bisector of one of the
    two shorter sides meets the longest side.

    Parameters
    ----------
    points : (v, 3) float
    faces : (m, 3) int

    Returns
    -------
    farthest : (m, 3) float
    reach : (m,) float
        Distance to the nearest corner.
    """
    corners = points[faces]
    sides = np.stack([((corners[:, k - 1] - corners[:, k - 2]) ** 2).sum(axis=1) for k in range(3)])
    apex = sides.argmax(axis=0)  # side k lies opposite corner k; the longest has the widest angle
    rows = np.arange(len(faces))
    top, left, right = (corners[rows, (apex + k) % 3] for k in range(3))
    to_top, base = top - left, right - left
    # of the base, from the left: where the bisectors of the other two sides meet it
    length = np.maximum((base**2).sum(axis=1), np.finfo(float).tiny)
    foot = (to_top * base).sum(axis=1) / length
    height = (to_top**2).sum(axis=1) / length - foot**2
    first = 0.5 * (foot + height / np.maximum(foot, 0.5**50))
    last = 1.0 - 0.5 * (1.0 - foot + height / np.maximum(1.0 - foot, 0.5**50))
    from_left = np.where(first >= 1.0 - last, first, last)
    obtuse = left + from_left[:, None] * base
    # the circumcentre lies on the base's bisector, where it is as far from the top as from the ends
    up = to_top - foot[:, None] * base
    rise = 0.5 * (1.0 - foot * (1.0 - foot) / np.maximum(height, FLAT))
    acute = 0.5 * (left + right) + rise[:, None] * up
    farthest = np.where((rise > 0.0)[:, None], acute, obtuse)
    reach = np.linalg.norm(corners - farthest[:, None], axis=2).min(axis=1)
    return farthest, reach


def _grid(corners: Floats) -> Floats:
    """Return (m, k, 3) points spread over triangles given by their corners, (m, 3, 3)."""
    shares = [(a, b, STEPS - a - b) for a in range(STEPS + 1) for b in range(STEPS + 1 - a)]
    grid: Floats = np.array(shares, dtype=float) / STEPS @ corners
    return grid
