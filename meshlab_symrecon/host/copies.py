"""A layer in a document of its own, to be changed before it is written."""

from __future__ import annotations

import tempfile
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab

from meshlab_symrecon.errors import SymReconWarning
from meshlab_symrecon.host.attributes import SCRATCH
from meshlab_symrecon.host.exporting import export
from meshlab_symrecon.host.formats import (
    VERTEX_TEXTURE,
    WEDGES,
    WRITABLE,
    Contents,
    contents_of,
)
from meshlab_symrecon.host.importing import after_loading
from meshlab_symrecon.host.meshset import read_layer
from meshlab_symrecon.host.process_state import process_kept
from meshlab_symrecon.host.sources import Source, input_files, remember, source_of, texture_file
from meshlab_symrecon.host.translation import translated
from meshlab_symrecon.plugin import Layer

__all__ = ["changed_copy", "needs_wedges"]

AXES = ("x", "y", "z")


def needs_wedges(contents: Contents, extension: str) -> bool:
    """Say whether texture coordinates of vertices have to become those of wedges to be kept."""
    held = contents.held & {VERTEX_TEXTURE, WEDGES}
    return (
        contents.faces > 0
        and held == {VERTEX_TEXTURE}
        and extension != "ply"
        and (WEDGES in WRITABLE[extension])
    )


def changed_copy(mesh_set: Any, identifier: int, world: bool, extension: str) -> tuple[Any, int]:
    """Return a document with a copy of a layer that can be written as it is, and its number there.

    pymeshlab's own copies lose textures or custom attributes, so a PLY file carries the layer over.

    Parameters
    ----------
    mesh_set : pymeshlab.MeshSet
    identifier : int
    world : bool
        Whether the layer's matrix goes into the coordinates.
    extension : str
        Of the file that it is for.

    Raises
    ------
    HostError
        The matrix cannot be applied, or MeshLab refused.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SymReconWarning)  # of names, which are kept below
        layer = read_layer(mesh_set, identifier) if world else None
    matrix = np.array(mesh_set.mesh(identifier).transform_matrix())
    copy = pymeshlab.MeshSet(verbose=False)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "layer.ply"
        contents = contents_of(mesh_set, identifier)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SymReconWarning)  # the real file will tell
            names = export(mesh_set, identifier, path, path, contents)
            with translated("copying a layer"), process_kept():
                copy.load_new_mesh(str(path))
            after_loading(copy, 0, path)
        _inherit(mesh_set, identifier, copy, names)
        if needs_wedges(contents_of(copy, 0), extension):
            with translated("texture coordinates of wedges"):
                copy.compute_texcoord_transfer_vertex_to_wedge()
        if layer is not None:
            _move(copy, layer, mirrored=bool(np.linalg.det(matrix[:3, :3]) < 0.0))
    return copy, 0


def _inherit(mesh_set: Any, identifier: int, copy: Any, names: Mapping[str, str]) -> None:
    """Let the copy know the files behind its textures, and what the layer's file had."""
    old, new = source_of(mesh_set, identifier), source_of(copy, 0)
    textures = {}
    for name in mesh_set.mesh(identifier).textures():
        file = texture_file(mesh_set, identifier, name)
        if file is not None:
            textures[names.get(name, name)] = file
    files = tuple(input_files(mesh_set))
    remember(copy, 0, Source(files, textures, new.missing, old.held, new.attributes))


def _move(copy: Any, layer: Layer, mirrored: bool) -> None:
    """Set positions and normals to those of a layer, to the last bit."""
    finite = np.isfinite(layer.points).all(axis=1)  # what a PLY file brings back
    wanted = {"place": layer.points[finite]}
    if layer.normals is not None:
        wanted["normal"] = layer.normals[finite]
    mesh = copy.mesh(0)
    for what, rows in wanted.items():
        for axis, values in zip(AXES, rows.T, strict=True):
            name = f"{SCRATCH}{what}{axis}"
            mesh.add_vertex_custom_scalar_attribute(np.ascontiguousarray(values), name)
    with translated("moving a layer to its place in the world"):
        copy.compute_coord_by_function(**{axis: f"{SCRATCH}place{axis}" for axis in AXES})
        if mirrored and mesh.face_number():
            copy.meshing_invert_face_orientation(forceflip=True, onlyselected=False)
        if layer.normals is not None:
            functions = {axis: f"{SCRATCH}normal{axis}" for axis in AXES}
            copy.compute_normal_by_function_per_vertex(**functions)
