"""What a document will be after a step is what it is: every quick filter, on real documents."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pymeshlab
import pytest

from meshlab_symrecon.errors import SymReconError, SymReconWarning
from meshlab_symrecon.host.checking import check_document, check_script
from meshlab_symrecon.host.document_state import UNKNOWN_LAYER, DocumentState, LayerState
from meshlab_symrecon.host.findings import ERROR, NOTE
from meshlab_symrecon.host.mlx import Param, Script, Step
from meshlab_symrecon.host.native_filters import apply_native, find_native, native_filters
from meshlab_symrecon.host.prediction import after
from meshlab_symrecon.host.resolution import ResolvedStep, matched
from meshlab_symrecon.host.script import run_steps

# Filters that take long, talk to a server, write files, or crash now and then whatever they get.
LEFT_OUT = (
    "export_mesh", "nxs_", "save_", "load_", "raster_", "set_camera", "generate_voronoi_",
    "generate_marching", "generate_sampling_v", "generate_surface_reconstruction_s",
    "generate_surface_reconstruction_vcg", "compute_iso", "generate_iso", "transfer_iso",
    "create_fractal", "create_sphere_points", "create_implicit", "apply_coord_developability",
    "apply_coord_cubic", "compute_curvature", "compute_scalar_ambient", "compute_scalar_by_shape",
    "compute_scalar_by_volumetric", "meshing_surface_subdivision_doo", "compute_texmap",
    "transfer_attributes_to_texture", "set_texture", "generate_dust", "generate_resampled",
    "meshing_re_orient_faces_by_geometry", "create_noisy", "generate_alpha",
)  # fmt: skip
QUICK = [
    name
    for name, item in native_filters().items()
    if not item.display and not name.startswith(LEFT_OUT) and name != "create_mesh_by_grammar"
]


def coloured_cloud():
    """A cloud with normals, colours and quality, and nothing beside it."""
    mesh_set = pymeshlab.MeshSet(verbose=False)
    directions = np.random.default_rng(3).normal(size=(120, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    mesh = pymeshlab.Mesh(vertex_matrix=directions * [3.0, 2.0, 1.0], v_normals_matrix=directions)
    mesh_set.add_mesh(mesh, "scan")
    mesh_set.compute_color_by_function_per_vertex(x="90", y="y*20", z="200")
    mesh_set.compute_scalar_by_function_per_vertex(q="z")
    return mesh_set


def plain_cloud_and_painted_mesh():
    """A plain cloud, current, before a mesh with colours and wedge coordinates."""
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.create_sphere_points(pointnum=60)
    mesh_set.create_cone(subdiv=9)
    mesh_set.compute_color_by_function_per_vertex()
    mesh_set.compute_texcoord_parametrization_triangle_trivial_per_wedge(sidedim=0, textdim=64)
    mesh_set.set_current_mesh(0)
    return mesh_set


def selected_torus():
    """A cube, and a torus with quality of faces of which half is selected, current."""
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.create_cube()
    mesh_set.create_torus(hsubdiv=9, vsubdiv=7)
    mesh_set.compute_scalar_by_function_per_face(q="x0")
    mesh_set.compute_selection_by_condition_per_face(condselect="x0>0")
    return mesh_set


def open_sheet():
    """A mesh with a boundary and quality, nothing selected."""
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.create_grid(numvertx=6, numverty=5)
    mesh_set.compute_scalar_by_function_per_vertex(q="x")
    return mesh_set


def non_manifold_fan():
    """Three triangles on one edge, two that meet in a point only, one of no area, a loose point."""
    points = [[0, 0, 0], [0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, -1, 0], [3, 0, 1], [3, 1, 1],
              [-3, 0, 1], [-3, 1, 1], [9, 9, 9]]  # fmt: skip
    faces = [[0, 1, 2], [0, 1, 3], [0, 1, 4], [1, 5, 6], [1, 7, 8], [5, 6, 6]]
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.add_mesh(pymeshlab.Mesh(np.array(points, dtype=float), np.array(faces)), "fan")
    mesh_set.compute_scalar_by_function_per_vertex(q="z")
    return mesh_set


DOCUMENTS = (coloured_cloud, plain_cloud_and_painted_mesh, selected_torus, open_sheet)


def resolved(name, **values):
    item = find_native(name)
    layers = {parameter.name for parameter in item.parameters if parameter.rich_type == "RichMesh"}
    return ResolvedStep(Step(item.menu_name, 1), item, values, tuple(layers & set(values)))


def ran(mesh_set, name, values):
    with warnings.catch_warnings():
        warnings.simplefilter("error", SymReconWarning)  # a step that was skipped
        try:
            apply_native(mesh_set, name, values)
        except (SymReconError, SymReconWarning):
            return False
    return True


def assert_foreseen(predicted, observed):
    """Compare everything that the prediction is certain of."""
    assert predicted.most is None or len(observed.layers) <= predicted.most
    assert len(predicted.layers) <= len(observed.layers)
    for known, seen in zip(predicted.layers, observed.layers, strict=False):
        assert_same_where_known(known, seen)
    if predicted.current is not None:
        assert predicted.current == observed.current
    if observed.current is not None:
        assert_same_where_known(predicted.current_layer, observed.current_layer)


def assert_same_where_known(known, seen):
    wrong = {fact: held for fact, held in known.facts.items() if seen.has(fact) is not held}
    assert wrong == {}
    assert known.label in ("", seen.label)
    assert known.vertices in (None, seen.vertices)


def test_the_filters_that_are_tried_are_most_of_them():
    assert len(QUICK) > 190


@pytest.mark.parametrize("name", QUICK)
def test_what_is_foreseen_comes_true(name):
    """And a step with an error does not run, and a step without is told apart by what it does."""
    for make in DOCUMENTS:
        assert_comes_true(make(), name)


def assert_comes_true(mesh_set, name, **values):
    before = DocumentState.of(mesh_set)
    step = resolved(name, **values)
    errors = [found for found in check_document([step], before) if found.severity == ERROR]
    predicted = after(before, step)
    if not ran(mesh_set, name, values):
        return False
    assert errors == []
    assert_foreseen(predicted, DocumentState.of(mesh_set))
    return True


THRESHOLDS = [
    ("meshing_remove_vertices_by_scalar", {"maxqualitythr": 0.5}),
    ("meshing_remove_vertices_by_scalar", {"maxqualitythr": -1.0}),
    ("generate_cylindrical_unwrapping", {}),
    ("generate_cylindrical_unwrapping", {"startangle": -180.0}),
    ("generate_cylindrical_unwrapping", {"endangle": 0.0}),
    ("meshing_close_holes", {"maxholesize": 100}),
    ("meshing_close_holes", {"maxholesize": 100, "newfaceselected": False}),
    ("get_topological_measures", {}),
    ("meshing_remove_folded_faces", {}),
    ("meshing_remove_null_faces", {}),
    ("meshing_remove_t_vertices", {"threshold": 1.0}),
    ("meshing_remove_unreferenced_vertices", {}),
    ("meshing_remove_connected_component_by_face_number", {"mincomponentsize": 1000}),
    ("meshing_merge_close_vertices", {"threshold": pymeshlab.PercentageValue(90.0)}),
    ("meshing_repair_non_manifold_edges", {"method": "Split Vertices"}),
    ("meshing_repair_non_manifold_vertices", {}),
    ("meshing_vertex_attribute_seam", {}),
    ("meshing_cut_along_crease_edges", {"angledeg": 1.0}),
    ("meshing_decimation_clustering", {"threshold": pymeshlab.PercentageValue(60.0)}),
    ("meshing_decimation_quadric_edge_collapse", {"targetfacenum": 1}),
    ("meshing_snap_mismatched_borders", {"edgedistratio": 1.0}),
    ("generate_splitting_by_connected_components", {}),
    ("generate_polyline_from_planar_section", {"planeoffset": 50.0}),
    ("generate_sampling_stratified_triangle", {"samplenum": 1}),
    ("compute_selection_by_self_intersections_per_face", {}),
    ("compute_selection_by_scalar_per_vertex", {"minq": 0.2, "maxq": 0.4}),
]
SAMPLING = "generate_sampling_poisson_disk"
TOGETHER = [
    (SAMPLING, {"samplenum": 30, "savemontecarlo": True}),
    (SAMPLING, {"samplenum": 30, "savemontecarlo": True, "subsample": True}),
    (SAMPLING, {"samplenum": 30, "savemontecarlo": True, "subsample": False}),
]


@pytest.mark.parametrize("make", [open_sheet, non_manifold_fan, selected_torus])
@pytest.mark.parametrize(("name", "values"), [*THRESHOLDS, *TOGETHER])
def test_other_values_on_unsound_shapes_are_foreseen(make, name, values):
    mesh_set = make()
    tried = assert_comes_true(mesh_set, name, **values)
    assert tried or make is not open_sheet


CHAIN = [
    ("generate_copy_of_current_mesh", {}),
    ("compute_scalar_by_function_per_vertex", {"q": "x"}),
    ("create_sphere", {"subdiv": 1}),
    ("compute_texcoord_parametrization_triangle_trivial_per_wedge", {"sidedim": 0, "textdim": 64}),
    ("compute_texcoord_transfer_wedge_to_vertex", {}),
    ("generate_sampling_montecarlo", {"samplenum": 50}),
    ("compute_normal_for_point_clouds", {}),
    ("delete_current_mesh", {}),
    ("create_cube", {}),
    ("meshing_invert_face_orientation", {}),
    ("generate_convex_hull", {}),
    ("set_selection_all", {}),
    ("generate_by_merging_visible_meshes", {"deletelayer": False}),
    ("generate_by_merging_visible_meshes", {}),
    ("delete_current_mesh", {}),
    ("create_cone", {}),
]


def test_a_long_chain_is_foreseen_from_its_beginning():
    mesh_set = coloured_cloud()
    predicted = DocumentState.of(mesh_set)
    for name, values in CHAIN:
        predicted = after(predicted, resolved(name, **values))
        assert ran(mesh_set, name, values), name
        observed = DocumentState.of(mesh_set)
        assert_foreseen(predicted, observed)
        assert (len(predicted.layers), predicted.more) == (len(observed.layers), 0)
        assert predicted.current == observed.current
    assert [known.vertices for known in observed.layers] != [None]


@pytest.mark.parametrize(
    ("values", "added"),
    [
        ({"subsample": True}, 1),
        ({"savemontecarlo": True, "subsample": False}, 2),
        ({"subsample": True, "savemontecarlo": True}, None),
    ],
)
def test_values_change_how_many_layers_there_will_be(values, added):
    state = DocumentState.of(coloured_cloud())
    predicted = after(state, resolved("generate_sampling_poisson_disk", **values))
    if added:
        assert (len(predicted.layers), predicted.more) == (1 + added, 0)
        assert predicted.current_layer.has("faces") is False
    else:
        assert predicted.most is None


def test_a_hidden_layer_makes_a_merger_uncertain():
    mesh_set = selected_torus()
    assert len(after(DocumentState.of(mesh_set), resolved(CHAIN[13][0])).layers) == 1
    mesh_set.set_mesh_visibility(0, False)
    state = DocumentState.of(mesh_set)
    assert after(state, resolved(CHAIN[13][0])).most == 3
    everything = after(state, resolved(CHAIN[13][0], mergevisible=False))
    assert len(everything.layers) == 1


def test_pieces_are_not_counted_before():
    predicted = after(
        DocumentState.of(selected_torus()), resolved("generate_splitting_by_connected_components")
    )
    assert (len(predicted.layers), predicted.most, predicted.current) == (2, None, None)


def test_the_layer_behind_a_deleted_one_becomes_current_or_the_first():
    for current, expected in ((0, 0), (1, 1), (2, 0)):
        mesh_set = selected_torus()
        mesh_set.create_cone()
        mesh_set.set_current_mesh(current)
        predicted = after(DocumentState.of(mesh_set), resolved("delete_current_mesh"))
        mesh_set.delete_current_mesh()
        assert predicted.current == expected
        assert_foreseen(predicted, DocumentState.of(mesh_set))


def test_nothing_is_foreseen_behind_an_unknown_step():
    assert after(DocumentState.of(selected_torus()), None) == DocumentState(more=None)


def test_an_unknown_document_stays_unknown():
    state = after(DocumentState.unknown(), resolved("meshing_close_holes"))
    assert (len(state.layers), state.most) == (1, None)
    state = after(DocumentState((UNKNOWN_LAYER,), current=0), resolved("meshing_close_holes"))
    assert state.current_layer.has("vertex_colour") is None


def test_no_normals_are_only_certain_without_faces():
    """MeshLab computes normals of faces whenever it likes."""
    facts = {"faces": True, "normals": False, "points": True}
    state = DocumentState((LayerState(facts),), current=0)
    later = after(state, resolved("set_selection_none")).current_layer
    assert later.has("normals") is None
    facts["faces"] = False
    state = DocumentState((LayerState(facts),), current=0)
    assert after(state, resolved("set_selection_none")).current_layer.has("normals") is False


@pytest.mark.parametrize("make", DOCUMENTS)
@pytest.mark.parametrize("strict", ["true", "false"])
def test_what_runs_after_a_step_is_foreseen_too(make, strict):
    """An old selection of vertices selected faces, of which a cloud has none."""
    step = Step("Conditional Vertex Selection", 1, (
        Param("condSelect", 1, "RichString", "(x > -9)"),
        Param("strictSelect", 1, "RichBool", strict),
    ))  # fmt: skip
    script = Script(Path("old.mlx"), (step,))
    mesh_set = make()
    mesh_set.set_selection_none()
    before = DocumentState.of(mesh_set)
    assert [found.severity for found in check_script(script, before)] == [NOTE]
    (known,) = matched(script).steps
    predicted = after(before, known)
    run_steps(mesh_set, script)
    assert_foreseen(predicted, DocumentState.of(mesh_set))
    with_faces = before.current_layer.has("faces")
    assert bool(mesh_set.current_mesh().selected_face_number()) is with_faces
    assert not with_faces or predicted.current_layer.has("face_selection") is None
