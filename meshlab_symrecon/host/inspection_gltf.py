"""GLTF and GLB files: corners that name points, and lists that name bytes, which are not there.

MeshLab's reader takes such a number for a place in its memory: it crashes, or gives a wrong mesh.
"""

from __future__ import annotations

import json
import struct
from base64 import b64decode
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np

from meshlab_symrecon.host.held import unusable
from meshlab_symrecon.host.ply_header import damaged

__all__ = ["check_gltf"]

BEGINNING = 12  # bytes of a binary file before its chunks
CHUNK = struct.Struct("<I4s")
INDICES = {5121: "<u1", 5123: "<u2", 5125: "<u4"}
FLOAT, ROW = 5126, 12  # the type of coordinates, and bytes of three
BYTES = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}  # of a component
COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


def check_gltf(path: Path) -> int:
    """Refuse numbers of points and bytes that a file does not have.

    What is no such file at all, the reader itself says.

    Returns
    -------
    int
        How many points have coordinates that are not numbers: MeshLab leaves them out.

    Raises
    ------
    FileError
    """
    try:
        document, binary = _parts(path)
        buffers = [_buffer(path, buffer, binary) for buffer in document["buffers"]]
        problem = next(_problems(document, buffers), "")
        lists = [] if problem else list(_lists(document, buffers))
    except (ValueError, LookupError, TypeError, AttributeError, OSError, RecursionError):
        return 0
    if problem:
        raise damaged(path, problem)
    return sum(int(unusable(path, points).sum()) for points in lists)


def _lists(document: Any, buffers: list[bytes]) -> Iterator[Any]:
    """Yield the points of all primitives, as often as nodes name them."""
    for node in document["nodes"]:
        if "mesh" in node:
            for primitive in document["meshes"][node["mesh"]]["primitives"]:
                yield _points(document, primitive["attributes"]["POSITION"], buffers)


def _points(document: Any, number: int, buffers: list[bytes]) -> Any:
    """Return the points of a list; none when they are all zeros, compressed or of another type."""
    accessor = document["accessors"][number]
    if "bufferView" not in accessor or accessor["componentType"] != FLOAT:
        return np.zeros((0, 3), dtype="<f4")
    buffer, start, end = _place(document, accessor)
    view = document["bufferViews"][accessor["bufferView"]]
    step = int(view.get("byteStride", 0) or ROW)
    shape, steps = (int(accessor["count"]), 3), (step, ROW // 3)
    return np.ndarray(shape, "<f4", buffers[buffer][start:end], strides=steps)


def _problems(document: Any, buffers: list[bytes]) -> Iterator[str]:
    accessors = document["accessors"]
    for mesh in document["meshes"]:
        for primitive in mesh["primitives"]:
            used = dict(primitive["attributes"])
            if "indices" in primitive:
                used["indices"] = primitive["indices"]
            for name, number in used.items():
                if _is_cut(document, accessors[number], buffers):
                    yield f"its {name} reach beyond the {_length(document, number, buffers)} bytes"
            if "indices" in primitive:
                points = int(accessors[used["POSITION"]]["count"])
                highest = _highest(document, accessors[used["indices"]], buffers)
                if highest >= points:
                    yield f"a face names point {highest} of a mesh with {points} points"


def _parts(path: Path) -> tuple[Any, bytes]:
    """Return the document, and the bytes that a binary file holds besides."""
    content = path.read_bytes()
    if not content.startswith(b"glTF"):
        return json.loads(content), b""
    parts: dict[bytes, bytes] = {}
    place = BEGINNING
    while place + CHUNK.size <= len(content):
        length, kind = CHUNK.unpack_from(content, place)
        parts.setdefault(kind, content[place + CHUNK.size : place + CHUNK.size + length])
        place += CHUNK.size + length
    return json.loads(parts[b"JSON"]), parts.get(b"BIN\0", b"")


def _buffer(path: Path, buffer: Any, binary: bytes) -> bytes:
    """Return the bytes of a buffer: in the file, in its text, or in another file."""
    if "uri" not in buffer:
        return binary
    uri = buffer["uri"]
    if uri.startswith("data:"):
        return b64decode(uri.partition(",")[2])
    return (path.parent / unquote(uri)).read_bytes()


def _place(document: Any, accessor: Any) -> tuple[int, int, int]:
    """Return the number of the buffer of a list, and where in it the list begins and ends."""
    view = document["bufferViews"][accessor["bufferView"]]
    each = BYTES[accessor["componentType"]] * COMPONENTS[accessor["type"]]
    start = int(view.get("byteOffset", 0)) + int(accessor.get("byteOffset", 0))
    steps = (int(accessor["count"]) - 1) * int(view.get("byteStride", 0) or each)
    return int(view["buffer"]), start, start + steps + each


def _is_cut(document: Any, accessor: Any, buffers: list[bytes]) -> bool:
    if "bufferView" not in accessor:  # all zeros, or compressed
        return False
    buffer, _, end = _place(document, accessor)
    return end > len(buffers[buffer])


def _length(document: Any, number: int, buffers: list[bytes]) -> int:
    return len(buffers[_place(document, document["accessors"][number])[0]])


def _highest(document: Any, accessor: Any, buffers: list[bytes]) -> int:
    """Return the highest number of a list of corners; -1 for none."""
    if "bufferView" not in accessor or "sparse" in accessor:
        return -1
    buffer, start, end = _place(document, accessor)
    kind = INDICES[accessor["componentType"]]
    return int(np.frombuffer(buffers[buffer][start:end], kind).max(initial=0))
