"""Steps that would end the process, or delete what was measured, do not run."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pymeshlab
import pytest

from meshlab_symrecon.errors import GeometryError, HostError, ParameterError, SymReconWarning
from meshlab_symrecon.host.guards import EMPTY_CLOUDS
from meshlab_symrecon.host.native_filters import apply_native, find_native, native_filters

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
        ("compute_matrix_by_icp_between_meshes", {"sourcemesh": 0, "referencemesh": 0}),
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


@pytest.mark.parametrize("name", sorted(EMPTY_CLOUDS))
def test_a_cleaning_step_that_would_delete_a_cloud_is_skipped(cloud_set, points, name):
    menu = find_native(name).menu_name
    with pytest.warns(SymReconWarning, match="was skipped: layer 'scan' has no faces") as caught:
        assert apply_native(cloud_set, menu, {}) == {}
    assert caught[0].filename == __file__
    np.testing.assert_array_equal(cloud_set.current_mesh().vertex_matrix(), points)


@pytest.mark.parametrize("name", sorted(EMPTY_CLOUDS))
def test_pymeshlab_itself_does_delete_the_cloud(cloud_set, name):
    """When this fails, the guard is no longer needed."""
    cloud_set.apply_filter(name)
    assert cloud_set.current_mesh().vertex_number() == 0


def test_cleaning_steps_run_on_meshes(cloud_set):
    cloud_set.create_cube()
    apply_native(cloud_set, "meshing_remove_unreferenced_vertices", {})
    assert cloud_set.current_mesh().vertex_number() == 8


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


CRASH = """
import pymeshlab, numpy
mesh_set = pymeshlab.MeshSet(verbose=False)
mesh_set.add_mesh(pymeshlab.Mesh(vertex_matrix=numpy.random.default_rng(0).normal(size=(40, 3))))
mesh_set.{}()
"""


@pytest.mark.parametrize("name", ["generate_alpha_wrap", "save_snapshot"])
def test_pymeshlab_itself_does_end_the_process(name):
    """When this fails, the guard is no longer needed."""
    ended = subprocess.run([sys.executable, "-c", CRASH.format(name)], capture_output=True)
    assert ended.returncode < 0
