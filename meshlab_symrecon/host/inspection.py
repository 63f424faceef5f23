"""What is checked in a file before MeshLab reads it: its readers may crash on damaged files."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from meshlab_symrecon.errors import FileError
from meshlab_symrecon.host.ply_header import damaged, read_header

__all__ = ["check_obj", "check_ply", "check_stl", "try_in_child"]

CHUNK = 1 << 22  # bytes
STL_HEADER, STL_TRIANGLE = 84, 50  # bytes
# Only whether the process survives is asked; what the reader raises, the real load tells.
TRIAL = (
    "import sys, pymeshlab\n"
    "try: pymeshlab.MeshSet(verbose=False).load_new_mesh(sys.argv[1])\n"
    "except Exception: pass\n"
)


def check_ply(path: Path) -> int:
    """Check a PLY file's header against its size; return the number of vertices it announces.

    Raises
    ------
    FileError
        The header is damaged, has no points with x, y and z, or announces more than the file holds.
    """
    header = read_header(path)
    vertices = header.element("vertex")
    if vertices is None or not {"x", "y", "z"} <= vertices.names:
        raise damaged(path, "its header declares no vertices with x, y and z")
    if vertices.count == 0:
        raise FileError(f"{path} holds no points; scan again or pick another file")
    if header.form == "ascii":
        needed = sum(element.least_words for element in header.elements)
        with path.open("rb") as file:
            file.seek(header.start)
            held, unit = _count_words(file, needed), "numbers"
    else:
        needed = sum(element.least_bytes for element in header.elements)
        held, unit = path.stat().st_size - header.start, "bytes"
    if held < needed:
        what = f"its header announces at least {needed} {unit} of data, and {held} follow"
        raise damaged(path, what)
    return vertices.count


def _count_words(file: BinaryIO, enough: int) -> int:
    """Count words until there are enough."""
    count = 0
    inside = False  # whether the chunk before ended inside a word
    while count < enough and (chunk := file.read(CHUNK)):
        count += len(chunk.split())
        if inside and not chunk[:1].isspace():
            count -= 1
        inside = not chunk[-1:].isspace()
    return count


def check_obj(path: Path) -> None:
    """Check what MeshLab's reader of OBJ files would crash on.

    Raises
    ------
    FileError
        A face names a vertex, texture coordinate or normal that the file does not have, or has a
        comment behind it.
    """
    counts = {b"v": 0, b"vt": 0, b"vn": 0}
    corners: set[bytes] = set()
    with path.open("rb") as file:
        for line in _whole_lines(file):
            words = line.split()
            if not words:
                continue
            if words[0] in counts:
                counts[words[0]] += 1
            elif words[0] == b"f":
                if b"#" in line:
                    message = f"{path} has a comment behind a face, on which MeshLab's reader fails"
                    raise FileError(f"{message}; remove it")
                if b"-" in line:  # counted back from here
                    _check_corners(path, words[1:], counts)
                else:
                    corners.update(words[1:])
    if counts[b"v"] == 0:
        raise FileError(f"{path} holds no points; scan again or pick another file")
    _check_corners(path, corners, counts)


def _whole_lines(file: BinaryIO) -> Iterator[bytes]:
    """Yield lines; one that ends in a backslash goes on in the next."""
    before = b""
    for line in file:
        stripped = before + line.rstrip()
        if stripped.endswith(b"\\"):
            before = stripped[:-1] + b" "
            continue
        before = b""
        yield stripped
    if before:
        yield before


def _check_corners(path: Path, corners: set[bytes] | list[bytes], counts: dict[bytes, int]) -> None:
    limits = tuple(counts.values())
    for corner in corners:
        indices = corner.split(b"/")
        try:
            numbers = [int(index) if index else 1 for index in indices]
        except ValueError as error:
            raise damaged(path, f"a face has the corner '{_shown(corner)}'") from error
        optional = zip(indices[1:], numbers[1:], limits[1:], strict=False)
        pairs = [(numbers[0], limits[0]), *((n, limit) for word, n, limit in optional if word)]
        if len(numbers) > 3 or any(n == 0 or abs(n) > limit for n, limit in pairs):
            what = (
                f"a face has the corner '{_shown(corner)}', and there are {limits[0]} vertices, "
                f"{limits[1]} texture coordinates and {limits[2]} normals"
            )
            raise damaged(path, what)


def _shown(corner: bytes) -> str:
    return corner[:30].decode("latin-1")


def check_stl(path: Path) -> None:
    """Check a binary STL file's count of triangles against its size.

    Raises
    ------
    FileError
        The file is shorter than it announces.
    """
    size = path.stat().st_size
    with path.open("rb") as file:
        beginning = file.read(1024)
    if beginning.lstrip().lower().startswith(b"solid") and b"facet" in beginning.lower():
        return
    count = int.from_bytes(beginning[80:STL_HEADER], "little")
    if size < STL_HEADER or size < STL_HEADER + STL_TRIANGLE * count:
        what = f"it announces {count} triangles, which {size} bytes cannot hold"
        raise damaged(path, what)


def try_in_child(path: Path) -> None:
    """Let a child process read the file first, in case MeshLab's reader crashes on it.

    Raises
    ------
    FileError
        It crashed.
    """
    ended = subprocess.run(  # noqa: S603  our own interpreter, our own program
        [sys.executable, "-c", TRIAL, str(path)], capture_output=True, check=False
    )
    if ended.returncode != 0:
        raise damaged(path, "MeshLab's reader crashes on it")
