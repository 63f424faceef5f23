"""The table of old names: every row leads to what is there today, by any spelling."""

from __future__ import annotations

import pytest

from meshlab_symrecon.errors import UnknownFilterError
from meshlab_symrecon.host.filter_names import find_any, known_today
from meshlab_symrecon.host.native_filters import native_filters
from meshlab_symrecon.host.native_values import parse_native
from meshlab_symrecon.host.old_names import (
    CHANGE_LAYER,
    NOTHING,
    _table,
    advice_on_gone,
    bare_name,
    change_of_parameter,
    find_old_name,
    old_names,
)

DECIMATION = "meshing_decimation_quadric_edge_collapse"
POISSON = "generate_surface_reconstruction_screened_poisson"
RENAMED = {
    "Quadric Edge Collapse Decimation": DECIMATION,
    "Quadric Edge Collapse Decimation (with texture)": f"{DECIMATION}_with_texture",
    "Clustering decimation": "meshing_decimation_clustering",
    "Remove Duplicated Vertex": "meshing_remove_duplicate_vertices",
    "Remove Unreferenced Vertex": "meshing_remove_unreferenced_vertices",
    "Split Vertexes Incident on Non Manifold Faces": "meshing_repair_non_manifold_vertices",
    "Re-Orient all faces coherentely": "meshing_re_orient_faces_coherently",
    "Screened Poisson Surface Reconstruction": POISSON,
    "Surface Reconstruction: Poisson": POISSON,
    "Transform: Move, Translate, Center": "compute_matrix_from_translation",
    "Transform: Scale": "compute_matrix_from_scaling_or_normalization",
    "Freeze Current Matrix": "apply_matrix_freeze",
    "Geometric Function": "compute_coord_by_function",
    "Small component selection": "compute_selection_by_small_disconnected_components_per_face",
    "Select Visible Points": "compute_selection_of_visible_convex_hull_per_vertex",
    "Smooths normals on a point sets": "apply_normal_point_cloud_smoothing",
    "Mesh Element Subsampling": "generate_sampling_element",
    "Clustered vertex Subsampling": "generate_sampling_clustered_vertex",
    "Move selection on another layer": "generate_from_selected_faces",
    "Vertex Color to Texture": "compute_texmap_from_color",
    "Texture to Vertex Color (between 2 meshes)": "transfer_texture_to_color_per_vertex",
    "Iso Parametrization": "compute_iso_parametrization",
    "Colorize by Quality": "compute_color_from_scalar_per_vertex",
    "Box": "create_cube",
    "Laplacian smooth (surface preserve)": "apply_coord_laplacian_smoothing_surface_preserving",
}
OLD_PYTHON_NAMES = {  # of pymeshlab before 2022
    "simplification_quadric_edge_collapse_decimation": DECIMATION,
    "transform_translate_center_set_origin": "compute_matrix_from_translation",
    "re_orient_all_faces_coherentely": "meshing_re_orient_faces_coherently",
    "remove_isolated_pieces_wrt_diameter": "meshing_remove_connected_component_by_diameter",
    "flatten_visible_layers": "generate_by_merging_visible_meshes",
    "box_cube": "create_cube",
    "per_vertex_color_function": "compute_color_by_function_per_vertex",
    "convert_pervertex_uv_into_perwedge_uv": "compute_texcoord_transfer_vertex_to_wedge",
    "surface_reconstruction_ball_pivoting": "generate_surface_reconstruction_ball_pivoting",
}
LOOSE = {
    "Repair non-manifold edges": "meshing_repair_non_manifold_edges",
    "closeholes": "meshing_close_holes",
    "Per-Vertex Color Function": "compute_color_by_function_per_vertex",
    "Recompute Face Normals": "compute_normal_per_face",
    "select NON manifold  edges ": "compute_selection_by_non_manifold_edges_per_face",
    "Transform: Scale & Normalize": "compute_matrix_from_scaling_or_normalization",
}


@pytest.mark.parametrize(("name", "today"), (RENAMED | OLD_PYTHON_NAMES | LOOSE).items())
@pytest.mark.parametrize("spelling", [str, str.upper, lambda name: f"  {name} "])
def test_renames(name, today, spelling):
    assert find_any(spelling(name)).python_name == today


@pytest.mark.parametrize("name", native_filters())
def test_every_filter_is_found_by_every_spelling_of_its_names(name):
    menu_name = native_filters()[name].menu_name
    for written in (name, menu_name):
        for spelling in (
            written,
            written.upper(),
            f" {written.lower()} ",
            written.replace(" ", "  ").replace("_", " "),
            "".join(letter for letter in written if letter.isalnum()),
        ):
            assert find_any(spelling).python_name == name


@pytest.mark.parametrize("name", old_names())
def test_rows_lead_to_filters_of_today(name):
    """No old name is one of today, and its values are taken."""
    old = old_names()[name]
    assert known_today(name) is None
    assert find_old_name(f" {name.upper()} ") is old
    if old.filter in (NOTHING, CHANGE_LAYER):
        assert not old.values
        return
    for successor in (old.filter, *old.words.values()):
        assert not successor or successor in native_filters()
    for parameter, text in old.values.items():
        known = native_filters()[old.filter].find(parameter)
        assert known.name == parameter
        parse_native(known, text)
    assert bool(old.filter) != bool(old.by)
    assert bool(old.by) == bool(old.words)


CHANGES = [(owner, name) for owner, changes in _table()["parameters"].items() for name in changes]


@pytest.mark.parametrize(("owner", "name"), CHANGES)
def test_changed_parameters_are_not_those_of_today(owner, name):
    change = change_of_parameter(owner, name)
    if owner == "*":
        assert any(known.name == change.to for item in native_filters().values()
                   for known in item.parameters)  # fmt: skip
        return
    parameters = {known.name: known for known in native_filters()[owner].parameters}
    assert name not in parameters
    assert name == name.lower()
    for today in (change.to, change.unless_file, *change.factors, *change.also):
        assert not today or today in parameters
    for text in change.values.values():
        assert text is None or parse_native(parameters[change.to], text)
    for today, text in change.also.items():
        parse_native(parameters[today], text)


def test_parameters_nobody_changed():
    assert change_of_parameter(DECIMATION, "no such") is None
    assert change_of_parameter("compute_matrix_from_rotation", "toall").to == "alllayers"


@pytest.mark.parametrize("name", _table()["gone"])
def test_filters_that_are_gone(name):
    assert known_today(name) is None
    assert find_old_name(name) is None
    with pytest.raises(UnknownFilterError) as caught:
        find_any(name.upper())
    assert str(caught.value) == f"'{name.upper()}' is gone from MeshLab; {advice_on_gone(name)}"


@pytest.mark.parametrize(
    ("name", "words"),
    [
        (
            "Remove T-Vertices by Edge Flip",
            "it is 'meshing_remove_t_vertices' with method 1",
        ),
        ("CSG Operation", "it is one of generate_boolean_intersection, generate_boolean_union, "),
        ("Compact faces", "leave it out"),
        ("Change the current layer", "use it in scripts only"),
    ],
)
def test_old_names_that_need_more_than_a_new_name(name, words):
    with pytest.raises(UnknownFilterError, match=f"no filter is called '{name}' today; {words}"):
        find_any(name)


def test_bare_names():
    assert bare_name(" Re-Compute  Face_Normals (2)!") == "recomputefacenormals2"
    assert bare_name("größe") == "größe"
