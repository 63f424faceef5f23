"""Values of the right type on which filters of pymeshlab 2025.7 crash or never end.

Each was seen to do so on a plain sphere or cube; what merely takes long, or gives nothing, is let
run.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from meshlab_symrecon.errors import ParameterError

if TYPE_CHECKING:
    from meshlab_symrecon.host.native_filters import NativeFilter

__all__ = ["check_limits"]

ABOVE_ZERO = {
    "create_implicit_surface": ("voxelsize",),
    "generate_sampling_regular_recursive": ("cellsize",),
    "generate_voronoi_scaffolding": ("samplesurfradius",),
}
NOT_ZERO = {  # below 0 they run
    "apply_coord_point_cloud_movement_over_mesh": ("mass", "steps"),
    "meshing_isotropic_explicit_remeshing": ("targetlen",),
}
LEAST = {
    "apply_normal_point_cloud_smoothing": {"k": 1},
    "apply_scalar_saturation_per_vertex": {"gradientthr": 0},
    "compute_custom_radius_scalar_attribute_per_vertex": {"nbneighbors": 1},
    "compute_matrix_by_mesh_global_alignment": {"samplenum": 0},
    "compute_normal_for_point_clouds": {"k": 1},
    "compute_selection_point_cloud_outliers": {"knearest": 1},
    "create_sphere_points": {"pointnum": 1},
    "create_torus": {"hsubdiv": 1, "vsubdiv": 1},
    "generate_sampling_poisson_disk": {"bestsamplepool": 1, "radiusvariance": 0},
    "generate_sampling_volumetric": {"samplevolnum": 1},
    "generate_sampling_voronoi": {"samplenum": 1},
    "generate_simplified_point_cloud": {"samplenum": 0},
    "generate_surface_reconstruction_vcg": {"subdiv": 1},
    "generate_voronoi_atlas_parametrization": {"regionnum": 1},
    "generate_voronoi_scaffolding": {"samplevolnum": 1},
}
MOST = {  # each step more takes four or eight times the memory: beyond these no machine has enough
    "create_fractal_terrain": {"steps": 14},
    "create_sphere": {"subdiv": 13},
    "create_sphere_cap": {"subdiv": 13},
    "generate_surface_reconstruction_screened_poisson": {"depth": 20, "fulldepth": 12},
}


def check_limits(item: NativeFilter, values: Mapping[str, Any]) -> None:
    """Refuse values on which a filter crashes or never ends.

    Raises
    ------
    ParameterError
    """
    name = item.python_name
    for parameter in ABOVE_ZERO.get(name, ()):
        if parameter in values and not _number(values[parameter]) > 0.0:
            raise _refusal(item, parameter, "above 0", values[parameter])
    for parameter in NOT_ZERO.get(name, ()):
        if parameter in values and _number(values[parameter]) == 0.0:
            raise _refusal(item, parameter, "other than 0", values[parameter])
    for parameter, least in LEAST.get(name, {}).items():
        if parameter in values and _number(values[parameter]) < least:
            raise _refusal(item, parameter, f"at least {least}", values[parameter])
    for parameter, most in MOST.get(name, {}).items():
        if parameter in values and _number(values[parameter]) > most:
            raise _refusal(item, parameter, f"at most {most}", values[parameter])


def _number(value: Any) -> float:
    """Return a plain number, or the one inside of a length or a percentage."""
    return float(value.value() if hasattr(value, "value") else value)


def _refusal(item: NativeFilter, parameter: str, wanted: str, value: Any) -> ParameterError:
    message = (
        f"parameter '{parameter}' of '{item.menu_name}' must be {wanted}, or MeshLab may crash "
        f"or never end; got {_number(value):g}"
    )
    return ParameterError(message)
