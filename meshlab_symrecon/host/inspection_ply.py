"""The data of PLY files: whether all of it is there, and whether it can be what it says."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from meshlab_symrecon.errors import FileError
from meshlab_symrecon.host.held import Held, unusable
from meshlab_symrecon.host.number_lines import blocks_of
from meshlab_symrecon.host.ply_header import Header, damaged, read_header
from meshlab_symrecon.host.ply_plain import STRIPS, is_kept
from meshlab_symrecon.host.ply_rows import Rows, rows_of
from meshlab_symrecon.host.ply_strips import check_strips

__all__ = ["check_ply"]

AXES = ("x", "y", "z")
CORNERS = ("vertex_indices", "vertex_index")
LEAST = 3  # corners of a face
# MeshLab's reader has room for so many, and goes on behind its end.
MOST: Mapping[str, int] = {**dict.fromkeys(CORNERS, 255), "texcoord": 32, "color": 32}


def check_ply(path: Path) -> Held:
    """Check a PLY file's header against its data, and the data against the header.

    Raises
    ------
    FileError
        The header is damaged, has no points with x, y and z, or announces more than the file holds;
        a face names a vertex that is not there, or has fewer than three corners or more than
        MeshLab can read, and so for strips of triangles; a coordinate is infinite.
    """
    header = read_header(path)
    _check_header(path, header)
    words = _words(path, header)
    start = 0
    points = np.zeros(0, dtype=np.bool_)  # which ones nobody can use
    strips: list[Rows] = []
    lost_faces = triangles = 0
    for element in header.elements:
        try:
            rows = rows_of(words, start, header.form, element)
        except ValueError as error:
            raise damaged(path, str(error)) from error
        if element.name == "vertex":
            points = _lost_points(path, rows)
        elif element.name == "face":
            lost_faces, triangles = _lost_faces(path, rows, points)
        elif element.name == STRIPS and element.count:
            strips.append(rows)
        start = rows.end
    for rows in strips:
        check_strips(path, rows, len(points))
    if points.all():
        raise FileError(f"{path} holds no points; scan again or pick another file")
    notes = _notes(path, header, len(words), start)
    return Held(len(points), int(points.sum()), lost_faces, notes, triangles=triangles)


def _notes(path: Path, header: Header, held: int, used: int) -> tuple[str, ...]:
    notes = []
    if held > used:
        unit = "numbers" if header.form == "ascii" else "bytes"
        words = f"{held - used} {unit} behind what its header announces; they were left out"
        notes.append(f"{path} has {words}")
    strips = header.element(STRIPS)
    if (
        strips is not None
        and strips.count
        and not any(is_kept(STRIPS, it) for it in strips.properties)
    ):
        words = (
            "triangle strips that MeshLab does not read; write triangles, or them as lists of int"
        )
        notes.append(f"{path} has {words}")
    return tuple(notes)


def _check_header(path: Path, header: Header) -> None:
    names = [element.name for element in header.elements]
    for element in header.elements:
        if names.count(element.name) > 1:
            raise damaged(path, f"its header declares '{element.name}' twice")
        if element.count and not element.properties:
            what = f"its header announces {element.count} of '{element.name}' without properties"
            raise damaged(path, what)
        properties = [item.name for item in element.properties]
        again = [name for name in properties if properties.count(name) > 1]
        if again:
            raise damaged(path, f"its header declares '{again[0]}' of '{element.name}' twice")
    vertex = header.element("vertex")
    lists = [] if vertex is None else [one.name for one in vertex.properties if one.length_kind]
    if vertex is None or not set(AXES) <= vertex.names - set(lists):
        raise damaged(path, "its header declares no vertices with x, y and z")
    if vertex.count == 0:
        raise FileError(f"{path} holds no points; scan again or pick another file")


def _needed(header: Header) -> int:
    """Return how many bytes or numbers the data has at least."""
    if header.form == "ascii":
        return sum(element.least_words for element in header.elements)
    return sum(element.least_bytes for element in header.elements)


def _words(path: Path, header: Header) -> Any:
    """Return the numbers of an ascii file, or the bytes of another one."""
    needed = _needed(header)
    held = path.stat().st_size - header.start
    unit = "bytes"
    words: Any = None
    if header.form == "ascii":
        words = _numbers(path, header)
        held, unit = len(words), "numbers"
    if held < needed:
        what = f"its header announces at least {needed} {unit} of data, and {held} follow"
        raise damaged(path, what)
    if words is None:
        words = np.memmap(path, dtype=np.uint8, mode="r", offset=header.start)
    return words


def _numbers(path: Path, header: Header) -> Any:
    with path.open("rb") as file, warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)  # how numpy tells of a word
        file.seek(header.start)
        try:
            return np.fromfile(file, dtype=np.float64, sep=" ")
        except (DeprecationWarning, ValueError):  # by the version of numpy
            file.seek(0)
            before = file.read(header.start).count(b"\n")
            for _ in blocks_of(path, file, before + 1):
                pass  # until the word is found
            raise damaged(path, "it has a comment among its numbers") from None


def _lost_points(path: Path, rows: Rows) -> Any:
    """Say of each point whether a coordinate is not a number."""
    names = [item.name for item in rows.element.properties]
    columns = [names.index(axis) for axis in AXES]
    kinds = [np.dtype(rows.element.properties[column].kind) for column in columns]
    lost = np.zeros(rows.element.count, dtype=np.bool_)
    for part in rows.parts():
        found = [rows.values(column, part) for column in columns]
        with np.errstate(over="ignore"):  # a text may have a number that its type cannot hold
            found = [one.astype(kind) for one, kind in zip(found, kinds, strict=True)]
        lost[part] = unusable(path, np.column_stack(found), part.start)
    return lost


def _lost_faces(path: Path, rows: Rows, points: Any) -> tuple[int, int]:
    """Check faces; return how many use a point that nobody can use, and how many triangles."""
    lost = triangles = 0
    for number, item in enumerate(rows.element.properties):
        if not item.length_kind or item.name not in MOST:
            continue
        for faces, lists in rows.lists(number):
            _check_length(path, item.name, faces, lists.shape[1])
            if item.name in CORNERS:
                lost += _lost_corners(path, faces, lists, points)
                triangles += lists.size - 2 * len(lists)
    return lost, triangles


def _check_length(path: Path, name: str, faces: Any, length: int) -> None:
    first = int(faces[0]) + 1
    if name in CORNERS and length < LEAST:
        raise damaged(path, f"face {first} has {length} corners")
    if length > MOST[name]:
        message = f"{path}: face {first} has a list '{name}' of {length} numbers, and MeshLab reads"
        raise FileError(f"{message} {MOST[name]} at most; cut it into triangles")


def _lost_corners(path: Path, faces: Any, corners: Any, points: Any) -> int:
    with np.errstate(invalid="ignore"):
        wrong = ~((corners >= 0) & (corners < len(points)))
    if corners.dtype.kind == "f":
        wrong |= corners != np.floor(corners)
    if wrong.any():
        row, column = (int(index) for index in np.argwhere(wrong)[0])
        what = f"face {int(faces[row]) + 1} names vertex {corners[row, column]:g}"
        raise damaged(path, f"Bad vertex index: {what}, and there are {len(points)}")
    if not points.any():
        return 0
    return int(points[corners.astype(np.int64)].any(axis=1).sum())
