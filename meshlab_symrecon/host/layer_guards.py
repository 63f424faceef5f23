"""The layers that a native step names: they must exist, and be the right ones in their roles."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from meshlab_symrecon.errors import ParameterError
from meshlab_symrecon.host.meshset import current_identifier

if TYPE_CHECKING:
    from meshlab_symrecon.host.native_filters import NativeFilter

__all__ = ["NEED_TWO_LAYERS", "WANT_CURRENT", "check_distinct", "check_layers", "layers_used"]

# Filters that crash or fail when two of their layers are one, and the parameters that name them.
NEED_TWO_LAYERS = {
    "apply_coord_craters_from_point_cloud": ("target_mesh", "samples_mesh"),
    "compute_matrix_by_icp_between_meshes": ("referencemesh", "sourcemesh"),
    "compute_mls_projection_apss": ("controlmesh", "proxymesh"),
    "compute_mls_projection_rimls": ("controlmesh", "proxymesh"),
    "compute_scalar_by_distance_from_another_mesh_per_vertex": ("measuremesh", "refmesh"),
    "get_hausdorff_distance": ("sampledmesh", "targetmesh"),
    "transfer_attributes_per_vertex": ("sourcemesh", "targetmesh"),
}
# Filters that crash unless the layer that this parameter names is the current one.
WANT_CURRENT = {
    "compute_mls_projection_apss": "controlmesh",
    "compute_mls_projection_rimls": "controlmesh",
}


def check_layers(mesh_set: Any, item: NativeFilter, values: Mapping[str, Any]) -> None:
    """Refuse numbers of layers that do not exist, given or by default: MeshLab would crash.

    Raises
    ------
    ParameterError
    """
    for name, number in layers_used(mesh_set, item, values).items():
        if mesh_set.mesh_id_exists(number):
            continue
        known = ", ".join(str(mesh.id()) for mesh in mesh_set) or "none"
        message = (
            f"parameter '{name}' of '{item.menu_name}' must be the number of a layer; "
            f"got {number}; the document has {known}"
        )
        raise ParameterError(message)


def check_distinct(mesh_set: Any, item: NativeFilter, values: Mapping[str, Any]) -> None:
    """Refuse one layer in two roles, or the wrong one in a role, where MeshLab would fail on it.

    Raises
    ------
    ParameterError
    """
    if item.python_name not in NEED_TWO_LAYERS:
        return
    first, second = NEED_TWO_LAYERS[item.python_name]
    used = layers_used(mesh_set, item, values)
    if used[first] == used[second]:
        message = (
            f"'{item.menu_name}' needs two layers; got {used[first]} as '{first}' and as "
            f"'{second}'; name two different ones"
        )
        raise ParameterError(message)
    wanted = WANT_CURRENT.get(item.python_name)
    if wanted is not None and used[wanted] != current_identifier(mesh_set):
        message = (
            f"'{item.menu_name}' needs the current layer as '{wanted}'; got {used[wanted]}; the "
            f"current one is {current_identifier(mesh_set)}; make the other one current first"
        )
        raise ParameterError(message)


def layers_used(mesh_set: Any, item: NativeFilter, values: Mapping[str, Any]) -> Mapping[str, int]:
    """Return the number of each layer that a step names, in its values or by its defaults."""
    names = [known.name for known in item.parameters if known.rich_type == "RichMesh"]
    given = {name: values[name] for name in names if name in values}
    if len(given) == len(names) or mesh_set.mesh_number() == 0:
        return given
    defaults = mesh_set.filter_parameter_values(item.python_name)
    return {name: defaults[name] for name in names} | given
