"""PTX files, scans in rows and columns: every point that is announced, and where it is."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from meshlab_symrecon.arrays import Floats
from meshlab_symrecon.errors import FileError
from meshlab_symrecon.host.held import Held, unusable
from meshlab_symrecon.host.number_lines import Block, blocks_of, check_plain_text
from meshlab_symrecon.host.ply_header import damaged
from meshlab_symrecon.host.point_copies import PointRows

__all__ = ["check_ptx", "ptx_rows"]

HEADER = 30  # numbers: columns, rows, four places of the scanner, a matrix
MATRIX = 14  # where it begins; a point is a row that it is multiplied to
WIDTHS = (4, 7)  # numbers of a point: its place and brightness, and its colour


@dataclass(slots=True)
class _Reading:
    """What has been read of the present grid."""

    path: Path
    header: list[float]
    line: int = 0  # the last one
    announced: int = 0
    found: int = 0

    def check_end(self) -> None:
        """Refuse a grid that is not whole."""
        if len(self.header) < HEADER:
            what = f"it ends in line {self.line}, in the middle of a header"
            raise damaged(self.path, what)
        if self.found < self.announced:
            what = f"it announces {self.announced} points, and {self.found} follow"
            raise damaged(self.path, what)


def check_ptx(path: Path) -> Held:
    """Compare the points of a PTX file with its headers; return what it holds.

    Raises
    ------
    FileError
        A header or a point is not whole, a word is no number, points are missing at the end, a
        coordinate is infinite, or there is no point.
    """
    points = lost = 0
    for rows in ptx_rows(path):
        lost += int(unusable(path, rows.points, points).sum())
        points += len(rows.points)
    if points == lost:
        raise FileError(f"{path} holds no points; scan again or pick another file")
    return Held(points, lost)


def ptx_rows(path: Path) -> Iterator[PointRows]:
    """Yield the points of all grids in their common frame, without those that met nothing.

    A scanner writes three zeros where its ray met nothing.

    Raises
    ------
    FileError
        As ``check_ptx``.
    """
    check_plain_text(path)
    reading = _Reading(path, [])
    with path.open("rb") as file:
        for block in blocks_of(path, file):
            rest = block
            while len(rest.counts):
                taken, rest = _taken(reading, rest)
                if taken is not None:
                    yield from _measured(reading, taken)
    reading.check_end()


def _taken(reading: _Reading, block: Block) -> tuple[Block | None, Block]:
    """Take the next line of a header, or as many points as there are; return them and the rest."""
    if len(reading.header) == HEADER and reading.found == reading.announced:
        reading.header, reading.found = [], 0
    if len(reading.header) == HEADER:
        used = min(reading.announced - reading.found, len(block.counts))
        wrong = ~np.isin(block.counts[:used], WIDTHS)
        if wrong.any():
            at = int(np.argmax(wrong))
            what = f"line {block.lines[at]} has {block.counts[at]} numbers, and a point has 4 or 7"
            raise damaged(reading.path, what)
        reading.found += used
        points = True
    else:
        used = 1
        reading.header += block.numbers[: block.counts[0]].tolist()
        _check_header(reading, int(block.lines[0]))
        points = False
    reading.line = int(block.lines[used - 1])
    end = int(block.counts[:used].sum())
    taken = Block(block.numbers[:end], block.counts[:used], block.lines[:used])
    rest = Block(block.numbers[end:], block.counts[used:], block.lines[used:])
    return (taken if points else None), rest


def _check_header(reading: _Reading, line: int) -> None:
    sizes = np.array(reading.header[:2])
    if len(reading.header) > HEADER or (sizes != np.floor(sizes)).any() or (sizes < 0).any():
        raise damaged(reading.path, f"line {line} is none of a header")
    if len(reading.header) == HEADER:
        if not np.isfinite(reading.header).all():
            what = f"the header that ends in line {line} has a number that is none"
            raise damaged(reading.path, what)
        reading.announced = int(sizes.prod())


def _measured(reading: _Reading, block: Block) -> Iterator[PointRows]:
    """Yield the points of some lines that met something, those of either width by themselves."""
    matrix = np.array(reading.header[MATRIX:]).reshape(4, 4)
    starts = block.starts()
    changes = np.flatnonzero(np.diff(block.counts)) + 1
    for run in np.split(np.arange(len(starts)), changes):
        width = int(block.counts[run[0]])
        numbers = block.numbers[starts[run[0]] :][: len(run) * width].reshape(-1, width)
        numbers = numbers[(numbers[:, :3] != 0.0).any(axis=1)]
        yield PointRows(_moved(numbers[:, :3], matrix), numbers[:, 3], _colours(numbers))


def _moved(points: Floats, matrix: Floats) -> Floats:
    """Return points in the common frame; infinite ones stay as they are, to be refused."""
    with np.errstate(invalid="ignore", over="ignore"):
        moved = points @ matrix[:3, :3] + matrix[3, :3]
    return np.where(np.isinf(points).any(axis=1, keepdims=True), points, moved)


def _colours(numbers: Floats) -> Floats:
    """Return red, green and blue from 0 to 255, or the brightness where there is no colour."""
    if numbers.shape[1] == max(WIDTHS):
        return numbers[:, 4:]
    return np.repeat(255.0 * numbers[:, 3:4], 3, axis=1)
