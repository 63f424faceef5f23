"""TXT files, points of other programs: what parts their numbers, and which columns are left out."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

import numpy as np

from meshlab_symrecon.arrays import Floats
from meshlab_symrecon.errors import FileError
from meshlab_symrecon.host.held import Held, unusable
from meshlab_symrecon.host.inspection_points import cut_off
from meshlab_symrecon.host.number_lines import (
    Block,
    blocks_of,
    check_plain_text,
    numbers_in,
    shown,
)
from meshlab_symrecon.host.ply_header import damaged
from meshlab_symrecon.host.point_copies import PointRows

__all__ = ["check_txt", "txt_rows"]

MARK = b"\xef\xbb\xbf"
COMMENT = b"#"
LONGEST = 1 << 16  # bytes of a first line
SEPARATORS = (b";", b",")  # beside blanks; a comma only when no semicolon is there
AXES = 3


def check_txt(path: Path) -> Held:
    """Check a text of points; return what it holds.

    Raises
    ------
    FileError
        A line has too few numbers or another number of them than the first, a word is no number,
        the numbers have decimal commas, a coordinate is infinite, or there is no point.
    """
    points = lost = columns = 0
    for block in _blocks(path):
        coordinates = _coordinates(block)
        lost += int(unusable(path, coordinates, points).sum())
        points += len(coordinates)
        columns = int(block.counts[0])
    if points == lost:
        raise FileError(f"{path} holds no points; scan again or pick another file")
    notes = (*_headings(path), *_left_out(path, columns), *cut_off(path))
    return Held(points, lost, notes=notes)


def txt_rows(path: Path) -> Iterator[PointRows]:
    """Yield the points of a text, the first three numbers of its lines.

    Raises
    ------
    FileError
        As ``check_txt``.
    """
    return (PointRows(_coordinates(block)) for block in _blocks(path))


def _coordinates(block: Block) -> Floats:
    return block.numbers.reshape(len(block.counts), -1)[:, :AXES]


def _headings(path: Path) -> tuple[str, ...]:
    """Return a warning when more than the names of the columns come before the points."""
    with path.open("rb") as file:
        first_line, _, headings = _beginning(path, file)
    if headings <= 1:  # the names of the columns
        return ()
    words = f"{path}: {headings} lines before line {first_line} hold no point and were passed over"
    return (f"{words}; look at what was read",)


def _left_out(path: Path, columns: int) -> tuple[str, ...]:
    if columns == AXES:
        return ()
    words = f"{path}: a .txt file does not say what its columns are, so the {columns - AXES} behind"
    return (f"{words} x, y and z were left out; write .ply to keep them",)


def _blocks(path: Path) -> Iterator[Block]:
    """Yield the lines of points, all of the same number of columns."""
    check_plain_text(path)
    columns = 0
    with path.open("rb") as file:
        first_line, separator, _ = _beginning(path, file)
        for block in blocks_of(path, file, first_line, separator):
            rows = block
            if not columns and len(rows.counts):
                rows = _without_count(rows)
            if not len(rows.counts):
                continue
            columns = columns or int(rows.counts[0])
            _check_columns(path, rows, columns)
            yield rows


def _without_count(block: Block) -> Block:
    """Pass over a first line that tells how many points follow."""
    if block.counts[0] != 1 or len(block.counts) == 1:
        return block
    return Block(block.numbers[1:], block.counts[1:], block.lines[1:])


def _check_columns(path: Path, block: Block, columns: int) -> None:
    wrong = (block.counts != columns) | (block.counts < AXES)
    if wrong.any():
        at = int(np.argmax(wrong))
        words = f"line {block.lines[at]} has {block.counts[at]} numbers"
        if columns < AXES:
            raise damaged(path, f"{words}, and a point has 3")
        raise damaged(path, f"{words}, and the first point has {columns}")


def _beginning(path: Path, file: BinaryIO) -> tuple[int, bytes, int]:
    """Go to the first line of numbers.

    Returns
    -------
    number : int
        Of that line.
    separator : bytes
        What parts its numbers beside blanks.
    headings : int
        How many lines of words come before it.
    """
    file.seek(len(MARK) if file.read(len(MARK)) == MARK else 0)
    headings = 0
    number = 1
    while True:
        start = file.tell()
        line = file.readline(LONGEST)
        text = line.partition(COMMENT)[0]
        separator = next((one for one in SEPARATORS if one in text), b"")
        words = text.replace(separator, b" ").split() if separator else text.split()
        if not line or (words and len(numbers_in(words[0].replace(b",", b".")))):
            _check_commas(path, number, text, separator)
            file.seek(start)
            return number, separator, headings
        headings += bool(words)
        number += line.endswith(b"\n")


def _check_commas(path: Path, number: int, text: bytes, separator: bytes) -> None:
    """Refuse '1,5 2,5 3,5' and '1,5; 2,5; 3,5', which are three numbers and not six."""
    parts = [part.split() for part in text.split(separator)] if separator else []
    if b"," not in text or (separator == b"," and all(len(part) < 2 for part in parts)):
        return
    message = f"{path}: line {number}, '{shown(text.strip())}', has commas within its numbers"
    raise FileError(f"{message}; write them with decimal points")
