"""Layers written by MeshLab's own writers, with exactly the attributes that are asked for."""

from __future__ import annotations

import locale
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from meshlab_symrecon.errors import FileError, HostError
from meshlab_symrecon.host.atomic import replacing, same_file
from meshlab_symrecon.host.files import FACES_ONLY, POINTS_ONLY, READABLE, new_document
from meshlab_symrecon.host.meshset import attribute_names, current_identifier
from meshlab_symrecon.host.native_filters import apply_native
from meshlab_symrecon.host.notices import warn_user
from meshlab_symrecon.host.translation import translated

__all__ = ["attribute_options", "bake_layer", "export_layer", "write_staged"]

UNREPORTED = ("xyz", "3mf", "dae", "e57", "wrl", "x3d")  # writers that hide a full disk
NEEDS_POINTS = ("obj", "x3d", "3ds", "ctm")  # writers that refuse a layer without points
TEXTURED = ("save_wedge_texcoord", "save_vertex_coord")
COMPRESSED = (".jpg", ".jpeg")
QUALITY = 95  # of 100; Qt's own choice of 75 shows
AXES = ("x", "y", "z")
ATTRIBUTE = "__ca_"  # how the options of a PLY file begin that stand for custom attributes


def export_layer(
    mesh_set: Any,
    identifier: int,
    path: str | Path,
    options: Mapping[str, bool],
    textures: Mapping[str, Path] | None = None,
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
    textures : mapping of str to Path, optional
        Files to copy instead of writing the texture of that name anew.

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
        write_staged(mesh_set, identifier, path, staged, options, textures)


def write_staged(
    mesh_set: Any,
    identifier: int,
    path: Path,
    staged: Path,
    options: Mapping[str, bool],
    textures: Mapping[str, Path] | None = None,
) -> None:
    """Write one layer, and its textures, to ``staged``; messages call it ``path``.

    Raises
    ------
    FileError
        As ``export_layer``.
    """
    extension = path.suffix.removeprefix(".").lower()
    mesh = mesh_set.mesh(identifier)
    _check_losses(mesh, path, extension)
    names = list(mesh.textures()) if any(options.get(name) for name in TEXTURED) else []
    before = current_identifier(mesh_set)
    compressed = any(name.lower().endswith(COMPRESSED) for name in names)
    try:
        with translated(f"{path} cannot be written"), _locale_kept():
            mesh_set.set_current_mesh(identifier)
            mesh_set.save_current_mesh(
                str(staged), save_textures=bool(names),
                texture_quality=QUALITY if compressed else -1, **options,
            )  # fmt: skip
    except HostError as error:
        raise FileError(f"{error}; check free space and the format") from error
    finally:
        mesh_set.set_current_mesh(before)
    _check_whole(mesh_set.mesh(identifier), path, extension, staged)
    _keep_textures(staged.parent, path.parent, textures or {})


def attribute_options(mesh_set: Any, identifier: int, extension: str) -> dict[str, bool]:
    """Return the options that save a layer's custom attributes; only PLY has them."""
    if extension != "ply":
        return {}
    return {f"{ATTRIBUTE}{name}": True for name in attribute_names(mesh_set, identifier, ATTRIBUTE)}


def _check_losses(mesh: Any, path: Path, extension: str) -> None:
    points, faces = mesh.vertex_number(), mesh.face_number()
    if points == 0 and extension in NEEDS_POINTS:
        message = f"{path}: layer '{mesh.label()}' has no points, which .{extension} cannot hold"
        raise FileError(f"{message}; look at what the steps before it deleted")
    if extension in POINTS_ONLY and faces:
        words = f"{path}: .{extension} holds points only, so {faces} faces were left out"
        warn_user(f"{words}; write .ply to keep them")
    if extension not in FACES_ONLY or points == 0:
        return
    lost = points - len(np.unique(mesh.face_matrix()))
    words = f"{path}: .{extension} holds faces only, and {lost} points belong to no face"
    if faces == 0:
        raise FileError(f"{words}; write .ply instead")
    if lost:
        warn_user(f"{words}, so they were left out; write .ply to keep them")


@contextmanager
def _locale_kept() -> Iterator[None]:
    """Undo what the 3MF writer does: it sets the locale of the whole process to ``C``."""
    before = locale.setlocale(locale.LC_ALL)
    try:
        yield
    finally:
        locale.setlocale(locale.LC_ALL, before)


def _check_whole(mesh: Any, path: Path, extension: str, staged: Path) -> None:
    """Read back what a writer wrote that does not tell when the disk was full."""
    if not staged.is_file() or staged.stat().st_size == 0:
        raise FileError(f"{path} cannot be written: the writer made no file; check free space")
    if extension not in UNREPORTED or extension not in READABLE or mesh.vertex_number() == 0:
        return
    written = new_document()
    try:
        with translated(f"{path} cannot be written"):
            written.load_new_mesh(str(staged))
        faces = sum(layer.face_number() for layer in written)
    except HostError:
        faces = -1
    if faces != (0 if extension in POINTS_ONLY else mesh.face_number()):
        message = f"{path} cannot be written: the writer did not finish; check free space"
        raise FileError(message)


def _keep_textures(staging: Path, folder: Path, textures: Mapping[str, Path]) -> None:
    """Put the files that textures came from in the place of those that were written anew."""
    for name, source in textures.items():
        written = staging / Path(name).name
        if not (written.is_file() and source.is_file()):
            continue
        if same_file(source, folder / written.name):
            written.unlink()
        else:
            shutil.copyfile(source, written)


def bake_layer(mesh_set: Any, identifier: int) -> None:
    """Apply a layer's transform matrix to its points and normals, and reset it.

    MeshLab's own way leaves normals that are not square to the surface, or not numbers.

    Raises
    ------
    HostError
        The matrix flattens the layer, or MeshLab refused a step.
    """
    mesh = mesh_set.mesh(identifier)
    matrix = np.array(mesh.transform_matrix())
    if np.array_equal(matrix, np.eye(4)):
        return
    if not np.isfinite(matrix).all() or np.linalg.det(matrix[:3, :3]) == 0.0:
        message = f"layer '{mesh.label()}' has a transform matrix that flattens it"
        raise HostError(f"{message}; reset the matrix first")
    mirrored = np.linalg.det(matrix[:3, :3]) < 0.0 and mesh.face_number() > 0
    before = current_identifier(mesh_set)
    mesh_set.set_current_mesh(identifier)
    try:
        apply_native(mesh_set, "compute_normal_by_function_per_vertex", _normal_functions(matrix))
        apply_native(mesh_set, "compute_coord_by_function", _point_functions(matrix))
        apply_native(mesh_set, "set_matrix", {"transformmatrix": np.eye(4), "freeze": False})
        if mirrored:
            apply_native(mesh_set, "meshing_invert_face_orientation", {"forceflip": True})
            apply_native(mesh_set, "compute_normal_per_vertex", {})
            apply_native(mesh_set, "apply_normal_normalization_per_vertex", {})
    finally:
        mesh_set.set_current_mesh(before)


def _combination(factors: Any, names: tuple[str, ...]) -> str:
    pairs = zip(factors, names, strict=True)
    return "(" + "+".join(f"({float(factor)!r})*{name}" for factor, name in pairs) + ")"


def _point_functions(matrix: Any) -> dict[str, str]:
    return {
        axis: f"{_combination(row[:3], AXES)}+({float(row[3])!r})"
        for axis, row in zip(AXES, matrix[:3], strict=True)
    }


def _normal_functions(matrix: Any) -> dict[str, str]:
    turned = np.linalg.inv(matrix[:3, :3]).T
    rows = [_combination(row, ("nx", "ny", "nz")) for row in turned]
    length = "sqrt(" + "+".join(f"{row}^2" for row in rows) + ")"
    return {
        axis: f"(({length})>0)?({row}/{length}):0" for axis, row in zip(AXES, rows, strict=True)
    }
