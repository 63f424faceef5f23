"""Steps against what is known of a document at each of them, before anything runs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pymeshlab
import pytest

from meshlab_symrecon.host.checking import check_document, check_script
from meshlab_symrecon.host.document_state import UNKNOWN_LAYER, DocumentState, LayerState
from meshlab_symrecon.host.findings import ERROR, NOTE, REMARK, SKIP
from meshlab_symrecon.host.mlx_reading import read_script
from meshlab_symrecon.host.native_filters import native_filters

CLOUD = LayerState({"points": True, "faces": False, "edges": False}, "scan.ply", 500)
MESH = LayerState({"points": True, "faces": True}, "bust.ply")
UNREFERENCED = "Remove Unreferenced Vertices"


def param(name: str, value: object, rich_type: str = "RichInt") -> str:
    return f'<Param type="{rich_type}" name="{name}" value="{value}"/>'


def layer(name: str, position: int) -> str:
    return param(name, position, "RichMesh")


@pytest.fixture
def check(tmp_path):
    """Return a function that checks filters, each on a line of its own from line 2, on layers."""

    def call(state, *filters):
        path = tmp_path / "scan.mlx"
        lines = (
            f'<filter name="{one}"/>'
            if isinstance(one, str)
            else f'<filter name="{one[0]}">{"".join(one[1:])}</filter>'
            for one in filters
        )
        path.write_text("<FilterScript>\n" + "\n".join(lines) + "\n</FilterScript>\n")
        return check_script(read_script(path), state)

    return call


def on(*layers: LayerState, current: int = -1, **facts: object) -> DocumentState:
    return DocumentState(layers, current=current % len(layers), **facts)


def errors(findings):
    """Return line and message of each error."""
    return [(found.line, found.message) for found in findings if found.severity == ERROR]


def test_a_cloud_that_would_be_deleted_is_an_error_with_its_place(check):
    (found,) = check(on(CLOUD), "Invert Selection", UNREFERENCED)
    assert (found.line, found.step, found.severity, found.remedy) == (3, 1, ERROR, SKIP)
    assert Path(found.file).name == "scan.mlx"
    assert found.message == (
        "'Remove Unreferenced Vertices' would delete all the 500 points of layer 'scan.ply', which "
        "has no faces; reconstruct a surface first, or run leniently to pass over the step"
    )


@pytest.mark.parametrize("known", [MESH, UNKNOWN_LAYER, LayerState({"faces": False})])
def test_what_is_not_certainly_a_cloud_is_not_an_error(check, known):
    assert check(on(known), UNREFERENCED) == ()


def test_every_step_that_would_delete_the_cloud_is_named(check):
    found = check(on(CLOUD), UNREFERENCED, "Remove Isolated pieces (wrt Face Num.)", UNREFERENCED)
    assert [line for line, _ in errors(found)] == [2, 3, 4]


def test_a_cloud_is_still_one_behind_the_usual_cleaning(check):
    usual = ("Remove Duplicate Vertices", "Remove Duplicate Faces", "Remove Zero Area Faces",
        "Merge Close Vertices", "Repair non Manifold Edges")  # fmt: skip
    assert [line for line, _ in errors(check(on(CLOUD), *usual, UNREFERENCED))] == [7]


def test_an_old_repair_that_splits_vertices_deletes_a_cloud(check):
    old = "Repair non Manifold Edges by splitting vertices"
    assert "would delete all the 500 points" in errors(check(on(CLOUD), old))[0][1]
    assert errors(check(on(CLOUD), "Remove Faces from Non Manifold Edges")) == []
    assert errors(check(on(MESH), old)) == []


@pytest.mark.parametrize(
    ("name", "facts", "what"),
    [
        ("Close Holes", {"faces": False}, "faces"),
        ("Laplacian Smooth", {"faces": False}, "faces"),
        ("Vertex Color Invert", {"vertex_colour": False}, "vertex colours"),
        ("Clamp Vertex Quality", {"quality": False}, "vertex quality"),
        ("Convert PerWedge UV into PerVertex UV", {"wedge_texture": False}, "wedges"),
        ("Convert PerVertex UV into PerWedge UV", {"vertex_texture": False}, "vertices"),
        ("Transfer Color: Face to Vertex", {"face_colour": False}, "face colours"),
        ("Create Solid Wireframe", {"faces": False, "edges": False}, "faces"),
        ("Alpha Wrap", {"faces": False}, "faces"),
        ("Compute normals for point sets", {"points": False}, "points"),
        ("Surface Reconstruction: Screened Poisson",
            {"points": True, "faces": False, "normals": False}, "normals"),
        ("Fit a plane to selection", {"vertex_selection": False, "face_selection": False},
            "a selection"),
        ("Power Crust", {"points": False}, "points"),
    ],
)  # fmt: skip
def test_missing_input_is_told_when_it_is_certain(check, name, facts, what):
    name = "Surface Reconstruction: Power Crust" if name == "Power Crust" else name
    ((line, message),) = errors(check(on(LayerState(facts, "bust")), name))
    assert line == 2
    assert f"'{name}' needs" in message
    assert f"{what}; layer 'bust' has none; " in message
    present = dict.fromkeys(facts, True)
    assert errors(check(on(LayerState(present, "bust")), name)) == []
    assert errors(check(on(UNKNOWN_LAYER), name)) == []


@pytest.mark.parametrize(
    ("parameters", "refused"),
    [
        ((), True),
        ((param("Subsample", "true", "RichBool"),), False),
        ((param("Subsample", "false", "RichBool"),), True),
    ],
)
def test_a_value_may_lift_a_need(check, parameters, refused):
    found = check(on(CLOUD), ("Poisson-disk Sampling", *parameters))
    assert bool(errors(found)) is refused


@pytest.mark.parametrize("selected", [True, False, None])
def test_a_value_may_bring_a_need(check, selected):
    facts = {} if selected is None else {"vertex_selection": selected, "face_selection": False}
    step = ("Per Vertex Quality Function", param("onselected", "true", "RichBool"))
    found = errors(check(on(LayerState(facts)), step))
    words = (
        "'Per Vertex Quality Function' needs a selection; the current layer at this step has none"
    )
    assert [message.startswith(words) for _, message in found] == [True] * (selected is False)


def test_layers_are_counted_when_the_step_runs(check):
    def union(second):
        return ("Mesh Boolean: Union", layer("first_mesh", 0), layer("second_mesh", second))

    found = errors(check(on(MESH), "Box/Cube", union(1), union(3)))
    begins = "parameter 'second_mesh' must be the position of a layer, counted from 0; "
    assert found == [(4, begins + "got 3; the document has 3 layers at this step")]
    found = errors(check(on(MESH), "Box/Cube", "Delete Current Mesh", union(1)))
    assert found == [(4, begins + "got 1; the document has 1 layer at this step")]


def test_a_layer_that_is_made_may_be_named(check):
    change = ("Change the current layer", layer("mesh", 1))
    assert errors(check(on(MESH), change)) != []
    assert errors(check(on(MESH), "Box/Cube", change)) == []
    assert errors(check(on(MESH), "Split in Connected Components", ("Change the current layer",
        layer("mesh", 50)))) == []  # fmt: skip
    assert errors(check(DocumentState.unknown(), change)) == []


def test_our_own_filters_add_no_more_than_they_declare(check):
    change = ("Change the current layer", layer("mesh", 2))
    assert errors(check(on(CLOUD), "Detect Reflection Planes (AP)", change)) != []
    steps = ("Detect Reflection Planes (AP)", "Mirror-Complete Points", change)
    assert errors(check(on(CLOUD), *steps)) == []


def test_the_layer_that_becomes_current_is_the_one_that_is_checked(check):
    steps = (("Change the current layer", layer("mesh", 0)), UNREFERENCED)
    assert [line for line, _ in errors(check(on(CLOUD, MESH), *steps))] == [3]
    assert errors(check(on(MESH, CLOUD), *steps)) == []


def test_nothing_is_left_after_the_last_layer_is_deleted(check):
    found = errors(check(on(MESH), "Delete Current Mesh", "Close Holes", "Box/Cube", "Close Holes"))
    assert found == [
        (3, "'Close Holes' needs a layer; the document has none at this step; load one first")
    ]


def test_one_layer_cannot_have_two_roles(check):
    icp = "ICP Between Meshes"
    assert "needs two layers; the document has 1" in errors(check(on(MESH), icp))[0][1]
    same = (icp, layer("referencemesh", 1), layer("sourcemesh", 1))
    assert "needs two layers; got 1 as" in errors(check(on(MESH, MESH), same))[0][1]
    assert errors(check(on(MESH, MESH), icp)) == []


def test_the_control_mesh_must_be_the_current_layer(check):
    def projection(control):
        return (
            "MLS projection (APSS)",
            layer("controlmesh", control),
            layer("proxymesh", 1 - control),
        )

    assert "needs the current layer as 'controlmesh'; got 0" in errors(
        check(on(MESH, MESH), projection(0))
    )[0][1]  # fmt: skip
    assert errors(check(on(MESH, MESH), projection(1))) == []


def test_what_another_layer_lacks(check):
    step = ("Transfer: Texture to Vertex Color (1 or 2 meshes)", layer("sourcemesh", 0))
    poor = replace(MESH, facts={**MESH.facts, "wedge_texture": False})
    assert (
        "needs texture coordinates of wedges in the layer that 'sourcemesh' names; layer 0"
        in (errors(check(on(poor, MESH), step))[0][1])
    )
    assert errors(check(on(MESH, poor), step)) == []


@pytest.mark.parametrize("facts", [{"faces": False}, {"faces": False, "edges": True}])
def test_a_wireframe_of_what_may_be_a_polyline_is_no_error(check, facts):
    assert check(on(LayerState(facts, "outline")), "Create Solid Wireframe") == ()


def test_a_layer_that_is_not_named_may_be_without_points(check):
    """The layers that these filters work on are others than the current one."""
    void = LayerState({"points": False, "faces": False}, "void")
    steps = [("Vertex Attribute Transfer", param("SourceMesh", 1, "RichMesh"),
        param("TargetMesh", 2, "RichMesh"))]  # fmt: skip
    assert errors(check(on(void, MESH, MESH), *steps)) == []
    ((_, message),) = errors(check(on(MESH, void, MESH), *steps))
    assert "needs points in the layer that 'sourcemesh' names; layer 1 has none" in message


# What hangs on numbers or on the shape is not certain, so the step behind it is not refused, and
# it is not said of it that nothing changes.
HANG_ON_SHAPE = [
    ([("Remove Vertices wrt Quality", param("MaxQualityThr", 0.1, "RichFloat"))], "Taubin Smooth"),
    (["Remove Vertices wrt Quality"], "Delete Selected Faces"),
    (["Geometric Cylindrical Unwrapping"], "Close Holes"),
    (["Close Holes"], "Delete Selected Faces"),
    (["Compute Topological Measures"], "Delete Selected Vertices"),
    (["Remove Isolated Folded Faces by Edge Flip"], "Delete Selected Faces"),
    (["Select All", "Vertex Attribute Seam"], "Delete Selected Vertices"),
    (["Select All", "Compute Topological Measures"], "Delete Selected Faces"),
]


@pytest.mark.parametrize(("steps", "last"), HANG_ON_SHAPE)
def test_what_hangs_on_the_shape_is_not_certain(check, steps, last):
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.create_grid(numvertx=4, numverty=4)
    mesh_set.compute_scalar_by_function_per_vertex(q="x")
    assert check(DocumentState.of(mesh_set), *steps, last) == ()


def test_what_a_filter_is_for_is_certain(check):
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.create_cube()
    state = DocumentState.of(mesh_set)
    assert len(errors(check(state, "Delete ALL Faces", "Taubin Smooth"))) == 1
    remark = check(state, "Select All", "Delete Selected Faces", "Delete Selected Faces")
    assert ["nothing changes" in found.message for found in remark] == [True]


def test_a_raster_is_needed_only_where_it_is_certain_that_there_is_none(check):
    name = "Rename Current Raster"
    assert "needs a raster" in errors(check(on(MESH, rasters=False), name))[0][1]
    assert errors(check(on(MESH), name)) == []


def test_values_that_never_end_are_found_before(check):
    steps = [("Compute normals for point sets", param("K", 0)),
        ("Dust Accumulation", param("draw_texture", "true", "RichBool"))]  # fmt: skip
    found = errors(check(on(CLOUD), *steps))
    assert [line for line, _ in found] == [2, 3]
    assert "must be at least 1" in found[0][1]


def test_an_error_does_not_make_others_up(check):
    """If the first step is mended there are normals, so the second is not called an error."""
    bare = replace(CLOUD, facts={**CLOUD.facts, "normals": False})
    poisson = "Surface Reconstruction: Screened Poisson"
    steps = (("Compute normals for point sets", param("K", 0)), poisson)
    assert [line for line, _ in errors(check(on(bare), *steps))] == [2]
    assert [line for line, _ in errors(check(on(bare), poisson))] == [2]
    assert errors(check(on(bare), "Compute normals for point sets", poisson)) == []


def test_nothing_is_certain_behind_an_unknown_filter(check):
    found = errors(check(on(CLOUD), "No Such Filter", UNREFERENCED, "Close Holes"))
    assert [line for line, _ in found] == [2]


def test_a_step_that_does_nothing_is_noted(check):
    bare = replace(MESH, facts={**MESH.facts, "face_selection": False})
    (found,) = check(on(bare), "Delete Selected Faces")
    assert (found.severity, found.remedy) == (REMARK, "")
    assert "selected faces, of which there are none" in found.message
    assert check(on(MESH), "Delete Selected Faces") == ()
    assert check(on(bare), "Select All", "Delete Selected Faces") == ()


def test_findings_come_in_the_order_of_the_steps(check):
    found = check(on(CLOUD), "Remove Duplicated Vertex", UNREFERENCED, "No Such Filter")
    assert [(one.line, one.severity) for one in found] == [(2, NOTE), (3, ERROR), (4, ERROR)]


def test_an_unknown_document_gives_no_errors_at_all():
    """Whatever the filter, with its defaults."""
    from meshlab_symrecon.host.mlx import Step
    from meshlab_symrecon.host.resolution import ResolvedStep

    for item in native_filters().values():
        if item.python_name == "create_mesh_by_grammar":  # it aborts on every document
            continue
        step = ResolvedStep(Step(item.menu_name, 1), item)
        assert check_document([step], DocumentState.unknown()) == (), item.python_name


def test_a_whole_document_is_read_from_a_mesh_set(check):
    mesh_set = pymeshlab.MeshSet(verbose=False)
    points = np.random.default_rng(0).normal(size=(30, 3))
    mesh_set.add_mesh(pymeshlab.Mesh(vertex_matrix=points), "scan")
    found = errors(check(DocumentState.of(mesh_set), UNREFERENCED, "Close Holes"))
    assert [line for line, _ in found] == [2, 3]
    assert "the 30 points of layer 'scan'" in found[0][1]
