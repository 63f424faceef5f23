"""A project saved the way ``meshlabserver`` did: layers beside the files they came from."""

from __future__ import annotations

import os
import re
import tempfile
from collections.abc import Iterable, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from defusedxml.ElementTree import parse

from meshlab_symrecon.host.atomic import replacing
from meshlab_symrecon.host.export import write_all
from meshlab_symrecon.host.mask import SAVED
from meshlab_symrecon.host.translation import translated

__all__ = ["copied_files", "save_project_copy"]


def copied_files(
    project: Path, labels: Mapping[int, str], origins: Mapping[int, Path], middle: str
) -> dict[int, Path]:
    """Return the file of each layer, by its identifier.

    Parameters
    ----------
    project : Path
    labels : mapping of int to str
        The label of each layer.
    origins : mapping of int to Path
        The file that a layer came from, if it came from one.
    middle : str
        Goes between the name and the extension; empty to write into the place of the origins.
    """
    files: dict[int, Path] = {}
    for identifier, label in labels.items():
        file = _wanted(project, label, origins.get(identifier), middle)
        if any(str(file).lower() == str(other).lower() for other in files.values()):
            file = file.with_name(f"{file.stem}-{identifier}{file.suffix}")
        files[identifier] = file
    return files


def _wanted(project: Path, label: str, origin: Path | None, middle: str) -> Path:
    if origin is None:
        stem = re.sub(r"[^\w.-]+", "", label) or "layer"
        if stem.rpartition(".")[2].lower() in SAVED:
            stem = stem.rpartition(".")[0]
        return project.parent / f"{stem}{middle}.ply"
    savable = origin.suffix.removeprefix(".").lower() in SAVED
    return origin.with_name(f"{origin.stem}{middle}{origin.suffix if savable else '.ply'}")


def save_project_copy(
    mesh_set: Any,
    path: Path,
    files: Mapping[int, Path],
) -> None:
    """Save every layer with all that its format holds, and a project that keeps their matrices.

    Parameters
    ----------
    mesh_set : pymeshlab.MeshSet
    path : Path
        The project.
    files : mapping of int to Path
        From ``copied_files``.

    Raises
    ------
    FileError
        A layer or the project cannot be written; then nothing was changed.
    """
    entries = []
    with ExitStack() as stack:
        staged_project = stack.enter_context(replacing(path))
        for identifier, file in files.items():
            staged = stack.enter_context(replacing(file))
            write_all(mesh_set, identifier, file, staged)
            mesh = mesh_set.mesh(identifier)
            name = Path(os.path.relpath(file, path.parent)).as_posix()
            entries.append((mesh.label(), name, mesh.is_visible(), mesh.transform_matrix()))
        staged_project.write_bytes(_project_text(entries, _rasters(mesh_set, path)))


def _rasters(mesh_set: Any, path: Path) -> list[ElementTree.Element]:
    """Return the rasters of a document, with their cameras, as a project at ``path`` names them."""
    if mesh_set.raster_number() == 0:
        return []
    with tempfile.TemporaryDirectory(prefix="symrecon-") as folder:
        written = Path(folder).resolve() / "rasters.mlp"
        with translated("the rasters cannot be saved"):
            mesh_set.save_project(str(written))
        rasters = list(parse(written).getroot().iter("MLRaster"))
        for plane in (plane for raster in rasters for plane in raster.iter("Plane")):
            image = (written.parent / plane.get("fileName", "")).resolve()
            plane.set("fileName", Path(os.path.relpath(image, path.parent.resolve())).as_posix())
    return rasters


def _project_text(
    entries: Iterable[tuple[str, str, bool, Any]], rasters: Iterable[ElementTree.Element] = ()
) -> bytes:
    """Return a project file.

    Parameters
    ----------
    entries : iterable of (str, str, bool, (4, 4) array)
        Label, file, visibility and matrix of each layer.
    rasters : iterable of Element
    """
    root = ElementTree.Element("MeshLabProject")
    group = ElementTree.SubElement(root, "MeshGroup")
    for label, name, visible, matrix in entries:
        attributes = {"label": label, "idInFile": "-1", "filename": name}
        attributes["visible"] = str(int(visible))
        element = ElementTree.SubElement(group, "MLMesh", attributes)
        rows = (" ".join(_number(value) for value in row) for row in np.asarray(matrix))
        ElementTree.SubElement(element, "MLMatrix44").text = "\n" + " \n".join(rows) + " \n"
    ElementTree.SubElement(root, "RasterGroup").extend(rasters)
    ElementTree.indent(root, " ")
    text = ElementTree.tostring(root, encoding="unicode")
    return f"<!DOCTYPE MeshLabDocument>\n{text}\n".encode()


def _number(value: Any) -> str:
    return f"{float(value)!r}".removesuffix(".0")
