"""The recipe of a picture: draw, light, lay plane sheets over it, develop."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from meshlab_symrecon.arrays import Floats
from meshlab_symrecon.errors import ParameterError
from meshlab_symrecon.pictures.lighting import shade
from meshlab_symrecon.pictures.occlusion import ambient_light
from meshlab_symrecon.pictures.projection import Camera, Screen, open_screen
from meshlab_symrecon.pictures.scene import Item, PlaneSheet
from meshlab_symrecon.pictures.shadows import lit_share
from meshlab_symrecon.pictures.sheets import lay_sheets
from meshlab_symrecon.pictures.surface_buffer import GAMMA, SurfaceBuffer, draw

__all__ = ["BACKGROUND", "render"]

BACKGROUND = (250, 248, 245)  # paper
SUPERSAMPLING = 2  # samples a pixel, each way
LARGEST = 8192  # pixels a side: beyond this a picture takes more memory than it is worth


def render(
    items: Sequence[Item],
    camera: Camera,
    size: tuple[int, int] = (800, 1000),
    background: tuple[int, int, int] = BACKGROUND,
) -> NDArray[np.uint8]:
    """Draw clouds, meshes and plane sheets.

    Parameters
    ----------
    items : sequence of PointCloud, TriangleMesh, PlaneSheet
        What to draw, in any order.
    camera : Camera
        Where from; it is fitted to the items unless it is aimed.
    size : two ints
        Width and height in pixels.
    background : three ints
        sRGB, 0 to 255.

    Returns
    -------
    (height, width, 3) uint8
        sRGB; equal arguments give equal bytes.

    Raises
    ------
    ParameterError
        A size that is not from 1 to 8192 pixels.

    Notes
    -----
    Depths are kept at twice the resolution, which smooths the edges; occlusion and shadows, soft
    by nature, are reckoned at the picture's own.
    """
    width, height = size
    if not (1 <= width <= LARGEST and 1 <= height <= LARGEST):
        message = f"a picture needs 1 .. {LARGEST} pixels a side; got {size}; choose another size"
        raise ParameterError(message)
    paper = (np.array(background) / 255.0) ** GAMMA
    scene = [item.corners if isinstance(item, PlaneSheet) else item.points for item in items]
    if not sum(len(points) for points in scene):
        blank: NDArray[np.uint8] = np.full((height, width, 3), background, dtype=np.uint8)
        return blank
    fine = open_screen(camera, scene, width * SUPERSAMPLING, height * SUPERSAMPLING)
    seen = draw(items, fine, SUPERSAMPLING)
    light = _light(items, fine, seen)
    covered = np.isfinite(seen.depth)[..., None]
    colour = np.where(covered, seen.albedo * light[..., None], paper)
    sheets = [item for item in items if isinstance(item, PlaneSheet)]
    inks = [(np.array(sheet.colour) / 255.0) ** GAMMA for sheet in sheets]
    colour = lay_sheets(colour, seen.depth, sheets, fine, (inks, SUPERSAMPLING))
    return _develop(colour)


def _light(items: Sequence[Item], fine: Screen, seen: SurfaceBuffer) -> Floats:
    """Light every fine pixel; occlusion and shadows come from every second one."""
    step = SUPERSAMPLING
    if not np.isfinite(seen.depth).any():
        return np.ones_like(seen.depth)
    coarse = Screen(
        fine.axes, fine.target, fine.unit * step, fine.width // step, fine.height // step
    )
    depth = seen.depth[::step, ::step] / step
    normal = seen.normal[::step, ::step]
    sky = ambient_light(depth, normal)
    key = lit_share(items, coarse, depth, normal)
    sky, key = (np.repeat(np.repeat(grid, step, axis=0), step, axis=1) for grid in (sky, key))
    return shade(seen.normal, sky, key, seen.inside)


def _develop(colour: Floats) -> NDArray[np.uint8]:
    """Average the fine pixels and turn light into sRGB."""
    step = SUPERSAMPLING
    height, width = colour.shape[0] // step, colour.shape[1] // step
    mean = colour.reshape(height, step, width, step, 3).mean(axis=(1, 3))
    encoded: NDArray[np.uint8] = np.round(255.0 * mean.clip(0.0, 1.0) ** (1.0 / GAMMA)).astype(
        np.uint8
    )
    return encoded
