"""What filters and parameters of older MeshLab versions are called today."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from meshlab_symrecon.plugin.registry import plain_name

__all__ = ["CHANGE_LAYER", "NOTHING", "OldName", "current_parameter", "find_old_name"]

NOTHING = "no operation"  # what the filter did happens by itself today
CHANGE_LAYER = "set_current_mesh"  # a method of MeshSet, no filter, today


@dataclass(frozen=True, slots=True)
class OldName:
    """What an old filter became.

    Attributes
    ----------
    filter : str
        Python name today, ``NOTHING`` or ``CHANGE_LAYER``.
    values : mapping of str to str
        Values that the old name stood for.
    parameters : mapping of str to str
        Old name of a parameter: its name today; empty when it is gone.
    """

    filter: str
    values: Mapping[str, str] = field(default_factory=dict)
    parameters: Mapping[str, str] = field(default_factory=dict)


POISSON = "generate_surface_reconstruction_screened_poisson"
NON_MANIFOLD = "meshing_repair_non_manifold_edges"
REMOVE_FACES = OldName(NON_MANIFOLD, {"method": "0"})
OLD_NAMES = {
    plain_name(name): old
    for name, old in {
        "Quadric Edge Collapse Decimation": OldName("meshing_decimation_quadric_edge_collapse"),
        "Remove Duplicated Vertex": OldName("meshing_remove_duplicate_vertices"),
        "Remove Faces from Non Manifold Edges": REMOVE_FACES,
        "Repair non Manifold Edges by removing faces": REMOVE_FACES,
        "Repair non Manifold Edges by splitting vertices": OldName(NON_MANIFOLD, {"method": "1"}),
        "Screened Poisson": OldName(POISSON),
        "Screened Poisson Surface Reconstruction": OldName(POISSON),
        "Surface Reconstruction: Poisson": OldName(
            POISSON,
            parameters={
                "octdepth": "depth",
                "samplespernode": "samplespernode",
                "solverdivide": "",
                "offset": "",
            },
        ),
        "Transform: Move, Translate, Center": OldName("compute_matrix_from_translation"),
        "Transform: Scale": OldName("compute_matrix_from_scaling_or_normalization"),
        "Vertex Color to Texture": OldName("compute_texmap_from_color"),
        "Texture to Vertex Color (between 2 meshes)": OldName(
            "transfer_texture_to_color_per_vertex"
        ),
        "Compact faces": OldName(NOTHING),
        "Compact vertices": OldName(NOTHING),
        "Change the current layer": OldName(CHANGE_LAYER),
    }.items()
}
OLD_PARAMETERS = {"toall": "alllayers", "centerflag": "", "assign": ""}  # of any filter


def find_old_name(name: str) -> OldName | None:
    """Return what an old filter became, if ``name`` is one's."""
    return OLD_NAMES.get(plain_name(name))


def current_parameter(old: OldName | None, name: str) -> str | None:
    """Return a parameter's name today, empty when it is gone, None when it is not an old one."""
    plain = name.strip().lower()
    if old is not None and plain in old.parameters:
        return old.parameters[plain]
    return OLD_PARAMETERS.get(plain)
