"""The picture of the main job: the scan, the mirror plane found in it, the closed surface."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from meshlab_symrecon.arrays import Booleans, Points, as_faces, as_planes, as_points, as_scalars
from meshlab_symrecon.errors import ParameterError
from meshlab_symrecon.one_thread import in_one_thread
from meshlab_symrecon.pictures.figure import Panel, save_panels
from meshlab_symrecon.pictures.projection import Camera, fit, open_screen
from meshlab_symrecon.pictures.renderer import render
from meshlab_symrecon.pictures.scene import (
    INVENTED,
    MEASURED,
    Item,
    PlaneSheet,
    PointCloud,
    TriangleMesh,
    colours_by_share,
    plane_sheet,
)
from meshlab_symrecon.pictures.viewpoint import disc_radius, upright, view_of_missing_side

__all__ = ["main_job_picture", "still"]

HEIGHT = 1000  # pixels of a panel
WIDTHS = (560, 1100)  # pixels: the narrowest and the widest panel
LEGEND = (("measured", MEASURED), ("invented", INVENTED))


@in_one_thread
def still(
    path: str | Path,
    items: Sequence[Item],
    camera: Camera,
    size: tuple[int, int] = (800, 1000),
    caption: str = "",
) -> None:
    """Save one view as a PNG.

    Parameters
    ----------
    path : path
        Of the PNG; an existing file is replaced.
    items : sequence of PointCloud, TriangleMesh, PlaneSheet
        What to draw.
    camera : Camera
        Where from; it is fitted to the items unless it is aimed.
    size : two ints
        Width and height of the view in pixels; the caption and a border come on top.
    caption : str
        Under the view; its first line is the heading.

    Raises
    ------
    SymReconError
        matplotlib is missing, the size is out of range, or the file cannot be written.
    """
    save_panels(path, [_panel(items, caption, camera, size)])


def _count(number: int) -> str:
    """Write a number with thin spaces between thousands."""
    return f"{number:,}".replace(",", "\N{THIN SPACE}")


@in_one_thread
def main_job_picture(  # noqa: PLR0913, PLR0917  the seven arrays of the whole method, in its order
    scan_points: ArrayLike,
    planes: ArrayLike,
    completed_points: ArrayLike,
    mirrored_mask: ArrayLike,
    surface_points: ArrayLike,
    surface_faces: ArrayLike,
    surface_share_invented: ArrayLike,
    path: str | Path,
    *,
    title: str = "",
    captions: tuple[str, str, str] | None = None,
    camera: Camera | None = None,
) -> None:
    """Save the scan, the plane with the invented points, and the closed surface side by side.

    Parameters
    ----------
    scan_points : (n, 3) float
        What was measured.
    planes : (k, 4) float
        Mirror planes, the best one first; only that one is drawn.
    completed_points : (c, 3) float
        Measured and mirrored points.
    mirrored_mask : (c,) bool
        Which of them were mirrored.
    surface_points, surface_faces : (v, 3) float, (m, 3) int
        The reconstructed surface.
    surface_share_invented : (v,) float
        0 where a vertex comes from measured points, 1 where it comes from mirrored ones.
    path : path
        Of the PNG; an existing file is replaced.
    title : str
        Above the panels.
    captions : three str, optional
        Under the panels, in place of the numbers; the first line of each is its heading.
    camera : Camera, optional
        In place of the one chosen from the missing side.

    Raises
    ------
    GeometryError
        An array of the wrong shape, values that are not finite, or a scan without points.
    ParameterError
        Not three captions.
    SymReconError
        matplotlib is missing, or the file cannot be written.
    """
    scan = as_points(scan_points, minimum=1)
    mirror = as_planes(planes)
    completed = as_points(completed_points, minimum=1)
    mirrored = as_scalars(mirrored_mask, len(completed), "mirrored_mask").astype(bool)
    vertices = as_points(surface_points)
    faces = as_faces(surface_faces, len(vertices))
    share = as_scalars(surface_share_invented, len(vertices), "surface_share_invented")
    if captions is not None and len(captions) != 3:
        message = f"captions must be three, one a panel; got {len(captions)}; give '' for none"
        raise ParameterError(message)

    chosen = camera or view_of_missing_side(completed, mirrored, mirror)
    sheets = [plane_sheet(plane, completed, upright(completed, mirror)) for plane in mirror[:1]]
    everything = [scan, completed, vertices, *(sheet.corners for sheet in sheets)]
    aimed, size = _frame(chosen, np.concatenate(everything))
    screen = open_screen(aimed, everything, *size)
    scenes: list[list[Item]] = [
        [PointCloud(scan, radius=disc_radius(screen, scan))],
        [_completed_cloud(completed, mirrored, disc_radius(screen, completed)), *sheets],
        [TriangleMesh(vertices, faces, colours_by_share(share))],
    ]
    if captions is None:
        parts = (int(mirrored.sum()), float(share[faces].mean()) if len(faces) else 0.0)
        captions = _captions(len(scan), parts, len(faces), sheets)
    legend = LEGEND if mirrored.any() else ()
    panels = [
        _panel(items, caption, aimed, size, swatches)
        for items, caption, swatches in zip(scenes, captions, ((), legend, legend), strict=True)
    ]
    save_panels(path, panels, title)


def _panel(
    items: Sequence[Item],
    caption: str,
    camera: Camera,
    size: tuple[int, int],
    swatches: tuple[tuple[str, tuple[int, int, int]], ...] = (),
) -> Panel:
    """Draw one panel; the first line of its caption is the heading."""
    heading, *lines = caption.split("\n")
    return Panel(render(items, camera, size), heading, tuple(lines), swatches)


def _completed_cloud(points: Points, mirrored: Booleans, radius: float) -> PointCloud:
    """Return the completed cloud with the invented points in their own colour."""
    return PointCloud(points, colours_by_share(mirrored.astype(float)), radius=radius)


def _frame(camera: Camera, points: Points) -> tuple[Camera, tuple[int, int]]:
    """Aim the camera at everything that any panel shows, in panels as wide as that needs."""
    seen = points @ camera.axes().T
    spans = np.maximum(np.ptp(seen, axis=0), 1e-12)
    width = int(np.clip(round(HEIGHT * spans[0] / spans[1] * 1.02), *WIDTHS))
    return fit(camera, points, (width, HEIGHT), margin=0.02), (width, HEIGHT)


def _captions(
    scanned: int, invented: tuple[int, float], triangles: int, sheets: Sequence[PlaneSheet]
) -> tuple[str, str, str]:
    """Say in numbers what the panels show."""
    points, share = invented
    found = (
        f"Its mirror plane\n{_count(points)} points invented by reflection"
        if sheets
        else "No mirror plane was found\nnothing was invented"
    )
    return (
        f"The scan\n{_count(scanned)} points measured",
        found,
        f"The closed surface\n{_count(triangles)} triangles, {100.0 * share:.0f} % invented",
    )
