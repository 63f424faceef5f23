"""Paths that users give: what cannot be read or written is refused before any work is done."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from meshlab_symrecon.errors import FileError
from meshlab_symrecon.host.atomic import check_target, reason, same_file
from meshlab_symrecon.host.formats import WRITABLE

__all__ = ["READABLE", "check_input", "check_output", "checked_extension", "reading"]

READABLE = (
    "ply", "obj", "off", "stl", "xyz", "3ds", "3mf", "apts", "asc", "bre", "ctm", "dae", "e57",
    "es", "fbx", "glb", "gltf", "pdb", "pts", "ptx", "qobj", "tri", "txt", "vmi", "wrl", "x3d",
    "x3dv",
)  # fmt: skip


def check_input(path: str | Path) -> None:
    """Refuse what is no file with something in it, before any other look at it.

    Whoever opens a pipe may wait for ever.

    Raises
    ------
    FileError
        No such file, not an ordinary one, empty, or the system refused.
    """
    path = Path(path)
    with reading(path):
        _check_ordinary(path)


@contextmanager
def reading(path: Path) -> Iterator[None]:
    """Turn what the system says to a look at a file into an error of ours.

    Raises
    ------
    FileError
    """
    try:
        yield
    except FileError:
        raise
    except (OSError, ValueError) as error:
        raise FileError(f"{path} cannot be read: {reason(error)}; check its path") from error


def _check_ordinary(path: Path) -> None:
    if not path.exists():
        raise FileError(f"{path} cannot be read: no such file; check its path")
    try:
        str(path).encode()
    except UnicodeEncodeError as error:
        shown = str(path).encode("utf-8", "replace").decode()
        message = f"{shown} cannot be read: its name is not UTF-8, and MeshLab takes no other"
        raise FileError(f"{message}; rename it") from error
    if not path.is_file():
        raise FileError(f"{path} cannot be read: it is not an ordinary file; give a mesh file")
    with path.open("rb") as file:
        if not file.read(1):
            raise FileError(f"{path} is empty; write or download it again")


def checked_extension(path: Path, known: Iterable[str], verb: str) -> str:
    """Return the extension of a path, in small letters and without the dot.

    Raises
    ------
    FileError
        It is none of those that are ``known``; the message says what cannot be done: the ``verb``.
    """
    extension = path.suffix.removeprefix(".").lower()
    if extension not in known:
        shown = f"the extension '.{extension}'" if extension else "no extension"
        message = f"{path} has {shown}, which cannot be {verb}; known are {', '.join(known)}"
        raise FileError(message)
    return extension


def check_output(
    path: str | Path, inputs: Iterable[str | Path] = (), known: Iterable[str] = tuple(WRITABLE)
) -> None:
    """Refuse an output path before any work is done.

    Parameters
    ----------
    path : str or Path
    inputs : iterable of str or Path
        Files that must stay as they are.
    known : iterable of str
        Extensions that can be written; empty for any.

    Raises
    ------
    FileError
        Unknown extension, no such directory, not an ordinary file, or one of the inputs.
    """
    path = Path(path)
    known = tuple(known)
    if known:
        checked_extension(path, known, "written")
    check_target(path)
    for other in inputs:
        if same_file(path, Path(other)):
            message = f"{path} would overwrite {other}, which is in use here; give another path"
            raise FileError(message)
