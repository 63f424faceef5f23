"""Translucent plane sheets, laid over the picture where nothing hides them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from meshlab_symrecon.arrays import Floats
from meshlab_symrecon.pictures.projection import Screen
from meshlab_symrecon.pictures.scene import PlaneSheet

__all__ = ["lay_sheets"]

EDGE_ON = 1e-9  # square pixels: a sheet seen from its side is not drawn
CUT_OPACITY = 0.9  # of borders and of the line in which the sheet cuts the object


def lay_sheets(
    colour: Floats,
    depth: Floats,
    sheets: Sequence[PlaneSheet],
    screen: Screen,
    layer: tuple[Sequence[Floats], float],
) -> Floats:
    """Blend sheets over a picture, the farthest first in every pixel.

    Parameters
    ----------
    colour : (height, width, 3) float
        Linear light of the picture so far.
    depth : (height, width) float
        In pixels; infinite where nothing is.
    sheets : sequence of PlaneSheet
        Any number; they may cross.
    screen : Screen
        The picture's pixels.
    layer : (inks, scale)
        Linear colour of each sheet, and how many of these pixels make one of the picture.
    """
    inks, scale = layer
    if not sheets:
        return colour
    drawn = [_coverage(sheet, depth, screen, scale) for sheet in sheets]
    depths = np.stack([sheet_depth for sheet_depth, _ in drawn])
    covers = np.stack([cover for _, cover in drawn])
    order = np.argsort(-depths, axis=0, kind="stable")
    palette = np.array(inks)
    blended = colour
    for turn in order:
        cover = np.take_along_axis(covers, turn[None], axis=0)[0][..., None]
        blended = (1.0 - cover) * blended + cover * palette[turn]
    return blended


def _coverage(
    sheet: PlaneSheet, depth: Floats, screen: Screen, scale: float
) -> tuple[Floats, Floats]:
    """Return depth and opacity of one sheet in every pixel; it is clear where it is hidden."""
    corners = screen.project(sheet.corners)
    origin, u, v = corners[0], corners[1] - corners[0], corners[3] - corners[0]
    area = u[0] * v[1] - u[1] * v[0]
    if abs(area) < EDGE_ON:
        return np.full_like(depth, np.inf), np.zeros_like(depth)
    x = np.arange(screen.width) + 0.5 - origin[0]
    y = (np.arange(screen.height) + 0.5 - origin[1])[:, None]
    along, up = (x * v[1] - y * v[0]) / area, (y * u[0] - x * u[1]) / area
    sheet_depth = origin[2] + along * u[2] + up * v[2]
    within = (along >= 0.0) & (along <= 1.0) & (up >= 0.0) & (up <= 1.0)
    to_side = np.minimum(along, 1.0 - along) * abs(area) / np.hypot(v[0], v[1])
    to_end = np.minimum(up, 1.0 - up) * abs(area) / np.hypot(u[0], u[1])
    width = sheet.border * scale
    lines = np.minimum(to_side, to_end) < width
    steepness = np.hypot(*np.linalg.solve(np.array([u[:2], v[:2]]), np.array([u[2], v[2]])))
    with np.errstate(invalid="ignore"):
        lines |= np.abs(depth - sheet_depth) < width * max(1.0, steepness)
    visible = within & (sheet_depth <= depth)
    opacity = np.where(lines, max(CUT_OPACITY, sheet.opacity), sheet.opacity)
    return sheet_depth, np.where(visible, opacity, 0.0)
