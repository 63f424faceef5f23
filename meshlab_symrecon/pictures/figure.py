"""Pictures on paper: panels side by side with captions, saved as PNG with the same bytes."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from meshlab_symrecon.errors import FileError, SymReconError
from meshlab_symrecon.pictures.renderer import BACKGROUND

__all__ = ["BODY", "DPI", "FAINT", "FONT", "INK", "Panel", "drawing_tools", "save_panels"]

DPI = 100
INK, FAINT = "#2e2a26", "#857d73"
FONT = {"font.family": "DejaVu Sans", "text.usetex": False, "text.hinting": "none"}
HEADING, BODY = 26.0, 19.0  # pixels
LINE = 34  # pixels from one line of text to the next
GAP = 24  # pixels between panels, and round all of them


@dataclass(frozen=True, slots=True, eq=False)
class Panel:
    """One picture and what is written under it."""

    image: NDArray[np.uint8]  # (height, width, 3)
    heading: str = ""
    lines: tuple[str, ...] = ()
    swatches: tuple[tuple[str, tuple[int, int, int]], ...] = ()  # words and their colours


def drawing_tools() -> tuple[Any, Any, Any]:
    """Import matplotlib, which is an extra, only when a picture is saved.

    Returns
    -------
    rc_context, FigureCanvasAgg, Figure

    Raises
    ------
    SymReconError
        matplotlib cannot be imported.
    """
    try:
        from matplotlib import rc_context
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError as error:
        message = (
            f"saving a picture needs matplotlib, which cannot be imported ({error}); "
            'install it with: pip install "meshlab-symrecon[report]"'
        )
        raise SymReconError(message) from error
    return rc_context, FigureCanvasAgg, Figure


def save_panels(path: str | Path, panels: Sequence[Panel], title: str = "") -> None:
    """Save panels side by side as a PNG.

    The file is written beside its place and renamed, so that it is never seen half written;
    equal panels give equal bytes with the same matplotlib.

    Parameters
    ----------
    path : path
        Of the PNG; an existing file is replaced.
    panels : sequence of Panel
        All of the same height.
    title : str
        Above the panels.

    Raises
    ------
    SymReconError
        matplotlib is missing.
    FileError
        The file cannot be written.
    """
    rc_context, canvas_class, figure_class = drawing_tools()
    with rc_context(FONT):
        figure = _lay_out(panels, title, figure_class)
        canvas = canvas_class(figure)
        _replace(Path(path), canvas)


def _lay_out(panels: Sequence[Panel], title: str, figure_class: Any) -> Any:
    """Return a figure with every panel at its own pixels and the words under them."""
    top = GAP + (round(1.6 * LINE) if title else 0)
    heights = [panel.image.shape[0] for panel in panels]
    text_lines = max(
        bool(panel.heading) + len(panel.lines) + bool(panel.swatches) for panel in panels
    )
    width = sum(panel.image.shape[1] for panel in panels) + GAP * (len(panels) + 1)
    height = top + max(heights) + GAP + text_lines * LINE
    paper = np.array(BACKGROUND) / 255.0
    figure = figure_class(figsize=(width / DPI, height / DPI), dpi=DPI, facecolor=paper)
    page = np.full((height, width, 3), BACKGROUND, dtype=np.uint8)
    left = GAP
    for panel in panels:
        rows, columns = panel.image.shape[:2]
        page[top : top + rows, left : left + columns] = panel.image
        left += columns + GAP
    figure.figimage(page, 0, 0)
    if title:
        _write(figure, (width / 2, GAP + LINE * 0.7), title, HEADING * 1.25, INK)
    left = GAP
    for panel in panels:
        centre = left + panel.image.shape[1] / 2
        _caption(figure, panel, (centre, top + panel.image.shape[0] + LINE * 0.6))
        left += panel.image.shape[1] + GAP
    return figure


def _write(figure: Any, place: tuple[float, float], words: str, size: float, colour: Any) -> Any:
    """Write centred words at a place given in pixels from the top left."""
    width, height = (float(side) * DPI for side in figure.get_size_inches())
    return figure.text(
        place[0] / width, 1.0 - place[1] / height, words, fontsize=size * 72.0 / DPI,
        color=colour, ha="center", va="center", parse_math=False,
    )  # fmt: skip


def _caption(figure: Any, panel: Panel, place: tuple[float, float]) -> None:
    """Write heading, lines and legend of one panel, from this place downwards."""
    x, y = place
    if panel.heading:
        _write(figure, (x, y), panel.heading, HEADING, INK)
        y += LINE
    for line in panel.lines:
        _write(figure, (x, y), line, BODY, FAINT)
        y += LINE
    if panel.swatches:
        widths = [BODY * (0.62 * len(words) + 2.6) for words, _ in panel.swatches]
        x -= sum(widths) / 2
        for (words, colour), width in zip(panel.swatches, widths, strict=True):
            _write(figure, (x + BODY * 0.6, y), "\N{BLACK CIRCLE}", BODY * 1.3, tuple(
                channel / 255.0 for channel in colour
            ))  # fmt: skip
            _write(figure, (x + width / 2 + BODY * 0.2, y), words, BODY, FAINT)
            x += width


def _replace(path: Path, canvas: Any) -> None:
    """Write the PNG beside its place, then rename it."""
    beside = None
    try:
        with tempfile.NamedTemporaryFile(
            dir=path.parent, prefix=f".{path.name}.", suffix=".png", delete=False
        ) as stream:
            beside = Path(stream.name)
            canvas.print_png(stream, metadata={"Software": None})
        beside.chmod(0o644)
        beside.replace(path)
    except OSError as error:
        if beside is not None:
            with suppress(OSError):
                beside.unlink()
        message = f"the picture {path} cannot be written ({error.strerror}); choose another path"
        raise FileError(message) from error
