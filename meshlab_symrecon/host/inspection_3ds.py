"""3DS files: faces that name vertices, and materials that name faces, which are not there.

MeshLab's reader takes such a number for a place in its memory: it crashes, or gives a wrong mesh.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt

from meshlab_symrecon.host.held import unusable
from meshlab_symrecon.host.ply_header import damaged

__all__ = ["check_3ds"]

HEADER = struct.Struct("<HI")  # of a chunk: what it is, and its length with this header
COUNT = 2  # bytes
MAIN, EDITOR, OBJECT, MESH = 0x4D4D, 0x3D3D, 0x4000, 0x4100
POINTS, FACES, MATERIAL, TEXTURE = 0x4110, 0x4120, 0x4130, 0x4140
FLOAT = 4  # bytes
FACE = 4  # numbers of two bytes: three corners and flags


def check_3ds(path: Path) -> int:
    """Refuse numbers of vertices and faces that a mesh does not have.

    Returns
    -------
    int
        How many points of faces have coordinates that are not numbers: MeshLab leaves them out.

    Raises
    ------
    FileError
    """
    lost = 0
    content = memoryview(path.read_bytes())
    for _, main in _chunks(content, MAIN):
        for _, editor in _chunks(main, EDITOR):
            for _, thing in _chunks(editor, OBJECT):
                for _, mesh in _chunks(_behind_name(thing), MESH):
                    lost += _check_mesh(path, mesh)
    return lost


def _chunks(content: memoryview, *kinds: int) -> Iterator[tuple[int, memoryview]]:
    """Yield the chunks of these kinds; what lies behind a broken one, no reader finds."""
    place = 0
    while place + HEADER.size <= len(content):
        kind, length = HEADER.unpack_from(content, place)
        if length < HEADER.size:
            return
        if kind in kinds:
            yield kind, content[place + HEADER.size : place + length]
        place += length


def _behind_name(content: memoryview) -> memoryview:
    return content[bytes(content).find(b"\0") + 1 :]


def _check_mesh(path: Path, mesh: memoryview) -> int:
    """Check the faces of one mesh, whatever the order of its chunks; count its unusable points."""
    parts = list(_chunks(mesh, POINTS, FACES, TEXTURE))
    counts = {kind: _count(part) for kind, part in parts}
    points, textured = counts.get(POINTS, 0), counts.get(TEXTURE, 0)
    known = min(points, textured) if textured else points
    used: set[int] = set()
    for kind, part in parts:
        if kind != FACES:
            continue
        faces = _numbers(part, FACE).reshape(-1, FACE)
        highest = int(faces[:, :3].max(initial=-1))
        if highest >= known:
            what = "points" if highest >= points else "texture coordinates"
            raise damaged(path, f"a face names point {highest} of a mesh with {known} {what}")
        used.update(faces[:, :3].ravel().tolist())
        for _, group in _chunks(part[COUNT + 2 * FACE * len(faces) :], MATERIAL):
            highest = int(_numbers(_behind_name(group), 1).max(initial=-1))
            if highest >= len(faces):
                message = f"a material names face {highest} of a mesh with {len(faces)} faces"
                raise damaged(path, message)
    return sum(_unusable(path, part, used) for kind, part in parts if kind == POINTS)


def _unusable(path: Path, part: memoryview, used: set[int]) -> int:
    """Count the points that faces use and that are not numbers."""
    count = min(_count(part), (len(part) - COUNT) // (3 * FLOAT))
    points = np.frombuffer(part[COUNT:], "<f4", max(0, count) * 3).reshape(-1, 3)
    lost = np.flatnonzero(unusable(path, points))
    return len(used.intersection(lost.tolist()))


def _count(part: memoryview) -> int:
    return int.from_bytes(part[:COUNT], "little")


def _numbers(part: memoryview, each: int) -> npt.NDArray[np.int64]:
    """Return the numbers behind a count, as many whole entries as there are."""
    entries = min(_count(part), (len(part) - COUNT) // (2 * each))
    return np.frombuffer(part[COUNT:], "<u2", max(0, entries) * each).astype(np.int64)
