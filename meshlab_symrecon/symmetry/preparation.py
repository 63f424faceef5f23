"""Prepare a cloud: unit size, without clutter and plinth, even, with normals and borders."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from meshlab_symrecon import _native
from meshlab_symrecon.arrays import Booleans, Floats, Indices, Planes, Points
from meshlab_symrecon.errors import GeometryError
from meshlab_symrecon.geometry.bounds import robust_diagonal
from meshlab_symrecon.geometry.neighbours import (
    NearestField,
    border_points,
    nearest_field,
    principal_normals,
)
from meshlab_symrecon.geometry.sampling import (
    canonical_order,
    farthest_point_order,
    principal_frame,
    thin_by_voxels,
    voxel_means,
)
from meshlab_symrecon.symmetry.breaks import broken_off, on_plane, rim_plane
from meshlab_symrecon.symmetry.cleaning import without_clutter, without_plinth
from meshlab_symrecon.symmetry.orientation import orient

__all__ = ["PreparedCloud", "prepare"]

# All lengths of the prepared cloud are in robust diagonals of the cloud without clutter and plinth.
BASE_COUNT = 8_000  # points of the level that is searched
NOISY = 0.0025  # roughness of the surface above which the base points are smoothed
FIELD_CELL = 0.008  # edge of a cell of the nearest-point table
FIELD_MARGIN = 0.12  # width of its rim
FIELD_CELLS = 500_000
COPLANAR = 0.015  # distance from a sample's tangent plane within which another one is coplanar
COPLANAR_DIRECTION = np.cos(np.radians(10.0))
MANY_COPLANAR = 1.5  # medians of the number of coplanar samples: from there distinctness falls
RELIEF_RADII = (0.03, 0.05, 0.08)
LANDMARKS = 600  # even samples that stand for all


@dataclass(frozen=True, slots=True, eq=False)
class PreparedCloud:
    """An even cloud of unit size around the origin, along its principal axes."""

    points: Points  # (m, 3)
    normals: Points  # (m, 3)  unit, pointing outwards where ``oriented``
    oriented: Booleans  # (m,)  the sign of the normal is known
    border: Booleans  # (m,)  on the rim of a hole
    border_distance: Floats  # (m,)  to the nearest rim but that of a flat break, or infinite
    rim_plane: Floats | None  # (4,)  the plane on which most of the rims lie
    broken_off: Floats  # (4,)  what lies below this plane is missing
    samples: Indices  # (s,)  farthest-point order: each beginning is an even sample
    distinctness: Floats  # (s,)  below 1 for a sample on an unusually large flat face
    relief: Floats  # (m, 3)  height of the centroid of a ball above the tangent plane, in radii
    root_covariance: Floats  # (3, 3)  square root of the covariance of the points
    spacing: float  # median distance to the nearest point
    roughness: float  # median deviation from the local planes: noise and bending
    field: NearestField
    on_plinth: bool  # a plinth was left out
    axes: Floats  # (3, 3)  rows: its axes, in the coordinates of the input
    centre: Floats  # (3,)  its origin, in the coordinates of the input
    scale: float  # its diagonal, in the units of the input

    @property
    def broken(self) -> bool:
        """Whether the cloud ends at a flat break."""
        return bool(self.broken_off[:3].any())

    def from_input(self, planes: Planes) -> Planes:
        """Return planes (k, 4) of the input in the coordinates of this cloud."""
        offsets = (planes[:, 3] + planes[:, :3] @ self.centre) / self.scale
        return np.column_stack([planes[:, :3] @ self.axes.T, offsets])

    def to_input(self, planes: Planes) -> Planes:
        """Return planes (k, 4) of this cloud in the coordinates of the input."""
        normals = planes[:, :3] @ self.axes
        return np.column_stack([normals, planes[:, 3] * self.scale - normals @ self.centre])


def prepare(
    points: Points, normals: Points | None, sample_count: int, *, plinth: bool = False
) -> PreparedCloud:
    """Bring a cloud to the form that the search works on.

    Parameters
    ----------
    points : (n, 3) float
        The scan, not flat.
    normals : (n, 3) float or None
        Outward normals; only their sides are used, since directions are fitted anew.
    sample_count : int
        Number of even samples to order.
    plinth : bool
        What looks like a plinth belongs to the shape.

    Returns
    -------
    PreparedCloud
        The same for any order of the points and any number of copies of them, up to rounding for
        any position and size.

    Raises
    ------
    GeometryError
        Nearly all points in one place, beside stray ones far away.
    """
    body = _body(points, normals, plinth=plinth)
    dense, sides = body.points, body.normals
    base = _base_level(dense)
    places, directions, roughness = _smooth_surface(dense, dense[base])
    directions, oriented = orient(places, directions, None if sides is None else sides[base])
    border = border_points(places, directions)
    spacing = float(np.median(cKDTree(places).query(places, k=2)[0][:, 1]))
    rims = rim_plane(places, border, spacing)
    ended = broken_off(places, border, rims, spacing)
    samples = farthest_point_order(places, sample_count)
    return PreparedCloud(
        points=places,
        normals=directions,
        oriented=oriented,
        border=border,
        border_distance=_to_holes(places, border, rims if ended[:3].any() else None, spacing),
        rim_plane=rims,
        broken_off=ended,
        samples=samples,
        distinctness=_distinctness(places[samples], directions[samples]),
        relief=np.stack([_native.relief(places, directions, r) for r in RELIEF_RADII], axis=1),
        root_covariance=_root_covariance(places),
        spacing=spacing,
        roughness=roughness,
        field=nearest_field(places, FIELD_CELL, FIELD_MARGIN, FIELD_CELLS),
        on_plinth=body.on_plinth,
        axes=body.frame.axes,
        centre=body.frame.centre,
        scale=body.frame.unit,
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Frame:
    centre: Floats  # (3,)
    axes: Floats  # (3, 3)  rows
    unit: float


@dataclass(frozen=True, slots=True, eq=False)
class _Body:
    points: Points  # (n, 3)  in the frame
    normals: Points | None  # (n, 3)  likewise
    frame: _Frame
    on_plinth: bool  # a plinth was left out


def _body(points: Points, normals: Points | None, *, plinth: bool) -> _Body:
    """Return a scan in its own frame, of unit size, without copies, clutter and plinth."""
    order = _order_of_distinct(points)
    points = points[order]
    frame = _frame(points)
    framed = (points - frame.centre) @ frame.axes.T / frame.unit
    sides = None if normals is None else normals[order] @ frame.axes.T
    turned = canonical_order(framed)  # the order follows motions, too
    framed, sides = framed[turned], None if sides is None else sides[turned]
    dense, sides = without_clutter(framed, sides)
    everything = len(dense)
    if not plinth:
        dense, sides = without_plinth(dense, sides)
    shift, size = dense.mean(axis=0), robust_diagonal(dense)
    if size == 0.0:
        message = (
            "detection of reflection planes needs points all over a body; got nearly all of "
            f"{len(points)} points in one place; remove stray points far away"
        )
        raise GeometryError(message)
    centre = frame.centre + (frame.unit * shift) @ frame.axes
    own = _Frame(centre, frame.axes, frame.unit * size)
    return _Body((dense - shift) / size, sides, own, on_plinth=len(dense) < everything)


def _order_of_distinct(points: Points) -> Indices:
    """Order points alike for every permutation; of those that coincide, only one is left."""
    order = canonical_order(points)
    steps = (points[order[1:]] != points[order[:-1]]).any(axis=1)
    return order[np.append(True, steps)]


def _frame(points: Points) -> _Frame:
    """Return a frame that follows the cloud: what is done in it follows every motion."""
    centre, axes = principal_frame(points)
    return _Frame(centre, axes, robust_diagonal(points @ axes.T))


def _to_holes(places: Points, border: Booleans, flat: Floats | None, spacing: float) -> Floats:
    """Return distances to the nearest rim, leaving out that of a flat break."""
    holes = places[border]
    if flat is not None:
        holes = holes[~on_plane(holes, flat, spacing)]
    if len(holes) == 0:
        return np.full(len(places), np.inf)
    distances: Floats = cKDTree(holes).query(places)[0]
    return distances


def _root_covariance(places: Points) -> Floats:
    variances, vectors = np.linalg.eigh(np.cov(places.T, bias=True))
    root: Floats = (vectors * np.sqrt(np.maximum(variances, 0.0))) @ vectors.T
    return root


def _base_level(points: Points) -> Indices:
    """Choose from each voxel the point nearest to the mean of its points."""
    labels, count = thin_by_voxels(points, BASE_COUNT)
    off_centre = ((points - voxel_means(points, labels, count)[labels]) ** 2).sum(axis=1)
    order = np.lexsort((off_centre, labels))
    first = np.flatnonzero(np.diff(labels[order], prepend=-1))
    chosen: Indices = order[first]
    return chosen


def _smooth_surface(dense: Points, places: Points) -> tuple[Points, Points, float]:
    """Fit normals; where the cloud is noisy, project the places on the fitted planes as well."""
    neighbours = int(np.clip(len(dense) // 400, 16, 40))
    normals, deviations = principal_normals(dense, places, neighbours)
    roughness = float(np.median(deviations))
    if roughness <= NOISY:
        return places, normals, roughness
    neighbours = int(np.clip(len(dense) // 120, 40, 60))
    tree = cKDTree(dense)
    for _ in range(2):
        members = dense[tree.query(places, k=min(neighbours, len(dense)))[1]]
        normals, _ = principal_normals(dense, places, neighbours)
        heights = np.einsum("mi,mi->m", members.mean(axis=1) - places, normals)
        places = places + heights[:, np.newaxis] * normals
    return places, normals, roughness


def _distinctness(points: Points, normals: Points) -> Floats:
    """Weigh samples down where unusually many others are coplanar: on a plinth, say."""
    places, directions = points[:LANDMARKS], normals[:LANDMARKS]
    heights = np.einsum("si,si->s", points, normals)[:, np.newaxis] - normals @ places.T
    coplanar = np.abs(heights) < COPLANAR
    coplanar &= np.abs(normals @ directions.T) > COPLANAR_DIRECTION
    counts = np.maximum(coplanar.sum(axis=1), 1)
    weights: Floats = np.minimum(1.0, MANY_COPLANAR * np.median(counts) / counts)
    return weights
