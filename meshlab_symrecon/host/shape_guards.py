"""Shapes on which filters of pymeshlab 2025.7 crash or never end; looked for when a step runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from meshlab_symrecon.arrays import Faces
from meshlab_symrecon.errors import GeometryError
from meshlab_symrecon.host.meshset import current_identifier

if TYPE_CHECKING:
    from meshlab_symrecon.host.native_filters import NativeFilter

__all__ = ["FATAL_WITH_NAN", "check_shape"]

VIEWPOINT = "compute_selection_of_visible_convex_hull_per_vertex"
CURVATURE = "compute_curvature_principal_directions_per_vertex"
STATISTICS = "get_scalar_statistics_per_vertex"
ON_FLAT = "Scale Dependent Quadric Fitting"  # the curvature method that aborts on what is flat
MOVEMENT = "apply_coord_point_cloud_movement_over_mesh"
CRATERS = "apply_coord_craters_from_point_cloud"
NEAR = 0.1  # of the mesh's box diagonal, round its box: within, no crash was seen
FLAT = 1e-9  # of the largest extent; rounding of coordinates is far below, relief far above

FATAL_WITH_NAN = frozenset(
    {
        "compute_matrix_by_mesh_global_alignment",
        "compute_scalar_by_discrete_curvature_per_vertex",
        "compute_texcoord_parametrization_triangle_trivial_per_wedge",
        "generate_boolean_difference",
        "generate_boolean_intersection",
        "generate_boolean_union",
        "generate_boolean_xor",
        "generate_sampling_montecarlo",
        "generate_sampling_poisson_disk",
        "generate_sampling_volumetric",
        "generate_sampling_voronoi",
        "generate_simplified_point_cloud",
        "generate_surface_reconstruction_screened_poisson",
        "generate_voronoi_atlas_parametrization",
        "generate_voronoi_scaffolding",
        "get_overlapping_meshes_graph",
        "meshing_remove_t_vertices",
        "meshing_surface_subdivision_doo_sabin",
    }
)
WITHOUT_EXTENT = frozenset(
    {
        "compute_matrix_by_mesh_global_alignment",
        "generate_convex_hull",
        "generate_sampling_montecarlo",
        "generate_sampling_poisson_disk",
        "generate_sampling_volumetric",
        "generate_sampling_voronoi",
        "generate_voronoi_atlas_parametrization",
        "generate_voronoi_scaffolding",
        "get_overlapping_meshes_graph",
        VIEWPOINT,
    }
)
UNREFERENCED = frozenset(
    {
        "apply_texcoord_merge_per_wedge",
        "compute_texcoord_parametrization_least_squares_conformal_maps",
    }
)
NON_MANIFOLD = frozenset({"meshing_refine_by_function"})
OPEN = frozenset({"meshing_surface_subdivision_doo_sabin"})
VERTEX_TEXTURE = frozenset(
    {"meshing_surface_subdivision_doo_sabin", "meshing_tri_to_quad_by_4_8_subdivision"}
)


def check_shape(mesh_set: Any, item: NativeFilter, values: Mapping[str, Any]) -> None:
    """Refuse a filter that crashes or never ends on a layer of this shape.

    Raises
    ------
    GeometryError
    """
    name = item.python_name
    mesh = mesh_set.mesh(_layer_of_interest(mesh_set, name, values))
    for filters, is_bad, what in TRIALS:
        if name in filters and is_bad(mesh, values):
            message = f"'{item.menu_name}' would end the process: layer '{mesh.label()}' {what}"
            raise GeometryError(message)
    if name == MOVEMENT:
        _check_nearness(mesh_set, item, values)


def _check_nearness(mesh_set: Any, item: NativeFilter, values: Mapping[str, Any]) -> None:
    """Refuse to move points over a mesh that they are not near to."""
    roles = {**mesh_set.filter_parameter_values(MOVEMENT), **values}
    target, cloud = (mesh_set.mesh(int(roles[role])) for role in ("target_mesh", "point_cloud"))
    corners = target.vertex_matrix()
    if len(corners) == 0 or cloud.vertex_number() == 0:
        return
    low, high = corners.min(axis=0), corners.max(axis=0)
    margin = NEAR * np.linalg.norm(high - low)
    points = cloud.vertex_matrix()
    far = np.count_nonzero(((points < low - margin) | (points > high + margin)).any(axis=1))
    if far:
        message = (
            f"'{item.menu_name}' would end the process: {far} points of layer '{cloud.label()}' "
            f"are far from layer '{target.label()}'; move them onto it first"
        )
        raise GeometryError(message)


def _layer_of_interest(mesh_set: Any, name: str, values: Mapping[str, Any]) -> int:
    """Return the layer whose shape matters: for two filters it is one that they name."""
    if name in (MOVEMENT, CRATERS):
        parameter = "target_mesh"
        if parameter in values:
            return int(values[parameter])
        return int(mesh_set.filter_parameter_values(name)[parameter])
    return current_identifier(mesh_set)


def _has_no_extent(mesh: Any, values: Mapping[str, Any]) -> bool:
    points = mesh.vertex_matrix()
    if len(points) == 0 or not np.ptp(points, axis=0).any():
        return True
    faces = mesh.face_matrix()
    first, second, third = (points[faces[:, corner]] for corner in range(3))
    return len(faces) > 0 and not np.cross(second - first, third - first).any()


def _has_unreferenced(mesh: Any, values: Mapping[str, Any]) -> bool:
    return len(np.unique(mesh.face_matrix())) < mesh.vertex_number()


def _uses_of_edges(faces: Faces) -> Any:
    """Return how many faces each edge has."""
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    return np.unique(edges, axis=0, return_counts=True)[1]


def _has_non_manifold_edges(mesh: Any, values: Mapping[str, Any]) -> bool:
    return bool((_uses_of_edges(mesh.face_matrix()) > 2).any())


def _has_boundary(mesh: Any, values: Mapping[str, Any]) -> bool:
    return mesh.face_number() > 0 and bool((_uses_of_edges(mesh.face_matrix()) == 1).any())


def _has_vertex_texture(mesh: Any, values: Mapping[str, Any]) -> bool:
    return bool(mesh.has_vertex_tex_coord())


def _has_no_faces(mesh: Any, values: Mapping[str, Any]) -> bool:
    return mesh.face_number() == 0


def _has_a_point_at_the_eye(mesh: Any, values: Mapping[str, Any]) -> bool:
    if values.get("usecamera"):
        return False
    eye = np.asarray(values.get("viewpoint", (0.0, 0.0, 0.0)), dtype=np.float64)
    return bool((mesh.vertex_matrix() == eye).all(axis=1).any())


def _is_flat(mesh: Any, values: Mapping[str, Any]) -> bool:
    if values.get("method") != ON_FLAT or mesh.vertex_number() == 0:
        return False
    points = mesh.vertex_matrix()
    extents = np.sqrt(np.abs(np.linalg.eigvalsh(np.cov(points.T))))
    return bool(extents[0] <= FLAT * extents[-1])


def _has_no_finite_quality(mesh: Any, values: Mapping[str, Any]) -> bool:
    return mesh.has_vertex_scalar() and not np.isfinite(mesh.vertex_scalar_array()).all()


Test = Callable[[Any, Mapping[str, Any]], bool]
TRIALS: tuple[tuple[frozenset[str], Test, str], ...] = (
    (WITHOUT_EXTENT, _has_no_extent, "has no extent: all its points, or all of each face's, fall "
        "together; remove duplicates first"),
    (UNREFERENCED, _has_unreferenced, "has vertices without faces; remove unreferenced vertices "
        "first"),
    (NON_MANIFOLD, _has_non_manifold_edges, "has edges with more than two faces; repair "
        "non-manifold edges first"),
    (frozenset({CRATERS}), _has_no_faces, "has no faces; name a mesh as 'target_mesh'"),
    (frozenset({MOVEMENT}), _has_boundary, "has a boundary, over which points would move; close "
        "its holes first"),
    (OPEN, _has_boundary, "has a boundary; close its holes first"),
    (VERTEX_TEXTURE, _has_vertex_texture, "has texture coordinates of vertices; transfer them to "
        "wedges in another layer first"),
    (frozenset({VIEWPOINT}), _has_a_point_at_the_eye, "has a point at 'viewpoint'; move the "
        "viewpoint away"),
    (frozenset({STATISTICS}), _has_no_finite_quality, "has vertex quality that is NaN or "
        "infinite; clamp or compute it again first"),
    (frozenset({CURVATURE}), _is_flat, "is flat, on which this method fails; use another method"),
)  # fmt: skip
