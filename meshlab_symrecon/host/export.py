"""Layers written by MeshLab's own writers, with exactly the attributes that are asked for."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from meshlab_symrecon.errors import FileError, HostError
from meshlab_symrecon.host.atomic import replacing
from meshlab_symrecon.host.export_refusals import exporting_to
from meshlab_symrecon.host.files import write_layer
from meshlab_symrecon.host.formats import WRITABLE
from meshlab_symrecon.host.image_names import rename_images
from meshlab_symrecon.host.losses import check_losses, check_points
from meshlab_symrecon.host.mask import TEXT, held_flags, save_options
from meshlab_symrecon.host.meshset import current_identifier
from meshlab_symrecon.host.process_state import process_kept
from meshlab_symrecon.host.textures import place_textures
from meshlab_symrecon.host.whole import check_whole

__all__ = ["export_layer", "write_all", "write_staged"]

TEXTURED = ("save_wedge_texcoord", "save_vertex_coord")


def export_layer(
    mesh_set: Any,
    identifier: int,
    path: str | Path,
    options: Mapping[str, bool],
) -> None:
    """Write one layer as it is, its matrix left out; a file at ``path`` is replaced by a whole one.

    Parameters
    ----------
    mesh_set : pymeshlab.MeshSet
    identifier : int
    path : str or Path
        Its extension is a key of ``mask.SAVED``.
    options : mapping of str to bool
        pymeshlab's save options, from ``mask.save_options``.

    Raises
    ------
    FileError
        The format holds nothing of the layer, or the system refused.

    Warns
    -----
    SymReconWarning
        The format loses faces, or points that belong to no face.
    """
    path = Path(path)
    with replacing(path) as staged:
        write_staged(mesh_set, identifier, path, staged, options)


def write_staged(
    mesh_set: Any,
    identifier: int,
    path: Path,
    staged: Path,
    options: Mapping[str, bool],
) -> None:
    """Write one layer, and its textures, to ``staged``; messages call it ``path``.

    Raises
    ------
    FileError
        As ``export_layer``.
    """
    extension = path.suffix.removeprefix(".").lower()
    mesh = mesh_set.mesh(identifier)
    check_points(mesh, path, extension)
    check_losses(mesh, path, extension)
    before = current_identifier(mesh_set)
    try:
        with exporting_to(path, staged), process_kept():
            mesh_set.set_current_mesh(identifier)
            mesh_set.save_current_mesh(str(staged.resolve()), save_textures=False, **options)
    except HostError as error:
        raise FileError(f"{error}; check free space and the format") from error
    finally:
        mesh_set.set_current_mesh(before)
    if any(options.get(name) for name in TEXTURED):
        names = place_textures(mesh_set, identifier, path, staged)
        for file in (staged, staged.with_name(f"{staged.name}.mtl")):
            rename_images(file, names)
    check_whole(mesh_set.mesh(identifier), path, staged)


def write_all(mesh_set: Any, identifier: int, path: Path, staged: Path, text: bool = False) -> None:
    """Write one layer, without its matrix, with everything that it has and its format can hold.

    Parameters
    ----------
    mesh_set : pymeshlab.MeshSet
    identifier : int
    path : Path
        Where the file will be; its extension is a key of ``mask.SAVED``.
    staged : Path
        Where it is written first.
    text : bool
        Write a PLY or STL file as text, without custom attributes.

    Raises
    ------
    FileError
        As ``export_layer``.
    """
    extension = path.suffix.removeprefix(".").lower()
    if extension in WRITABLE and not text:
        write_layer(mesh_set, identifier, path, staged, world=False)
        return
    held = held_flags(extension, mesh_set.mesh(identifier))
    flags = held | {TEXT} if text else held
    write_staged(mesh_set, identifier, path, staged, save_options(extension, flags))
