"""Normals for points that have none: the relief that their discs form on the screen."""

from __future__ import annotations

import numpy as np

from meshlab_symrecon.arrays import Booleans, Floats

__all__ = ["relief_normals", "shifted", "smooth_relief"]

STEEP = 4.0  # pixels of depth a pixel: more than this is another surface


def shifted(grid: Floats, rows: int, columns: int, outside: float) -> Floats:
    """Return the grid moved so that cell (r, c) holds what was at (r + rows, c + columns)."""
    moved = np.full_like(grid, outside)
    height, width = grid.shape
    if abs(rows) < height and abs(columns) < width:
        here = slice(max(0, -rows), height - max(0, rows))
        across = slice(max(0, -columns), width - max(0, columns))
        there = slice(max(0, rows), height - max(0, -rows))
        beyond = slice(max(0, columns), width - max(0, -columns))
        moved[here, across] = grid[there, beyond]
    return moved


def smooth_relief(depth: Floats, mask: Booleans, radius: float) -> Floats:
    """Average depths within the mask over about two radii, but not across steps.

    Parameters
    ----------
    depth : (height, width) float
        In pixels.
    mask : (height, width) bool
        The pixels of the cloud; the others do not count and are infinite in the result.
    radius : float
        Of a disc, in pixels.

    Notes
    -----
    A bilateral filter: a pixel counts less the more its depth differs, and nothing beyond the
    steepest slope taken for one surface. The taps come closer by half from pass to pass (a trous),
    the last ones side by side, so that no weave is left between them.
    """
    smooth = np.where(mask, depth, np.inf)
    widest = max(1, int(round(radius)))
    strides = [widest >> halving for halving in range(widest.bit_length())]
    for stride in strides:
        total, weights = np.zeros_like(smooth), np.zeros_like(smooth)
        for rows in (-stride, 0, stride):
            for columns in (-stride, 0, stride):
                there = shifted(smooth, rows, columns, np.inf)
                with np.errstate(invalid="ignore"):
                    step = (there - smooth) / (STEEP * stride)
                    weight = np.where(np.abs(step) < 1.0, (1.0 - step * step) ** 2, 0.0)
                    total += np.where(weight > 0.0, weight * there, 0.0)
                weights += weight
        smooth = np.where(mask, total / np.maximum(weights, np.finfo(float).tiny), np.inf)
    return smooth


def relief_normals(depth: Floats) -> Floats:
    """Return (height, width, 3) unit normals of a relief, all turned towards the viewer.

    Of the two one-sided differences the flatter one is taken, so that a silhouette does not
    bend the normals beside it.
    """
    slopes = []
    for rows, columns in ((0, 1), (1, 0)):
        with np.errstate(invalid="ignore"):
            ahead = shifted(depth, rows, columns, np.inf) - depth
            behind = depth - shifted(depth, -rows, -columns, np.inf)
        ahead, behind = (np.where(np.isfinite(side), side, np.inf) for side in (ahead, behind))
        flatter = np.where(np.abs(ahead) < np.abs(behind), ahead, behind)
        both = np.isfinite(ahead) & np.isfinite(behind)
        close = both & (np.abs(ahead - np.where(both, behind, 0.0)) < STEEP)
        mean = 0.5 * (np.where(close, ahead, 0.0) + np.where(close, behind, 0.0))
        slopes.append(np.where(close, mean, np.where(np.isfinite(flatter), flatter, 0.0)))
    across, down = slopes
    normal = np.stack([across, -down, np.ones_like(depth)], axis=-1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    return normal
