"""What the viewer sees in every pixel: depth, colour and normal of the nearest surface."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from meshlab_symrecon.arrays import Booleans, Faces, Floats, Points
from meshlab_symrecon.pictures.projection import Screen
from meshlab_symrecon.pictures.rasterisation import (
    DepthBuffer,
    barycentric,
    empty_buffer,
    scan_convert,
    splat_discs,
)
from meshlab_symrecon.pictures.relief import relief_normals, smooth_relief
from meshlab_symrecon.pictures.scene import Item, PointCloud, TriangleMesh

__all__ = ["SurfaceBuffer", "draw", "vertex_normals"]

GAMMA = 2.2  # sRGB to light, near enough for pictures


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceBuffer:
    """One value a pixel; normals are in the camera's frame (right, up, towards the viewer)."""

    depth: Floats  # (height, width)  pixels away from the viewer; infinite where nothing is
    albedo: Floats  # (height, width, 3)  share of light that is thrown back, 0..1
    normal: Floats  # (height, width, 3)  unit, turned towards the viewer
    inside: Booleans  # (height, width)  the back of the surface is seen


def vertex_normals(points: Points, faces: Faces) -> Points:
    """Return unit normals of the vertices, means of their triangles weighted by area."""
    corners = points[faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    sums = np.column_stack(
        [
            np.bincount(faces.ravel(), np.repeat(across[:, axis], 3), minlength=len(points))
            for axis in range(3)
        ]
    )
    return unit(sums)


def unit(vectors: ArrayLike) -> Floats:
    """Scale the rows to length one; zero stays zero."""
    rows = np.asarray(vectors, dtype=np.float64)
    lengths = np.linalg.norm(rows, axis=-1, keepdims=True)
    scaled: Floats = rows / np.maximum(lengths, np.finfo(float).tiny)
    return scaled


def draw(items: Sequence[Item], screen: Screen, scale: float) -> SurfaceBuffer:
    """Draw clouds and meshes; plane sheets are left out.

    Parameters
    ----------
    items : sequence
        What to draw.
    screen : Screen
        The pixels to draw on.
    scale : float
        How many of these pixels make one pixel of the picture (discs are measured in those).
    """
    buffer = empty_buffer(screen.width, screen.height)
    for index, item in enumerate(items):
        if isinstance(item, PointCloud):
            splat_discs(buffer, index, screen.project(item.points), item.radius * scale)
        elif isinstance(item, TriangleMesh):
            scan_convert(buffer, index, screen.project(item.points), item.faces)
    return _resolve(items, screen, buffer, scale)


def _resolve(
    items: Sequence[Item], screen: Screen, buffer: DepthBuffer, scale: float
) -> SurfaceBuffer:
    """Look up colour and normal of the winner of every pixel."""
    depth = buffer.depth.copy()
    albedo = np.ones((len(depth), 3))
    normal = np.tile([0.0, 0.0, 1.0], (len(depth), 1))
    for index, item in enumerate(items):
        pixels = np.flatnonzero(buffer.item == index)
        won = buffer.primitive[pixels]
        if isinstance(item, TriangleMesh):
            corners = screen.project(item.points)[item.faces[won]]
            rows, columns = np.divmod(pixels, screen.width)
            weights = barycentric(corners, columns + 0.5, rows + 0.5)
            light = ((item.colours / 255.0) ** GAMMA)[item.faces[won]]
            albedo[pixels] = np.einsum("nk,nkc->nc", weights, light).clip(0.0, 1.0)
            turned = (vertex_normals(item.points, item.faces) @ screen.axes.T)[item.faces[won]]
            normal[pixels] = unit(np.einsum("nk,nkc->nc", weights, turned))
        elif isinstance(item, PointCloud):
            albedo[pixels] = ((item.colours / 255.0) ** GAMMA)[won]
            if item.normals is not None:
                normal[pixels] = unit(item.normals @ screen.axes.T)[won]
            else:
                mask = (buffer.item == index).reshape(screen.height, screen.width)
                smooth = smooth_relief(depth.reshape(mask.shape), mask, item.radius * scale)
                depth[pixels] = smooth[mask]
                normal[pixels] = relief_normals(smooth)[mask]
    inside = normal[:, 2] < 0.0
    normal[inside] *= -1.0
    shape = (screen.height, screen.width)
    return SurfaceBuffer(
        depth.reshape(shape),
        albedo.reshape(*shape, 3),
        normal.reshape(*shape, 3),
        inside.reshape(shape),
    )
