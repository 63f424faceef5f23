"""CTM files: counts of points and faces that so many bytes cannot hold, however well packed."""

from __future__ import annotations

import struct
from pathlib import Path

from meshlab_symrecon.host.ply_header import damaged

__all__ = ["check_ctm"]

MARK = b"OCTM"
COUNTS = struct.Struct("<IIII")  # of points, faces, texture coordinates and attributes of points
PLACE = 12  # of the counts, behind the mark, the version and the way of packing
MAPS = 8  # of either kind that the format has
A_BYTE = 1000  # points or faces that a byte holds at most: scans are packed a hundred times worse


def check_ctm(path: Path) -> int:
    """Compare the counts in the header with the size; return 0.

    A point that is no number makes MeshLab read nothing of the file.

    Raises
    ------
    FileError
        It begins otherwise, or announces more than it can hold.
    """
    with path.open("rb") as file:
        header = file.read(PLACE + COUNTS.size)
    if not header.startswith(MARK) or len(header) < PLACE + COUNTS.size:
        raise damaged(path, "it does not begin as .ctm files do")
    size = path.stat().st_size
    points, faces, *maps = COUNTS.unpack_from(header, PLACE)
    for count, what in ((points, "points"), (faces, "faces")):
        if count > A_BYTE * size:
            raise damaged(
                path, f"its {size} bytes cannot hold the {count} {what} that it announces"
            )
    if max(maps) > MAPS:
        raise damaged(path, f"it announces {max(maps)} values of a point, and {MAPS} can be")
    return 0
