"""Names of images in mesh files that MeshLab has written."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from xml.sax.saxutils import escape

from meshlab_symrecon.host.ply_writing import extend_ply

__all__ = ["rename_images"]

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
        extend_ply(file, change=lambda header: pattern.sub(renamed, header))
    else:
        file.write_bytes(pattern.sub(renamed, file.read_bytes()))


def _encoded(name: str, extension: str) -> bytes:
    return (escape(name) if extension in XML else name).encode("utf-8")
