"""OBJ files: what MeshLab's reader crashes on, hangs on, or leaves out without a word."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO

from meshlab_symrecon.errors import FileError
from meshlab_symrecon.host.held import LARGEST, Held
from meshlab_symrecon.host.inspection_obj_plain import plain_obj
from meshlab_symrecon.host.inspection_points import cut_off
from meshlab_symrecon.host.number_lines import check_plain_text, shown
from meshlab_symrecon.host.ply_header import damaged

__all__ = ["check_obj"]

MARK = b"\xef\xbb\xbf"
LEAST = {b"v": 3, b"vt": 2, b"vn": 3}  # numbers
MOST_CORNERS = 10_000  # MeshLab's time for a polygon grows faster than its corners
MOST_BYTES = 1 << 26  # of a line
COUNTED = re.compile(rb"# (Vertices|Faces): (\d+)\s*")  # in MeshLab's own files
END = b"# End of File"


@dataclass(slots=True)
class _Reading:
    """What has been read so far."""

    path: Path
    counts: dict[bytes, int] = field(default_factory=lambda: dict.fromkeys(LEAST, 0))
    corners: set[bytes] = field(default_factory=set)
    lost: set[int] = field(default_factory=set)  # points, from 1 on, that nobody can use
    lost_faces: int = 0
    faces: int = 0
    triangles: int = 0
    announced: dict[bytes, int] = field(default_factory=dict)
    ended: bool = False


def check_obj(path: Path) -> Held:
    """Check an OBJ file line by line.

    Raises
    ------
    FileError
        A face names a vertex, texture coordinate or normal that the file does not have, has a
        comment behind it, fewer than three corners or too many; a vertex has a word or too few
        numbers; a coordinate is infinite; it names a device as its library of materials.
    """
    check_plain_text(path)
    with path.open("rb") as file:
        beginning = file.read(len(MARK) + 2)
        if beginning.startswith(MARK) and beginning[len(MARK) :][:1] not in (b"#", b"\r", b"\n"):
            message = f"{path} begins with a byte order mark, with which MeshLab loses line 1"
            raise FileError(f"{message}; save it as UTF-8 without one")
    plain = plain_obj(path)
    return _checked_by_lines(path) if plain is None else plain


def _checked_by_lines(path: Path) -> Held:
    reading = _Reading(path)
    with path.open("rb") as file:
        for number, line in _whole_lines(path, file):
            _take(reading, number, line)
    if reading.counts[b"v"] == len(reading.lost):
        raise FileError(f"{path} holds no points; scan again or pick another file")
    _check_corners(path, reading.corners, reading.counts)
    _check_counts(reading)
    notes = () if reading.ended else cut_off(path)
    return Held(
        reading.counts[b"v"],
        len(reading.lost),
        reading.lost_faces,
        notes,
        triangles=reading.triangles,
    )


def _take(reading: _Reading, number: int, line: bytes) -> None:
    words = line.split()
    if not words:
        return
    keyword = words[0]
    if keyword in LEAST:
        if line[:1] != b"v":
            what = f"line {number} has a blank before '{keyword.decode()}'"
            raise FileError(f"{reading.path}: {what}, on which MeshLab fails; remove it")
        _take_numbers(reading, number, words)
    elif keyword == b"f":
        _take_face(reading, number, line, words[1:])
    elif keyword == b"mtllib":
        _check_library(reading.path, number, line.partition(b"mtllib")[2].strip())
    elif b"\0" in keyword:
        raise damaged(reading.path, f"line {number} has a byte of zero")
    elif keyword[:1] == b"#":
        reading.ended = line.strip() == END
        counted = COUNTED.fullmatch(line)
        if counted:
            reading.announced[counted[1]] = int(counted[2])


def _take_numbers(reading: _Reading, number: int, words: list[bytes]) -> None:
    keyword = words[0]
    reading.counts[keyword] += 1
    given = words[1:]
    if b"#" in b"".join(given):
        given = b" ".join(given).partition(b"#")[0].split()
    try:
        numbers = [float(word) for word in given]
    except ValueError as error:
        word = next(word for word in given if not _is_number(word))
        what = f"line {number} has '{shown(word)}' instead of a number"
        raise damaged(reading.path, what) from error
    if len(numbers) < LEAST[keyword]:
        what = f"line {number} has {len(numbers)} numbers, and '{keyword.decode()}' needs"
        raise damaged(reading.path, f"{what} {LEAST[keyword]}")
    if keyword != b"v":
        return
    size = max(map(abs, numbers[:3]))
    if size > LARGEST:
        message = f"{reading.path}: line {number} has the coordinate {size:g}"
        raise FileError(f"{message}, with which nothing can be measured; remove that point")
    if math.isnan(sum(numbers[:3])):
        reading.lost.add(reading.counts[keyword])


def _is_number(word: bytes) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _take_face(reading: _Reading, number: int, line: bytes, corners: list[bytes]) -> None:
    path = reading.path
    if b"#" in line:
        message = f"{path} has a comment behind a face, on which MeshLab's reader fails"
        raise FileError(f"{message}; remove it")
    if len(corners) < 3:
        raise damaged(path, f"the face in line {number} has {len(corners)} corners")
    if len(corners) > MOST_CORNERS:
        message = f"{path}: the face in line {number} has {len(corners)} corners, and MeshLab"
        raise FileError(f"{message} takes too long from {MOST_CORNERS} on; cut it into triangles")
    reading.faces += 1
    reading.triangles += len(corners) - 2
    if b"-" in line:  # counted back from here
        _check_corners(path, corners, reading.counts)
    else:
        reading.corners.update(corners)
    if reading.lost:
        count = reading.counts[b"v"]
        points = [int(corner.split(b"/")[0] or 0) for corner in corners]
        named = {point + 1 + count if point < 0 else point for point in points}
        reading.lost_faces += not named.isdisjoint(reading.lost)


def _check_library(path: Path, number: int, name: bytes) -> None:
    """Refuse devices and the like as libraries of materials: reading one may never end."""
    try:
        file = path.parent / name.decode("utf-8", "surrogateescape")
        special = file.exists() and not file.is_file() and not file.is_dir()
    except (OSError, ValueError):
        return
    if special:
        message = f"{path}: line {number} names {file}, which is no ordinary file"
        raise FileError(f"{message}; remove that line")


def _check_counts(reading: _Reading) -> None:
    """Compare with what MeshLab's own files say of themselves."""
    if reading.ended or not reading.announced:
        return
    found = {b"Vertices": reading.counts[b"v"], b"Faces": reading.faces}
    for what, announced in reading.announced.items():
        if found[what] < announced:
            words = f"it announces {announced} {what.decode().lower()}, and {found[what]} follow"
            raise damaged(reading.path, words)


def _whole_lines(path: Path, file: BinaryIO) -> Iterator[tuple[int, bytes]]:
    """Yield lines and their numbers; one that ends in a backslash goes on in the next."""
    before = b""
    for number, line in enumerate(iter(lambda: file.readline(MOST_BYTES), b""), 1):
        if len(line) == MOST_BYTES:
            raise damaged(path, f"line {number} has more than {MOST_BYTES >> 20} MB")
        stripped = before + line.rstrip()
        if stripped.endswith(b"\\"):
            before = stripped[:-1] + b" "
            if len(before) > MOST_BYTES:
                raise damaged(path, f"line {number} goes on for more than {MOST_BYTES >> 20} MB")
            continue
        before = b""
        yield number, stripped
    if before:
        yield number, before


def _check_corners(path: Path, corners: set[bytes] | list[bytes], counts: dict[bytes, int]) -> None:
    limits = tuple(counts.values())
    for corner in corners:
        indices = corner.split(b"/")
        try:
            numbers = [int(index) if index else 1 for index in indices]
        except ValueError as error:
            raise damaged(path, f"a face has the corner '{shown(corner)}'") from error
        optional = zip(indices[1:], numbers[1:], limits[1:], strict=False)
        pairs = [(numbers[0], limits[0]), *((n, limit) for word, n, limit in optional if word)]
        if len(numbers) > 3 or any(n == 0 or abs(n) > limit for n, limit in pairs):
            what = (
                f"a face has the corner '{shown(corner)}', and there are {limits[0]} vertices, "
                f"{limits[1]} texture coordinates and {limits[2]} normals"
            )
            raise damaged(path, what)
