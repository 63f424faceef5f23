"""PTX files, scans in rows and columns: whether every point that is announced is there."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from meshlab_symrecon.host.number_lines import Block, blocks_of, check_plain_text
from meshlab_symrecon.host.ply_header import damaged

__all__ = ["check_grids"]

HEADER = 30  # numbers: columns, rows, four places of the scanner, a matrix
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


def check_grids(path: Path, extension: str) -> None:
    """Compare the points of a PTX file with its headers.

    Raises
    ------
    FileError
        A header or a point is not whole, a word is no number, or points are missing at the end.
    """
    if extension != "ptx":
        return
    check_plain_text(path)
    reading = _Reading(path, [])
    with path.open("rb") as file:
        for block in blocks_of(path, file):
            rest = block
            while len(rest.counts):
                rest = _taken(reading, rest)
    reading.check_end()


def _taken(reading: _Reading, block: Block) -> Block:
    """Take the next line of a header, or as many points as there are; return the rest."""
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
    else:
        used = 1
        reading.header += block.numbers[: block.counts[0]].tolist()
        _check_header(reading, int(block.lines[0]))
    reading.line = int(block.lines[used - 1])
    end = int(block.counts[:used].sum())
    return Block(block.numbers[end:], block.counts[used:], block.lines[used:])


def _check_header(reading: _Reading, line: int) -> None:
    sizes = np.array(reading.header[:2])
    if len(reading.header) > HEADER or (sizes != np.floor(sizes)).any() or (sizes < 0).any():
        raise damaged(reading.path, f"line {line} is none of a header")
    if len(reading.header) == HEADER:
        reading.announced = int(sizes.prod())
