"""What is checked before a native step, since MeshLab would end the process or do silent damage."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from meshlab_symrecon.errors import GeometryError, HostError, ParameterError
from meshlab_symrecon.host.meshset import current_identifier

if TYPE_CHECKING:
    from meshlab_symrecon.host.native_filters import NativeFilter

__all__ = [
    "check_display",
    "check_distinct",
    "check_document",
    "check_faces",
    "check_finite",
    "check_layers",
    "check_sound",
    "check_step",
    "check_vertices",
    "reason_to_skip",
]

# Filters that crash when two of their layers are one, and the parameters that name these layers.
NEED_TWO_LAYERS = {
    "compute_matrix_by_icp_between_meshes": ("referencemesh", "sourcemesh"),
    "compute_mls_projection_apss": ("controlmesh", "proxymesh"),
    "compute_mls_projection_rimls": ("controlmesh", "proxymesh"),
}
ALWAYS_ABORTS = frozenset({"create_mesh_by_grammar"})  # whatever the grammar
# Filters that clean meshes, common in scripts, and delete every point of a cloud.
EMPTY_CLOUDS = frozenset(
    {
        "meshing_edge_flip_by_curvature_optimization",
        "meshing_remove_connected_component_by_diameter",
        "meshing_remove_connected_component_by_face_number",
        "meshing_remove_unreferenced_vertices",
    }
)
# Filters that do so in passing, and the parameter that names the layer
# (none: the current one).
EMPTY_CLOUDS_TOO = {
    "compute_color_by_point_cloud_voronoi_projection": "coloredmesh",
    "generate_solid_wireframe": "",
}


def check_step(mesh_set: Any, item: NativeFilter, values: Mapping[str, Any]) -> None:
    """Refuse a native step that would end the process or do silent damage.

    Raises
    ------
    HostError, GeometryError, ParameterError
        As the other functions of this module.
    """
    check_display(item)
    check_sound(item)
    check_document(mesh_set, item)
    check_layers(mesh_set, item, values)
    if current_identifier(mesh_set) >= 0:
        check_distinct(mesh_set, item, values)
        check_vertices(mesh_set, item)
        check_faces(mesh_set, item, values)
        check_finite(mesh_set, item, values)


def check_display(item: NativeFilter) -> None:
    """Refuse a filter that draws with OpenGL: it would abort the process.

    Raises
    ------
    HostError
    """
    if item.display:
        message = (
            f"'{item.menu_name}' draws with OpenGL, for which pymeshlab has no window; run that "
            "step in the MeshLab program"
        )
        raise HostError(message)


def check_sound(item: NativeFilter) -> None:
    """Refuse a filter that aborts the process whatever it is given.

    Raises
    ------
    HostError
    """
    if item.python_name in ALWAYS_ABORTS:
        message = f"'{item.menu_name}' aborts in pymeshlab 2025.7; run it in the MeshLab program"
        raise HostError(message)


def check_document(mesh_set: Any, item: NativeFilter) -> None:
    """Refuse a filter that crashes on a document without layers.

    Raises
    ------
    HostError
    """
    if "empty" in item.fatal and mesh_set.mesh_number() == 0:
        message = f"'{item.menu_name}' needs a layer; got an empty document; load one first"
        raise HostError(message)


def check_layers(mesh_set: Any, item: NativeFilter, values: Mapping[str, Any]) -> None:
    """Refuse numbers of layers that do not exist, given or by default: MeshLab would crash.

    Raises
    ------
    ParameterError
    """
    for name, number in _layers_used(mesh_set, item, values).items():
        if mesh_set.mesh_id_exists(number):
            continue
        known = ", ".join(str(mesh.id()) for mesh in mesh_set) or "none"
        message = (
            f"parameter '{name}' of '{item.menu_name}' must be the number of a layer; "
            f"got {number}; the document has {known}"
        )
        raise ParameterError(message)


def check_distinct(mesh_set: Any, item: NativeFilter, values: Mapping[str, Any]) -> None:
    """Refuse one layer in two roles, given or by default, where MeshLab would crash on it.

    Raises
    ------
    ParameterError
    """
    if item.python_name not in NEED_TWO_LAYERS:
        return
    first, second = NEED_TWO_LAYERS[item.python_name]
    used = _layers_used(mesh_set, item, values)
    if used[first] == used[second]:
        message = (
            f"'{item.menu_name}' needs two layers; got {used[first]} as '{first}' and as "
            f"'{second}'; name two different ones"
        )
        raise ParameterError(message)


def _layers_used(mesh_set: Any, item: NativeFilter, values: Mapping[str, Any]) -> Mapping[str, int]:
    """Return the number of each layer that a step names, in its values or by its defaults."""
    names = [known.name for known in item.parameters if known.rich_type == "RichMesh"]
    given = {name: values[name] for name in names if name in values}
    if len(given) == len(names) or mesh_set.mesh_number() == 0:
        return given
    defaults = mesh_set.filter_parameter_values(item.python_name)
    return {name: defaults[name] for name in names} | given


def check_vertices(mesh_set: Any, item: NativeFilter) -> None:
    """Refuse a filter that crashes on a layer without vertices.

    Raises
    ------
    GeometryError
    """
    mesh = mesh_set.current_mesh()
    if "void" in item.fatal and mesh.vertex_number() == 0:
        message = (
            f"'{item.menu_name}' needs points; layer '{mesh.label()}' has none; look at what the "
            "steps before it deleted"
        )
        raise GeometryError(message)


def check_faces(mesh_set: Any, item: NativeFilter, values: Mapping[str, Any]) -> None:
    """Refuse a filter that crashes on a cloud, or deletes its points on the way to something else.

    Raises
    ------
    GeometryError
    """
    fatal = "cloud" in item.fatal and "mesh" not in item.fatal
    if not fatal and item.python_name not in EMPTY_CLOUDS_TOO:
        return
    parameter = EMPTY_CLOUDS_TOO.get(item.python_name, "")
    mesh = mesh_set.mesh(values.get(parameter, current_identifier(mesh_set)))
    if mesh.face_number() == 0:
        message = (
            f"'{item.menu_name}' needs faces; layer '{mesh.label()}' is a cloud; reconstruct a "
            "surface first"
        )
        raise GeometryError(message)


def check_finite(mesh_set: Any, item: NativeFilter, values: Mapping[str, Any]) -> None:
    """Refuse defaults that are shares of the box when a vertex is NaN: the box is then made up.

    Raises
    ------
    GeometryError
    """
    defaulted = [
        parameter.name
        for parameter in item.parameters
        if parameter.rich_type == "RichAbsPerc" and parameter.name not in values
    ]
    if not defaulted:
        return
    mesh = mesh_set.current_mesh()
    bad = np.count_nonzero(~np.isfinite(mesh.vertex_matrix()).all(axis=1))
    if bad:
        message = (
            f"'{item.menu_name}' measures '{defaulted[0]}' by the layer's box; layer "
            f"'{mesh.label()}' has {bad} points with NaN or infinity; remove them first"
        )
        raise GeometryError(message)


def reason_to_skip(mesh_set: Any, item: NativeFilter) -> str:
    """Say why a cleaning step must not run although it would not crash; empty when it may run."""
    if item.python_name in EMPTY_CLOUDS and current_identifier(mesh_set) >= 0:
        mesh = mesh_set.current_mesh()
        if mesh.face_number() == 0 and mesh.vertex_number() > 0:
            return f"layer '{mesh.label()}' has no faces, so every point would be deleted"
    return ""
