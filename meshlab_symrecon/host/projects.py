"""MeshLab projects: layers in files of their own, and the ``.mlp`` that lists them."""

from __future__ import annotations

import copy
import re
import tempfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from meshlab_symrecon.errors import FileError, HostError
from meshlab_symrecon.host.atomic import replacing
from meshlab_symrecon.host.files import load, new_document, write_layer
from meshlab_symrecon.host.native_filters import apply_native
from meshlab_symrecon.host.notices import warn_user
from meshlab_symrecon.host.paths import check_output
from meshlab_symrecon.host.project_files import (
    READABLE_PROJECTS,
    Project,
    ProjectLayer,
    read_project,
)
from meshlab_symrecon.host.record_text import Record
from meshlab_symrecon.host.translation import translated

__all__ = [
    "PROJECT",
    "files_of",
    "layer_files",
    "load_input",
    "load_layers",
    "load_project",
    "save_project",
]

PROJECT = "mlp"  # extension


def load_project(path: str | Path, mesh_set: Any = None) -> Any:
    """Load the layers of a project with their labels, matrices and visibility, and its rasters.

    Parameters
    ----------
    path : str or Path
        ``.mlp``, ``.mlb`` or ``.aln``.
    mesh_set : pymeshlab.MeshSet, optional
        Where to add them; a new one when left out.

    Returns
    -------
    pymeshlab.MeshSet

    Raises
    ------
    FileError
        As ``read_project``; or a layer's file cannot be read.

    Warns
    -----
    SymReconWarning
        Rasters whose images are missing were left out.
    """
    mesh_set = new_document() if mesh_set is None else mesh_set
    load_layers(read_project(path), mesh_set)
    return mesh_set


def load_input(path: Path, mesh_set: Any) -> None:
    """Add the layers of a mesh's file, or of a project, to a document.

    Raises
    ------
    FileError
        As ``load``, or ``load_project``.
    """
    if _is_project(path):
        load_project(path, mesh_set)
    else:
        load(path, mesh_set)


def files_of(path: Path) -> tuple[Path, ...]:
    """Return the files that an input consists of: itself, and the meshes that a project names.

    Raises
    ------
    FileError
        As ``read_project``.
    """
    layers = read_project(path).layers if _is_project(path) else ()
    return (path, *(layer.path for layer in layers))


def _is_project(path: Path) -> bool:
    return path.suffix.removeprefix(".").lower() in READABLE_PROJECTS


def load_layers(project: Project, mesh_set: Any) -> dict[int, Path]:
    """Load a project that has been read; return the file of each new layer, by its identifier.

    Raises
    ------
    FileError
        A layer's file cannot be read.

    Warns
    -----
    SymReconWarning
        Rasters whose images are missing were left out.
    """
    origins: dict[int, Path] = {}
    for layer in project.layers:
        before = {mesh.id() for mesh in mesh_set}
        load(layer.path, mesh_set)
        added = [int(mesh.id()) for mesh in mesh_set if mesh.id() not in before]
        chosen = _chosen(mesh_set, added, layer)
        for identifier in chosen:
            _place(mesh_set, identifier, layer, alone=len(chosen) == 1)
            origins[identifier] = layer.path
    if project.missing_images:
        names = ", ".join(str(path) for path in project.missing_images)
        warn_user(f"{project.path}: rasters were left out, for their images are missing: {names}")
    if project.rasters:
        _load_rasters(project, mesh_set)
    return origins


def _chosen(mesh_set: Any, added: list[int], layer: ProjectLayer) -> list[int]:
    """Return the layers that a project means, of a file with several; remove the others."""
    if len(added) == 1 or layer.index not in range(len(added)):
        return added
    for identifier in added:
        if identifier != added[layer.index]:
            mesh_set.set_current_mesh(identifier)
            mesh_set.delete_current_mesh()
    mesh_set.set_current_mesh(added[layer.index])
    return [added[layer.index]]


def _place(mesh_set: Any, identifier: int, layer: ProjectLayer, *, alone: bool) -> None:
    if layer.label and alone:
        mesh_set.mesh(identifier).set_label(layer.label)
    if not np.array_equal(layer.matrix, np.eye(4)):
        mesh_set.set_current_mesh(identifier)
        apply_native(mesh_set, "set_matrix", {"transformmatrix": layer.matrix, "freeze": False})
    mesh_set.set_mesh_visibility(identifier, layer.visible)


def _load_rasters(project: Project, mesh_set: Any) -> None:
    """Load rasters by way of a project of them alone, the only way that keeps their cameras."""
    root = ElementTree.Element("MeshLabProject")
    ElementTree.SubElement(root, "MeshGroup")
    ElementTree.SubElement(root, "RasterGroup").extend(copy.deepcopy(project.rasters))
    with tempfile.TemporaryDirectory(prefix="symrecon-") as folder:
        path = Path(folder) / "rasters.mlp"
        ElementTree.ElementTree(root).write(path, encoding="utf-8")
        try:
            with translated(f"the rasters of {project.path} cannot be read"):
                mesh_set.load_project(str(path))
        except HostError as error:
            raise FileError(f"{error}; remove its <RasterGroup>") from error


def save_project(
    mesh_set: Any,
    path: str | Path,
    inputs: Iterable[str | Path] = (),
    labels: Mapping[int, str] | None = None,
    record: Record | None = None,
) -> None:
    """Save every layer beside a MeshLab project that lists them.

    The layers' files are named after the project and the layers: ``name-label.ply``. Coordinates
    stay as they are, and the project keeps each layer's transform matrix and whether it is shown.

    Parameters
    ----------
    mesh_set : pymeshlab.MeshSet
    path : str or Path
    inputs : iterable of str or Path
        Files that must stay as they are.
    labels : mapping of int to str, optional
        Labels in the project, by layer identifier; the layers' own where left out.
    record : Record, optional
        Goes into the header of every layer's file.

    Raises
    ------
    FileError
        The path does not end in ``.mlp``, a file would take the place of one of ``inputs``, no
        such directory, or the system refused.

    Warns
    -----
    SymReconWarning
        The document has pictures, which pymeshlab does not tell about.
    """
    path = Path(path)
    inputs = tuple(inputs)
    check_output(path, inputs, (PROJECT,))
    shown = {mesh.id(): mesh.label() for mesh in mesh_set} | dict(labels or {})
    names = layer_files(path, shown)
    for name in names.values():
        check_output(path.parent / name, inputs)
    with replacing(path) as staged:
        for identifier, name in names.items():
            place = staged.parent / name
            output = path.parent / name
            write_layer(mesh_set, identifier, output, place, world=False, record=record)
        staged.write_bytes(_project_text(mesh_set, shown, names).encode("utf-8"))
    pictures = mesh_set.raster_number()
    if pictures:
        warn_user(f"{path}: {pictures} raster layers were left out; keep the project they are in")


def layer_files(project: Path, labels: Mapping[int, str]) -> dict[int, str]:
    """Return the name of each layer's file beside a project, by layer identifier."""
    names: dict[int, str] = {}
    for identifier, label in labels.items():
        plain = re.sub(r"[^\w.-]+", "-", label).strip("-") or "layer"
        name = f"{project.stem}-{plain}.ply"
        if name.lower() in (other.lower() for other in names.values()):
            name = f"{project.stem}-{plain}-{identifier}.ply"
        names[identifier] = name
    return names


def _project_text(mesh_set: Any, labels: Mapping[int, str], names: Mapping[int, str]) -> str:
    root = ElementTree.Element("MeshLabProject")
    group = ElementTree.SubElement(root, "MeshGroup")
    for identifier, name in names.items():
        attributes = {
            "label": labels[identifier],
            "idInFile": "-1",
            "filename": name,
            "visible": str(int(mesh_set.mesh(identifier).is_visible())),
        }
        matrix = ElementTree.SubElement(
            ElementTree.SubElement(group, "MLMesh", attributes), "MLMatrix44"
        )
        rows = np.asarray(mesh_set.mesh(identifier).transform_matrix()).tolist()
        matrix.text = "\n" + "".join(" ".join(map(_number, row)) + " \n" for row in rows)
    ElementTree.SubElement(root, "RasterGroup")
    ElementTree.indent(root, " ")
    return f"<!DOCTYPE MeshLabDocument>\n{ElementTree.tostring(root, encoding='unicode')}\n"


def _number(value: float) -> str:
    """Return a number in full, a whole one without a fraction."""
    return str(int(value)) if value.is_integer() else repr(value)
