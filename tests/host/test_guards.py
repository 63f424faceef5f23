"""Steps that would end the process, or delete what was measured, do not run."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pymeshlab
import pytest

from meshlab_symrecon.errors import GeometryError, HostError, ParameterError
from meshlab_symrecon.host.layer_guards import NEED_TWO_LAYERS
from meshlab_symrecon.host.native_filters import apply_native, find_native, native_filters
from meshlab_symrecon.host.shape_guards import FATAL_WITH_NAN
from meshlab_symrecon.host.value_limits import ABOVE_ZERO, LEAST, MOST, NOT_ZERO

DRAW = [name for name, item in native_filters().items() if item.display]


def test_filters_that_draw_are_known():
    assert {
        "apply_texmap_defragmentation",
        "compute_color_from_active_rasters_projection",
        "compute_scalar_ambient_occlusion_gpu",
        "get_depth_complexity",
        "raster_alignment_mutual_information",
        "save_snapshot",
    } <= set(DRAW)
    assert len(DRAW) == 15


@pytest.mark.parametrize("name", DRAW)
def test_filters_that_draw_are_refused(cloud_set, name):
    with pytest.raises(HostError, match="draws with OpenGL"):
        apply_native(cloud_set, name, {})


def test_a_filter_that_always_aborts_is_refused(cloud_set):
    with pytest.raises(HostError, match="aborts in pymeshlab"):
        apply_native(cloud_set, "create_mesh_by_grammar", {"grammar": "sphere"})


@pytest.mark.parametrize(
    "name", ["generate_sampling_texel", "Define New Per Vertex Custom Point Attribute"]
)
def test_an_empty_document_is_refused_where_it_would_crash(name):
    with pytest.raises(HostError, match="got an empty document"):
        apply_native(pymeshlab.MeshSet(verbose=False), name, {})


def test_an_empty_document_is_refused_by_meshlab_elsewhere():
    with pytest.raises(HostError, match="requires at least one mesh"):
        apply_native(pymeshlab.MeshSet(verbose=False), "compute_normal_for_point_clouds", {})
    mesh_set = pymeshlab.MeshSet(verbose=False)
    apply_native(mesh_set, "create_cube", {})
    assert mesh_set.mesh_number() == 1


def test_layers_that_do_not_exist_are_refused(cloud_set):
    cloud_set.create_cube()
    with pytest.raises(
        ParameterError, match=r"'second_mesh' of .* must be .*; got 99; .* has 0, 1$"
    ):
        apply_native(cloud_set, "generate_boolean_union", {"first_mesh": 1, "second_mesh": 99})


def test_a_default_layer_that_does_not_exist_is_refused(cloud_set):
    """The default of this filter is layer 1, in a document that has only layer 0 as well."""
    with pytest.raises(ParameterError, match=r"'sourcemesh' of .* got 1; the document has 0$"):
        apply_native(cloud_set, "compute_matrix_by_icp_between_meshes", {})


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("compute_mls_projection_apss", {}),
        ("compute_mls_projection_rimls", {"controlmesh": 0, "proxymesh": 0}),
        *((name, dict.fromkeys(roles, 0)) for name, roles in NEED_TWO_LAYERS.items()),
    ],
)
def test_one_layer_in_two_roles_is_refused(cloud_set, name, values):
    with pytest.raises(ParameterError, match="needs two layers; got 0 as"):
        apply_native(cloud_set, name, values)


def test_two_layers_in_two_roles_run(points):
    mesh_set = pymeshlab.MeshSet(verbose=False)
    for shift in (0.0, 0.001):
        mesh_set.add_mesh(pymeshlab.Mesh(vertex_matrix=points + shift, v_normals_matrix=points))
    values = {"referencemesh": 0, "sourcemesh": 1, "samplenum": 40}
    apply_native(mesh_set, "compute_matrix_by_icp_between_meshes", values)


def fatal_on(document):
    """Return the filters that crash on a document but not on meshes."""
    items = native_filters().values()
    return [i.python_name for i in items if document in i.fatal and "mesh" not in i.fatal]


@pytest.mark.parametrize("name", fatal_on("void"))
def test_a_layer_without_points_is_refused_where_it_would_crash(cloud_set, name):
    cloud_set.set_selection_all()
    cloud_set.meshing_remove_selected_vertices()
    with pytest.raises(GeometryError, match="needs points; layer 'scan' has none"):
        apply_native(cloud_set, name, {})


@pytest.mark.parametrize(
    "name",
    [
        *fatal_on("cloud"),
        "generate_solid_wireframe",
        "compute_iso_parametrization",
        "get_scalar_statistics_per_face",
        "compute_color_by_point_cloud_voronoi_projection",
    ],
)
def test_a_cloud_is_refused_where_it_would_crash_or_be_emptied(cloud_set, points, name):
    with pytest.raises(GeometryError, match="needs faces; layer 'scan' is a cloud"):
        apply_native(cloud_set, name, {})
    np.testing.assert_array_equal(cloud_set.mesh(0).vertex_matrix(), points)


def test_the_layer_that_needs_faces_may_be_another_one(cloud_set):
    cloud_set.create_sphere()
    cloud_set.set_current_mesh(0)
    values = {"coloredmesh": 1, "vertexmesh": 0}
    apply_native(cloud_set, "compute_color_by_point_cloud_voronoi_projection", values)
    assert cloud_set.mesh(0).vertex_number() == 40
    cloud_set.set_current_mesh(1)
    with pytest.raises(GeometryError, match="layer 'scan' is a cloud"):
        apply_native(cloud_set, "Voronoi Vertex Coloring", {"coloredmesh": 0, "vertexmesh": 1})


def test_a_mesh_may_be_coloured_by_default_while_a_cloud_is_current(cloud_set):
    cloud_set.create_sphere()
    cloud_set.set_current_mesh(0)
    apply_native(cloud_set, "Voronoi Vertex Coloring", {})
    assert cloud_set.mesh(0).vertex_number() == 40


def test_a_wireframe_is_made_of_a_polyline():
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.create_cube()
    mesh_set.generate_polyline_from_planar_section()
    assert (mesh_set.current_mesh().face_number(), mesh_set.current_mesh().edge_number()) == (0, 8)
    apply_native(mesh_set, "Create Solid Wireframe", {})
    assert list(mesh_set)[-1].face_number() > 0


def test_the_layers_that_need_points_are_those_that_are_named(cloud_set, points):
    cloud_set.add_mesh(pymeshlab.Mesh(vertex_matrix=points), "void")
    cloud_set.set_selection_all()
    cloud_set.meshing_remove_selected_vertices()
    roles = {"sourcemesh": 0, "targetmesh": 1}
    apply_native(cloud_set, "transfer_attributes_per_vertex", roles)  # the target may be void
    cloud_set.set_current_mesh(0)
    with pytest.raises(GeometryError, match="needs points; layer 'void' has none"):
        apply_native(
            cloud_set, "transfer_attributes_per_vertex", {"sourcemesh": 1, "targetmesh": 0}
        )


def test_shares_of_a_box_are_refused_when_a_point_is_not_finite(points):
    points[3, 1] = np.nan
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.add_mesh(pymeshlab.Mesh(vertex_matrix=points), "scan")
    with pytest.raises(
        GeometryError, match=r"'threshold' by the layer's box; .*'scan' has 1 points"
    ):
        apply_native(mesh_set, "meshing_merge_close_vertices", {})
    apply_native(mesh_set, "meshing_merge_close_vertices", {"threshold": 1e-9})
    apply_native(mesh_set, "compute_selection_by_condition_per_vertex", {"condselect": "y != y"})


@pytest.mark.parametrize("preclean", [True, False])
def test_screened_poisson_without_normals_is_refused(cloud_set, points, preclean):
    """With 'preclean', MeshLab would delete every point."""
    with pytest.raises(GeometryError, match="needs normals; layer 'scan' has none"):
        apply_native(
            cloud_set, "generate_surface_reconstruction_screened_poisson", {"preclean": preclean}
        )
    np.testing.assert_array_equal(cloud_set.current_mesh().vertex_matrix(), points)


def test_screened_poisson_gives_the_same_bits_every_time(points):
    """It does in one thread only."""
    normals = points / np.linalg.norm(points, axis=1, keepdims=True)
    made = []
    for _ in range(2):
        mesh_set = pymeshlab.MeshSet(verbose=False)
        mesh_set.add_mesh(pymeshlab.Mesh(vertex_matrix=normals, v_normals_matrix=normals))
        apply_native(mesh_set, "generate_surface_reconstruction_screened_poisson", {"depth": 4})
        made.append(mesh_set.current_mesh().vertex_matrix())
    np.testing.assert_array_equal(made[0], made[1])
    assert len(made[0]) > 50


def test_a_value_that_aborts_is_refused(cloud_set):
    cloud_set.create_cube()
    with pytest.raises(HostError, match=r"aborts in .* with 'draw_texture' set to true; run"):
        apply_native(cloud_set, "generate_dust_accumulation_point_cloud", {"draw_texture": True})


def too_low():
    for name, parameters in ABOVE_ZERO.items():
        yield from ((name, parameter, 0.0, "above 0") for parameter in parameters)
    for name, parameters in NOT_ZERO.items():
        yield from ((name, parameter, 0, "other than 0") for parameter in parameters)
    for name, least in LEAST.items():
        for parameter, low in least.items():
            yield name, parameter, low - 1, f"at least {low}"
    for name, most in MOST.items():
        for parameter, high in most.items():
            yield name, parameter, high + 1, f"at most {high}"


@pytest.mark.parametrize(("name", "parameter", "value", "wanted"), list(too_low()))
def test_values_that_crash_or_never_end_are_refused(cloud_set, name, parameter, value, wanted):
    find_native(name).find(parameter)
    with pytest.raises(
        ParameterError, match=f"'{parameter}' of .* must be {wanted}, or MeshLab may"
    ):
        apply_native(cloud_set, name, {parameter: value})


def test_values_at_the_limits_run(cloud_set):
    apply_native(cloud_set, "compute_normal_for_point_clouds", {"k": 1})
    apply_native(cloud_set, "create_torus", {"hsubdiv": 3, "vsubdiv": 3})
    apply_native(
        cloud_set, "meshing_isotropic_explicit_remeshing",
        {"targetlen": pymeshlab.PercentageValue(50.0), "iterations": 1},
    )  # fmt: skip
    assert cloud_set.mesh_number() == 2


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("generate_marching_cubes_apss", {"resolution": 0}),
        ("generate_marching_cubes_rimls", {"resolution": 0}),
        ("meshing_surface_subdivision_doo_sabin", {"iterations": 0}),
        ("generate_sampling_volumetric", {"samplesurfradius": pymeshlab.PureValue(-1.0)}),
        ("meshing_isotropic_explicit_remeshing", {"targetlen": pymeshlab.PureValue(-1.0)}),
    ],
)
def test_odd_values_that_meshlab_runs_are_not_refused(name, values):
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.create_cube()
    apply_native(mesh_set, name, values)


def test_no_samples_align_nothing(cloud_set):
    cloud_set.create_sphere(subdiv=1)
    cloud_set.create_sphere(subdiv=1)
    apply_native(cloud_set, "compute_matrix_by_mesh_global_alignment", {"samplenum": 0})


@pytest.mark.parametrize("name", sorted(FATAL_WITH_NAN))
def test_nan_is_refused_where_it_would_crash(name):
    mesh_set = pymeshlab.MeshSet(verbose=False)
    points = np.random.default_rng(1).normal(size=(12, 3))
    points[5, 2] = np.nan
    mesh_set.add_mesh(pymeshlab.Mesh(points, np.arange(12).reshape(4, 3)), "scan")
    with pytest.raises(GeometryError, match="fails on NaN; layer 'scan' has 1 points with NaN"):
        apply_native(mesh_set, name, {})


def test_nan_in_another_layer_is_found(cloud_set):
    bad = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, np.nan, 0.0]])
    cloud_set.add_mesh(pymeshlab.Mesh(bad, np.array([[0, 1, 2]])), "bad")
    cloud_set.create_cube()
    with pytest.raises(GeometryError, match="layer 'bad' has 1 points with NaN"):
        apply_native(cloud_set, "generate_boolean_union", {"first_mesh": 2, "second_mesh": 1})


FAN = np.array([[0, 1, 2], [0, 1, 3], [0, 1, 4]])  # three faces on one edge
SHAPES = {
    "nothing": (np.ones((3, 3)), np.array([[0, 1, 2]])),
    "fan": (np.random.default_rng(2).normal(size=(5, 3)), FAN),
    "stray": (np.random.default_rng(2).normal(size=(5, 3)), FAN[:1]),
    "flat": (np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1.5, 0]], float),
        np.array([[0, 1, 2], [1, 3, 2]])),
}  # fmt: skip
OUTLIERS = "compute_selection_of_visible_convex_hull_per_vertex"
CURVATURE = "compute_curvature_principal_directions_per_vertex"


@pytest.mark.parametrize(
    ("shape", "name", "values", "words"),
    [
        ("nothing", "generate_sampling_montecarlo", {}, "has no extent"),
        ("nothing", "generate_convex_hull", {}, "has no extent"),
        ("stray", "apply_texcoord_merge_per_wedge", {}, "has vertices without faces"),
        ("fan", "meshing_refine_by_function", {}, "edges with more than two faces"),
        ("flat", "meshing_surface_subdivision_doo_sabin", {}, "has a boundary"),
        ("flat", OUTLIERS, {}, "has a point at 'viewpoint'"),
        ("flat", OUTLIERS, {"viewpoint": [1, 0, 0]}, "has a point at 'viewpoint'"),
        ("flat", CURVATURE, {"method": "Scale Dependent Quadric Fitting"}, "is flat"),
    ],
)
def test_shapes_that_crash_or_never_end_are_refused(shape, name, values, words):
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.add_mesh(pymeshlab.Mesh(*SHAPES[shape]), "scan")
    mesh_set.compute_texcoord_by_function_per_wedge()
    with pytest.raises(GeometryError, match=f"would end the process: layer 'scan' .*{words}"):
        apply_native(mesh_set, name, values)


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("generate_sampling_montecarlo", {"samplenum": 9}),
        ("apply_texcoord_merge_per_wedge", {}),
        ("meshing_refine_by_function", {}),
        ("meshing_surface_subdivision_doo_sabin", {"iterations": 1}),
        (OUTLIERS, {}),
        (CURVATURE, {"method": "Scale Dependent Quadric Fitting"}),
        ("meshing_tri_to_quad_by_4_8_subdivision", {}),
    ],
)
def test_sound_shapes_are_not_refused(name, values):
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.create_sphere(subdiv=2)
    mesh_set.compute_texcoord_parametrization_triangle_trivial_per_wedge(sidedim=0, textdim=256)
    apply_native(mesh_set, name, values)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_statistics_of_what_is_not_finite_are_refused(points, value):
    quality = np.linspace(0.0, 1.0, len(points))
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.add_mesh(pymeshlab.Mesh(vertex_matrix=points, v_scalar_array=quality), "sound")
    apply_native(mesh_set, "get_scalar_statistics_per_vertex", {})
    quality[4] = value
    mesh_set.add_mesh(pymeshlab.Mesh(vertex_matrix=points, v_scalar_array=quality), "scan")
    with pytest.raises(GeometryError, match="layer 'scan' has vertex quality that is NaN"):
        apply_native(mesh_set, "get_scalar_statistics_per_vertex", {})


def test_texture_coordinates_of_vertices_are_refused_where_they_crash():
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.create_sphere(subdiv=1)
    mesh_set.compute_texcoord_by_function_per_vertex()
    with pytest.raises(GeometryError, match="has texture coordinates of vertices"):
        apply_native(mesh_set, "meshing_tri_to_quad_by_4_8_subdivision", {})


def test_the_target_of_a_movement_is_closed_and_that_of_craters_has_faces(cloud_set):
    cloud_set.create_grid(numvertx=4, numverty=4)
    movement = "apply_coord_point_cloud_movement_over_mesh"
    with pytest.raises(GeometryError, match=r"layer 'Grid.*' has a boundary"):
        apply_native(cloud_set, movement, {"point_cloud": 0, "target_mesh": 1})
    craters = "apply_coord_craters_from_point_cloud"
    with pytest.raises(GeometryError, match="layer 'scan' has no faces; name a mesh"):
        apply_native(cloud_set, craters, {"target_mesh": 0, "samples_mesh": 1})
    cloud_set.create_sphere(subdiv=2)
    with pytest.raises(GeometryError, match="points of layer 'scan' are far from layer 'Sphere'"):
        apply_native(cloud_set, movement, {"point_cloud": 0, "target_mesh": 2})
    inside = pymeshlab.Mesh(np.random.default_rng(0).uniform(-0.5, 0.5, size=(20, 3)))
    cloud_set.add_mesh(inside, "near", False)
    apply_native(cloud_set, movement, {"point_cloud": 3, "target_mesh": 2})


@pytest.mark.parametrize("name", ["compute_mls_projection_apss", "compute_mls_projection_rimls"])
def test_the_control_mesh_must_be_current(name):
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.create_sphere(subdiv=2)
    mesh_set.create_sphere(subdiv=2, radius=1.01)
    with pytest.raises(ParameterError, match="needs the current layer as 'controlmesh'; got 0"):
        apply_native(mesh_set, name, {"controlmesh": 0, "proxymesh": 1})
    apply_native(mesh_set, name, {"controlmesh": 1, "proxymesh": 0})


CRASH = """
import pymeshlab, numpy
mesh_set = pymeshlab.MeshSet(verbose=False)
mesh_set.add_mesh(pymeshlab.Mesh(vertex_matrix=numpy.random.default_rng(0).normal(size=(40, 3))))
mesh_set.{}
"""


@pytest.mark.parametrize(
    "call",
    ["generate_alpha_wrap()", "save_snapshot()", "compute_normal_for_point_clouds(k=0)"],
)
def test_pymeshlab_itself_does_end_the_process(call):
    """When this fails, the guard is no longer needed."""
    ended = subprocess.run([sys.executable, "-c", CRASH.format(call)], capture_output=True)
    assert ended.returncode < 0
