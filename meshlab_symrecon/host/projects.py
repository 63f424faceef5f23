"""MeshLab projects: every layer in a file of its own, and the ``.mlp`` that lists them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from meshlab_symrecon.host.atomic import replacing
from meshlab_symrecon.host.files import check_output, write_layer

__all__ = ["PROJECT", "layer_files", "save_project"]

PROJECT = "mlp"  # extension


def save_project(
    mesh_set: Any,
    path: str | Path,
    inputs: Iterable[str | Path] = (),
    labels: Mapping[int, str] | None = None,
) -> None:
    """Save every layer beside a MeshLab project that lists them, in world coordinates.

    The layers' files are named after the project and the layers: ``name-label.ply``.

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
            write_layer(mesh_set, identifier, path.parent / name, staged.parent / name)
        staged.write_bytes(_project_text(shown, names).encode("utf-8"))


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


def _project_text(labels: Mapping[int, str], names: Mapping[int, str]) -> str:
    root = ElementTree.Element("MeshLabProject")
    group = ElementTree.SubElement(root, "MeshGroup")
    for identifier, name in names.items():
        attributes = {
            "label": labels[identifier],
            "idInFile": "-1",
            "filename": name,
            "visible": "1",
        }
        matrix = ElementTree.SubElement(
            ElementTree.SubElement(group, "MLMesh", attributes), "MLMatrix44"
        )
        matrix.text = "\n1 0 0 0 \n0 1 0 0 \n0 0 1 0 \n0 0 0 1 \n"
    ElementTree.SubElement(root, "RasterGroup")
    ElementTree.indent(root, " ")
    return f"<!DOCTYPE MeshLabDocument>\n{ElementTree.tostring(root, encoding='unicode')}\n"
