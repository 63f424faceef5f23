"""What a browser can draw: an upright frame near zero, a subset of points, a simpler surface."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from meshlab_symrecon.arrays import Faces, Floats, Indices, Points

__all__ = [
    "DIMMEST",
    "Frame",
    "Levels",
    "Singles",
    "even_subset",
    "shading",
    "simplified",
    "upright_frame",
]

Singles: TypeAlias = NDArray[np.float32]
Levels: TypeAlias = NDArray[np.uint8]

ROUNDS = 8  # of the search for a size of cells
SLACK = 0.85  # of the cells that are allowed: enough to stop searching
LIGHT = np.array([-0.45, -0.65, 0.62])  # from above the viewer's left shoulder
LIGHT = LIGHT / np.linalg.norm(LIGHT)
DIMMEST = 115  # of 255: what faces away gets so much light, so that it can still be seen


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """The frame of the view: right, away from the viewer, up; the object's box has diagonal 2."""

    origin: Floats  # (3,)  in the middle of the view
    axes: Floats  # (3, 3)  rows: right, away, up
    unit: float  # length of 1 in the view

    def place(self, points: Points) -> Singles:
        """Return (n, 3) positions in the view; the origin is taken off before they are rounded."""
        placed: Singles = self.turn((points - self.origin) / self.unit).astype(np.float32)
        return placed

    def turn(self, directions: Points) -> Points:
        """Return directions, (3,) or (n, 3), as they stand in the view."""
        turned: Points = directions @ self.axes.T
        return turned


def upright_frame(points: Points, up: Floats, direction: Floats) -> Frame:
    """Return the frame of a viewer who stands upright and looks roughly along a direction.

    Parameters
    ----------
    points : (n, 3) float
        Everything that is drawn.
    up, direction : (3,) float
        Not parallel; ``up`` is kept exactly.
    """
    upward = up / np.linalg.norm(up)
    away = direction - (direction @ upward) * upward
    away /= np.linalg.norm(away)
    axes = np.array([np.cross(away, upward), away, upward])
    low, high = points.min(axis=0), points.max(axis=0)
    half = float(np.linalg.norm(high - low)) / 2.0
    return Frame((low + high) / 2.0, axes, half if half > 0.0 else 1.0)


def even_subset(points: Points, most: int) -> Indices:
    """Return the indices of at most ``most`` points, one from each cell of a grid, in order."""
    if len(points) <= most:
        return np.arange(len(points))
    labels, _ = _cells(points, most)
    return np.sort(np.unique(labels, return_index=True)[1])


def simplified(
    points: Points, faces: Faces, values: Floats, most: int
) -> tuple[Points, Faces, Floats]:
    """Merge the vertices of a surface within the cells of a grid (Rossignac and Borrel 1993).

    Triangles folded onto each other, back to back, are left out: they would be drawn as dark
    specks. So would slivers, where neighbouring cells have nearly the same mean: every merged
    vertex moves halfway to the mean of its neighbours.

    Parameters
    ----------
    points, faces : (n, 3) float, (m, 3) int
    values : (n,) float
        Of the vertices; averaged as their positions are.
    most : int
        Vertices to keep; no surface that has as few is changed.
    """
    if len(points) <= most:
        return points, faces, values
    labels, count = _cells(points, most)
    members = np.bincount(labels, minlength=count)
    columns = np.column_stack([points, values])
    means = np.stack(
        [np.bincount(labels, weights=column, minlength=count) / members for column in columns.T],
        axis=1,
    )
    merged = labels[faces]
    a, b, c = merged.T
    kept = _unfolded(merged[(a != b) & (b != c) & (c != a)])
    return _smoothed(means[:, :3], kept), kept, means[:, 3]


def _unfolded(faces: Faces) -> Faces:
    """Return every triangle once, the way round in which there are more; none where both tie.

    What is left is closed where the faces were.
    """
    corners = np.sort(faces, axis=1)
    a, b, c = faces.T
    forward = ((a < b) & (b < c)) | ((b < c) & (c < a)) | ((c < a) & (a < b))
    single, group = np.unique(corners, axis=0, return_inverse=True)
    turns = np.bincount(group.reshape(-1), np.where(forward, 1.0, -1.0), len(single))
    return np.concatenate([single[turns > 0.0], single[turns < 0.0][:, [0, 2, 1]]])


def _smoothed(points: Points, faces: Faces) -> Points:
    """Return vertices halfway between their places and the mean of their neighbours."""
    start, end = faces.reshape(-1), np.roll(faces, -1, axis=1).reshape(-1)
    ends = np.concatenate([start, end, np.arange(len(points))])
    others = np.concatenate([end, start, np.arange(len(points))])  # itself, so that none has none
    count = np.bincount(ends, minlength=len(points))
    means = [
        np.bincount(ends, weights=points[others, axis], minlength=len(points)) / count
        for axis in range(3)
    ]
    return (points + np.stack(means, axis=1)) / 2.0


def _cells(points: Points, most: int) -> tuple[Indices, int]:
    """Label points with the occupied cells of a cubic grid, of which there are at most ``most``."""
    low = points.min(axis=0)
    size = float(np.linalg.norm(np.ptp(points, axis=0))) / np.sqrt(most)
    best: tuple[Indices, int] = np.zeros(len(points), dtype=np.int64), 1
    if not size > 0.0:
        return best
    for _ in range(ROUNDS):
        labels, count = _labelled(points - low, size)
        if best[1] < count <= most:
            best = labels, count
        if SLACK * most <= count <= most:
            break
        size *= float(np.clip(np.sqrt(count / (0.93 * most)), 0.25, 4.0))
    return best


def _labelled(points: Points, size: float) -> tuple[Indices, int]:
    cells = np.floor(points / size).astype(np.int64)
    extent = cells.max(axis=0) + 1
    keys = (cells[:, 0] * extent[1] + cells[:, 1]) * extent[2] + cells[:, 2]
    occupied, labels = np.unique(keys, return_inverse=True)
    return labels.reshape(-1).astype(np.int64), len(occupied)


def shading(normals: Points | None, points: Points, frame: Frame) -> Levels:
    """Return (n,) levels of light, from ``DIMMEST`` to 255, on points with these normals.

    Normals that point inward in the majority are turned over, all of them; without normals every
    point is fully lit.
    """
    if normals is None or not len(points):
        return np.full(len(points), 255, dtype=np.uint8)
    outward = np.einsum("ij,ij->i", normals, points - points.mean(axis=0)).sum()
    lengths = np.maximum(np.linalg.norm(normals, axis=1), np.finfo(float).tiny)
    facing = frame.turn(normals) @ LIGHT / lengths * (1.0 if outward >= 0.0 else -1.0)
    light = DIMMEST + (255.0 - DIMMEST) * (0.5 + 0.5 * np.clip(facing, -1.0, 1.0))
    levels: Levels = np.round(light).astype(np.uint8)
    return levels
