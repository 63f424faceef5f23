"""The header of a PLY file: its format, its elements and their properties."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from meshlab_symrecon.errors import FileError

__all__ = ["Element", "Header", "Property", "damaged", "read_header"]

HEADER_LIMIT = 1 << 20  # bytes; comments included, no PLY header in use comes near
KINDS = {
    **dict.fromkeys(("char", "int8"), "i1"),
    **dict.fromkeys(("uchar", "uint8"), "u1"),
    **dict.fromkeys(("short", "int16"), "i2"),
    **dict.fromkeys(("ushort", "uint16"), "u2"),
    **dict.fromkeys(("int", "int32"), "i4"),
    **dict.fromkeys(("uint", "uint32"), "u4"),
    **dict.fromkeys(("float", "float32"), "f4"),
    **dict.fromkeys(("double", "float64"), "f8"),
}  # PLY's word: numpy's code, without the order of bytes
FORMATS = ("ascii", "binary_little_endian", "binary_big_endian")


@dataclass(frozen=True, slots=True)
class Property:
    """One property of an element.

    Attributes
    ----------
    name : str
    kind : str
        numpy's code of its numbers without the order of bytes, such as ``f4``.
    length_kind : str
        The same of a list's length; empty for a single number.
    """

    name: str
    kind: str
    length_kind: str = ""

    @property
    def least_bytes(self) -> int:
        """The bytes that it takes at least: a list may be empty."""
        return int((self.length_kind or self.kind)[1])


@dataclass(frozen=True, slots=True)
class Element:
    """One element: its name, how many follow, and the properties of each."""

    name: str
    count: int
    properties: tuple[Property, ...]

    @property
    def names(self) -> frozenset[str]:
        """The names of its properties."""
        return frozenset(item.name for item in self.properties)

    @property
    def least_bytes(self) -> int:
        """The bytes that all of it takes at least, in a binary file."""
        return self.count * sum(item.least_bytes for item in self.properties)

    @property
    def least_words(self) -> int:
        """The numbers that all of it takes at least, in an ascii file."""
        return self.count * len(self.properties)


@dataclass(frozen=True, slots=True)
class Header:
    """A PLY header.

    Attributes
    ----------
    form : str
        One of ``FORMATS``.
    elements : tuple of Element
        In the order of the file.
    start : int
        Where the data begins, in bytes.
    """

    form: str
    elements: tuple[Element, ...]
    start: int

    def element(self, name: str) -> Element | None:
        """Return the element of that name."""
        return next((element for element in self.elements if element.name == name), None)


def read_header(path: Path) -> Header:
    """Read a PLY file's header.

    Raises
    ------
    FileError
        It is damaged.
    """
    with path.open("rb") as file:
        lines = _lines(path, file)
        start = file.tell()
    form = ""
    elements: list[tuple[str, int, list[Property]]] = []
    for line in lines:
        words = line.split()
        try:
            if not words or words[0] in ("comment", "obj_info"):
                continue
            if words[0] == "format" and words[1] in FORMATS:
                form = words[1]
            elif words[0] == "element" and int(words[2]) >= 0:
                elements.append((words[1], int(words[2]), []))
            elif words[0] == "property":
                elements[-1][2].append(_property(words[1:]))
            else:
                raise damaged(path, f"its header has the line '{line:.60}'")
        except (IndexError, KeyError, ValueError) as error:
            raise damaged(path, f"its header has the line '{line:.60}'") from error
    if not form:
        raise damaged(path, "its header names no format")
    declared = tuple(Element(name, count, tuple(items)) for name, count, items in elements)
    return Header(form, declared, start)


def _lines(path: Path, file: BinaryIO) -> list[str]:
    if file.readline(8).strip() != b"ply":
        raise damaged(path, "it does not start with the word 'ply'")
    lines: list[str] = []
    while file.tell() < HEADER_LIMIT:
        line = file.readline(HEADER_LIMIT)
        words = line.decode("latin-1").strip()
        if words == "end_header":
            return lines
        if not line:
            break
        lines.append(words)
    raise damaged(path, "its header has no end")


def _property(words: list[str]) -> Property:
    if words[0] == "list":
        return Property(" ".join(words[3:]) or words[3], KINDS[words[2]], KINDS[words[1]])
    return Property(" ".join(words[1:]) or words[1], KINDS[words[0]])


def damaged(path: Path, what: str) -> FileError:
    """Return the error for a file that cannot be right."""
    return FileError(f"{path} is damaged: {what}; write or download it again")
