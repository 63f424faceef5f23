"""The picture of a map of deviation: the object from two sides, and the bar of its colours."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from meshlab_symrecon.arrays import as_faces, as_planes, as_points
from meshlab_symrecon.errors import ParameterError
from meshlab_symrecon.one_thread import in_one_thread
from meshlab_symrecon.pictures.deviation_colours import (
    UNKNOWN,
    colour_limit,
    deviation_colours,
)
from meshlab_symrecon.pictures.figure import (
    BODY,
    DPI,
    FAINT,
    FONT,
    INK,
    Panel,
    drawing_tools,
    save_panels,
)
from meshlab_symrecon.pictures.projection import Camera, fit, open_screen
from meshlab_symrecon.pictures.renderer import BACKGROUND, render
from meshlab_symrecon.pictures.scene import PointCloud, TriangleMesh
from meshlab_symrecon.pictures.viewpoint import disc_radius, views_of_both_sides

__all__ = ["colour_bar", "deviation_picture"]

HEIGHT = 1000  # pixels of a panel
WIDTHS = (560, 1100)  # pixels: the narrowest and the widest panel
BAR_WIDTH = 250  # pixels: the bar with what is written beside it
STRIP = (34, 26)  # pixels: left edge and width of the colours
STRETCH = (0.14, 0.70)  # share of the height: top and bottom of the colours
UNKNOWN_TOP = 0.76  # of the square for what has no counterpart
MARKS = (1.0, 0.5, 0.0, -0.5, -1.0)  # shares of the limit that are written


@in_one_thread
def deviation_picture(  # noqa: PLR0913  # what a map shows, and how
    points: ArrayLike,
    faces: ArrayLike,
    distances: ArrayLike,
    has_counterpart: ArrayLike,
    plane: ArrayLike,
    path: str | Path,
    *,
    unit: str = "",
    limit: float | None = None,
    title: str = "",
    captions: tuple[str, str] = ("", ""),
) -> None:
    """Save a map of deviation, seen from before and to either side of the mirror plane.

    Parameters
    ----------
    points, faces : (n, 3) float, (m, 3) int
        The scan; a cloud when there are no faces.
    distances, has_counterpart : (n,) float, (n,) bool
        Of its points, as ``mirror_deviation`` gives them.
    plane : (4,) float
        The mirror plane.
    path : path
        Of the PNG; an existing file is replaced.
    unit : str
        Of the points, written on the bar.
    limit : float, optional
        The distance of the deepest colours, in place of `colour_limit`'s.
    title : str
        Above the views.
    captions : two str
        Under the views; the first line of each is its heading.

    Raises
    ------
    GeometryError
        An array of the wrong shape, values that are not finite, or no points.
    ParameterError
        A limit that is not positive, or not two captions.
    SymReconError
        matplotlib is missing, or the file cannot be written.
    """
    if len(captions) != 2:
        message = f"captions must be two, one a view; got {len(captions)}; give '' for none"
        raise ParameterError(message)
    scan = as_points(points, minimum=1)
    triangles = as_faces(faces, len(scan))
    mirror = as_planes(np.asarray(plane)[np.newaxis])
    deepest = colour_limit(distances, has_counterpart) if limit is None else limit
    colours = deviation_colours(distances, has_counterpart, deepest)
    panels = []
    for camera, caption in zip(views_of_both_sides(scan, mirror), captions, strict=True):
        aimed, size = _frame(camera, scan)
        item: PointCloud | TriangleMesh
        if len(triangles):
            item = TriangleMesh(scan, triangles, colours)
        else:
            radius = disc_radius(open_screen(aimed, [scan], *size), scan)
            item = PointCloud(scan, colours, radius=radius)
        heading, *lines = caption.split("\n")
        panels.append(Panel(render([item], aimed, size), heading, tuple(lines)))
    panels.append(Panel(colour_bar(deepest, unit, HEIGHT)))
    save_panels(path, panels, title)


def colour_bar(limit: float, unit: str = "", height: int = HEIGHT) -> NDArray[np.uint8]:
    """Draw the bar of the colours of a map.

    Parameters
    ----------
    limit : float
        The distance of the deepest colours.
    unit : str
        Of the distances.
    height : int
        Pixels.

    Returns
    -------
    (height, 250, 3) uint8
        sRGB.

    Raises
    ------
    SymReconError
        matplotlib is missing.
    """
    rc_context, canvas_class, figure_class = drawing_tools()
    page = np.full((height, BAR_WIDTH, 3), BACKGROUND, dtype=np.uint8)
    top, bottom = (round(share * height) for share in STRETCH)
    left, right = STRIP[0], STRIP[0] + STRIP[1]
    along = np.linspace(limit, -limit, bottom - top)
    page[top:bottom, left:right] = deviation_colours(
        along, np.ones(len(along), dtype=np.bool_), limit
    )[:, np.newaxis]
    square = round(UNKNOWN_TOP * height)
    page[square : square + STRIP[1], left:right] = UNKNOWN
    middle, half = (top + bottom) / 2.0, (bottom - top) / 2.0
    notes = [(middle - half * mark, _length(mark * limit, unit), INK) for mark in MARKS]
    notes += [(top - 34.0, "stands out", FAINT), (bottom + 34.0, "lies under", FAINT)]
    notes.append((square + STRIP[1] / 2.0, "no counterpart", FAINT))
    with rc_context(FONT):
        size = (BAR_WIDTH / DPI, height / DPI)
        figure = figure_class(figsize=size, dpi=DPI)
        figure.figimage(page, 0, 0)
        for row, words, ink in notes:
            beside = left if ink == FAINT and words != "no counterpart" else right + 14
            figure.text(
                beside / BAR_WIDTH, 1.0 - row / height, words, fontsize=BODY * 72.0 / DPI,
                color=ink, ha="left", va="center", parse_math=False,
            )  # fmt: skip
        canvas = canvas_class(figure)
        canvas.draw()
        drawn: NDArray[np.uint8] = np.array(canvas.buffer_rgba())[..., :3]
    return drawn


def _length(value: float, unit: str) -> str:
    """Write a signed length with a true minus sign."""
    sign = "" if value == 0.0 else "+" if value > 0.0 else "\N{MINUS SIGN}"
    return f"{sign}{abs(value):.3g} {unit}".strip()


def _frame(camera: Camera, points: NDArray[np.float64]) -> tuple[Camera, tuple[int, int]]:
    """Aim the camera at all points, in a panel as wide as they need."""
    spans = np.maximum(np.ptp(points @ camera.axes().T, axis=0), 1e-12)
    width = int(np.clip(round(HEIGHT * spans[0] / spans[1] * 1.02), *WIDTHS))
    return fit(camera, points, (width, HEIGHT), margin=0.02), (width, HEIGHT)
