"""The images of textures: where a mesh file names them, and put beside one that is written."""

from __future__ import annotations

import filecmp
import re
import shutil
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path, PurePosixPath
from typing import Any

import pymeshlab

from meshlab_symrecon.errors import HostError
from meshlab_symrecon.host.checksums import sha256_of
from meshlab_symrecon.host.notices import warn_user
from meshlab_symrecon.host.sources import input_files, source_of, texture_file
from meshlab_symrecon.host.translation import translated

__all__ = ["images_named_by_contents", "place_textures", "plain_texture_name", "same_image"]

STAND_IN = ".png"  # for an image whose name has no ending that MeshLab can write
DIGITS = 12  # of the checksum in a name
_by_contents: ContextVar[bool] = ContextVar("_by_contents", default=False)


@contextmanager
def images_named_by_contents() -> Iterator[None]:
    """Let the images that are placed in this block have a checksum of their contents in the name.

    Then processes that write into one folder at the same time never mean different images by one
    name, and the names are the same whoever comes first.
    """
    token = _by_contents.set(True)
    try:
        yield
    finally:
        _by_contents.reset(token)


def plain_texture_name(name: str) -> str:
    """Return a name beneath the mesh's folder, without blanks, which MeshLab cannot read back."""
    parts = PurePosixPath(name.replace("\\", "/")).parts
    inside = [part for part in parts if part != "."]
    if not inside or ".." in inside or PurePosixPath(*inside).is_absolute() or ":" in inside[0]:
        inside = [part for part in inside if part not in ("..", "/")][-1:] or ["texture"]
    return "/".join(re.sub(r"[\s\"'*?<>|]+", "_", part) for part in inside)


def place_textures(mesh_set: Any, identifier: int, path: Path, staged: Path) -> Mapping[str, str]:
    """Put the images of a layer's textures beside ``staged``; return the names that changed.

    An image that no step has changed is the input's file, byte for byte. What is beside ``path``
    already is used when it is the same; else the image takes a name that begins as ``path`` does.
    No file of an input is ever replaced. See also ``images_named_by_contents``.

    Parameters
    ----------
    mesh_set : pymeshlab.MeshSet
    identifier : int
    path : Path
        Where the mesh will be.
    staged : Path
        Where it is written first.

    Returns
    -------
    mapping of str to str
        The new name, by the name that MeshLab has written into the mesh.

    Warns
    -----
    SymReconWarning
        An image is missing, or cannot be written.
    """
    renamed: dict[str, str] = {}
    missing = source_of(mesh_set, identifier).missing
    for name, image in mesh_set.mesh(identifier).textures().items():
        wanted = plain_texture_name(missing.get(name, name))
        made = staged.parent / f".{len(renamed)}-{PurePosixPath(wanted).name}"
        made = _with_ending(made)
        wanted = str(PurePosixPath(wanted).with_suffix(made.suffix))
        origin = texture_file(mesh_set, identifier, name)
        if name in missing and origin is None:
            renamed[name] = missing[name]
            warn_user(f"{path}: the texture {missing[name]} was missing, and is not written")
            continue
        try:
            _make(image, origin, name in missing, made)
        except (HostError, OSError) as error:
            warn_user(f"{path}: the texture {name} was left out: {error}")
            continue
        renamed[name] = _settle(made, wanted, path, staged, input_files(mesh_set))
    return {old: new for old, new in renamed.items() if old != new}


def _with_ending(path: Path) -> Path:
    return path if path.suffix else path.with_suffix(STAND_IN)


def _make(image: Any, origin: Path | None, unread: bool, made: Path) -> None:
    """Write an image: a copy of its file, unless a step has changed it."""
    if origin is not None and (unread or same_image(image, origin)):
        shutil.copyfile(origin, made)
        return
    with translated("its image cannot be written"):
        image.save(str(made), 100)


def same_image(image: Any, origin: Path) -> bool:
    """Say whether an image in memory has the pixels of a file."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        copied = plain_texture_name(origin.name)
        try:
            shutil.copyfile(origin, place / copied)
            (place / "a.ply").write_text(ONE_TRIANGLE.format(name=copied))
            again = pymeshlab.MeshSet(verbose=False)
            again.load_new_mesh(str(place / "a.ply"))
            image.save(str(place / "now.bmp"))
            again.mesh(0).texture(0).save(str(place / "then.bmp"))
        except (OSError, pymeshlab.PyMeshLabException):
            return False
        return filecmp.cmp(place / "now.bmp", place / "then.bmp", shallow=False)


ONE_TRIANGLE = """ply
format ascii 1.0
comment TextureFile {name}
element vertex 3
property float x
property float y
property float z
property float texture_u
property float texture_v
element face 1
property list uchar int vertex_indices
end_header
0 0 0 0 0
1 0 0 1 0
0 1 0 0 1
3 0 1 2
"""


def _settle(made: Path, wanted: str, path: Path, staged: Path, protected: Iterable[Path]) -> str:
    """Move an image that was made to the first name that is free for it; return the name."""
    folder = path.resolve().parent

    def same(name: str) -> bool:
        files = [file for file in (folder / name, staged.parent / name) if file.is_file()]
        return any(filecmp.cmp(made, file, shallow=False) for file in files)

    if _by_contents.get():
        wanted = _with_checksum(wanted, made)

    def free(name: str) -> bool:
        there = folder / name
        ours = (name != wanted or _by_contents.get()) and there.resolve() not in protected
        return not (staged.parent / name).exists() and (ours or not there.exists())

    name = next(name for name in _names(wanted, path) if same(name) or free(name))
    if same(name):
        made.unlink()
    else:
        beside = staged.parent / name
        beside.parent.mkdir(parents=True, exist_ok=True)
        made.replace(beside)
    return name


def _with_checksum(name: str, image: Path) -> str:
    """Return a name that tells what the image holds; one that does so already stays."""
    plain, ending = PurePosixPath(name), f"-{sha256_of(image)[:DIGITS]}"
    return name if plain.stem.endswith(ending) else str(plain.with_stem(plain.stem + ending))


def _names(wanted: str, path: Path) -> Iterable[str]:
    yield wanted
    plain = PurePosixPath(wanted)
    number = 1
    while True:
        ending = "" if number == 1 else f"-{number}"
        yield f"{path.stem}-{plain.stem}{ending}{plain.suffix}"
        number += 1
