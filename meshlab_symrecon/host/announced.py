"""How many points and faces a mesh file announces, found without reading the file."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

from meshlab_symrecon.errors import FileError
from meshlab_symrecon.host.ply_header import Header, read_header

__all__ = ["Announced", "announced_points"]

BEGINNING = 1 << 16  # bytes: as much of a file's beginning as a header takes
SAMPLES, SAMPLE = 64, 1 << 14  # pieces of a text file that are looked at, and their bytes
STL_HEADER, STL_TRIANGLE = 84, 50  # bytes
E57_PAGE, E57_CHECKSUM = 1024, 4  # bytes; the checksum ends every page
GLB_HEADER, GLB_JSON = 20, b"JSON"
POINT_LINES = ("xyz", "asc", "txt", "pts", "ptx", "apts")  # text, one point a line
OFF_WORDS = re.compile(rb"^\s*(?:ST)?C?N?4?n?OFF\b")
E57_COUNT = re.compile(rb"<points\b[^>]*\brecordCount\s*=\s*[\"'](\d+)[\"']")
E57_LIMIT = 1 << 26  # bytes of XML that are looked at


@dataclass(frozen=True, slots=True)
class Announced:
    """The size of a mesh that is still in its file.

    Attributes
    ----------
    points, faces : int
    exact : bool
        Whether the file tells the number itself; otherwise it is an estimate from a sample.
    """

    points: int
    faces: int = 0
    exact: bool = True


def announced_points(path: str | Path) -> Announced | None:
    """Return how many points and faces a file announces.

    Headers are read where the format has one; text is sampled, a few pieces of the whole file.

    Returns
    -------
    Announced or None
        None for a format that does not tell, for what is no ordinary file, and for a file that is
        damaged, has not the bytes for what it announces, or cannot be read: what is wrong with it,
        the reader says.
    """
    path = Path(path)
    extension = path.suffix.removeprefix(".").lower()
    count = _COUNTERS.get(extension)
    if count is None:
        return None
    try:
        return count(path) if path.is_file() else None  # a pipe would have us wait for ever
    except (FileError, OSError, ValueError, LookupError, TypeError, RecursionError):
        return None


def _ply(path: Path) -> Announced | None:
    header = read_header(path)
    vertex, face = header.element("vertex"), header.element("face")
    if vertex is None or _data_size(header) > path.stat().st_size - header.start:
        return None
    return Announced(vertex.count, 0 if face is None else face.count)


def _data_size(header: Header) -> int:
    """Return how many bytes the data of a PLY file takes at least."""
    if header.form == "ascii":
        return _text_size(sum(element.least_words for element in header.elements))
    return sum(element.least_bytes for element in header.elements)


def _text_size(numbers: int) -> int:
    """Return how many bytes numbers take at least: a digit each, and what parts them."""
    return max(0, 2 * numbers - 1)


def _off(path: Path) -> Announced | None:
    with path.open("rb") as file:
        beginning = file.read(BEGINNING)
    without_comments = re.sub(rb"#[^\n]*", b"", beginning)
    words = OFF_WORDS.sub(b"", without_comments, count=1).split(None, 3)
    points, faces = max(0, int(words[0])), max(0, int(words[1]))
    if _text_size(3 * points + 2 * faces) > path.stat().st_size:
        return None
    return Announced(points, faces)


def _stl(path: Path) -> Announced | None:
    """Count triangles; each point of a closed mesh is in six, and MeshLab joins equal ones."""
    with path.open("rb") as file:
        beginning = file.read(1024)
    if beginning.lstrip().lower().startswith(b"solid") and b"facet" in beginning.lower():
        faces = _lines(path, (b"endfacet",))[0]
        return Announced(faces // 2, faces, exact=False)
    if len(beginning) < STL_HEADER:
        raise ValueError(beginning)
    faces = int.from_bytes(beginning[80:STL_HEADER], "little")
    if path.stat().st_size < STL_HEADER + STL_TRIANGLE * faces:
        return None
    return Announced(faces // 2, faces, exact=False)


def _obj(path: Path) -> Announced:
    points, faces = _lines(path, (b"v", b"f"))
    return Announced(points, faces, exact=False)


def _point_lines(path: Path) -> Announced:
    return Announced(_lines(path, (b"",))[0], exact=False)


def _lines(path: Path, words: tuple[bytes, ...]) -> list[int]:
    """Estimate how many lines begin with each word, any line for an empty one."""
    size = path.stat().st_size
    seen = 0
    counts = [0] * len(words)
    with path.open("rb") as file:
        for piece in _pieces(file, size):
            seen += len(piece)
            for line in piece.splitlines():
                first = line.split(None, 1)[:1]
                for number, word in enumerate(words):
                    counts[number] += bool(first) and word in (b"", first[0])
    share = seen / size if seen else 1.0
    return [round(count / share) for count in counts]


def _pieces(file: BinaryIO, size: int) -> list[bytes]:
    """Return the whole of a small file, or even pieces that begin and end with a line."""
    if size <= SAMPLES * SAMPLE:
        return [file.read()]
    pieces = []
    for number in range(SAMPLES):
        file.seek(number * (size - SAMPLE) // (SAMPLES - 1))
        piece = file.read(SAMPLE)
        first, last = piece.find(b"\n") + 1, piece.rfind(b"\n") + 1
        pieces.append(piece[first if number else 0 : last] if last > first else b"")
    return pieces


def _e57(path: Path) -> Announced | None:
    """Add up the records of all scans; the header says where the XML that tells them is."""
    with path.open("rb") as file:
        header = file.read(48)
        if header[:8] != b"ASTM-E57":
            return None
        start, length = (int.from_bytes(header[at : at + 8], "little") for at in (24, 32))
        file.seek(start - start % E57_PAGE)
        content = file.read(min(length + length // 100 + 2 * E57_PAGE, E57_LIMIT))
    kept = E57_PAGE - E57_CHECKSUM
    pages = (content[at : at + kept] for at in range(0, len(content), E57_PAGE))
    xml = b"".join(pages)[start % E57_PAGE :][:length]
    counts = [int(count) for count in E57_COUNT.findall(xml)]
    return Announced(sum(counts)) if counts and _may_hold(path, sum(counts)) else None


def _may_hold(path: Path, points: int) -> bool:
    """Say whether a packed file is large enough: a point that differs from others takes a bit."""
    return points <= 8 * path.stat().st_size


def _gltf(path: Path) -> Announced:
    return _in_accessors(json.loads(path.read_bytes()))


def _glb(path: Path) -> Announced | None:
    with path.open("rb") as file:
        header = file.read(GLB_HEADER)
        if header[:4] != b"glTF" or header[16:] != GLB_JSON:
            return None
        text = file.read(int.from_bytes(header[12:16], "little"))
    found = _in_accessors(json.loads(text))
    return found if _may_hold(path, found.points) else None


def _in_accessors(document: Any) -> Announced:
    """Count what the primitives of all meshes name; accessors may be shared."""
    accessors = document["accessors"]
    points: dict[int, int] = {}
    faces = 0
    for mesh in document["meshes"]:
        for primitive in mesh["primitives"]:
            position = primitive["attributes"]["POSITION"]
            points[position] = int(accessors[position]["count"])
            corners = primitive.get("indices", position)
            faces += int(accessors[corners]["count"]) // 3
    return Announced(sum(points.values()), faces)


_COUNTERS = {
    "ply": _ply,
    "off": _off,
    "stl": _stl,
    "obj": _obj,
    "e57": _e57,
    "gltf": _gltf,
    "glb": _glb,
    **dict.fromkeys(POINT_LINES, _point_lines),
}
