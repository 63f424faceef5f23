"""The z-buffer: which disc or triangle is nearest in every pixel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshlab_symrecon.arrays import Faces, Floats, Indices, Points

__all__ = ["DepthBuffer", "barycentric", "empty_buffer", "scan_convert", "splat_discs"]

CANDIDATES = 1 << 20  # pixels tested at once: 8 MB an array
ON_EDGE = 1e-9  # of a triangle: neighbours leave no crack between them


@dataclass(frozen=True, slots=True, eq=False)
class DepthBuffer:
    """What is nearest in every pixel; filled in place while a scene is drawn."""

    depth: Floats  # (height * width,)  pixels away from the viewer; infinite where nothing is
    item: Indices  # (height * width,)  index of the item, -1 where nothing is
    primitive: Indices  # (height * width,)  index of its point or triangle
    width: int
    height: int


def empty_buffer(width: int, height: int) -> DepthBuffer:
    """Return a buffer in which nothing is drawn yet."""
    count = width * height
    nothing = np.full(count, -1)
    return DepthBuffer(np.full(count, np.inf), nothing, nothing.copy(), width, height)


def _offer(
    buffer: DepthBuffer, item: int, pixels: Indices, depths: Floats, primitives: Indices
) -> None:
    """Keep, in every pixel, the nearest of what is there and what is offered."""
    before = buffer.depth[pixels]
    better = depths < before
    pixels, depths, primitives = pixels[better], depths[better], primitives[better]
    np.minimum.at(buffer.depth, pixels, depths)
    nearest = depths == buffer.depth[pixels]
    buffer.item[pixels[nearest]] = item
    buffer.primitive[pixels[nearest]] = primitives[nearest]


def splat_discs(buffer: DepthBuffer, item: int, projected: Points, radius: float) -> None:
    """Draw round discs of this radius, in pixels, that face the viewer."""
    reach = int(np.ceil(radius))
    steps = np.arange(-reach, reach + 1)
    columns, rows = (grid.ravel() for grid in np.meshgrid(steps, steps))
    own = (columns == 0) & (rows == 0)  # a disc smaller than a pixel is still seen
    batch = max(1, CANDIDATES // len(own))
    for start in range(0, len(projected), batch):
        centres = projected[start : start + batch]
        corner = np.floor(centres[:, :2]).astype(np.int64)
        rest = centres[:, :2] - corner - 0.5
        x, y = corner[:, :1] + columns, corner[:, 1:] + rows
        covered = (columns - rest[:, :1]) ** 2 + (rows - rest[:, 1:]) ** 2 <= radius**2
        covered |= own
        covered &= (x >= 0) & (x < buffer.width) & (y >= 0) & (y < buffer.height)
        which = np.nonzero(covered)[0]
        pixels = y[covered] * buffer.width + x[covered]
        _offer(buffer, item, pixels, centres[which, 2], start + which)


def barycentric(corners: Floats, x: Floats, y: Floats) -> Floats:
    """Return (n, 3) barycentric coordinates of pixels in (n, 3, 3) projected triangles."""
    first, second, third = corners[:, 0, :2], corners[:, 1, :2], corners[:, 2, :2]
    u, v = second - first, third - first
    area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    px, py = x - first[:, 0], y - first[:, 1]
    weight_second = (px * v[:, 1] - py * v[:, 0]) / area
    weight_third = (py * u[:, 0] - px * u[:, 1]) / area
    return np.column_stack([1.0 - weight_second - weight_third, weight_second, weight_third])


def scan_convert(buffer: DepthBuffer, item: int, projected: Points, faces: Faces) -> None:
    """Draw triangles.

    Triangles are tested against the pixels of their boxes, all boxes of about the same size
    (powers of two) at once, so that no Python loop runs over triangles.
    """
    corners = projected[faces]
    u, v = corners[:, 1, :2] - corners[:, 0, :2], corners[:, 2, :2] - corners[:, 0, :2]
    limits = np.array([buffer.width, buffer.height]) - 1
    low = np.clip(np.ceil(corners[:, :, :2].min(axis=1) - 0.5), 0, limits + 1).astype(np.int64)
    high = np.clip(np.floor(corners[:, :, :2].max(axis=1) - 0.5), -1, limits).astype(np.int64)
    spans = high - low + 1
    seen = (spans > 0).all(axis=1) & (u[:, 0] * v[:, 1] != u[:, 1] * v[:, 0])
    classes = np.ceil(np.log2(np.maximum(spans, 1))).astype(np.int64)
    for column_class, row_class in np.unique(classes[seen], axis=0):
        columns, rows = 1 << column_class, 1 << row_class
        alike = seen & (classes == (column_class, row_class)).all(axis=1)
        members = np.flatnonzero(alike)
        batch = max(1, CANDIDATES // (columns * rows))
        for start in range(0, len(members), batch):
            chosen = members[start : start + batch]
            box = np.arange(columns), np.arange(rows)
            _fill(buffer, item, corners[chosen], chosen, (low[chosen], box))


def _fill(
    buffer: DepthBuffer,
    item: int,
    corners: Floats,
    primitives: Indices,
    boxes: tuple[Indices, tuple[Indices, Indices]],
) -> None:
    """Offer the pixels of these triangles, looked for in boxes of one size."""
    low, (columns, rows) = boxes
    origin = corners[:, 0]
    u, v = corners[:, 1] - origin, corners[:, 2] - origin
    area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    second = np.column_stack([v[:, 1], -v[:, 0]]) / area[:, None]  # slopes across the picture
    third = np.column_stack([-u[:, 1], u[:, 0]]) / area[:, None]
    start = low + 0.5 - origin[:, :2]

    def plane(slopes: Floats, constant: Floats) -> Floats:
        across = constant[:, None] + slopes[:, :1] * columns
        planar: Floats = across[:, None, :] + (slopes[:, 1:] * rows)[:, :, None]
        return planar

    weight_second = plane(second, (second * start).sum(axis=1))
    weight_third = plane(third, (third * start).sum(axis=1))
    inside = (weight_second >= -ON_EDGE) & (weight_third >= -ON_EDGE)
    inside &= weight_second + weight_third <= 1.0 + ON_EDGE
    x, y = low[:, :1] + columns, low[:, 1:] + rows
    inside &= (x < buffer.width)[:, None, :] & (y < buffer.height)[:, :, None]
    which, row, column = np.nonzero(inside)
    pixels = y[which, row] * buffer.width + x[which, column]
    depths = origin[which, 2] + weight_second[inside] * u[which, 2]
    depths += weight_third[inside] * v[which, 2]
    _offer(buffer, item, pixels, depths, primitives[which])
