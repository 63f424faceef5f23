"""BRE files, grids of a Breuckmann scanner: places outside of the grid, and what they hold.

MeshLab's reader writes a point of such a place behind its memory.
"""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np

from meshlab_symrecon.host.held import Held, unusable
from meshlab_symrecon.host.ply_header import damaged

__all__ = ["check_bre"]

SMALLEST, LARGEST = 256, 1024  # bytes of a header that MeshLab has room for
MARK = slice(6, 8)
POINT = np.dtype([("place", "<f4", 3), ("quality", "u1"), ("", "u1"), ("pixel", "<u2", 2),
                  ("colour", "<u2")])  # fmt: skip


def check_bre(path: Path) -> Held:
    """Compare the points of a file with its grid; return what it holds.

    Raises
    ------
    FileError
        It is cut off, a point lies outside of the grid, or has an infinite coordinate.
    """
    with path.open("rb") as file:
        header = file.read(SMALLEST)
    if header[MARK] != b"BR" or len(header) < SMALLEST:
        raise damaged(path, "it does not begin as .bre files do")
    (size,) = struct.unpack_from("<H", header, 4)
    grid = struct.unpack_from("<HH", header, 14)
    data = path.stat().st_size - size
    if not SMALLEST <= size <= LARGEST or data < 0 or data % POINT.itemsize:
        raise damaged(path, f"behind its header of {size} bytes are no whole points")
    points = np.fromfile(path, POINT, offset=size)
    outside = (points["pixel"] >= np.array(grid)).any(axis=1)
    if outside.any():
        at = int(np.argmax(outside))
        column, row = points["pixel"][at].tolist()
        what = f"point {at + 1} is in column {column} and row {row} of a grid of"
        raise damaged(path, f"{what} {grid[0]} columns and {grid[1]} rows")
    lost = unusable(path, points["place"])
    different = len(np.unique(points["place"][~lost], axis=0))  # MeshLab joins equal ones
    return Held(different + int(lost.sum()), int(lost.sum()))
