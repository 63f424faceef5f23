"""MeshLab projects: every layer in a file of its own, and the ``.mlp`` that lists them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from meshlab_symrecon.host.atomic import replacing
from meshlab_symrecon.host.files import check_output, write_layer
from meshlab_symrecon.host.notices import warn_user

__all__ = ["PROJECT", "layer_files", "save_project"]

PROJECT = "mlp"  # extension


def save_project(
    mesh_set: Any,
    path: str | Path,
    inputs: Iterable[str | Path] = (),
    labels: Mapping[int, str] | None = None,
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
            write_layer(mesh_set, identifier, path.parent / name, place, world=False)
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
