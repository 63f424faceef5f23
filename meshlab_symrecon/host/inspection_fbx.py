"""FBX files: points that are no numbers, which MeshLab leaves out without a word."""

from __future__ import annotations

import re
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from meshlab_symrecon.host.held import unusable
from meshlab_symrecon.host.inspection_xml import check_numbers

__all__ = ["check_fbx"]

BINARY = b"Kaydara FBX Binary"
POINTS = re.compile(rb"\x08Vertices([df])")  # the length of a name, the name, the type of an array
CORNERS = re.compile(rb"\x12PolygonVertexIndex(i)")
ARRAY = struct.Struct("<III")  # how many numbers, whether they are packed, and in how many bytes
TYPES = {b"d": "<f8", b"f": "<f4", b"i": "<i4"}
MOST = 1 << 31  # bytes that an array may unpack to


def check_fbx(path: Path) -> int:
    """Count the points of faces that are not numbers.

    Raises
    ------
    FileError
        A coordinate is infinite; or, in an FBX file of text, no number at all.
    """
    content = path.read_bytes()
    if not content.startswith(BINARY):
        check_numbers(path)
        return 0
    found = [_array(content, match) for match in POINTS.finditer(content)]
    corners = [_array(content, match) for match in CORNERS.finditer(content)]
    lost = 0
    for numbers, named in zip(found, corners, strict=False):
        points = numbers[: len(numbers) - len(numbers) % 3].reshape(-1, 3)
        wrong = np.flatnonzero(unusable(path, points))
        used = np.where(named < 0, -1 - named, named)  # the last corner of a face is told so
        lost += int(np.isin(wrong, used).sum())
    return lost


def _array(content: bytes, match: re.Match[bytes]) -> NDArray[Any]:
    """Return the numbers behind a name; none when they are not whole: the reader says so."""
    kind = np.dtype(TYPES[match[1]])
    if len(content) < match.end() + ARRAY.size:
        return np.zeros(0, kind)
    count, packed, length = ARRAY.unpack_from(content, match.end())
    start = match.end() + ARRAY.size
    data = content[start : start + length]
    size = count * kind.itemsize
    if packed and size < MOST:
        try:
            data = zlib.decompressobj().decompress(data, size)
        except zlib.error:
            return np.zeros(0, kind)
    return np.frombuffer(data, kind, count) if len(data) >= size else np.zeros(0, kind)
