"""What is checked before a native step, since MeshLab would end the process or do silent damage."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from meshlab_symrecon.errors import GeometryError, HostError
from meshlab_symrecon.host.layer_guards import check_distinct, check_layers, layers_used
from meshlab_symrecon.host.meshset import current_identifier
from meshlab_symrecon.host.shape_guards import FATAL_WITH_NAN, check_shape
from meshlab_symrecon.host.value_limits import check_limits

if TYPE_CHECKING:
    from meshlab_symrecon.host.native_filters import NativeFilter

__all__ = ["check_display", "check_sound", "check_step"]

# Filters that crash when the layer that this parameter names has no points; the current may have
# none.
WANT_POINTS = {
    "compute_mls_projection_apss": "controlmesh",
    "compute_mls_projection_rimls": "controlmesh",
    "transfer_attributes_per_vertex": "sourcemesh",
}
ALWAYS_ABORTS = frozenset({"create_mesh_by_grammar"})  # whatever the grammar
# Filters that abort for that value whatever they work on.
ABORTS_WITH: dict[str, tuple[str, object]] = {
    "generate_dust_accumulation_point_cloud": ("draw_texture", True)
}
POISSON = "generate_surface_reconstruction_screened_poisson"
# Filters that delete every point of a cloud in passing, or crash on layers with edges only, and the
# parameter that names the layer (none: the current one).
EMPTY_CLOUDS_TOO = {
    "compute_color_by_point_cloud_voronoi_projection": "coloredmesh",
    "compute_iso_parametrization": "",
    "generate_solid_wireframe": "",
    "get_scalar_statistics_per_face": "",
}
# Of those that need faces, the ones that run on polylines, too.
WORK_ON_EDGES = frozenset({"generate_solid_wireframe"})


def check_step(mesh_set: Any, item: NativeFilter, values: Mapping[str, Any]) -> None:
    """Refuse a native step that would end the process or do silent damage.

    Raises
    ------
    HostError, GeometryError, ParameterError
        As the functions that are called.
    """
    check_display(item)
    check_sound(item, values)
    check_limits(item, values)
    _check_document(mesh_set, item)
    check_layers(mesh_set, item, values)
    if current_identifier(mesh_set) >= 0:
        _check_vertices(mesh_set, item, values)
        check_distinct(mesh_set, item, values)
        _check_faces(mesh_set, item, values)
        _check_finite(mesh_set, item, values)
        _check_normals(mesh_set, item)
        check_shape(mesh_set, item, values)


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


def check_sound(item: NativeFilter, values: Mapping[str, Any]) -> None:
    """Refuse a filter that aborts the process whatever it works on.

    Raises
    ------
    HostError
    """
    name, where = item.python_name, ""
    if name in ABORTS_WITH:
        parameter, value = ABORTS_WITH[name]
        if values.get(parameter) != value:
            return
        where = f" with '{parameter}' set to {str(value).lower()}"
    elif name not in ALWAYS_ABORTS:
        return
    message = f"'{item.menu_name}' aborts in pymeshlab 2025.7{where}; run it in the MeshLab program"
    raise HostError(message)


def _check_document(mesh_set: Any, item: NativeFilter) -> None:
    """Refuse a filter that crashes on a document without layers."""
    if "empty" in item.fatal and mesh_set.mesh_number() == 0:
        message = f"'{item.menu_name}' needs a layer; got an empty document; load one first"
        raise HostError(message)


def _check_vertices(mesh_set: Any, item: NativeFilter, values: Mapping[str, Any]) -> None:
    """Refuse a filter that crashes on a layer without vertices: one that it names, if it does."""
    if "void" not in item.fatal:
        return
    number = current_identifier(mesh_set)
    if item.python_name in WANT_POINTS:
        number = layers_used(mesh_set, item, values)[WANT_POINTS[item.python_name]]
    mesh = mesh_set.mesh(number)
    if mesh.vertex_number() == 0:
        message = (
            f"'{item.menu_name}' needs points; layer '{mesh.label()}' has none; look at what the "
            "steps before it deleted"
        )
        raise GeometryError(message)


def _check_faces(mesh_set: Any, item: NativeFilter, values: Mapping[str, Any]) -> None:
    """Refuse a filter that crashes on a cloud, or deletes its points in passing."""
    fatal = "cloud" in item.fatal and "mesh" not in item.fatal
    if not fatal and item.python_name not in EMPTY_CLOUDS_TOO:
        return
    parameter = EMPTY_CLOUDS_TOO.get(item.python_name, "")
    used = layers_used(mesh_set, item, values)
    mesh = mesh_set.mesh(used.get(parameter, current_identifier(mesh_set)))
    if mesh.edge_number() > 0 and item.python_name in WORK_ON_EDGES:
        return
    if mesh.face_number() == 0:
        message = (
            f"'{item.menu_name}' needs faces; layer '{mesh.label()}' is a cloud; reconstruct a "
            "surface first"
        )
        raise GeometryError(message)


def _check_finite(mesh_set: Any, item: NativeFilter, values: Mapping[str, Any]) -> None:
    """Refuse NaN where a filter crashes on it, or takes shares of the box that it spoils."""
    shares = (known.name for known in item.parameters if known.rich_type == "RichAbsPerc")
    defaulted = [name for name in shares if name not in values]
    fatal = item.python_name in FATAL_WITH_NAN
    if not defaulted and not fatal:
        return
    used = set(layers_used(mesh_set, item, values).values()) if fatal else set()
    for number in sorted(used | {current_identifier(mesh_set)}):
        mesh = mesh_set.mesh(number)
        bad = np.count_nonzero(~np.isfinite(mesh.vertex_matrix()).all(axis=1))
        if bad:
            why = "fails on NaN" if fatal else f"measures '{defaulted[0]}' by the layer's box"
            message = (
                f"'{item.menu_name}' {why}; layer '{mesh.label()}' has {bad} points with NaN or "
                "infinity; remove them first"
            )
            raise GeometryError(message)


def _check_normals(mesh_set: Any, item: NativeFilter) -> None:
    """Refuse Screened Poisson without normals: its 'preclean' would delete every point."""
    if item.python_name != POISSON:
        return
    mesh = mesh_set.current_mesh()
    if mesh.face_number() == 0 and mesh.vertex_number() and not np.any(mesh.vertex_normal_matrix()):
        message = (
            f"'{item.menu_name}' needs normals; layer '{mesh.label()}' has none; compute normals "
            "for point sets first"
        )
        raise GeometryError(message)
