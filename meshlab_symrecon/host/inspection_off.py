"""OFF files: counts, lines and corners, which MeshLab's reader takes on trust."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO

import numpy as np

from meshlab_symrecon.arrays import Floats, Indices
from meshlab_symrecon.errors import FileError
from meshlab_symrecon.host.held import Held, unusable
from meshlab_symrecon.host.number_lines import (
    Block,
    blocks_of,
    check_plain_text,
    shown,
    whole_lines,
)
from meshlab_symrecon.host.ply_header import damaged

__all__ = ["check_off"]

MARK = b"\xef\xbb\xbf"
LONGEST_LINE = 1 << 16  # bytes, of what comes before the points
KEYWORD = re.compile(rb"(ST)?(C)?(N)?(C)?OFF")
COMMENT = re.compile(rb"(?m)^([^#\n]+)#")  # where no line begins
COLOUR = 1  # the fewest numbers of a point's: MeshLab takes an index into a table, too
COLOURS = 4  # the most of a point's, and it fails on more


@dataclass(slots=True)
class _Reading:
    """What was announced, and what has been read so far."""

    path: Path
    points: int
    faces: int
    least: int  # numbers of a point
    most: int
    found: int = 0
    polygons: int = 0
    lost: list[Indices] = field(default_factory=list)  # points that nobody can use
    lost_faces: int = 0
    triangles: int = 0
    edges: int = 0  # faces of two corners
    more: int = 0  # lines behind what was announced


def check_off(path: Path) -> Held:
    """Check an OFF file.

    Raises
    ------
    FileError
        Its header is none, a line has too few numbers or a word, a face names a vertex that the
        file does not have, or has an index for its colour, it ends before what it announces, or a
        coordinate is infinite.
    """
    check_plain_text(path)
    with path.open("rb") as file:
        reading, line = _begun(path, file)
        _check_comments(path, file, line)
        for block in blocks_of(path, file, line):
            _take_faces(reading, _without_points(reading, block))
    for what, announced, found in (
        ("points", reading.points, reading.found),
        ("faces", reading.faces, reading.polygons),
    ):
        if found < announced:
            raise damaged(path, f"it announces {announced} {what}, and {found} follow")
    lost = sum(map(len, reading.lost))
    if lost == reading.points:
        raise FileError(f"{path} holds no points; scan again or pick another file")
    notes = _notes(reading)
    return Held(reading.points, lost, reading.lost_faces, notes, triangles=reading.triangles)


def _notes(reading: _Reading) -> tuple[str, ...]:
    notes = []
    if reading.edges:
        words = f"{reading.edges} faces of two corners, which MeshLab leaves out"
        notes.append(f"{reading.path} has {words}")
    if reading.more:
        words = f"{reading.more} lines behind the faces that it announces; they were left out"
        notes.append(f"{reading.path} has {words}")
    return tuple(notes)


def _begun(path: Path, file: BinaryIO) -> tuple[_Reading, int]:
    """Return what the header announces, and the number of the line behind it."""
    words: list[bytes] = []
    number = 0
    file.seek(len(MARK) if file.read(len(MARK)) == MARK else 0)
    while len(words) < 4:
        line = file.readline(LONGEST_LINE)
        number += 1
        if not line:
            break
        before, mark, _ = line.partition(b"#")
        words += before.split()
        if before and mark and len(words) == 1:
            raise _comment_behind(path, number)
        if words and not KEYWORD.fullmatch(words[0]):
            raise damaged(path, f"it begins with '{shown(words[0])}' instead of 'OFF'")
        if len(words) > 1 and words[1].upper() == b"BINARY":
            raise FileError(f"{path} is a binary OFF file, which MeshLab does not read; write .ply")
    try:
        counts = [int(word) for word in words[1:]]
    except ValueError:
        counts = []
    if len(counts) != 3 or min(counts) < 0:
        raise damaged(path, f"line {number} must have the numbers of points, faces and edges")
    if counts[0] == 0:
        raise FileError(f"{path} holds no points; scan again or pick another file")
    keyword = words[0]
    extra = 2 * (b"ST" in keyword) + 3 * (b"N" in keyword) + COLOUR * (b"C" in keyword)
    most = 3 + extra + (COLOURS - COLOUR) * (b"C" in keyword)
    return _Reading(path, counts[0], counts[1], 3 + extra, most), number + 1


def _check_comments(path: Path, file: BinaryIO, line: int) -> None:
    """Refuse comments behind numbers: MeshLab takes their words for numbers, or crashes."""
    start = file.tell()
    for text in whole_lines(path, file):
        found = COMMENT.search(text) if b"#" in text else None
        if found:
            raise _comment_behind(path, line + text.count(b"\n", 0, found.start(1)))
        line += text.count(b"\n")
    file.seek(start)


def _comment_behind(path: Path, line: int) -> FileError:
    message = f"{path} has a comment in line {line} that does not begin it, which MeshLab does not"
    return FileError(f"{message} read; remove it")


def _without_points(reading: _Reading, block: Block) -> Block:
    """Take points from a block's beginning; return the rest."""
    needed = reading.points - reading.found
    if needed == 0 or not len(block.counts):
        return block
    plain = reading.least == 3
    each = block.counts // 3 if plain else np.ones(len(block.counts), dtype=np.int64)
    used = int(np.searchsorted(np.cumsum(each), needed)) + 1
    counts = block.counts[:used]
    wrong = (counts % 3 != 0) if plain else (counts < reading.least)
    if wrong.any():
        at = int(np.argmax(wrong))
        what = f"line {block.lines[at]} has {counts[at]} numbers, and a point has {reading.least}"
        raise damaged(reading.path, what)
    if not plain and counts.max() > reading.most:
        at = int(np.argmax(counts > reading.most))
        message = f"{reading.path}: line {block.lines[at]} has {counts[at]} numbers, and MeshLab"
        raise FileError(f"{message} reads {reading.most} of a point at most; leave out the others")
    end = int(counts.sum())
    coordinates: Floats
    if plain:
        coordinates = block.numbers[:end].reshape(-1, 3)
    else:
        coordinates = block.numbers[block.starts()[:used, None] + np.arange(3)]
    if len(coordinates) > needed:
        message = f"line {block.lines[len(counts) - 1]} goes on behind the last point"
        raise damaged(reading.path, message)
    lost = unusable(reading.path, coordinates, reading.found)
    reading.lost.append(np.flatnonzero(lost) + reading.found)
    reading.found += len(coordinates)
    return Block(block.numbers[end:], block.counts[used:], block.lines[used:])


def _take_faces(reading: _Reading, block: Block) -> None:
    taken = min(len(block.counts), reading.faces - reading.polygons)
    reading.more += len(block.counts) - taken
    if taken == 0:
        return
    starts, counts = block.starts()[:taken], block.counts[:taken]
    sizes = block.numbers[starts]
    wrong = ~((sizes >= 2) & (sizes < counts) & (sizes == np.floor(sizes)))
    if wrong.any():
        at = int(np.argmax(wrong))
        what = f"the face in line {block.lines[at]} announces {sizes[at]:g} corners"
        raise damaged(reading.path, f"{what}, and {counts[at] - 1} numbers follow")
    lengths = sizes.astype(np.int64)
    _check_colours(reading.path, counts - 1 - lengths, block.lines)
    owners = np.repeat(np.arange(taken), lengths)
    within = np.arange(len(owners)) - np.repeat(np.cumsum(lengths) - lengths, lengths)
    corners = block.numbers[starts[owners] + 1 + within]
    wrong = ~((corners >= 0) & (corners < reading.points) & (corners == np.floor(corners)))
    if wrong.any():
        at = int(np.argmax(wrong))
        what = f"the face in line {block.lines[owners[at]]} names vertex {corners[at]:g}"
        raise damaged(reading.path, f"{what}, and there are {reading.points}, counted from 0")
    lost = np.isin(corners.astype(np.int64), np.concatenate(reading.lost))
    reading.lost_faces += len(np.unique(owners[lost]))
    reading.edges += int((lengths == 2).sum())
    reading.triangles += int((lengths - 2).sum())
    reading.polygons += taken


def _check_colours(path: Path, numbers: Indices, lines: Indices) -> None:
    """Refuse one number behind a face's corners, with which MeshLab's reader ends the process."""
    if (numbers == 1).any():
        line = lines[int(np.argmax(numbers == 1))]
        message = f"{path}: the face in line {line} has one number for its colour, an index into"
        message = f"{message} a table, on which MeshLab's reader fails"
        raise FileError(f"{message}; remove it, or write red, green and blue")
