"""PLY files of types that MeshLab misreads, read through a copy in types that it reads.

Doubles in the order of bytes of big-endian machines come out as garbage, without an error; lists
with indices of one byte or lengths of two, and whole coordinates, are refused. Of lists that it
does not keep it passes over the wrong number of bytes, or writes behind the end of its memory;
the copy is without them.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from meshlab_symrecon.errors import FileError
from meshlab_symrecon.host.atomic import reason
from meshlab_symrecon.host.ply_header import Element, Header, Property, read_header
from meshlab_symrecon.host.ply_rows import Rows, rows_of

__all__ = ["STRIPS", "is_kept", "with_plain_data"]

AXES = ("x", "y", "z")
CORNERS = ("vertex_indices", "vertex_index")
STRIPS = "tristrips"  # MeshLab crashes on those of other types
WEDGES = ("texcoord", "color")
REAL = ("f4", "f8")
ONE_BYTE = ("u1", "i1")
READ_WELL = {("u1", "i4"), ("u1", "u4"), ("u1", "i2"), ("i4", "i4")}  # length and index
PASSED_OVER = 512  # bytes of a list: MeshLab passes over so many, and fails at the latest at 1020
WORDS = {
    "i1": "char", "u1": "uchar", "i2": "short", "u2": "ushort", "i4": "int", "u4": "uint",
    "f4": "float", "f8": "double",
}  # fmt: skip


@contextmanager
def with_plain_data(path: Path) -> Iterator[Path]:
    """Yield a path under which MeshLab reads a PLY file that has been checked.

    Raises
    ------
    FileError
        The system refused to write a copy.
    """
    header = read_header(path)
    if _is_plain(header) and _passes_over(path, header):
        yield path
        return
    with tempfile.TemporaryDirectory(prefix="symrecon-") as folder:
        copy = Path(folder, path.name)
        try:
            _write(path, header, copy)
        except OSError as error:
            message = f"{path} is read through a copy, which cannot be written in {folder}"
            words = f"{message}: {reason(error)}; free space there or set TMPDIR"
            raise FileError(words) from error
        yield copy


def is_kept(element: str, item: Property) -> bool:
    """Say whether MeshLab keeps a list of an element of that name, in one type or another."""
    if element == "face" and item.name in WEDGES:
        return item.kind in REAL
    if element == STRIPS:
        return item.name in CORNERS and (item.length_kind, item.kind) == ("i4", "i4")
    return element == "face" and item.name in CORNERS


def _is_plain(header: Header) -> bool:
    """Say whether all properties are of types that MeshLab reads."""
    return all(
        _is_read_well(element.name, item, header.form)
        for element in header.elements
        for item in (element.properties if element.count else ())
    )


def _is_read_well(element: str, item: Property, form: str) -> bool:
    big = form == "binary_big_endian"
    if big and (item.kind == "f8" or item.length_kind not in ("", *ONE_BYTE)):
        return False
    if not item.length_kind:
        return item.name not in AXES or item.kind in REAL
    if element == STRIPS:
        return is_kept(element, item)
    if not is_kept(element, item):
        return form == "ascii" or item.length_kind in ONE_BYTE
    if item.name in WEDGES:
        return (item.length_kind, item.kind) == ("u1", "f4")
    return (item.length_kind, item.kind) in READ_WELL


def _passes_over(path: Path, header: Header) -> bool:
    """Say whether MeshLab passes over all lists that it does not keep, whose types it knows."""
    others = [one for one in header.elements if any(_is_left_out(one, it) for it in one.properties)]
    if header.form == "ascii" or not any(element.count for element in others):
        return True
    words = _words(path, header)
    start = 0
    for element in header.elements:
        rows = rows_of(words, start, header.form, element)
        start = rows.end
        for number, item in enumerate(element.properties):
            if not element.count or not _is_left_out(element, item):
                continue
            for _, lists in rows.lists(number):
                if not 0 < lists.shape[1] * lists.itemsize <= PASSED_OVER:
                    return False
    return True


def _is_left_out(element: Element, item: Property) -> bool:
    """Say whether the copy is without a property."""
    return bool(item.length_kind) and not is_kept(element.name, item)


def _plain(element: str, item: Property) -> Property:
    """Return the property in the types in which it is read well."""
    if item.length_kind and element == STRIPS:
        return item
    if item.length_kind:
        return Property(item.name, "f4" if item.name in WEDGES else "i4", "u1")
    if item.name in AXES and item.kind not in REAL:
        return Property(item.name, "f8")
    return item


def _copied(element: Element) -> tuple[tuple[int, Property], ...]:
    """Return the places and new types of the properties that the copy has."""
    return tuple(
        (number, _plain(element.name, item))
        for number, item in enumerate(element.properties)
        if not _is_left_out(element, item)
    )


def _write(path: Path, header: Header, copy: Path) -> None:
    with path.open("rb") as file:
        beginning = file.read(header.start)
    words = _words(path, header)
    start = 0
    with copy.open("wb") as file:
        file.write(_header_text(beginning, header))
        for element in header.elements:
            rows = rows_of(words, start, header.form, element)
            if element.count and _copied(element):
                file.write(_even(rows) if rows.places is None else _uneven(rows))
            start = rows.end


def _words(path: Path, header: Header) -> Any:
    if header.form != "ascii":
        return np.memmap(path, dtype=np.uint8, mode="r", offset=header.start)
    with path.open("rb") as file:
        file.seek(header.start)
        return np.fromfile(file, dtype=np.float64, sep=" ")


def _header_text(beginning: bytes, header: Header) -> bytes:
    elements = iter(header.elements)
    lines = []
    for line in beginning.splitlines():
        words = line.split()
        if words[:1] == [b"format"]:
            lines.append(b"format binary_little_endian 1.0")
        elif words[:1] == [b"element"]:
            lines += _declared(next(elements))
        elif words[:1] != [b"property"]:
            lines.append(line.strip())
    return b"".join(line + b"\n" for line in lines)


def _declared(element: Element) -> list[bytes]:
    """Return the lines that declare an element of the copy; none when nothing of it is left."""
    lines = []
    for _, item in _copied(element):
        kinds = [f"list {WORDS[item.length_kind]}"] if item.length_kind else []
        lines.append(" ".join(["property", *kinds, WORDS[item.kind], item.name]))
    if lines:
        lines.insert(0, f"element {element.name} {element.count}")
    return [line.encode("latin-1") for line in lines]


def _even(rows: Rows) -> bytes:
    """Return the items of an element whose lists are of one length."""
    fields: list[Any] = []
    for number, item in _copied(rows.element):
        if item.length_kind:
            fields.append((f"n{number}", "<" + item.length_kind))
        fields.append((f"v{number}", "<" + item.kind, rows.table.dtype[f"v{number}"].shape))
    plain = np.zeros(rows.element.count, fields)
    for name in plain.dtype.names or ():
        plain[name] = rows.table[name]
    return plain.tobytes()


def _uneven(rows: Rows) -> bytes:
    pieces: list[list[bytes]] = []
    for number, item in _copied(rows.element):
        if not item.length_kind:
            values = rows.values(number, slice(0, rows.element.count)).astype("<" + item.kind)
            pieces.append([value.tobytes() for value in values])
            continue
        lists = [b""] * rows.element.count
        for items, values in rows.lists(number):
            length = np.array(values.shape[1], "<" + item.length_kind).tobytes()
            for place, row in zip(items.tolist(), values.astype("<" + item.kind), strict=True):
                lists[place] = length + row.tobytes()
        pieces.append(lists)
    return b"".join(piece for item in zip(*pieces, strict=True) for piece in item)
