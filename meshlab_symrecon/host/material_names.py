"""OBJ files whose images have names that MeshLab does not read: with blanks, quotes, options.

MeshLab takes one stand-in for all of them, so that which face has which is lost. Such a file is
read through links in a folder of its own, where the images have plain names.
"""

from __future__ import annotations

import re
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from meshlab_symrecon.host.textures import plain_texture_name

__all__ = ["LIBRARY", "MAP", "image_name", "libraries_of", "with_plain_names"]

LIBRARY = re.compile(rb"[ \t]*mtllib[ \t]+(.+?)[ \t\r\n]*$")
MAP = re.compile(rb"(?mi)^([ \t]*map_Kd[ \t]+)(.+?)([ \t\r]*)$")
OPTION = re.compile(r"-(?:[ost](?:\s+[-+.\de]+){1,3}|mm(?:\s+[-+.\de]+){2}|\w+\s+\S+)\s+")


def image_name(words: bytes) -> str:
    """Return the name of an image without the options and quotes that it was written with."""
    text = words.decode("utf-8", "replace").replace("\\", "/")
    return OPTION.sub("", text).strip().strip('"').replace("\0", "")


def libraries_of(path: Path) -> dict[str, Path]:
    """Return the files of materials that an OBJ file names and that are there, by their names."""
    found = {}
    with path.open("rb") as file:
        for line in file:
            match = LIBRARY.match(line) if b"mtllib" in line else None
            if match:
                name = image_name(match[1])
                found[name] = path.parent / name
    return {name: file for name, file in found.items() if file.is_file()}


@contextmanager
def with_plain_names(path: Path) -> Iterator[Path]:
    """Yield a path under which MeshLab reads an OBJ file with all of its images."""
    libraries = libraries_of(path)
    contents = {name: file.read_bytes() for name, file in libraries.items()}
    names = [match[2] for content in contents.values() for match in MAP.finditer(content)]
    images = {image_name(name): path.parent / image_name(name) for name in names}
    unread = [name for name in names if b" " in name or b'"' in name]
    inside = all(plain_texture_name(name) == name.removeprefix("./") for name in libraries)
    if not inside or not any(images[image_name(name)].is_file() for name in unread):
        yield path
        return
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        for name, content in contents.items():
            (place / name).parent.mkdir(parents=True, exist_ok=True)
            (place / name).write_bytes(MAP.sub(_plainly, content))
        links = {place / plain_texture_name(name): file for name, file in images.items()}
        for link, file in {**links, place / path.name: path}.items():
            link.parent.mkdir(parents=True, exist_ok=True)
            if file.is_file() and not link.exists():
                _link(link, file.resolve())
        yield place / path.name


def _plainly(match: re.Match[bytes]) -> bytes:
    return match[1] + plain_texture_name(image_name(match[2])).encode("utf-8") + match[3]


def _link(link: Path, file: Path) -> None:
    try:
        link.symlink_to(file)
    except OSError:  # where links are not allowed
        shutil.copyfile(file, link)
