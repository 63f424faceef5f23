"""Text files of numbers, block by block: the numbers, and how many each line has."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np

from meshlab_symrecon.arrays import Floats, Indices
from meshlab_symrecon.errors import FileError
from meshlab_symrecon.host.ply_header import damaged

__all__ = [
    "Block",
    "block_of",
    "blocks_of",
    "check_plain_text",
    "numbers_in",
    "shown",
    "whole_lines",
]

CHUNK = 1 << 22  # bytes
BEGINNING = 1 << 12  # bytes
LONGEST = 1 << 26  # bytes of a line; what is longer is no text of numbers
COMMENT = re.compile(rb"#[^\n]*")
BLANKS = np.zeros(256, dtype=np.bool_)
BLANKS[list(b" \t\r\n\v\f")] = True
MARKS = {b"\xff\xfe": "UTF-16", b"\xfe\xff": "UTF-16"}
ARCHIVES = {b"\x1f\x8b": "gzip", b"PK\x03\x04": "zip", b"BZh": "bzip2", b"\xfd7zXZ": "xz"}


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """Some whole lines, without the blank ones.

    Attributes
    ----------
    numbers : (total,) float
    counts : (n,) int
        How many numbers each line has.
    lines : (n,) int
        Their numbers in the file, from 1 on.
    """

    numbers: Floats
    counts: Indices
    lines: Indices

    def starts(self) -> Indices:
        """Return where in ``numbers`` each line begins."""
        return np.cumsum(self.counts) - self.counts


def check_plain_text(path: Path) -> None:
    """Refuse what is no text of lines.

    Raises
    ------
    FileError
        It is UTF-16, a compressed file, or its lines end in carriage returns alone.
    """
    with path.open("rb") as file:
        beginning = file.read(BEGINNING)
    for mark, name in MARKS.items():
        if beginning.startswith(mark):
            raise FileError(f"{path} is {name} text, which MeshLab does not read; save it as UTF-8")
    for mark, name in ARCHIVES.items():
        if beginning.startswith(mark):
            raise FileError(f"{path} is compressed by {name}; unpack it first")
    if b"\r" in beginning.removesuffix(b"\r").replace(b"\r\n", b"\n"):
        message = f"{path} has lines that end in a carriage return alone, which MeshLab does not"
        raise FileError(f"{message} read; save it with line feeds")


def blocks_of(
    path: Path, file: BinaryIO, first_line: int = 1, separators: bytes = b""
) -> Iterator[Block]:
    """Yield the lines from where a file stands to its end; what is behind a '#' is left out.

    ``separators`` stand between numbers beside blanks.

    Raises
    ------
    FileError
        A word is no number.
    """
    table = bytes.maketrans(separators, b" " * len(separators))
    for raw in whole_lines(path, file):
        text = COMMENT.sub(b"", raw) if b"#" in raw else raw
        text = text.translate(table) if separators else text
        yield block_of(path, text, first_line)
        first_line += raw.count(b"\n")


def whole_lines(path: Path, file: BinaryIO) -> Iterator[bytes]:
    """Yield chunks that end where lines end.

    Raises
    ------
    FileError
        A line is too long.
    """
    rest: list[bytes] = []
    held = 0
    while chunk := file.read(CHUNK):
        cut = chunk.rfind(b"\n") + 1
        if cut:
            yield b"".join([*rest, chunk[:cut]])
            rest, held = [], 0
        rest.append(chunk[cut:])
        held += len(chunk) - cut
        if held > LONGEST:
            raise damaged(path, f"it has a line of more than {LONGEST >> 20} MB")
    yield b"".join(rest)


def block_of(path: Path, text: bytes, first_line: int) -> Block:
    """Return the numbers of some whole lines without comments.

    Raises
    ------
    FileError
        A word is no number.
    """
    content = np.frombuffer(text, dtype=np.uint8)
    blank = BLANKS[content]
    begins = ~blank
    begins[1:] &= blank[:-1]
    ends = np.flatnonzero(content == ord("\n"))
    line_of = np.searchsorted(ends, np.flatnonzero(begins))
    numbers = numbers_in(text)
    if len(numbers) != len(line_of):
        raise _no_number(path, text, first_line)
    counts = np.bincount(line_of)
    used = np.flatnonzero(counts)
    return Block(numbers, counts[used], used + first_line)


def numbers_in(text: bytes) -> Floats:
    """Return the numbers up to the first word that is none."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)  # how numpy tells of a word
        try:
            return np.fromstring(text, dtype=np.float64, sep=" ") if text.strip() else np.zeros(0)
        except (DeprecationWarning, ValueError):  # by the version of numpy
            return np.zeros(0)


def _no_number(path: Path, text: bytes, first_line: int) -> FileError:
    word, number = _first_word(text, first_line, lambda one: _is_number(one))
    return damaged(path, f"line {number} has '{shown(word)}' instead of a number")


def _first_word(text: bytes, first_line: int, fine: Callable[[bytes], bool]) -> tuple[bytes, int]:
    for number, line in enumerate(text.split(b"\n"), first_line):
        for word in line.split():
            if not fine(word):
                return word, number
    return b"", first_line


def _is_number(word: bytes) -> bool:
    return b"\0" not in word and len(numbers_in(word)) == 1


def shown(word: bytes) -> str:
    """Return the beginning of a word of a file, fit to be printed."""
    return "".join(char if char.isprintable() else "?" for char in word[:30].decode("latin-1"))
