"""Where to stand: a camera that shows the side on which points are missing."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from meshlab_symrecon.arrays import Booleans, Floats, Planes, Points
from meshlab_symrecon.pictures.projection import Camera, Screen, open_screen
from meshlab_symrecon.pictures.rasterisation import empty_buffer, splat_discs

__all__ = ["disc_radius", "upright", "view_of_missing_side", "views_of_both_sides"]

NEARLY = np.cos(np.radians(25.0))  # a scan that leans less than this was stood on its axis
AZIMUTH = np.radians(38.0)  # from straight ahead towards the missing side
ELEVATION = np.radians(7.0)  # the viewer looks down a little
TRIAL = 160  # pixels a side of the trial pictures
CELL = 8  # pixels: the grid on which points are counted
COVER = 1.3  # spacings: discs of this radius close the surface


def upright(points: Points, planes: Planes) -> Floats:
    """Guess what is up: the longest principal axis within the mirror plane.

    The nearest coordinate axis gives the sign, and the direction as well if it leans less than
    25 degrees, as scans are usually stood upright on an axis.

    Parameters
    ----------
    points : (n, 3) float
        The object.
    planes : (k, 4) float
        The best one first; without any the longest principal axis of all is taken.

    Returns
    -------
    (3,) float
        Of unit length.
    """
    flatten = np.eye(3)
    if len(planes):
        flatten -= np.outer(planes[0, :3], planes[0, :3])
    spread = flatten @ np.cov((points - points.mean(axis=0)).T) @ flatten
    axis: Floats = np.linalg.eigh(spread)[1][:, -1]
    nearest = int(np.argmax(np.abs(axis)))
    if axis[nearest] < 0.0:
        axis = -axis
    standing = flatten[nearest] / max(float(np.linalg.norm(flatten[nearest])), 1e-12)
    return standing if standing @ axis > NEARLY else axis


def _camera(ahead: Floats, aside: Floats, up: Floats) -> Camera:
    level = np.cos(AZIMUTH) * ahead + np.sin(AZIMUTH) * aside
    towards = np.cos(ELEVATION) * level + np.sin(ELEVATION) * up
    x, y, z = (-towards).tolist()
    return Camera((x, y, z), (float(up[0]), float(up[1]), float(up[2])))


def view_of_missing_side(points: Points, mirrored: Booleans, planes: Planes) -> Camera:
    """Choose a camera, obliquely before the side on which points were mirrored.

    Parameters
    ----------
    points : (n, 3) float
        The completed cloud.
    mirrored : (n,) bool
        Which of them were invented.
    planes : (k, 4) float
        The best one first.

    Notes
    -----
    Front or back: whichever shows more invented points, in two small trial pictures.
    """
    up = upright(points, planes)
    if len(planes):
        aside = planes[0, :3]
    else:
        across = np.eye(3) - np.outer(up, up)
        spread = across @ np.cov((points - points.mean(axis=0)).T) @ across
        aside = np.linalg.eigh(spread)[1][:, -1]
        aside = aside * np.sign(aside[np.argmax(np.abs(aside))])
    if mirrored.any():
        middle = points[mirrored].mean(axis=0)
        offset = float(planes[0, 3]) if len(planes) else -float(points.mean(axis=0) @ aside)
        aside = aside if middle @ aside + offset >= 0.0 else -aside
    ahead = np.cross(aside, up)
    ahead = ahead * np.sign(ahead[np.argmax(np.abs(ahead))])
    return max(
        (_camera(ahead, aside, up), _camera(-ahead, aside, up)),
        key=lambda camera: _visible_share(camera, points, mirrored),
    )


def views_of_both_sides(points: Points, planes: Planes) -> tuple[Camera, Camera]:
    """Choose two cameras, obliquely before either side of the mirror plane.

    Parameters
    ----------
    points : (n, 3) float
        The object.
    planes : (k, 4) float
        The best one first, at least one.

    Notes
    -----
    Front is where a coordinate axis says it may be: most scans look along one of them, towards
    positive numbers.
    """
    up, aside = upright(points, planes), planes[0, :3]
    ahead = np.cross(aside, up)
    ahead = ahead * np.sign(ahead[np.argmax(np.abs(ahead))])
    return _camera(ahead, aside, up), _camera(ahead, -aside, up)


def _visible_share(camera: Camera, points: Points, chosen: Booleans) -> float:
    """Return the share of a small picture of the points that the chosen ones fill."""
    screen = open_screen(camera, [points], TRIAL, TRIAL)
    buffer = empty_buffer(TRIAL, TRIAL)
    splat_discs(buffer, 0, screen.project(points), 1.5)
    covered = buffer.primitive[buffer.item >= 0]
    return float(np.mean(chosen[covered]))


def disc_radius(screen: Screen, points: ArrayLike) -> float:
    """Return the disc radius, in pixels, with which a cloud looks like a closed surface.

    Half the points in a typical cell of the picture are taken to lie on the near side.
    """
    projected = screen.project(np.asarray(points, dtype=float))
    cells = np.floor(projected[:, :2] / CELL).astype(np.int64)
    counts = np.unique(cells, axis=0, return_counts=True)[1]
    typical = np.average(counts, weights=counts)  # the cell of a typical point
    return float(np.clip(COVER * CELL * np.sqrt(2.0 / typical), 0.8, 3.0 * CELL))
