"""Soft shadows of the key light: the scene is seen once more, from the light."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from meshlab_symrecon.arrays import Floats, Points
from meshlab_symrecon.pictures.lighting import KEY
from meshlab_symrecon.pictures.occlusion import GOLDEN_ANGLE
from meshlab_symrecon.pictures.projection import Camera, Screen, open_screen
from meshlab_symrecon.pictures.rasterisation import empty_buffer, scan_convert, splat_discs
from meshlab_symrecon.pictures.scene import Item, PointCloud, TriangleMesh

__all__ = ["lit_share"]

RESOLUTION = 900  # pixels a side of the light's picture
TAPS = 24
SOFTNESS = 0.016  # of the light's picture: radius of the penumbra
BIAS = 0.006  # of the light's picture: a surface does not shade itself


def lit_share(items: Sequence[Item], screen: Screen, depth: Floats, normal: Floats) -> Floats:
    """Return (height, width) shares of the key light that reach each pixel, 0..1.

    Parameters
    ----------
    items : sequence
        What throws shadows; plane sheets throw none.
    screen : Screen
        The picture's pixels.
    depth : (height, width) float
        In its pixels; infinite where nothing is.
    normal : (height, width, 3) float
        Unit normals in the camera's frame.
    """
    solid = [item for item in items if isinstance(item, PointCloud | TriangleMesh)]
    direction, up = -KEY @ screen.axes, screen.axes[1]
    camera = Camera((direction[0], direction[1], direction[2]), (up[0], up[1], up[2]))
    light = open_screen(camera, [item.points for item in solid], RESOLUTION, RESOLUTION)
    nearest = _depths_from_light(solid, light, screen.unit)
    rows, columns = np.nonzero(np.isfinite(depth))
    facing = normal[rows, columns]
    seen = screen.unproject(np.column_stack([columns + 0.5, rows + 0.5, depth[rows, columns]]))
    raised = seen + facing @ screen.axes * (BIAS * RESOLUTION * light.unit)
    share = np.ones_like(depth)
    share[rows, columns] = _soft_comparison(nearest, light.project(raised))
    return share


def _depths_from_light(items: Sequence[Item], light: Screen, pixel: float) -> Floats:
    """Return the (RESOLUTION, RESOLUTION) depths that the light sees."""
    buffer = empty_buffer(RESOLUTION, RESOLUTION)
    for index, item in enumerate(items):
        if isinstance(item, PointCloud):
            radius = item.radius * pixel / light.unit
            splat_discs(buffer, index, light.project(item.points), radius)
        elif isinstance(item, TriangleMesh):
            scan_convert(buffer, index, light.project(item.points), item.faces)
    return buffer.depth.reshape(RESOLUTION, RESOLUTION)


def _soft_comparison(nearest: Floats, projected: Points) -> Floats:
    """Return the share of taps round each projected point behind which nothing is hidden."""
    lit = np.zeros(len(projected))
    for tap in range(TAPS):
        distance = SOFTNESS * RESOLUTION * np.sqrt((tap + 0.5) / TAPS)
        angle = tap * GOLDEN_ANGLE
        columns = np.floor(projected[:, 0] + distance * np.cos(angle)).astype(np.int64)
        rows = np.floor(projected[:, 1] + distance * np.sin(angle)).astype(np.int64)
        columns, rows = columns.clip(0, RESOLUTION - 1), rows.clip(0, RESOLUTION - 1)
        slack = BIAS * RESOLUTION + distance  # a penumbra as wide as this on a slope of 45 degrees
        lit += projected[:, 2] <= nearest[rows, columns] + slack
    return lit / TAPS
