"""What is done after MeshLab has loaded a file: its textures found, its properties completed."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from meshlab_symrecon.host.formats import COLOURS, FACE_COLOURS, QUALITY
from meshlab_symrecon.host.image_names import IMAGES
from meshlab_symrecon.host.material_names import MAP, image_name, libraries_of
from meshlab_symrecon.host.notices import warn_user
from meshlab_symrecon.host.ply_header import read_header
from meshlab_symrecon.host.ply_properties import add_unread_properties
from meshlab_symrecon.host.sources import Source, remember
from meshlab_symrecon.host.textures import plain_texture_name
from meshlab_symrecon.host.translation import translated

__all__ = ["after_loading"]

WORDS_OF_AN_EDGE = 3  # l, and two points
STAND_IN = "dummy.png"  # MeshLab's name for the image that it takes for one it cannot find
UNREAD = (".x3d", ".wrl")  # formats of whose textures MeshLab reads the coordinates only
OTHER_MAPS = re.compile(rb"(?mi)^([ \t]*(?:map_\w+|bump|disp|norm|refl)[ \t]+)(.+?)[ \t\r]*$")
IN_PLY = re.compile(rb"(?m)^(comment TextureFile[ \t]+)(.+?)[ \t\r]*$")


def after_loading(mesh_set: Any, identifier: int, path: Path) -> None:
    """Complete a layer that was just loaded, and remember where it came from.

    Warns
    -----
    SymReconWarning
        The image of a texture is missing, or MeshLab leaves out something of the file.
    """
    extension = path.suffix.removeprefix(".").lower()
    mesh = mesh_set.mesh(identifier)
    held = {QUALITY} if mesh.has_vertex_scalar() else set()
    if mesh.has_vertex_color():
        held.add(COLOURS)
    if mesh.has_face_color() and extension != "obj":  # where each material has a colour, white
        held.add(FACE_COLOURS)
    attributes: Mapping[str, str] = {}
    if extension == "ply":
        vertex = read_header(path).element("vertex")
        if vertex is not None and not {"red", "diffuse_red"} & vertex.names:
            held.discard(COLOURS)  # MeshLab makes white ones for an intensity
        attributes = add_unread_properties(mesh_set, identifier, path)
    if extension == "dae" and mesh.face_number() == 0:
        _clear_normals(mesh_set, identifier)
    libraries = _libraries(mesh, path) if extension == "obj" else ()
    named = _named_images(path, extension, libraries)
    textures, missing = _found(path, mesh_set.mesh(identifier).textures(), named)
    files = (path, *libraries, *(path.parent / name for name in named), *textures.values())
    source = Source(files, textures, missing, frozenset(held), attributes)
    remember(mesh_set, identifier, source)


def _clear_normals(mesh_set: Any, identifier: int) -> None:
    """Set normals to zero: MeshLab's reader leaves chance numbers in those of points."""
    with translated("clearing normals"):
        mesh_set.set_current_mesh(identifier)
        mesh_set.compute_normal_by_function_per_vertex(x="0", y="0", z="0")


def _libraries(mesh: Any, path: Path) -> tuple[Path, ...]:
    """Return the files of materials that an OBJ file names; warn of what MeshLab leaves out."""
    normals = longer = 0
    with path.open("rb") as file:
        for line in file:
            beginning = line[:7].lstrip()
            if beginning.startswith(b"vn "):
                normals += 1
            elif beginning.startswith(b"l "):
                longer += len(line.split()) > WORDS_OF_AN_EDGE
    if normals and mesh.face_number() == 0:
        warn_user(f"{path}: MeshLab does not read normals of points without faces; write .ply")
    if longer:
        words = f"{path}: of {longer} lines along more than two points MeshLab reads"
        warn_user(f"{words} the first edge only; write a line an edge")
    return tuple(libraries_of(path).values())


def _named_images(path: Path, extension: str, libraries: tuple[Path, ...]) -> dict[str, bool]:
    """Return the images that a file names, and whether each is a texture that MeshLab reads."""
    if extension == "ply":
        with path.open("rb") as file:
            header = file.read(read_header(path).start)
        return dict.fromkeys(_names(IN_PLY, header), True)
    if extension in IMAGES:
        content = path.read_bytes()
        return {
            match[2].decode("utf-8", "replace"): True
            for match in IMAGES[extension].finditer(content)
        }
    named: dict[str, bool] = {}
    for library in libraries:
        content = library.read_bytes()
        named |= dict.fromkeys(_names(OTHER_MAPS, content), False)
        named |= dict.fromkeys(_names(MAP, content), True)
    return named


def _names(pattern: re.Pattern[bytes], content: bytes) -> Iterator[str]:
    """Return the names of images in a file of materials or a header."""
    named = (image_name(match[2]) for match in pattern.finditer(content))
    return (name for name in named if name)


def _found(
    path: Path, in_mesh: Any, named: dict[str, bool]
) -> tuple[dict[str, Path], dict[str, str]]:
    """Return the image files of a layer's textures, and what MeshLab put a stand-in for."""
    by_name = {name: path.parent / name for name in named}
    by_plain = {plain_texture_name(name): file for name, file in by_name.items()}
    by_end = {file.name: file for file in by_name.values()}
    textures = {}
    for name in in_mesh:
        file = (
            by_name.get(name)
            or by_plain.get(name)
            or by_end.get(Path(name).name)
            or path.parent / name
        )
        if file.is_file():
            textures[name] = file
    if named and not in_mesh and path.suffix.lower() in UNREAD:
        warn_user(f"{path}: MeshLab does not read textures ({', '.join(named)}) of such files")
    if STAND_IN not in in_mesh or STAND_IN in textures:
        return textures, {}
    found = set(textures.values())
    unread = [name for name, used in named.items() if used and by_name[name] not in found]
    if not unread:
        return textures, {}
    file = by_name[unread[0]]
    if file.is_file():
        textures[STAND_IN] = file
        why = "MeshLab does not read an image of that name"
    else:
        why = "there is no such image"
    warn_user(
        f"{path}: of the texture {', '.join(unread)} only the name is kept, since {why}; "
        "filters that look at it see a checkered one"
    )
    return textures, {STAND_IN: unread[0]}
