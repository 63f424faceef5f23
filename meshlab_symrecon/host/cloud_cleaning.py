"""Cleaning steps that are made for meshes, and would delete every point of a cloud."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from meshlab_symrecon.host.meshset import current_identifier

if TYPE_CHECKING:
    from meshlab_symrecon.host.native_filters import NativeFilter

__all__ = ["EMPTY_CLOUDS", "empties_clouds", "reason_to_skip"]

# Common in scripts.
EMPTY_CLOUDS = frozenset(
    {
        "meshing_edge_flip_by_curvature_optimization",
        "meshing_remove_connected_component_by_diameter",
        "meshing_remove_connected_component_by_face_number",
        "meshing_remove_unreferenced_vertices",
    }
)
# The same, but only with that value.
EMPTY_CLOUDS_WITH: dict[str, tuple[str, object]] = {
    "meshing_repair_non_manifold_edges": ("method", "Split Vertices")
}


def reason_to_skip(
    mesh_set: Any, item: NativeFilter, values: Mapping[str, Any] | None = None
) -> str:
    """Say why a cleaning step must not run although it would not crash; empty when it may run."""
    if empties_clouds(item, values or {}) and current_identifier(mesh_set) >= 0:
        mesh = mesh_set.current_mesh()
        if mesh.face_number() == 0 and mesh.vertex_number() > 0:
            return f"layer '{mesh.label()}' has no faces, so every point would be deleted"
    return ""


def empties_clouds(item: NativeFilter, values: Mapping[str, Any]) -> bool:
    """Say whether a cleaning step with these values deletes every point of a cloud."""
    if item.python_name in EMPTY_CLOUDS_WITH:
        parameter, value = EMPTY_CLOUDS_WITH[item.python_name]
        return bool(values.get(parameter) == value)
    return item.python_name in EMPTY_CLOUDS
