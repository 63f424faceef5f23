"""PLY files of types that MeshLab misreads, read through a copy in types that it reads.

Doubles in the order of bytes of big-endian machines come out as garbage, without an error; lists
with indices of one byte or lengths of two, and whole coordinates, are refused.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from meshlab_symrecon.host.ply_header import Element, Header, Property, read_header
from meshlab_symrecon.host.ply_rows import Rows, rows_of

__all__ = ["with_plain_data"]

AXES = ("x", "y", "z")
LISTS = ("vertex_indices", "vertex_index", "texcoord", "color")
READ_WELL = {("u1", "i4"), ("u1", "u4"), ("u1", "i2"), ("i4", "i4")}  # length and index
WORDS = {
    "i1": "char", "u1": "uchar", "i2": "short", "u2": "ushort", "i4": "int", "u4": "uint",
    "f4": "float", "f8": "double",
}  # fmt: skip


@contextmanager
def with_plain_data(path: Path) -> Iterator[Path]:
    """Yield a path under which MeshLab reads a PLY file that has been checked."""
    header = read_header(path)
    big = header.form == "binary_big_endian"
    if all(_is_read_well(item, big) for element in header.elements for item in _read(element)):
        yield path
        return
    with tempfile.TemporaryDirectory(prefix="symrecon-") as folder:
        copy = Path(folder, path.name)
        _write(path, header, copy)
        yield copy


def _read(element: Element) -> tuple[Property, ...]:
    """Return what MeshLab reads or has to pass over."""
    return element.properties if element.count else ()


def _is_read_well(item: Property, big: bool) -> bool:
    if big and (item.kind == "f8" or item.length_kind not in ("", "u1", "i1")):
        return False
    if item.name in LISTS[:2] and item.length_kind:
        return (item.length_kind, item.kind) in READ_WELL
    return item.name not in AXES or item.kind in ("f4", "f8")


def _plain(item: Property) -> Property:
    """Return the property in the types in which it is read well."""
    if item.name in LISTS[:2] and item.length_kind:
        return Property(item.name, "i4", "u1")
    if item.name in LISTS and item.length_kind:
        return Property(item.name, item.kind, "u1")
    if item.name in AXES and item.kind not in ("f4", "f8"):
        return Property(item.name, "f8")
    return item


def _write(path: Path, header: Header, copy: Path) -> None:
    with path.open("rb") as file:
        beginning = file.read(header.start)
    words = _words(path, header)
    start = 0
    with copy.open("wb") as file:
        file.write(_header_text(beginning, header))
        for element in header.elements:
            rows = rows_of(words, start, header.form, element)
            if element.count:
                file.write(_even(rows) if rows.places is None else _uneven(rows))
            start = rows.end


def _words(path: Path, header: Header) -> Any:
    if header.form != "ascii":
        return np.memmap(path, dtype=np.uint8, mode="r", offset=header.start)
    with path.open("rb") as file:
        file.seek(header.start)
        return np.fromfile(file, dtype=np.float64, sep=" ")


def _header_text(beginning: bytes, header: Header) -> bytes:
    properties = iter([item for element in header.elements for item in element.properties])
    lines = []
    for line in beginning.splitlines():
        words = line.split()
        if words[:1] == [b"format"]:
            lines.append(b"format binary_little_endian 1.0")
        elif words[:1] == [b"property"]:
            item = _plain(next(properties))
            kinds = [f"list {WORDS[item.length_kind]}"] if item.length_kind else []
            text = " ".join(["property", *kinds, WORDS[item.kind], item.name])
            lines.append(text.encode("latin-1"))
        else:
            lines.append(line.strip())
    return b"".join(line + b"\n" for line in lines)


def _even(rows: Rows) -> bytes:
    """Return the items of an element whose lists are of one length."""
    fields: list[Any] = []
    for number, item in enumerate(map(_plain, rows.element.properties)):
        if item.length_kind:
            fields.append((f"n{number}", "<" + item.length_kind))
        fields.append((f"v{number}", "<" + item.kind, rows.table.dtype[f"v{number}"].shape))
    plain = np.zeros(rows.element.count, fields)
    for name in plain.dtype.names or ():
        plain[name] = rows.table[name]
    return plain.tobytes()


def _uneven(rows: Rows) -> bytes:
    pieces: list[list[bytes]] = []
    for number, old in enumerate(rows.element.properties):
        item = _plain(old)
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
