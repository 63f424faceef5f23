"""Meshes in files: checked before they are read, whole or not at all when written."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab

from meshlab_symrecon.errors import FileError, HostError
from meshlab_symrecon.host.atomic import reason, replacing
from meshlab_symrecon.host.copies import changed_copy, needs_wedges
from meshlab_symrecon.host.exporting import export
from meshlab_symrecon.host.formats import contents_of, lost_in
from meshlab_symrecon.host.held import Held, check_box
from meshlab_symrecon.host.importing import after_loading
from meshlab_symrecon.host.inspection import inspect
from meshlab_symrecon.host.losses import check_losses, check_points
from meshlab_symrecon.host.material_names import with_plain_names
from meshlab_symrecon.host.meshset import current_identifier
from meshlab_symrecon.host.notices import warn_user
from meshlab_symrecon.host.paths import (
    READABLE,
    check_input,
    check_output,
    checked_extension,
    reading,
)
from meshlab_symrecon.host.ply_plain import with_plain_data
from meshlab_symrecon.host.process_state import process_kept
from meshlab_symrecon.host.record_text import Record, put_record
from meshlab_symrecon.host.translation import translated
from meshlab_symrecon.host.whole import check_whole

__all__ = ["load", "new_document", "save_current", "write_layer"]


def new_document() -> Any:
    """Return an empty MeshSet that prints nothing."""
    return pymeshlab.MeshSet(verbose=False)


def load(path: str | Path, mesh_set: Any = None) -> Any:
    """Load a file's layers; the last one becomes the current one.

    Parameters
    ----------
    path : str or Path
    mesh_set : pymeshlab.MeshSet, optional
        Where to add them; a new one when left out.

    Returns
    -------
    pymeshlab.MeshSet

    Raises
    ------
    FileError
        The file is missing, empty, damaged, of no known format, or holds no points.

    Warns
    -----
    SymReconWarning
        MeshLab left out points whose coordinates are not numbers.
    """
    path = Path(path)
    held = _checked_before(path)
    mesh_set = new_document() if mesh_set is None else mesh_set
    before = {mesh.id() for mesh in mesh_set}
    current = current_identifier(mesh_set)
    readable = path
    try:
        with translated(f"{path} cannot be read"), process_kept(), _readable(path) as readable:
            mesh_set.load_new_mesh(str(readable))
    except HostError as error:
        message = str(error).replace(str(readable), str(path))
        raise FileError(f"{message}; write or download it again") from error
    new = [int(mesh.id()) for mesh in mesh_set if mesh.id() not in before]
    try:
        _compare(mesh_set, new, path, held)
    except FileError:
        _remove(mesh_set, new, current)
        raise
    try:
        for identifier in new:
            after_loading(mesh_set, identifier, path)
    except OSError as error:
        message = f"{error.filename or path} cannot be read: {reason(error)}; check its path"
        raise FileError(message) from error
    return mesh_set


def _compare(mesh_set: Any, new: list[int], path: Path, held: Held) -> None:
    """Compare what was loaded with what the file holds; say what is missing."""
    loaded = sum(mesh_set.mesh(identifier).vertex_number() for identifier in new)
    if loaded == 0:
        raise FileError(f"{path} holds no points; scan again or pick another file")
    for identifier in new:
        if mesh_set.mesh(identifier).vertex_number():
            check_box(path, mesh_set.mesh(identifier))
    for note in held.notes:
        warn_user(note)
    if held.unusable:
        words = f"{path}: {held.unusable} of {held.points} points have coordinates that are "
        faces = f" with {held.lost_faces} faces that use them" if held.lost_faces else ""
        warn_user(f"{words}not numbers; MeshLab left them out{faces}")
    if loaded != held.points - held.unusable and not held.merged:
        words = f"MeshLab read {loaded} of the {held.points - held.unusable} points that it holds"
        warn_user(f"{path}: {words}; look at what was read, or write the file again")
    faces = sum(mesh_set.mesh(identifier).face_number() for identifier in new)
    if held.triangles is not None and faces < held.triangles and not held.lost_faces:
        words = f"MeshLab made {faces} triangles of faces that can be cut into {held.triangles}"
        warn_user(f"{path}: {words}; corners that come twice and bent polygons are left out")


def _remove(mesh_set: Any, identifiers: list[int], current: int) -> None:
    """Remove layers that cannot be used, and make the one current that was."""
    for identifier in identifiers:
        mesh_set.set_current_mesh(identifier)
        mesh_set.delete_current_mesh()
    if current >= 0:
        mesh_set.set_current_mesh(current)


def _readable(path: Path) -> AbstractContextManager[Path]:
    """Return the path, or one under which MeshLab reads all that the file holds."""
    extension = path.suffix.lower()
    if extension == ".obj":
        return with_plain_names(path)
    return with_plain_data(path) if extension == ".ply" else nullcontext(path)


def _checked_before(path: Path) -> Held:
    """Check a file before MeshLab touches it; return what it holds."""
    check_input(path)
    with reading(path):
        return inspect(path, checked_extension(path, READABLE, "read"))


def save_current(mesh_set: Any, path: str | Path, record: Record | None = None) -> None:
    """Save the current layer in world coordinates, with everything the format can hold.

    Normals, colours and quality are written when the layer has them and the format can hold them;
    PLY keeps coordinates to the last bit. A file at ``path`` is replaced only by a whole one.

    Parameters
    ----------
    mesh_set : pymeshlab.MeshSet
    path : str or Path
    record : Record, optional
        Goes into the header of a PLY file; other formats have no place for it.

    Raises
    ------
    FileError
        Unknown extension, no such directory, no layer, or the system refused.

    Warns
    -----
    SymReconWarning
        The format loses faces, or points that belong to no face.
    """
    path = Path(path)
    check_output(path)
    identifier = current_identifier(mesh_set)
    if identifier < 0:
        raise FileError(f"{path} cannot be written: the document is empty; load a layer first")
    with replacing(path) as staged:
        write_layer(mesh_set, identifier, path, staged, record=record)


def write_layer(
    mesh_set: Any,
    identifier: int,
    path: Path,
    staged: Path,
    world: bool = True,
    record: Record | None = None,
) -> None:
    """Write one layer and the images of its textures to ``staged`` and beside it.

    Parameters
    ----------
    mesh_set : pymeshlab.MeshSet
    identifier : int
    path : Path
        Where the file will be, and what messages call it.
    staged : Path
        Where it is written first.
    world : bool
        Whether the layer's transform matrix goes into the coordinates; otherwise it is left out.
    record : Record, optional
        As ``save_current``.

    Raises
    ------
    FileError
        The format holds nothing of the layer, or the system refused.

    Warns
    -----
    SymReconWarning
        The format loses something that the layer has.
    """
    extension = path.suffix.removeprefix(".").lower()
    mesh = mesh_set.mesh(identifier)
    check_points(mesh, path, extension)
    source, number = mesh_set, identifier
    in_place = np.array_equal(mesh.transform_matrix(), np.eye(4)) or not world
    try:
        contents = contents_of(mesh_set, identifier)
        check_losses(mesh, path, extension)
        lost = lost_in(contents, extension)
        if lost:
            told = ", ".join(lost)
            warn_user(f"{path}: .{extension} cannot keep {told}; write .ply to keep all")
        if not in_place or needs_wedges(contents, extension):
            source, number = changed_copy(mesh_set, identifier, world, extension)
            contents = contents_of(source, number)
        export(source, number, path, staged, contents)
    except HostError as error:
        told = str(error).removeprefix(f"{path} cannot be written: ")
        message = f"{path} cannot be written: {told}; check free space and the format"
        raise FileError(message) from error
    if record is not None and extension == "ply":
        put_record(staged, record)
    check_whole(mesh, path, staged)
