"""What MeshLab's PLY files lack, put into one that it has written: attributes and edges."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from meshlab_symrecon.arrays import Floats, Indices
from meshlab_symrecon.host.ply_header import Element, Header, read_header
from meshlab_symrecon.host.ply_table import record_of

__all__ = ["Columns", "extend_ply"]

END = b"end_header\n"
CHUNK = 1 << 16  # items that are written at once
Columns = Mapping[str, Mapping[str, Floats]]


def extend_ply(
    file: Path,
    columns: Columns | None = None,
    edges: Indices | None = None,
    change: Callable[[bytes], bytes] = bytes,
) -> None:
    """Add properties and edges to a binary little-endian PLY file.

    Parameters
    ----------
    file : Path
        It is replaced.
    columns : mapping of str to mapping of str to (n,) or (n, 3) float, optional
        New properties of each element, by name; rows of three numbers become lists.
    edges : (k, 2) int, optional
        Their ends.
    change : callable
        What else is done to the text of the header.

    Raises
    ------
    ValueError
        The file ends too early, or has lists of different lengths.
    """
    added = {name: of for name, of in (columns or {}).items() if of}
    header = read_header(file)
    changed = file.with_name(f".changed-{file.name}")
    with file.open("rb") as old, changed.open("wb") as new:
        text = change(old.read(header.start))
        new.write(_extended(text, header, added, edges))
        data = np.memmap(file, dtype=np.uint8, mode="r", offset=header.start)
        start = 0
        for element in header.elements:
            start = _copy(new, data, start, element, added.get(element.name, {}))
        if edges is not None:
            new.write(edges.astype("<i4").tobytes())
    changed.replace(file)


def _extended(text: bytes, header: Header, added: Columns, edges: Indices | None) -> bytes:
    lines = text.splitlines(keepends=True)
    for element in header.elements:
        beginning = f"element {element.name} ".encode()
        place = next(i for i, line in enumerate(lines) if line.startswith(beginning)) + 1
        declared = [
            f"property {'double' if values.ndim == 1 else 'list uchar double'} {name}\n".encode()
            for name, values in added.get(element.name, {}).items()
        ]
        place += len(element.properties)
        lines[place:place] = declared
    if edges is not None:
        declaration = f"element edge {len(edges)}\nproperty int vertex1\nproperty int vertex2\n"
        lines.insert(lines.index(END), declaration.encode())
    return b"".join(lines)


def _copy(
    new: BinaryIO, data: Any, start: int, element: Element, added: Mapping[str, Floats]
) -> int:
    """Copy an element's items, each followed by its new properties; return where they ended."""
    if element.count == 0:
        return start
    record = record_of(data, start, "binary_little_endian", element)
    if record is None:
        raise ValueError(f"the exporter wrote the element '{element.name}' in lists or not whole")
    width = record.itemsize
    end = start + element.count * width
    rows = data[start:end].reshape(element.count, width)
    for first in range(0, element.count, CHUNK):
        part = slice(first, first + CHUNK)
        blocks = [rows[part], *(_bytes_of(values[part]) for values in added.values())]
        new.write(np.hstack(blocks).tobytes())
    return end


def _bytes_of(values: Floats) -> Any:
    numbers = np.ascontiguousarray(values, dtype="<f8")
    raw = numbers.view(np.uint8).reshape(len(values), -1)
    if values.ndim == 1:
        return raw
    return np.hstack([np.full((len(values), 1), values.shape[1], dtype=np.uint8), raw])
