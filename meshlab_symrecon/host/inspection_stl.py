"""STL files, binary and text: their size, their facets, their coordinates."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from meshlab_symrecon.arrays import Floats
from meshlab_symrecon.errors import FileError
from meshlab_symrecon.host.held import Held, unusable
from meshlab_symrecon.host.number_lines import check_plain_text, numbers_in, shown
from meshlab_symrecon.host.ply_header import damaged

__all__ = ["check_stl", "check_stl_content"]

HEADER, TRIANGLE = 84, 50  # bytes
BEGINNING = 1024  # bytes
FACETS = 1 << 16  # at a time
CHUNK = 1 << 22  # bytes
LONGEST = 1 << 26  # bytes of a line
RECORD = np.dtype([("numbers", "<f4", (4, 3)), ("attribute", "<u2")])
LEAST_LINES = 6  # of a facet, for MeshLab's reader: it looks for keywords where lines begin
MARK = b"\xef\xbb\xbf"
NAME = re.compile(rb"(?m)^[ \t]*(?:end)?solid\b[^\n]*")
FACET = (
    (b"facet normal - - - outer loop vertex - - - vertex - - - vertex - - - endloop endfacet")
    .replace(b"-", b"")
    .split(b" ")
)  # the words of one, empty where a number is
KEYWORDS = re.compile(rb"facet normal|outer loop|vertex|endloop|endfacet")
NUMBERS = 12  # of a facet


def check_stl(path: Path) -> None:
    """Check a binary STL file's count of triangles against its size.

    Raises
    ------
    FileError
        The file is shorter than it announces.
    """
    size = path.stat().st_size
    with path.open("rb") as file:
        beginning = file.read(BEGINNING)
    if _is_text(beginning, size):
        return
    count = int.from_bytes(beginning[80:HEADER], "little")
    if size < HEADER or size < HEADER + TRIANGLE * count:
        what = f"it announces {count} triangles, which {size} bytes cannot hold"
        raise damaged(path, what)


def _is_text(beginning: bytes, size: int) -> bool:
    """Say whether a file is text; binary ones may begin with the word, too, but have their size."""
    words = beginning.lstrip(b" \t\r\n\xef\xbb\xbf").lower()
    count = int.from_bytes(beginning[80:HEADER], "little")
    binary = len(beginning) >= HEADER and size == HEADER + TRIANGLE * count
    return not binary and words.startswith(b"solid") and (b"facet" in words or b"endsolid" in words)


def check_stl_content(path: Path) -> Held:
    """Check an STL file to its end.

    Raises
    ------
    FileError
        It is shorter or longer than it announces, a facet is not whole, the text has no end, or a
        coordinate is infinite.
    """
    size = path.stat().st_size
    with path.open("rb") as file:
        beginning = file.read(BEGINNING)
    if _is_text(beginning, size):
        return _check_text(path)
    check_stl(path)
    count = int.from_bytes(beginning[80:HEADER], "little")
    if size != HEADER + TRIANGLE * count:
        what = f"it announces {count} triangles, and {size - HEADER - TRIANGLE * count} bytes more"
        raise damaged(path, f"{what} follow")
    if count == 0:
        raise FileError(f"{path} holds no points; scan again or pick another file")
    lost = lost_facets = 0
    with path.open("rb") as file:
        file.seek(HEADER)
        for first in range(0, count, FACETS):
            facets = np.fromfile(file, RECORD, min(FACETS, count - first))
            corners = facets["numbers"][:, 1:]
            bad = _unusable(path, corners, first)
            lost += int(bad.sum())
            lost_facets += int(bad.any(axis=1).sum())
    return _held(path, count, lost, lost_facets)


def _unusable(path: Path, corners: Floats, first: int) -> Floats:
    """Say of each corner of some facets whether it is not a number."""
    return unusable(path, corners.reshape(-1, 3), 3 * first).reshape(-1, 3)


def _held(path: Path, facets: int, lost: int, lost_facets: int) -> Held:
    if lost_facets == facets:
        raise FileError(f"{path} holds no facet with whole coordinates; scan again")
    return Held(3 * facets, lost, lost_facets, merged=True)


def _check_text(path: Path) -> Held:
    check_plain_text(path)
    facets = lost = lost_facets = lines = 0
    words: list[bytes] = []
    ended = False
    with path.open("rb") as file:
        while chunk := file.read(CHUNK):
            chunk += file.readline(LONGEST)  # to the end of a line
            lines += chunk.count(b"\n")
            text = chunk.lower().replace(MARK, b"")
            names = NAME.findall(text)
            if any(b"facet normal" in name for name in names):
                message = f"{path} has facets in the line of 'solid', which MeshLab does not read"
                raise FileError(f"{message}; give each keyword a line")
            ended = names[-1].lstrip().startswith(b"end") if names else ended
            words += NAME.sub(b"", text).split()
            whole = len(words) // len(FACET)
            corners = _corners(path, words[: whole * len(FACET)], facets)
            del words[: whole * len(FACET)]
            bad = _unusable(path, corners, facets)
            facets, lost = facets + whole, lost + int(bad.sum())
            lost_facets += int(bad.any(axis=1).sum())
    if words:
        raise damaged(path, f"its facet {facets + 1} is not whole")
    if facets == 0:
        raise FileError(f"{path} holds no points; scan again or pick another file")
    if lines < LEAST_LINES * facets:
        message = f"{path} has {facets} facets in {lines} lines, which MeshLab does not read"
        raise FileError(f"{message}; give each keyword a line")
    if not ended:
        raise damaged(path, f"no 'endsolid' follows its {facets} facets")
    return _held(path, facets, lost, lost_facets)


def _corners(path: Path, words: list[bytes], before: int) -> Floats:
    """Return the corners of facets, (n, 3, 3), whose words must come in their order."""
    for place, keyword in enumerate(FACET):
        found = words[place :: len(FACET)]
        if keyword and found.count(keyword) != len(found):
            at = next(number for number, word in enumerate(found) if word != keyword)
            what = (
                f"its facet {before + at + 1} has '{shown(found[at])}' where '{keyword.decode()}'"
            )
            raise damaged(path, f"{what} must be")
    numbers = numbers_in(KEYWORDS.sub(b"", b" ".join(words)))
    if len(numbers) != NUMBERS * len(words) // len(FACET):
        at, word = next(
            (place // len(FACET), word)
            for place, word in enumerate(words)
            if not FACET[place % len(FACET)] and len(numbers_in(word)) != 1
        )
        raise damaged(path, f"its facet {before + at + 1} has '{shown(word)}' instead of a number")
    return numbers.reshape(-1, 4, 3)[:, 1:]
