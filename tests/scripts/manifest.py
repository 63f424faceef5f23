"""What every script of the corpus is run on, and what is to become of it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

FOLDER = Path(__file__).resolve().parent
RAN, MAPPED, SKIPPED = "ran", "mapped", "skipped"


@dataclass(frozen=True, slots=True)
class Case:
    """What is to become of a script.

    Attributes
    ----------
    document : str
        What it is run on; see ``documents``.
    steps : str
        Python names of the filters that its steps become, in order, all of which run.
    layers : tuple of (str, int or None, int or None)
        Label, vertices and faces of each layer at the end; None for what varies from run to run.
    current : int
        Position of the layer that is current at the end.
    mapped : mapping of int to tuple of str
        The steps that are reported as mapped, by their line, and their notes; all others just run.
    remarked : mapping of int to tuple of str
        The same of steps that run as they are written, with a remark.
    measures : mapping of int to mapping of str to value
        Some of what the step of a line returns.
    refused : mapping of int to str
        When not empty: the lines of which the script is refused, and words of the reasons.
    untouched : bool
        Whether it is refused before anything runs.
    lenient : str
        What a lenient run makes of a refused script: the status of each step.
    """

    document: str
    steps: str = ""
    layers: tuple[tuple[str, int | None, int | None], ...] = ()
    current: int = -1
    mapped: Mapping[int, tuple[str, ...]] = field(default_factory=dict)
    remarked: Mapping[int, tuple[str, ...]] = field(default_factory=dict)
    measures: Mapping[int, Mapping[str, Any]] = field(default_factory=dict)
    refused: Mapping[int, str] = field(default_factory=dict)
    untouched: bool = True
    lenient: str = ""


def near(value: float, tolerance: float) -> Any:
    """Return what equals a number that is only known for the smooth shape."""
    return pytest.approx(value, abs=tolerance)


BALL = 4.15274081709307  # volume of the polyhedron of 1280 faces that stands for the unit sphere
CUBE = 1.2**3
LENS = 1.2436630169187513  # volume of what the two have in common, as MeshLab measures it
CLOSED = {"boundary_edges": 0, "genus": 0, "is_mesh_two_manifold": True}

RUNS = {
    "alpha_wrap": Case(
        "ball",
        "generate_alpha_wrap get_topological_measures",
        layers=(("Sphere", 642, 1280), ("Alpha wrap", 87, 170)),
        measures={7: CLOSED},
    ),
    "bake_between_layers": Case(
        "ball",
        "generate_copy_of_current_mesh meshing_decimation_quadric_edge_collapse "
        "compute_texcoord_parametrization_triangle_trivial_per_wedge "
        "transfer_attributes_to_texture_per_vertex",
        layers=(("Sphere", 642, 1280), ("Sphere_copy", 162, 320)),
    ),
    "bake_colours": Case(
        "ball",
        "compute_texcoord_parametrization_triangle_trivial_per_wedge compute_texmap_from_color",
        layers=(("Sphere", 642, 1280),),
    ),
    "bake_colours_2016": Case(
        "ball",
        "compute_texcoord_parametrization_triangle_trivial_per_wedge compute_texmap_from_color",
        layers=(("Sphere", 642, 1280),),
        mapped={
            9: (
                "is 'Transfer: Vertex Color to Texture' today",
                "line 14: parameter 'assign' ignored",
            )
        },
    ),
    "ball_pivoting": Case(
        "cloud",
        "generate_surface_reconstruction_ball_pivoting meshing_close_holes "
        "get_topological_measures",
        layers=(("cloud", 800, 1366),),
        measures={9: {"closed_holes": 7, "new_faces": 12}},
    ),
    "blanks_and_cases": Case(
        "ball",
        "meshing_remove_duplicate_vertices apply_coord_taubin_smoothing",
        layers=(("Sphere", 642, 1280),),
    ),
    "boolean_all": Case(
        "two_solids",
        "generate_boolean_union get_geometric_measures generate_boolean_intersection "
        "get_geometric_measures generate_boolean_difference generate_boolean_xor",
        layers=(
            ("Sphere", 642, 1280),
            ("Box/Cube", 8, 12),
            ("union", 657, 1310),
            ("intersection", 177, 350),
            ("difference", 657, 1310),
            ("xor", 742, 1660),
        ),
        measures={7: {"mesh_volume": BALL + CUBE - LENS}, 12: {"mesh_volume": LENS}},
    ),
    "byte_order_mark": Case(
        "ball",
        "set_mesh_name apply_coord_laplacian_smoothing",
        layers=(("Büste aus Köln", 642, 1280),),
    ),
    "center_2013": Case(
        "ball",
        "compute_matrix_from_translation",
        layers=(("Sphere", 642, 1280),),
        mapped={
            3: (
                "is 'Transform: Translate, Center, set Origin' today",
                "is 'Center on Layer BBox' of 'traslmethod' today",
            )
        },
    ),
    "center_and_unit": Case(
        "two_solids",
        "compute_matrix_from_translation compute_matrix_from_scaling_or_normalization "
        "apply_matrix_freeze",
        layers=(("Sphere", 642, 1280), ("Box/Cube", 8, 12)),
    ),
    "clean_by_diameter": Case(
        "dirty",
        "meshing_remove_connected_component_by_diameter meshing_merge_close_vertices "
        "meshing_repair_non_manifold_edges meshing_repair_non_manifold_vertices "
        "meshing_remove_t_vertices meshing_remove_folded_faces",
        layers=(("scan", 647, 1276),),
    ),
    "clean_scan": Case(
        "dirty",
        "meshing_remove_duplicate_vertices meshing_remove_duplicate_faces "
        "meshing_remove_null_faces meshing_repair_non_manifold_edges "
        "meshing_remove_connected_component_by_face_number "
        "meshing_remove_unreferenced_vertices",
        layers=(("scan", 643, 1278),),
    ),
    "clean_scan_2014": Case(
        "dirty",
        "meshing_remove_duplicate_vertices meshing_repair_non_manifold_edges "
        "meshing_remove_null_faces meshing_remove_unreferenced_vertices no operation no "
        "operation",
        layers=(("scan", 647, 1280),),
        mapped={
            3: ("is 'Remove Duplicate Vertices' today",),
            4: (
                "is 'Repair non Manifold Edges' today",
                "'method' set to 'Remove Faces', which the old name stood for",
            ),
            6: ("is 'Remove Unreferenced Vertices' today",),
            7: ("MeshLab does this by itself today",),
            8: ("MeshLab does this by itself today",),
        },
    ),
    "cloud_outliers": Case(
        "cloud",
        "compute_selection_point_cloud_outliers meshing_remove_selected_vertices "
        "compute_custom_radius_scalar_attribute_per_vertex",
        layers=(("cloud", 795, 0),),
    ),
    "colour_components": Case(
        "dirty",
        "compute_color_by_conntected_component_per_face compute_color_scattering_per_mesh"
        " compute_color_transfer_mesh_to_face",
        layers=(("scan", 650, 1285),),
    ),
    "colour_filling": Case(
        "ball",
        "set_color_per_vertex compute_selection_by_condition_per_vertex "
        "compute_color_perlin_noise_per_vertex",
        layers=(("Sphere", 642, 1280),),
    ),
    "colour_functions": Case(
        "ball",
        "set_color_per_vertex compute_color_by_function_per_vertex "
        "compute_color_by_function_per_face",
        layers=(("Sphere", 642, 1280),),
        mapped={4: ("'y' is '((y > 0) ? (255) : (40))' today",)},
    ),
    "colour_grading": Case(
        "ball",
        "apply_color_brightness_contrast_gamma_per_vertex "
        "apply_color_level_adjustment_per_vertex apply_color_white_balance_per_vertex "
        "apply_color_intensity_colourisation_per_vertex "
        "apply_color_desaturation_per_vertex apply_color_inverse_per_vertex "
        "apply_color_equalization_per_vertex apply_color_laplacian_smoothing_per_vertex",
        layers=(("Sphere", 642, 1280),),
    ),
    "colour_two_tone": Case(
        "ball",
        "apply_color_thresholding_per_vertex compute_color_transfer_vertex_to_face "
        "apply_color_laplacian_smoothing_per_face compute_color_transfer_face_to_vertex",
        layers=(("Sphere", 642, 1280),),
    ),
    "compare_scans": Case(
        "two_solids",
        "get_hausdorff_distance compute_scalar_by_distance_from_another_mesh_per_vertex "
        "set_current_mesh get_scalar_statistics_per_vertex",
        layers=(("Sphere", 642, 1280), ("Box/Cube", 8, 12)),
        current=0,
        remarked={20: ("the current layer changes, by position",)},
        measures={3: {"max": 1.0, "n_samples": 642}, 23: {"max": 1.0}},
    ),
    "crease_lines": Case(
        "two_solids",
        "compute_selection_crease_per_edge generate_polyline_from_selected_edges",
        layers=(("Sphere", 642, 1280), ("Box/Cube", 8, 12), ("EdgeMesh", 8, 0)),
    ),
    "curvature_map": Case(
        "ball",
        "compute_scalar_by_discrete_curvature_per_vertex "
        "apply_scalar_smoothing_per_vertex apply_scalar_clamping_per_vertex "
        "get_scalar_statistics_per_vertex get_scalar_histogram_per_vertex "
        "compute_color_from_scalar_per_vertex",
        layers=(("Sphere", 642, 1280),),
        measures={13: {"avg": near(1.0, 1e-3)}},
    ),
    "custom_attributes": Case(
        "ball",
        "compute_new_custom_scalar_attribute_per_vertex "
        "compute_new_custom_scalar_attribute_per_face "
        "compute_scalar_by_function_per_vertex",
        layers=(("Sphere", 642, 1280),),
    ),
    "cut_by_condition": Case(
        "ball",
        "compute_selection_by_condition_per_vertex meshing_remove_selected_vertices "
        "compute_selection_by_condition_per_face apply_selection_inverse",
        layers=(("Sphere", 564, 1089),),
    ),
    "dae_for_game": Case(
        "ball",
        "meshing_remove_duplicate_faces compute_scalar_ambient_occlusion "
        "compute_color_from_scalar_per_vertex "
        "compute_texcoord_parametrization_triangle_trivial_per_wedge "
        "compute_texmap_from_color",
        layers=(("Sphere", 642, 1280),),
    ),
    "decimate_2012": Case(
        "ball",
        "meshing_decimation_quadric_edge_collapse",
        layers=(("Sphere", 252, 500),),
        mapped={3: ("is 'Simplification: Quadric Edge Collapse Decimation' today",)},
    ),
    "decimate_clustering": Case(
        "ball",
        "meshing_decimation_clustering apply_coord_laplacian_smoothing",
        layers=(("Sphere", 306, 608),),
    ),
    "decimate_keeping_texture": Case(
        "textured",
        "meshing_decimation_quadric_edge_collapse_with_texture",
        layers=(("textured.obj", 302, 600),),
    ),
    "deviation_in_colours": Case(
        "statue",
        "compute_normal_for_point_clouds generate_reflection_planes "
        "compute_scalar_by_mirror_symmetry_per_vertex "
        "compute_color_from_scalar_per_vertex",
        layers=(("statue", 1342, 0), ("reflection planes", 4, 2)),
        current=0,
        measures={4: {"converged": True}, 7: {"signed": True}},
    ),
    "distance_from_border": Case(
        "sheet",
        "compute_scalar_by_border_distance_per_vertex "
        "compute_selection_by_scalar_per_vertex apply_scalar_smoothing_per_vertex",
        layers=(("Grid Generator", 143, 234),),
    ),
    "enum_by_word": Case(
        "ball",
        "meshing_repair_non_manifold_edges "
        "compute_scalar_by_discrete_curvature_per_vertex get_scalar_statistics_per_vertex",
        layers=(("Sphere", 642, 1280),),
        measures={9: {"avg": near(1.0, 0.01)}},
    ),
    "face_quality": Case(
        "ball",
        "compute_scalar_by_aspect_ratio_per_face get_scalar_statistics_per_face "
        "get_scalar_histogram_per_face compute_selection_by_scalar_per_face "
        "compute_color_from_scalar_per_face compute_scalar_transfer_face_to_vertex "
        "compute_scalar_transfer_vertex_to_face",
        layers=(("Sphere", 642, 1280),),
        measures={6: {"max": 3**0.5 / 2}},
    ),
    "flat_parametrization": Case(
        "sheet",
        "compute_texcoord_parametrization_flat_plane_per_wedge "
        "compute_texcoord_by_function_per_wedge set_texture_per_mesh",
        layers=(("Grid Generator", 143, 234),),
    ),
    "flatten_layers": Case(
        "two_solids",
        "generate_by_merging_visible_meshes generate_splitting_by_connected_components",
        layers=(("Merged Mesh", 650, 1292), ("CC 0", 642, 1280), ("CC 1", 8, 12)),
    ),
    "flip_and_swap": Case(
        "ball",
        "apply_matrix_flip_or_swap_axis compute_matrix_from_translation_rotation_scale",
        layers=(("Sphere", 642, 1280),),
        mapped={3: ("line 11: parameter 'ToAll' is 'alllayers' today",)},
    ),
    "fractal_relief": Case(
        "ball", "apply_coord_fractal_displacement", layers=(("Sphere", 642, 1280),)
    ),
    "geodesic_from_point": Case(
        "ball",
        "compute_scalar_by_geodesic_distance_from_given_point_per_vertex "
        "get_scalar_statistics_per_vertex",
        layers=(("Sphere", 642, 1280),),
        measures={7: {"min": 0.0, "max": near(math.pi, 0.1)}},
    ),
    "geodesic_from_selection": Case(
        "ball",
        "compute_selection_by_condition_per_vertex "
        "compute_scalar_by_geodesic_distance_from_selection_per_vertex "
        "apply_scalar_saturation_per_vertex",
        layers=(("Sphere", 642, 1280),),
    ),
    "geometry_function": Case(
        "ball",
        "compute_coord_by_function compute_normal_per_face "
        "apply_normal_normalization_per_face apply_normal_smoothing_per_face "
        "compute_normal_per_vertex apply_normal_normalization_per_vertex",
        layers=(("Sphere", 642, 1280),),
        mapped={3: ("is 'Per Vertex Geometric Function' today",)},
    ),
    "harmonic_field": Case(
        "ball",
        "compute_scalar_by_scalar_harmonic_field_per_vertex",
        layers=(("Sphere", 642, 1280),),
    ),
    "hulls": Case(
        "cloud",
        "generate_convex_hull get_geometric_measures set_current_mesh generate_alpha_shape",
        layers=(("cloud", 800, 0), ("Convex Hull", 800, 1596), ("Alpha Shapes", 800, 2097)),
        remarked={5: ("the current layer changes, by position",)},
        measures={4: {"mesh_volume": near(8 * math.pi, 0.5)}},
    ),
    "implicit_solid": Case(
        "nothing",
        "create_implicit_surface create_sphere_points",
        layers=(("Implicit Surface", 291, 572), ("Points on a Sphere", 64, 0)),
    ),
    "latin1": Case(
        "ball",
        "set_mesh_name apply_coord_laplacian_smoothing",
        layers=(("Büste aus Köln", 642, 1280),),
    ),
    "layers_by_position": Case(
        "two_solids",
        "set_current_mesh delete_current_mesh generate_copy_of_current_mesh "
        "set_current_mesh set_mesh_name",
        layers=(("the one that stayed", 8, 12), ("Box/Cube_copy", 8, 12)),
        current=0,
        remarked={
            3: ("the current layer changes, by position",),
            9: ("the current layer changes, by position",),
        },
    ),
    "leading_blank_lines": Case(
        "ball",
        "set_mesh_name apply_coord_laplacian_smoothing",
        layers=(("Büste aus Köln", 642, 1280),),
    ),
    "lod_chain": Case(
        "ball",
        "generate_copy_of_current_mesh set_mesh_name "
        "meshing_decimation_quadric_edge_collapse generate_copy_of_current_mesh "
        "set_mesh_name meshing_decimation_quadric_edge_collapse",
        layers=(("Sphere", 642, 1280), ("lod1", 322, 640), ("lod2", 82, 160)),
    ),
    "marching_cubes_apss": Case(
        "cloud",
        "compute_normal_for_point_clouds generate_marching_cubes_apss "
        "compute_selection_by_small_disconnected_components_per_face "
        "meshing_remove_selected_vertices_and_faces",
        layers=(("cloud", 800, 0), ("mc_mesh", 2144, 4284)),
    ),
    "measures_xmlfilter": Case(
        "ball",
        "get_geometric_measures get_topological_measures",
        layers=(("Sphere", 642, 1280),),
        measures={3: {"mesh_volume": BALL}, 4: CLOSED},
    ),
    "missing_parameters": Case(
        "ball",
        "apply_coord_laplacian_smoothing meshing_isotropic_explicit_remeshing",
        layers=(("Sphere", 2562, 5120),),
    ),
    "morph": Case(
        "two_scans",
        "set_current_mesh compute_coord_linear_morphing",
        layers=(("Sphere", 2562, 5120), ("Sphere_copy", 2562, 5120)),
        current=0,
        remarked={3: ("the current layer changes, by position",)},
    ),
    "move_to_origin_2013": Case(
        "ball",
        "compute_matrix_from_translation",
        layers=(("Sphere", 642, 1280),),
        mapped={
            3: (
                "is 'Transform: Translate, Center, set Origin' today",
                "line 7: parameter 'centerFlag' ignored: 'false' says nothing today",
                "line 9: parameter 'ToAll' is 'alllayers' today",
            )
        },
    ),
    "no_doctype_with_comments": Case("ball", "set_selection_all", layers=(("Sphere", 642, 1280),)),
    "normals_for_cloud": Case(
        "cloud",
        "compute_normal_for_point_clouds apply_normal_point_cloud_smoothing "
        "apply_normal_normalization_per_vertex",
        layers=(("cloud", 800, 0),),
    ),
    "normals_function": Case(
        "ball",
        "compute_normal_by_function_per_vertex compute_normal_by_function_per_face",
        layers=(("Sphere", 642, 1280),),
    ),
    "nothing_to_do": Case("ball", "", layers=(("Sphere", 642, 1280),)),
    "paint_by_points": Case(
        "ball_and_points",
        "compute_color_by_point_cloud_voronoi_projection "
        "compute_scalar_by_distance_from_point_cloud_per_vertex",
        layers=(("Sphere", 642, 1280), ("marks", 8, 0)),
    ),
    "percentages": Case(
        "ball",
        "meshing_merge_close_vertices meshing_decimation_clustering",
        layers=(("Sphere", 426, 848),),
    ),
    "photogrammetry": Case(
        "cloud",
        "compute_selection_point_cloud_outliers meshing_remove_selected_vertices "
        "compute_normal_for_point_clouds generate_surface_reconstruction_screened_poisson"
        " transfer_attributes_per_vertex set_current_mesh "
        "meshing_decimation_quadric_edge_collapse",
        layers=(("cloud", 795, 0), ("Poisson mesh", 502, 1000)),
        mapped={
            9: (
                "is 'Surface Reconstruction: Screened Poisson' today",
                "the layer that it makes becomes current",
            ),
            21: ("is 'Simplification: Quadric Edge Collapse Decimation' today",),
        },
        remarked={18: ("the current layer changes, by position",)},
    ),
    "poisson_2009": Case(
        "cloud",
        "compute_normal_for_point_clouds generate_surface_reconstruction_screened_poisson",
        layers=(("cloud", 800, 0), ("Poisson mesh", None, None)),
        mapped={
            6: (
                "is 'Surface Reconstruction: Screened Poisson' today",
                "line 7: parameter 'OctDepth' is 'depth' today",
                "line 8: parameter 'SolverDivide' ignored",
                "line 10: parameter 'Offset' ignored",
            )
        },
    ),
    "poisson_from_cloud": Case(
        "cloud",
        "compute_normal_for_point_clouds generate_surface_reconstruction_screened_poisson",
        layers=(("cloud", 800, 0), ("Poisson mesh", 1620, 3236)),
    ),
    "poisson_xmlfilter": Case(
        "cloud",
        "compute_normal_for_point_clouds generate_surface_reconstruction_screened_poisson",
        layers=(("cloud", 800, 0), ("Poisson mesh", None, None)),
        mapped={
            6: (
                "is 'Surface Reconstruction: Screened Poisson' today",
                "the layer that it makes becomes current",
            )
        },
    ),
    "primitives": Case(
        "nothing",
        "create_sphere create_cube create_torus create_cone create_grid create_annulus "
        "create_tetrahedron create_octahedron create_icosahedron create_dodecahedron "
        "create_sphere_cap",
        layers=(
            ("Sphere", 642, 1280),
            ("Box/Cube", 8, 12),
            ("Torus", 288, 576),
            ("Cone", 38, 72),
            ("Grid Generator", 20, 24),
            ("Annulus", 64, 64),
            ("Tetrahedron", 4, 4),
            ("Octahedron", 6, 8),
            ("Icosahedron", 12, 20),
            ("Dodecahedron", 20, 36),
            ("Sphere Cap", 217, 384),
        ),
    ),
    "principal_curvature": Case(
        "ball", "compute_curvature_principal_directions_per_vertex", layers=(("Sphere", 642, 1280),)
    ),
    "print_preparation": Case(
        "dirty",
        "meshing_merge_close_vertices meshing_remove_duplicate_faces "
        "meshing_remove_null_faces meshing_remove_connected_component_by_face_number "
        "meshing_repair_non_manifold_edges meshing_close_holes "
        "meshing_re_orient_faces_coherently compute_matrix_from_scaling_or_normalization "
        "get_geometric_measures get_topological_measures",
        layers=(("scan", 643, 1282),),
        measures={
            9: {"closed_holes": 2},
            22: {"mesh_volume": near(BALL * 25.4**3, 50.0)},
            23: CLOSED,
        },
    ),
    "pymeshlab_2021_names": Case(
        "ball",
        "meshing_remove_duplicate_vertices meshing_decimation_quadric_edge_collapse "
        "apply_coord_laplacian_smoothing get_geometric_measures",
        layers=(("Sphere", 202, 400),),
        mapped={
            3: ("is 'Remove Duplicate Vertices' today",),
            4: ("is 'Simplification: Quadric Edge Collapse Decimation' today",),
            7: ("is 'Laplacian Smooth' today",),
            10: ("is 'Compute Geometric Measures' today",),
        },
    ),
    "python_names": Case(
        "ball",
        "meshing_merge_close_vertices apply_coord_taubin_smoothing get_topological_measures",
        layers=(("Sphere", 642, 1280),),
        measures={9: CLOSED},
    ),
    "quads_and_back": Case(
        "ball",
        "meshing_tri_to_quad_dominant compute_normal_polygon_mesh_per_face meshing_poly_to_tri",
        layers=(("Sphere", 642, 1280),),
    ),
    "quality_unsharp": Case(
        "ball",
        "compute_scalar_by_function_per_vertex apply_scalar_unsharp_mask_per_vertex "
        "compute_color_from_scalar_using_transfer_function_per_vertex",
        layers=(("Sphere", 642, 1280),),
    ),
    "refine_where": Case(
        "ball",
        "meshing_refine_by_function meshing_cut_along_crease_edges meshing_snap_mismatched_borders",
        layers=(("Sphere", 1094, 2184),),
    ),
    "registration_icp": Case(
        "two_scans",
        "compute_matrix_by_icp_between_meshes apply_matrix_freeze "
        "generate_by_merging_visible_meshes",
        # ICP samples at random, and where its copies meet exactly their vertices become one.
        layers=(("Sphere", 2562, 5120), ("Sphere_copy", 2562, 5120), ("Merged Mesh", None, None)),
    ),
    "remesh_isotropic": Case(
        "ball",
        "meshing_isotropic_explicit_remeshing meshing_edge_flip_by_planar_optimization",
        layers=(("Sphere", 348, 692),),
    ),
    "reorient": Case(
        "ball",
        "meshing_invert_face_orientation get_geometric_measures "
        "meshing_re_orient_faces_coherently meshing_invert_face_orientation "
        "get_geometric_measures",
        layers=(("Sphere", 642, 1280),),
        measures={7: {"mesh_volume": -BALL}, 12: {"mesh_volume": BALL}},
    ),
    "resample_volume": Case(
        "ball",
        "generate_resampled_uniform_mesh meshing_decimation_edge_collapse_for_marching_cube_meshes",
        layers=(("Sphere", 642, 1280), ("Offset mesh", 720, 1436)),
    ),
    "sample_many_ways": Case(
        "ball",
        "generate_sampling_element set_current_mesh generate_sampling_montecarlo "
        "set_current_mesh generate_sampling_stratified_triangle",
        layers=(
            ("Sphere", 642, 1280),
            ("Element samples", 150, 0),
            ("Montecarlo Samples", 300, 0),
            ("Subdiv Samples", 2000, 0),
        ),
        remarked={
            7: ("the current layer changes, by position",),
            15: ("the current layer changes, by position",),
        },
    ),
    "sample_poisson_disk": Case(
        "ball",
        "generate_sampling_poisson_disk",
        layers=(("Sphere", 642, 1280), ("Poisson-disk Samples", None, None)),
    ),
    "sample_regular": Case(
        "ball",
        "generate_sampling_clustered_vertex set_current_mesh generate_sampling_regular_recursive",
        layers=(("Sphere", 642, 1280), ("Cluster samples", 152, 0), ("Recursive Samples", 520, 0)),
        remarked={8: ("the current layer changes, by position",)},
    ),
    "scale_2013": Case(
        "two_solids",
        "compute_matrix_from_scaling_or_normalization",
        layers=(("Sphere", 642, 1280), ("Box/Cube", 8, 12)),
        mapped={
            3: (
                "is 'Transform: Scale, Normalize' today",
                "line 12: parameter 'ToAll' is 'alllayers' today",
            )
        },
    ),
    "scanner_turntable": Case(
        "cloud",
        "compute_selection_by_condition_per_vertex meshing_remove_selected_vertices "
        "compute_matrix_from_rotation generate_simplified_points "
        "compute_normal_for_point_clouds generate_surface_reconstruction_power_crust",
        layers=(("cloud", 788, 0), ("simplified points", 394, 0), ("power crust", 788, 1572)),
        measures={12: {"points": 394}, 16: {"closed": True, "genus": 0}},
    ),
    "select_border_and_trim": Case(
        "sheet",
        "compute_selection_from_mesh_border apply_selection_dilatation "
        "apply_selection_dilatation apply_selection_erosion "
        "compute_selection_transfer_vertex_to_face meshing_remove_selected_faces "
        "meshing_remove_unreferenced_vertices",
        layers=(("Grid Generator", 6, 2),),
    ),
    "select_by_colour": Case(
        "ball",
        "compute_color_transfer_vertex_to_face compute_selection_by_color_per_face "
        "apply_selection_by_same_connected_component "
        "compute_selection_transfer_face_to_vertex",
        layers=(("Sphere", 642, 1280),),
    ),
    "select_by_quality": Case(
        "ball",
        "compute_scalar_by_function_per_vertex compute_selection_by_scalar_per_vertex "
        "generate_from_selected_faces set_mesh_name",
        layers=(("Sphere", 604, 1172), ("poles of the ball", 74, 108)),
    ),
    "select_crease_2012": Case(
        "two_solids",
        "compute_selection_crease_per_edge",
        layers=(("Sphere", 642, 1280), ("Box/Cube", 8, 12)),
        mapped={3: ("is 'Select Crease Edges' today",)},
    ),
    "select_facing_up": Case(
        "ball",
        "compute_selection_by_angle_with_direction_per_face "
        "get_area_and_perimeter_of_selection generate_polyline_from_selection_perimeter",
        layers=(("Sphere", 642, 1280), ("_perimeter", 46, 0)),
        measures={8: {"seleced_triangles_number": 750, "border_edge_number": 46}},
    ),
    "select_problems": Case(
        "dirty",
        "compute_selection_by_self_intersections_per_face meshing_remove_selected_faces "
        "compute_selection_by_non_manifold_edges_per_face "
        "compute_selection_by_non_manifold_per_vertex compute_selection_bad_faces "
        "compute_selection_by_edge_length set_selection_none",
        layers=(("scan", 650, 1283),),
    ),
    "select_small_parts": Case(
        "dirty",
        "compute_selection_by_small_disconnected_components_per_face "
        "meshing_remove_selected_vertices_and_faces",
        layers=(("scan", 646, 1280),),
    ),
    "set_matrix": Case(
        "ball",
        "set_matrix apply_matrix_inverse generate_copy_of_current_mesh set_matrix_identity",
        layers=(("Sphere", 642, 1280), ("Sphere_copy", 642, 1280)),
    ),
    "sharpen": Case(
        "ball",
        "apply_coord_unsharp_mask apply_normal_unsharp_mask_per_vertex "
        "apply_color_unsharp_mask_per_vertex",
        layers=(("Sphere", 642, 1280),),
    ),
    "sheet_repair": Case(
        "sheet",
        "meshing_close_holes get_area_and_perimeter_of_selection "
        "meshing_surface_subdivision_ls3_loop meshing_edge_flip_by_curvature_optimization",
        layers=(("Grid Generator", 148, 250),),
        measures={3: {"closed_holes": 1, "new_faces": 6}, 8: {"border_edge_number": 8}},
    ),
    "single_line": Case(
        "ball",
        "set_mesh_name apply_coord_laplacian_smoothing",
        layers=(("Büste aus Köln", 642, 1280),),
    ),
    "slice": Case(
        "ball",
        "generate_polyline_from_planar_section",
        layers=(("Sphere", 642, 1280), ("_sect_Z_0.25", 90, 0), ("_sect_Z_0.25_filled", 90, 88)),
    ),
    "slice_2015": Case(
        "ball",
        "generate_polyline_from_planar_section",
        layers=(("Sphere", 642, 1280), ("_sect_custom_0.1", 88, 0)),
    ),
    "smooth_all_ways": Case(
        "ball",
        "apply_coord_laplacian_smoothing apply_coord_taubin_smoothing "
        "apply_coord_hc_laplacian_smoothing "
        "apply_coord_laplacian_smoothing_scale_dependent apply_coord_two_steps_smoothing "
        "apply_coord_laplacian_smoothing_surface_preserving",
        layers=(("Sphere", 642, 1280),),
    ),
    "smooth_depth": Case(
        "ball",
        "apply_coord_random_displacement apply_coord_depth_smoothing",
        layers=(("Sphere", 642, 1280),),
    ),
    "stand_upright": Case(
        "ball",
        "compute_matrix_by_principal_axis compute_selection_by_condition_per_vertex "
        "compute_matrix_by_fitting_to_plane",
        layers=(("Sphere", 642, 1280),),
    ),
    "statue_by_alias": Case(
        "statue",
        "generate_simplified_points generate_surface_reconstruction_power_crust "
        "get_geometric_measures",
        layers=(("statue", 1342, 0), ("simplified points", 300, 0), ("power crust", 300, 596)),
        measures={3: {"points": 300}, 6: {"closed": True, "genus": 0, "vertices": 300}},
    ),
    "statue_from_scan": Case(
        "statue",
        "compute_normal_for_point_clouds generate_reflection_planes "
        "generate_mirror_completed_points generate_surface_reconstruction_power_crust "
        "apply_coord_laplacian_smoothing get_topological_measures",
        layers=(
            ("statue", 1342, 0),
            ("reflection planes", 4, 2),
            ("completed points", 1488, 0),
            ("power crust", 3491, 6978),
        ),
        measures={5: {"measured": 1342}, 8: {"closed": True, "genus": 0}, 14: CLOSED},
    ),
    "subdivide_all": Case(
        "ball",
        "meshing_surface_subdivision_midpoint meshing_surface_subdivision_loop "
        "meshing_surface_subdivision_butterfly",
        layers=(("Sphere", 40962, 81920),),
    ),
    "subdivide_polygons": Case(
        "nothing",
        "create_cube meshing_surface_subdivision_catmull_clark meshing_poly_to_tri "
        "compute_normal_per_vertex",
        layers=(("Box/Cube", 98, 192),),
    ),
    "texture_to_another_2016": Case(
        "textured_and_plain",
        "transfer_texture_to_color_per_vertex",
        layers=(("textured.obj", 642, 1280), ("Sphere", 642, 1280)),
        mapped={3: ("is 'Transfer: Texture to Vertex Color (1 or 2 meshes)' today",)},
    ),
    "texture_to_colours": Case(
        "textured",
        "compute_color_from_texture_per_vertex compute_texcoord_transfer_wedge_to_vertex "
        "compute_texcoord_transfer_vertex_to_wedge",
        layers=(("textured.obj", 3840, 1280),),
    ),
    "thickness": Case(
        "ball",
        "compute_scalar_by_shape_diameter_function_per_vertex get_scalar_statistics_per_vertex",
        layers=(("Sphere", 642, 1280),),
    ),
    "thin_cloud": Case(
        "cloud",
        "generate_simplified_point_cloud set_mesh_name",
        layers=(("cloud", 800, 0), ("thin cloud", 141, 0)),
    ),
    "transfer_colours": Case(
        "two_solids",
        "transfer_attributes_per_vertex",
        layers=(("Sphere", 642, 1280), ("Box/Cube", 8, 12)),
    ),
    "turn_about_axis": Case(
        "ball", "compute_matrix_from_rotation", layers=(("Sphere", 642, 1280),)
    ),
    "untyped": Case(
        "ball",
        "apply_coord_laplacian_smoothing set_color_per_vertex",
        layers=(("Sphere", 642, 1280),),
    ),
    "unwrap_sheet": Case(
        "sheet",
        "compute_texcoord_parametrization_harmonic "
        "compute_texcoord_transfer_vertex_to_wedge apply_texcoord_merge_per_wedge "
        "compute_selection_by_texture_seams_per_vertex",
        layers=(("Grid Generator", 143, 234),),
    ),
    "utf16": Case(
        "ball",
        "set_mesh_name apply_coord_laplacian_smoothing",
        layers=(("Büste aus Köln", 642, 1280),),
    ),
    "vcg_merge": Case(
        "ball",
        "generate_surface_reconstruction_vcg",
        layers=(("Sphere", 642, 1280), ("plymcout.ply", 2622, 5240)),
    ),
    "voronoi_atlas": Case(
        "ball",
        "generate_voronoi_atlas_parametrization",
        layers=(("Sphere", 642, 1280), ("VoroAtlas", 642, 1280)),
        current=0,
    ),
    "voronoi_cells": Case(
        "ball",
        "generate_sampling_voronoi",
        layers=(("Sphere", 642, 1280), ("voro", 32, 60), ("poly", 72, 0)),
        current=0,
    ),
    "whole_numbers_as_fractions": Case(
        "ball",
        "meshing_decimation_quadric_edge_collapse apply_coord_laplacian_smoothing",
        layers=(("Sphere", 202, 400),),
    ),
    "windows_line_ends": Case(
        "ball",
        "set_mesh_name apply_coord_laplacian_smoothing",
        layers=(("Büste aus Köln", 642, 1280),),
    ),
    "wireframe": Case(
        "nothing",
        "create_icosahedron generate_solid_wireframe",
        layers=(("Icosahedron", 12, 20), ("Shell Mesh", 2724, 5280)),
        current=0,
    ),
    "boolean_2009": Case(
        "two_solids",
        "generate_boolean_intersection",
        layers=(("Sphere", 642, 1280), ("Box/Cube", 8, 12), ("intersection", 177, 350)),
        mapped={
            3: (
                "'CSG Operation' is 'Mesh Boolean: Intersection' today",
                "line 4: parameter 'FirstMesh' is 'first_mesh' today",
                "line 5: parameter 'SecondMesh' is 'second_mesh' today",
                "line 6: parameter 'Delta' ignored",
                "line 7: parameter 'SubDelta' ignored",
                "line 8: parameter 'Operator' ignored",
            )
        },
    ),
    "quality_mapper_2011": Case(
        "ball",
        "compute_scalar_by_function_per_vertex "
        "compute_color_from_scalar_using_transfer_function_per_vertex",
        layers=(("Sphere", 642, 1280),),
    ),
    "select_and_detect": Case(
        "statue",
        "compute_normal_for_point_clouds compute_selection_by_condition_per_vertex "
        "generate_reflection_planes set_selection_none generate_mirror_completed_points "
        "set_mesh_name",
        layers=(("statue", 1342, 0), ("reflection planes", 4, 2), ("whole statue", 1578, 0)),
        measures={13: {"measured": 1342}},
    ),
    "set_camera": Case(
        "ball",
        "set_camera_per_mesh apply_selection_inverse",
        layers=(("Sphere", 642, 1280),),
        mapped={3: ("line 4: parameter 'Shot' ignored",)},
    ),
    "two_scans_to_solid": Case(
        "two_scans",
        "apply_matrix_freeze "
        "generate_by_merging_visible_meshes generate_simplified_points "
        "generate_surface_reconstruction_power_crust get_topological_measures",
        layers=(
            ("Merged Mesh", None, None),  # as above
            ("simplified points", 500, 0),
            ("power crust", None, None),
        ),
        mapped={8: ("is 'Matrix: Freeze Current Matrix' today",)},
        measures={12: {"points": 500}, 15: {"closed": True}, 16: {"boundary_edges": 0}},
    ),
}

REFUSALS = {
    "select_faces_by_range_2010": Case(
        "ball", refused={4: "is gone from MeshLab"}, lenient="ran skipped"
    ),
    "cloud_cleaned_away": Case(
        "cloud", refused={7: "would delete all the"}, lenient="ran ran skipped ran"
    ),
    "cloud_pieces_removed": Case(
        "cloud", refused={6: "would delete all the"}, lenient="ran skipped ran"
    ),
    "filter_of_no_version": Case(
        "ball", refused={3: "no filter is called 'Polish the statue with wax'"}, lenient="skipped"
    ),
    "gpu_ambient_occlusion": Case(
        "ball", refused={4: "'Ambient Occlusion' draws with OpenGL"}, lenient="ran skipped"
    ),
    "gpu_raster_projection": Case(
        "ball",
        refused={
            3: "'Project active rasters color to current mesh' draws with OpenGL",
            5: "'Texture Map Defragmentation' draws with OpenGL",
        },
        lenient="skipped ran skipped",
    ),
    "gpu_thickness": Case(
        "ball", refused={6: "'Shape Diameter Function' draws with OpenGL"}, lenient="ran skipped"
    ),
    "grammar_city": Case(
        "ball",
        refused={6: "'Structure Synth Mesh Creation' aborts in pymeshlab"},
        lenient="ran skipped",
    ),
    "icp_with_itself": Case("two_scans", refused={6: "needs two layers"}, lenient="ran skipped"),
    "layer_not_yet_there": Case("ball", refused={6: "got 1"}, lenient="ran skipped ran"),
    "layer_out_of_range": Case("two_solids", refused={6: "got 7"}, lenient="ran skipped"),
    "matrix_with_a_gap": Case(
        "ball",
        refused={4: "parameter 'TransformMatrix' has no attribute 'val1'"},
        lenient="mapped",
    ),
    "needs_faces": Case(
        "cloud",
        refused={6: "'Voronoi Sampling' needs faces"},
        lenient="ran skipped",
    ),
    "normals_on_nothing": Case(
        "cloud",
        refused={5: "'Compute normals for point sets' needs points"},
        untouched=False,
        lenient="ran ran skipped",
    ),
    "power_crust_out_of_range": Case(
        "statue",
        refused={
            4: "parameter 'maxplanes' must be a whole number from 1 to 32; got 500",
            7: "unknown parameter 'gapp' of 'Mirror-Complete Points'; did you mean 'gap'?",
        },
        lenient="mapped mapped",
    ),
    "unknown_filter": Case(
        "ball",
        refused={4: "no filter is called 'Laplacian Smoth'; did you mean 'Laplacian Smooth'?"},
        lenient="ran skipped",
    ),
    "unknown_parameter": Case(
        "ball",
        refused={
            4: "unknown parameter 'MaxHoleSise' of 'Close Holes'; did you mean 'maxholesize'?"
        },
        lenient="mapped",
    ),
    "wrong_types": Case(
        "ball",
        refused={
            4: "parameter 'stepsmoothnum' must be a whole number; got 'three'",
            5: "parameter 'boundary' must be true or false; got 'yes'",
            8: "parameter 'color1' must be 3 or 4 numbers from 0 to 255",
            11: "parameter 'curvaturetype' must be one of 'Mean Curvature'",
        },
        lenient="mapped mapped mapped",
    ),
}

CASES = RUNS | REFUSALS
