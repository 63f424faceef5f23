"""Text files of points, a line a point: what MeshLab would leave out of them without a word."""

from __future__ import annotations

from pathlib import Path
from typing import BinaryIO

import numpy as np

from meshlab_symrecon.errors import FileError
from meshlab_symrecon.host.held import Held, unusable
from meshlab_symrecon.host.number_lines import Block, blocks_of, check_plain_text, shown
from meshlab_symrecon.host.ply_header import damaged

__all__ = ["check_points_text"]

MARK = b"\xef\xbb\xbf"
HEADING = b"//"  # how a line begins that names the columns
LONGEST_HEADING = 1 << 16  # bytes
WIDTHS = (3, 6)  # numbers of a line: a point, and its normal


def check_points_text(path: Path) -> Held:
    """Check a file with a point a line.

    A first line that begins with two slashes names the columns, and one of one whole number is the
    number of points.

    Raises
    ------
    FileError
        A line has other than three or six numbers, a word is no number, the count in front is not
        that of the lines, MeshLab takes the names of the columns for a point, a coordinate is
        infinite, or there is no point.
    """
    announced: int | None = None
    points = lost = 0
    begun = False
    check_plain_text(path)
    with path.open("rb") as file:
        file.seek(len(MARK) if file.read(len(MARK)) == MARK else 0)
        for block in blocks_of(path, file, _without_heading(path, file)):
            rows = block
            if not begun and len(block.counts):
                begun = True
                announced, rows = _without_count(block)
            _check_widths(path, rows)
            coordinates = rows.numbers[rows.starts()[:, None] + np.arange(3)]
            lost += int(unusable(path, coordinates, points).sum())
            points += len(coordinates)
    if announced is not None and announced != points:
        raise damaged(path, f"its first line announces {announced} points, and {points} follow")
    if points == lost:
        raise FileError(f"{path} holds no points; scan again or pick another file")
    return Held(points, lost, notes=cut_off(path))


def _without_heading(path: Path, file: BinaryIO) -> int:
    """Pass over the names of the columns; return the number of the line that follows."""
    start = file.tell()
    line = file.readline(LONGEST_HEADING)
    if not line.startswith(HEADING) or not line.endswith(b"\n"):
        file.seek(start)
        return 1
    if len(line.split()) in WIDTHS:
        message = f"{path}: MeshLab takes line 1, '{shown(line.strip())}', for a point"
        raise FileError(f"{message}; remove that line")
    return 2


def _without_count(block: Block) -> tuple[int | None, Block]:
    """Return the number of points in the first line, None when it is a point, and the rest."""
    first = float(block.numbers[0])
    if block.counts[0] != 1 or not first.is_integer():
        return None, block
    return int(first), Block(block.numbers[1:], block.counts[1:], block.lines[1:])


def _check_widths(path: Path, block: Block) -> None:
    wrong = ~np.isin(block.counts, WIDTHS)
    if wrong.any():
        at = int(np.argmax(wrong))
        message = f"{path}: line {block.lines[at]} has {block.counts[at]} numbers, and MeshLab"
        raise FileError(f"{message} reads 3 (a point) or 6 (with its normal); keep those columns")


def cut_off(path: Path) -> tuple[str, ...]:
    """Return a warning when the last line of a text has no end: it may be half a line."""
    with path.open("rb") as file:
        file.seek(-1, 2)
        if file.read(1) in b"\r\n":
            return ()
    return (f"{path}: its last line has no end, so it may have been cut off; compare its size",)
