"""Strips of triangles in PLY files: what MeshLab's reader crashes on."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from meshlab_symrecon.errors import FileError
from meshlab_symrecon.host.ply_header import damaged
from meshlab_symrecon.host.ply_plain import STRIPS, is_kept
from meshlab_symrecon.host.ply_rows import Rows

__all__ = ["check_strips"]

END = -1  # what stands between two strips of one list
LEAST = 3  # corners of a strip that another one follows


def check_strips(path: Path, rows: Rows, points: int) -> None:
    """Check the strips of triangles that MeshLab reads.

    Raises
    ------
    FileError
        One names a vertex that is not there, or has fewer than three corners before its end.
    """
    for number, item in enumerate(rows.element.properties):
        if not is_kept(STRIPS, item):
            continue
        for places, lists in rows.lists(number):
            for place, strip in zip(places.tolist(), lists, strict=True):
                _check_strip(path, place + 1, strip, points)


def _check_strip(path: Path, number: int, strip: Any, points: int) -> None:
    wrong = (strip != END) & ~((strip >= 0) & (strip < points) & (strip == np.floor(strip)))
    if wrong.any():
        what = f"strip {number} names vertex {strip[wrong][0]:g}, and there are {points}"
        raise damaged(path, what)
    ends = np.flatnonzero(strip == END)
    if len(ends) and np.diff(ends, prepend=-1).min() <= LEAST:
        message = f"{path}: strip {number} ends after fewer than {LEAST} corners, on which"
        raise FileError(f"{message} MeshLab's reader fails; write triangles")
