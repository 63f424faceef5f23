"""One layer through MeshLab's exporter, with what the exporter itself gets wrong put right."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from meshlab_symrecon.arrays import Floats
from meshlab_symrecon.host.attributes import read_attribute
from meshlab_symrecon.host.export_refusals import exporting_to
from meshlab_symrecon.host.formats import TEXTURED, Contents, options_for
from meshlab_symrecon.host.image_names import rename_images
from meshlab_symrecon.host.meshset import current_identifier
from meshlab_symrecon.host.notices import warn_user
from meshlab_symrecon.host.ply_header import read_header
from meshlab_symrecon.host.ply_writing import extend_ply
from meshlab_symrecon.host.process_state import process_kept
from meshlab_symrecon.host.sources import input_files
from meshlab_symrecon.host.textures import place_textures
from meshlab_symrecon.host.translation import translated

__all__ = ["export"]


def export(
    mesh_set: Any, identifier: int, path: Path, staged: Path, contents: Contents
) -> Mapping[str, str]:
    """Write a layer as it is, without its matrix; return the names of images that changed.

    The images of its textures are put beside it.

    MeshLab would write each image anew, at any place that its name leads to, so it is not asked to.

    Raises
    ------
    FileError
        The system takes no more, as a full disk does.
    HostError
        MeshLab refused.
    """
    extension = path.suffix.removeprefix(".").lower()
    options = options_for(contents, extension)
    before = current_identifier(mesh_set)
    try:
        with exporting_to(path, staged), process_kept():
            mesh_set.set_current_mesh(identifier)
            mesh_set.save_current_mesh(str(staged.resolve()), save_textures=False, **options)
    finally:
        mesh_set.set_current_mesh(before)
    names: Mapping[str, str] = {}
    if extension in TEXTURED:
        names = place_textures(mesh_set, identifier, path, staged)
        materials = staged.with_name(f"{staged.name}.mtl")
        for file in (staged, materials):
            rename_images(file, names)
        _settle_materials(mesh_set, path, staged, materials)
    if extension == "ply":
        with translated(f"{path} cannot be written"):
            _complete_ply(mesh_set.mesh(identifier), contents, path, staged)
    return names


def _complete_ply(mesh: Any, contents: Contents, path: Path, staged: Path) -> None:
    """Put edges and custom attributes into a PLY file, as far as their names are free there."""
    header = read_header(staged)
    columns: dict[str, dict[str, Floats]] = {}
    taken = []
    for attribute in contents.attributes:
        element = header.element(attribute.element)
        name = "_".join(attribute.name.split())
        of_element = columns.setdefault(attribute.element, {})
        if not attribute.known or element is None:
            continue
        values = read_attribute(mesh, attribute)
        if name not in element.names and name not in of_element:
            of_element[name] = values
        elif name != "quality" or not np.array_equal(values, mesh.vertex_scalar_array()):
            taken.append(attribute.name)
    if taken:
        words = f"{path}: custom attributes ({', '.join(taken)}) were left out"
        warn_user(f"{words}: a PLY file has something else of that name; rename them")
    edges = np.asarray(mesh.edge_matrix()) if contents.edges else None
    if edges is not None or any(columns.values()):
        extend_ply(staged, columns, edges)


def _settle_materials(mesh_set: Any, path: Path, staged: Path, materials: Path) -> None:
    """Give a file of materials another name when an input's has the one that MeshLab chose."""
    folder, protected = path.resolve().parent, input_files(mesh_set)
    number, name = 1, materials.name
    while folder / name in protected:
        number += 1
        name = f"{path.name}-{number}.mtl"
    if name == materials.name or not materials.exists():
        return
    content = staged.read_bytes()
    old, new = (f"mtllib ./{word}".encode() for word in (materials.name, name))
    staged.write_bytes(content.replace(old, new, 1))
    materials.replace(materials.with_name(name))
