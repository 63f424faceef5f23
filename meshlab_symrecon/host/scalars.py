"""New vertex scalars for a layer that is in the document, which pymeshlab has no setter for.

A custom attribute can be given to a layer, and one of MeshLab's own filters sets the quality of its
vertices to it, to the last bit. The attribute stays, since nothing can remove it.
"""

from __future__ import annotations

import re
from itertools import count
from typing import Any

import numpy as np

from meshlab_symrecon.errors import HostError
from meshlab_symrecon.host.meshset import (
    POINT_PREFIX,
    SCALAR_PREFIX,
    attribute_names,
    current_identifier,
)
from meshlab_symrecon.host.native_filters import apply_native
from meshlab_symrecon.host.translation import translated
from meshlab_symrecon.plugin import VertexScalars

__all__ = ["NATIVE_STEPS", "QUALITY_FUNCTION", "check_writable", "write_scalars"]

PLAIN = re.compile("[a-z][a-z0-9_]*")  # what both MeshLab's formulas and its lists can tell
QUALITY_FUNCTION = "compute_scalar_by_function_per_vertex"
NATIVE_STEPS = 1  # that each call of `write_scalars` leaves in the history


def check_writable(mesh_set: Any, scalars: VertexScalars) -> None:
    """Refuse scalars that do not fit their layer.

    Raises
    ------
    HostError
        There is no such layer, an array has not one number a vertex, or a name is not made of lower
        case letters, digits and underscores.
    """
    if not mesh_set.mesh_id_exists(scalars.identifier):
        message = f"scalars for layer {scalars.identifier}, which is not in the document"
        raise HostError(f"{message}; report this to the filter's author")
    mesh = mesh_set.mesh(scalars.identifier)
    if not mesh.is_compact():
        mesh.compact()
    vertices = mesh.vertex_number()
    for name, values in {scalars.name: scalars.quality, **scalars.attributes}.items():
        if not PLAIN.fullmatch(name):
            message = f"a custom attribute needs a name like 'my_attribute'; got {name!r}"
            raise HostError(f"{message}; report this to the filter's author")
        if np.shape(values) != (vertices,):
            message = (
                f"'{name}' of layer {scalars.identifier} needs {vertices} numbers, one a vertex; "
                f"got shape {np.shape(values)}; report this to the filter's author"
            )
            raise HostError(message)


def write_scalars(mesh_set: Any, scalars: VertexScalars) -> None:
    """Set the vertex quality of a layer, and keep the numbers as custom attributes as well.

    All else stays as it is: positions, normals, colours, faces, selections, the matrix, and which
    layer is current. One step of MeshLab's is added to the history.

    Raises
    ------
    HostError
        The scalars do not fit the layer, or MeshLab did not take them.
    """
    check_writable(mesh_set, scalars)
    ending = _free_ending(mesh_set, scalars)
    name = scalars.name + ending
    current = current_identifier(mesh_set)
    mesh_set.set_current_mesh(scalars.identifier)
    try:
        with translated(f"writing '{name}' into layer {scalars.identifier}"):
            mesh = mesh_set.current_mesh()
            for plain, values in {scalars.name: scalars.quality, **scalars.attributes}.items():
                numbers = np.array(values, dtype=np.float64)
                mesh.add_vertex_custom_scalar_attribute(numbers, plain + ending)
            apply_native(mesh_set, QUALITY_FUNCTION, {"q": name})
    finally:
        if current >= 0:
            mesh_set.set_current_mesh(current)


def _free_ending(mesh_set: Any, scalars: VertexScalars) -> str:
    """Return what to append to the names so that all of them are free: nothing, _2, _3 ..."""
    kinds = (SCALAR_PREFIX, POINT_PREFIX)
    taken = {name for kind in kinds for name in attribute_names(mesh_set, scalars.identifier, kind)}
    wanted = (scalars.name, *scalars.attributes)
    endings = ("" if number == 1 else f"_{number}" for number in count(1))
    return next(ending for ending in endings if not taken & {name + ending for name in wanted})
