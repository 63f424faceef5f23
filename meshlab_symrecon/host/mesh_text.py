"""Small changes to mesh files that MeshLab has written: names of images, edges of a PLY."""

from __future__ import annotations

import re
import shutil
from collections.abc import Mapping
from pathlib import Path
from xml.sax.saxutils import escape

from meshlab_symrecon.arrays import Indices

__all__ = ["add_ply_edges", "rename_images"]

END = b"end_header\n"
IMAGES = {
    "ply": re.compile(rb"(?m)^(comment TextureFile )(.*?)()$"),
    "mtl": re.compile(rb"(?m)^(map_Kd )(.*?)(\r?)$"),
    "dae": re.compile(rb"(<init_from>)(.*?)(</init_from>)"),
    "x3d": re.compile(rb'(url="&quot;)(.*?)(&quot;")'),
    "wrl": re.compile(rb'(url ")(.*?)(")'),
}  # how MeshLab writes the name of an image, by the file's extension
XML = ("dae", "x3d")


def rename_images(file: Path, names: Mapping[str, str]) -> None:
    """Change names of images in a mesh or in a file of materials; all at once, so they may swap."""
    extension = file.suffix.removeprefix(".").lower()
    pattern = IMAGES.get(extension)
    if not names or pattern is None or not file.exists():
        return
    written = {_encoded(old, extension): _encoded(new, extension) for old, new in names.items()}

    def renamed(match: re.Match[bytes]) -> bytes:
        return match[1] + written.get(match[2], match[2]) + match[3]

    if extension == "ply":
        header, start = _ply_header(file)
        _rewrite_ply(file, pattern.sub(renamed, header), start)
    else:
        file.write_bytes(pattern.sub(renamed, file.read_bytes()))


def _encoded(name: str, extension: str) -> bytes:
    return (escape(name) if extension in XML else name).encode("utf-8")


def add_ply_edges(file: Path, edges: Indices) -> None:
    """Put edges at the end of a binary PLY file, which MeshLab reads and does not write."""
    header, start = _ply_header(file)
    declared = f"element edge {len(edges)}\nproperty int vertex1\nproperty int vertex2\n"
    header = header.removesuffix(END) + declared.encode("ascii") + END
    _rewrite_ply(file, header, start, edges.astype("<i4").tobytes())


def _ply_header(file: Path) -> tuple[bytes, int]:
    """Return the header with its last line, and where the data begins."""
    lines = []
    with file.open("rb") as stream:
        for line in stream:
            lines.append(line)
            if line == END:
                break
        return b"".join(lines), stream.tell()


def _rewrite_ply(file: Path, header: bytes, start: int, tail: bytes = b"") -> None:
    changed = file.with_name(f".changed-{file.name}")
    with file.open("rb") as old, changed.open("wb") as new:
        old.seek(start)
        new.write(header)
        shutil.copyfileobj(old, new, 1 << 20)
        new.write(tail)
    changed.replace(file)
