"""The files behind a file: meshes of a project, materials, images of textures."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from meshlab_symrecon.batch.checksums import sha256_of
from meshlab_symrecon.errors import FileError

__all__ = ["checksums_of", "further_files", "unchanged"]

PLY_HEADER = 1 << 16  # bytes; the names of images are in the header
IN_PLY = re.compile(rb"(?m)^comment TextureFile[ \t]+(.+?)[ \t\r]*$")
IN_MATERIALS = re.compile(rb"(?mi)^[ \t]*(?:map_\w+|bump|disp|norm|refl)[ \t]+(.+?)[ \t\r]*$")


def further_files(path: Path) -> tuple[Path, ...]:
    """Return the files that a mesh or a project names, those behind them too; the file not.

    What a damaged file names is not known; whoever reads it will say that it is damaged.
    """
    from meshlab_symrecon.host.projects import files_of

    try:
        meshes = files_of(path)
    except FileError:
        return ()
    behind = (file for mesh in meshes for file in (mesh, *_named_in(mesh)))
    return tuple(dict.fromkeys(file for file in behind if file != path))


def checksums_of(files: Iterable[Path], folder: Path) -> dict[str, str | None]:
    """Return the checksum of each file by its name relative to a folder, in full outside of it."""
    named = {
        file.relative_to(folder).as_posix() if file.is_relative_to(folder) else str(file): file
        for file in files
    }
    return {name: sha256_of(file) for name, file in sorted(named.items())}


def unchanged(known: Mapping[str, str | None], folder: Path) -> bool:
    """Say whether files are what their checksums say."""
    return checksums_of((folder / name for name in known), folder) == dict(known)


def _named_in(mesh: Path) -> Iterator[Path]:
    """Yield the files of materials and the images that a mesh names."""
    from meshlab_symrecon.host.material_names import image_name, libraries_of

    extension = mesh.suffix.lower()
    if extension not in (".obj", ".ply"):
        return
    try:
        if not mesh.is_file():
            return
        if extension == ".obj":
            libraries = tuple(libraries_of(mesh).values())
            yield from libraries
            pattern, contents = IN_MATERIALS, [library.read_bytes() for library in libraries]
        else:
            with mesh.open("rb") as file:
                pattern, contents = IN_PLY, [file.read(PLY_HEADER).partition(b"end_header")[0]]
    except (OSError, ValueError):  # it is told where it is read
        return
    for content in contents:
        names = (image_name(match[1]) for match in pattern.finditer(content))
        yield from (mesh.parent / name for name in names if name)
