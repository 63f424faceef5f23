"""Written steps and values, of any version, matched with the filters of today."""

from __future__ import annotations

from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np
import pymeshlab
import pytest

from meshlab_symrecon.errors import ScriptError
from meshlab_symrecon.host.findings import ERROR, IGNORE, NOTE, SKIP
from meshlab_symrecon.host.mlx import Param, Script, Step
from meshlab_symrecon.host.mlx_reading import read_script
from meshlab_symrecon.host.mlx_writing import write_script
from meshlab_symrecon.host.native_filters import find_native, native_filters
from meshlab_symrecon.host.native_values import checked_value
from meshlab_symrecon.host.resolution import matched, resolve_script
from meshlab_symrecon.host.written_steps import written_step

SCRIPT = Path("scan.mlx")
MERGE, DEPTH, BORDER = "Merge Close Vertices", "Depth Smooth", "Select Border"
TAUBIN = "Taubin Smooth"


def param(name, text=None, rich_type="", **attributes):
    return Param(name, 7, rich_type, text, attributes)


def resolved(name, *parameters):
    (step,) = resolve_script(Script(SCRIPT, (Step(name, 3, parameters),)))
    return step


def values(name, *parameters):
    """Return what is given to the filter, and what is said of it."""
    step = resolved(name, *parameters)
    given = {}
    for parameter, value in step.values.items():
        if isinstance(value, pymeshlab.PureValue):
            value = value.value()
        given[parameter] = value.tolist() if isinstance(value, np.ndarray) else value
    return given, tuple(str(note) for note in step.notes)


def mistakes(name, *parameters):
    """Return every mistake; a note is none."""
    findings = matched(Script(SCRIPT, (Step(name, 3, parameters),))).findings
    return [str(finding) for finding in findings if finding.severity == ERROR]


RANGE = {"min": "0", "max": "3"}
AT = {"x": "1", "y": "2", "z": "3"}
WORDS = {"enum_val0": "X axis", "enum_val1": "Y axis", "enum_val2": "Z axis"}


@pytest.mark.parametrize(
    ("name", "parameter", "given"),
    [
        # Whole numbers.
        ("Close Holes", param("MaxHoleSize", "30", "RichInt"), {"maxholesize": 30}),
        ("Close Holes", param("MaxHoleSize", "30"), {"maxholesize": 30}),
        ("Close Holes", param("MaxHoleSize", " 30.0 ", "RichFloat"), {"maxholesize": 30}),
        ("Close Holes", param("maxholesize", "30.f", "RichFloat"), {"maxholesize": 30}),
        ("Close Holes", param("MAXHOLESIZE ", "+30", "RichString"), {"maxholesize": 30}),
        # Booleans.
        ("Close Holes", param("Selected", "TRUE ", "RichBool"), {"selected": True}),
        ("Close Holes", param("Selected", "False", ""), {"selected": False}),
        ("Close Holes", param("Selected", "1", "RichInt"), {"selected": True}),
        ("Close Holes", param("Selected", "0", "RichMesh"), {"selected": False}),
        # Numbers.
        (TAUBIN, param("lambda", "0.12345678901234567"), {"lambda_": 0.12345678901234567}),
        (TAUBIN, param("lambda", " .5 ", "RichInt"), {"lambda_": 0.5}),
        (TAUBIN, param("lambda", "-5e-1f", "RichFloat"), {"lambda_": -0.5}),
        (TAUBIN, param("lambda", "1", "RichDynamicFloat", **RANGE), {"lambda_": 1.0}),
        # Lengths: absolute, with or without a range, of any of their types.
        (MERGE, param("Threshold", "0.5", "RichAbsPerc", **RANGE), {"threshold": 0.5}),
        (MERGE, param("Threshold", "0.5", "RichAbsPerc"), {"threshold": 0.5}),
        (MERGE, param("Threshold", "0.5", "RichPercentage", **RANGE), {"threshold": 0.5}),
        (MERGE, param("Threshold", "2.5e-1", "RichFloat"), {"threshold": 0.25}),
        # Positions and directions.
        (DEPTH, param("viewPoint", None, "RichPoint3f", **AT), {"viewpoint": [1, 2, 3]}),
        (DEPTH, param("viewPoint", "0", "RichPosition", **AT), {"viewpoint": [1, 2, 3]}),
        (DEPTH, param("viewPoint", None, "", x="1,5", y="2f", z="3"), {"viewpoint": [1.5, 2, 3]}),
        (DEPTH, param("viewPoint", "1;2;3", "RichPoint3f"), {"viewpoint": [1, 2, 3]}),
        (DEPTH, param("viewPoint", "1, 2, 3"), {"viewpoint": [1, 2, 3]}),
        (DEPTH, param("viewPoint", "1,2,3"), {"viewpoint": [1, 2, 3]}),
        (DEPTH, param("viewPoint", "[1 2 3]"), {"viewpoint": [1, 2, 3]}),
        # Choices: by number, by word, by the word that the script lists.
        ("Transform: Rotate", param("rotAxis", "2", "RichEnum", **WORDS), {"rotaxis": "Z axis"}),
        ("Transform: Rotate", param("rotAxis", "2", "RichEnum"), {"rotaxis": "Z axis"}),
        ("Transform: Rotate", param("rotAxis", "2.00", "RichInt"), {"rotaxis": "Z axis"}),
        ("Transform: Rotate", param("rotAxis", " z AXIS"), {"rotaxis": "Z axis"}),
        ("Transform: Rotate", param("rotAxis", "true", "RichBool"), {"rotaxis": "Y axis"}),
        # Text, which keeps its blanks.
        ("Rename Current Mesh", param("newName", " a  b ", "RichString"), {"newname": " a  b "}),
        ("Rename Current Mesh", param("newName", "", "RichString"), {"newname": ""}),
        # A layer's position.
        ("Hausdorff Distance", param("SampledMesh", "1.000000", "RichMesh"), {"sampledmesh": 1}),
    ],
)  # fmt: skip
def test_values_are_read_as_what_the_parameter_is_today(name, parameter, given):
    assert values(name, parameter) == (given, ())


@pytest.mark.parametrize(
    ("name", "parameter", "words"),
    [
        ("Close Holes", param("MaxHoleSize", "30.5"), "must be a whole number; got '30.5'"),
        ("Close Holes", param("MaxHoleSize", "1e99"), "must be a whole number; got '1e99'"),
        ("Close Holes", param("MaxHoleSize", str(2**31)), f"must be a whole number; got {2**31}"),
        ("Close Holes", param("MaxHoleSize", "nan"), "must be a whole number; got 'nan'"),
        ("Close Holes", param("MaxHoleSize", "true"), "must be a whole number; got 'true'"),
        ("Close Holes", param("Selected", "yes"), "must be true or false; got 'yes'"),
        ("Close Holes", param("Selected"), "has no attribute 'value'; write value"),
        (TAUBIN, param("lambda", "1e999"), "must be a number; got"),
        (TAUBIN, param("lambda", "inf"), "must be a number; got"),
        (TAUBIN, param("lambda", "1,2,3"), "must be a number; got '1,2,3'"),
        (TAUBIN, param("lambda", "1_000"), "must be a number; got '1_000'"),
        (TAUBIN, param("lambda", "\u0661"), "must be a number; got"),
        ("Close Holes", param("MaxHoleSize", "1_0"), "must be a whole number; got '1_0'"),
        ("Transform: Rotate", param("rotAxis", "\u0661"), "must be one of 'X axis'"),
        (TAUBIN, param("lambda", "f"), "must be a number; got 'f'"),
        (TAUBIN, param("lambda", ""), "must be a number; got ''"),
        (DEPTH, param("viewPoint", "1 2"), "must be 3 numbers; got"),
        (DEPTH, param("viewPoint", None, "", x="1", y="2"), "no attribute 'z'; write all"),
        ("Transform: Rotate", param("rotAxis", "7"), "must be one of 'X axis', 'Y axis'"),
        ("Transform: Rotate", param("rotAxis", "-1"), "must be one of 'X axis', 'Y axis'"),
        ("Transform: Rotate", param("rotAxis", "W axis"), "must be one of 'X axis', 'Y axis'"),
        ("Hausdorff Distance", param("SampledMesh", "-1"), "must be a layer's position; got -1"),
        ("Close Holes", param("MaxHole", "3"), "unknown parameter 'MaxHole' of 'Close Holes'"),
        ("CSG Operation", param("Operator", "3"), "parameter 'operator' must be one of 'Inters"),
    ],
)  # fmt: skip
def test_values_that_stand_for_nothing(name, parameter, words):
    (mistake,) = mistakes(name, parameter)
    assert mistake.startswith(("scan.mlx:7: ", "scan.mlx:3: "))
    assert words in mistake


@pytest.mark.parametrize("rich_type", ["RichFloat", ""])
def test_a_decimal_comma_is_told(rich_type):
    """It might have stood between thousands."""
    given, notes = values(TAUBIN, param("lambda", " 0,5", rich_type))
    assert given == {"lambda_": 0.5}
    assert notes == ("scan.mlx:7: '0,5' of parameter 'lambda' is read with a decimal comma",)


def test_a_row_of_sixteen_and_a_colour():
    attributes = {f"val{number}": str(number / 2) for number in range(16)}
    given, _ = values("Matrix: Set/Copy Transformation",
                      param("TransformMatrix", None, "RichMatrix44f", **attributes))  # fmt: skip
    assert given == {"transformmatrix": (np.arange(16).reshape(4, 4) / 2).tolist()}
    for colour in (
        param("color1", None, "RichColor", r="255", g="0", b="51", a="7"),
        param("color1", "255 0 51 7", "RichColor"),
        param("color1", "255.0;0;51;7"),
    ):
        found = resolved("Vertex Color Filling", colour).values["color1"]
        assert (found.red(), found.green(), found.blue(), found.alpha()) == (255, 0, 51, 7)


NOW = "scan.mlx:3: "
HERE = "scan.mlx:7: "


@pytest.mark.parametrize(
    ("name", "parameters", "filter_name", "given", "notes"),
    [
        (
            "Transform: Move, Translate, Center",
            [param("centerFlag", "true"), param("ToAll", "true")],
            "compute_matrix_from_translation",
            {"traslmethod": "Center on Layer BBox", "alllayers": True},
            [
                NOW + "'Transform: Move, Translate, Center' is 'Transform: Translate, Center, set "
                "Origin' today",
                HERE + "'true' of parameter 'centerFlag' is 'Center on Layer BBox' of "
                "'traslmethod' today",
                HERE + "parameter 'ToAll' is 'alllayers' today",
            ],
        ),
        (
            "Transform: Move, Translate, Center",
            [param("axisX", "2"), param("centerFlag", "0")],
            "compute_matrix_from_translation",
            {"axisx": 2.0},
            [None, HERE + "parameter 'centerFlag' ignored: 'false' says nothing today"],
        ),
        (
            "Surface Reconstruction: Poisson",
            [param("OctDepth", "9"), param("SolverDivide", "6"), param("SamplesPerNode", "1"),
             param("Offset", "1")],
            "generate_surface_reconstruction_screened_poisson",
            {"depth": 9, "samplespernode": 1.0},
            [
                None,
                HERE + "parameter 'OctDepth' is 'depth' today",
                HERE + "parameter 'SolverDivide' ignored: it is gone from 'Surface "
                "Reconstruction: Screened Poisson'",
                HERE + "parameter 'Offset' ignored: it is gone from 'Surface Reconstruction: "
                "Screened Poisson'",
            ],
        ),
        (
            "Repair non Manifold Edges by splitting vertices",
            [],
            "meshing_repair_non_manifold_edges",
            {"method": "Split Vertices"},
            [None, NOW + "'method' set to 'Split Vertices', which the old name stood for"],
        ),
        (
            "Remove T-Vertices by Edge Flip",
            [param("Threshold", "30"), param("Repeat", "false")],
            "meshing_remove_t_vertices",
            {"method": "Edge Flip", "threshold": 30.0, "repeat": False},
            [None, None],
        ),
        (
            "Recompute Angle Weighted Vertex Normals",
            [],
            "compute_normal_per_vertex",
            {"weightmode": "By Angle"},
            [None, None],
        ),
        (
            "Variable density Disk Sampling",
            [param("RadiusVariance", "3")],
            "generate_sampling_poisson_disk",
            {"radiusvariance": 3.0},
            [None, None],
        ),
        (
            "CSG Operation",
            [param("FirstMesh", "0"), param("SecondMesh", "1"), param("Delta", "0.1"),
             param("Operator", "2", enum_val0="Intersection", enum_val1="Union",
                   enum_val2="Difference")],
            "generate_boolean_difference",
            {"first_mesh": 0, "second_mesh": 1},
            [NOW + "'CSG Operation' is 'Mesh Boolean: Difference' today", None, None, None, None],
        ),
        ("CSG Operation", [param("Operator", "union")], "generate_boolean_union", {}, [None, None]),
        ("CSG Operation", [], "generate_boolean_intersection", {}, [None]),
        (
            "Crease Marking with NonFaux Edges",
            [param("AngleDeg", "45")],
            "compute_selection_crease_per_edge",
            {"angledegneg": -45.0, "angledegpos": 45.0},
            [None, HERE + "parameter 'AngleDeg' is 'angledegneg' -45 and 'angledegpos' 45 today"],
        ),
        *(
            (
                f"Simplification: Quadric Edge Collapse Decimation{textured}",
                [param("PlanarSimplification", "true")],
                f"meshing_decimation_quadric_edge_collapse{textured and '_with_texture'}",
                {},
                [
                    HERE + "parameter 'PlanarSimplification' ignored: MeshLab has no such "
                    "parameter; 'PlanarQuadric' has that label"
                ],
            )
            for textured in ("", " (with texture)")
        ),
        (
            "Convex Hull",
            [param("reorient", "true")],
            "generate_convex_hull",
            {},
            [HERE + "parameter 'reorient' ignored: it is gone from 'Convex Hull'"],
        ),
        (
            "Conditional Vertex Selection",
            [param("condSelect", "(x < 0)"), param("strictSelect", "true")],
            "compute_selection_by_condition_per_vertex",
            {"condselect": "(x < 0)"},
            [
                HERE + "parameter 'strictSelect' is 'Select Faces from Vertices', which runs after "
                "this filter"
            ],
        ),
        (
            "Vertex Color to Texture",
            [param("textName", "a.png"), param("assign", "false")],
            "compute_texmap_from_color",
            {"textname": "a.png"},
            [None, None],
        ),
        (BORDER, [param("Iteration", "1")], "compute_selection_from_mesh_border", {}, [None]),
        (
            "Clustering decimation",
            [param("Selected", "false")],
            "meshing_decimation_clustering",
            {},
            [None, None],
        ),
        (
            "Repair non-manifold edges",
            [],
            "meshing_repair_non_manifold_edges",
            {},
            [NOW + "'Repair non-manifold edges' is 'Repair non Manifold Edges' today"],
        ),
    ],
)  # fmt: skip
def test_what_old_steps_are_today(name, parameters, filter_name, given, notes):
    step = resolved(name, *parameters)
    found, said = values(name, *parameters)
    assert step.python_name == filter_name
    assert found == given
    assert len(said) == len(notes)
    for words, expected in zip(said, notes, strict=True):
        assert expected is None or words == expected


@pytest.mark.parametrize("name", ["MeshLab menu", "python"])
def test_spellings_of_today_need_no_note(name):
    item = find_native("meshing_close_holes")
    written = item.menu_name if name != "python" else item.python_name
    for spelling in (written, written.upper(), f" {written} "):
        assert resolved(spelling).python_name == item.python_name
    assert resolved(written).notes == ()


def test_words_of_a_choice_that_were_renumbered():
    """The word that the script lists counts, not its number today."""
    listed = {"enum_val0": "Barycenter", "enum_val1": "Origin"}
    given, notes = values("Transform: Rotate", param("rotCenter", "0", "RichEnum", **listed))
    assert given == {"rotcenter": "barycenter"}
    assert notes == (HERE + "0 of parameter 'rotCenter' was 'Barycenter', which is 1 today",)


def test_words_of_a_choice_that_were_renamed():
    listed = {"enum_val0": "axis of X", "enum_val1": "axis of Y"}
    given, notes = values("Transform: Rotate", param("rotAxis", "1", "RichEnum", **listed))
    assert given == {"rotaxis": "Y axis"}
    assert notes == (HERE + "1 of parameter 'rotAxis' was 'axis of Y', 'Y axis' today",)
    beyond = {f"enum_val{number}": f"word {number}" for number in range(9)}
    assert "must be one of" in mistakes("Transform: Rotate", param("rotAxis", "8", **beyond))[0]


@pytest.mark.parametrize("name", ["mesh", "layer", "Mesh "])
def test_the_current_layer_by_either_name(name):
    step = resolved("Change the current layer", param(name, "2.0", "RichMesh"))
    assert (step.filter, step.values, step.layers) == ("set_current_mesh", {"mesh": 2}, ("mesh",))


def test_a_texture_that_old_scripts_made_on_the_way(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    parameters = (param("textName", "a.png"), param("textDim", "512"))
    given, notes = values("Set Texture", *parameters)
    assert given == {"textname": "a.png", "use_dummy_texture": True, "dummy_img_size": 512}
    assert notes == (
        HERE + "'use_dummy_texture' set to True, which parameter 'textDim' stood for",
        HERE + "parameter 'textDim' is 'dummy_img_size' today",
    )
    Path("a.png").touch()
    assert values("Set Texture", *parameters)[0] == {"textname": "a.png", "dummy_img_size": 512}


def test_layers_are_named_once():
    step = resolved("Hausdorff Distance", param("TargetMesh", "0"), param("SampledMesh", "1"))
    assert step.layers == ("sampledmesh", "targetmesh")


def test_filters_that_draw_are_refused_under_old_names_too():
    for name in ("Ambient Occlusion", "ambient_occlusion", "snapshot"):
        (mistake,) = mistakes(name)
        assert "draws with OpenGL" in mistake


EXAMPLES = {
    "RichBool": [True, False],
    "RichInt": [0, -7, 2**31 - 1],
    "RichFloat": [0.1, -1.5e-7, 123456.789],
    "RichDynamicFloat": [0.3, 1 / 3],
    "RichAbsPerc": [0.1, 1 / 3],
    "RichString": ["", " <a> & \"b\" 'c'\t\n", "größe"],
    "RichPosition": [[0.1, -2.0, 1 / 3]],
    "RichDirection": [[0.0, 1.0, -0.1]],
    "RichMatrix44f": [(np.arange(16.0).reshape(4, 4) / 7).tolist()],
    "RichColor": [[1, 2, 3, 4], [255, 0, 51, 255]],
}
TYPED = {
    parameter.rich_type: (item, parameter)
    for item in native_filters().values()
    for parameter in item.parameters
    if not (item.display or item.probed)
}


def plain(value):
    if isinstance(value, pymeshlab.PureValue):
        return value.value()
    if isinstance(value, pymeshlab.Color):
        return [value.red(), value.green(), value.blue(), value.alpha()]
    return value.tolist() if isinstance(value, np.ndarray) else value


@pytest.mark.parametrize(
    ("rich_type", "value"),
    [(kind, value) for kind, examples in EXAMPLES.items() for value in examples],
)
def test_values_come_back_from_a_written_script(tmp_path, rich_type, value):
    """Write, read, resolve: the same value, to the last bit that pymeshlab keeps of it."""
    item, parameter = TYPED[rich_type]
    path = tmp_path / "a.mlx"
    write_script([written_step(item, {parameter.name: value})], path)
    written = read_script(path)
    (step,) = resolve_script(written)
    assert plain(step.values[parameter.name]) == plain(checked_value(parameter, value))
    assert step.notes == ()
    again = tmp_path / "b.mlx"
    write_script(written.steps, again)
    assert read_script(again).steps == written.steps
    assert again.read_bytes() == path.read_bytes()


def test_every_rich_type_of_today_has_its_examples():
    assert set(TYPED) - {"RichMesh", "RichEnum", "RichShotf"} == set(EXAMPLES)


CHOICES = [
    (item.python_name, parameter.name)
    for item in native_filters().values()
    for parameter in item.parameters
    if parameter.words
]


@pytest.mark.parametrize(("name", "parameter"), CHOICES)
def test_every_choice_by_its_number_and_its_word(name, parameter):
    item = find_native(name)
    if item.display:
        assert mistakes(name)
        return
    words = item.find(parameter).words
    listed = {f"enum_val{number}": word for number, word in enumerate(words)}
    for number, word in enumerate(words):
        for written in (
            param(parameter, str(number)),
            param(parameter, word.upper()),
            param(parameter, str(number), "RichEnum", **listed),
        ):
            assert resolved(name, written).values == {parameter: word}
            assert resolved(name, written).notes == ()


def test_written_scripts_are_those_of_pymeshlab(tmp_path):
    """pymeshlab reads what we write: names, and values to the digits that it keeps."""
    steps = [
        written_step(find_native("apply_coord_taubin_smoothing"), {"lambda_": 0.4}),
        written_step(find_native("meshing_merge_close_vertices"), {"threshold": 0.25}),
        written_step(find_native("set_mesh_name"), {"newname": "a < b"}),
        written_step(find_native("compute_matrix_from_rotation"), {"rotaxis": "Z axis"}),
    ]
    path, saved = tmp_path / "a.mlx", tmp_path / "b.mlx"
    write_script(steps, path)
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.load_filter_script(str(path))
    mesh_set.save_filter_script(str(saved))
    ours, theirs = read_script(path).steps, read_script(saved).steps
    assert [step.name for step in theirs] == [step.name for step in ours]
    for step, copy in zip(
        resolve_script(Script(path, ours)), resolve_script(Script(saved, theirs)), strict=True
    ):
        for name, value in step.values.items():
            kept = plain(copy.values[name])
            if isinstance(value, str | bool):
                assert kept == value
            else:
                assert np.allclose(kept, plain(value), rtol=1e-5, atol=0)


def test_notes_are_in_the_order_of_the_lines(tmp_path):
    path = tmp_path / "scan.mlx"
    path.write_text(
        "<FilterScript>\n<filter name='Box'>\n<Param name='size' value='2'/>\n</filter>\n"
        f"<filter name={quoteattr('Geometric Function')}/>\n</FilterScript>",
        encoding="utf-8",
    )
    findings = matched(read_script(path)).findings
    assert [(finding.line, finding.severity) for finding in findings] == [(2, NOTE), (5, NOTE)]


UNSOUND = """<FilterScript>
<filter name="Remove Duplicated Vertex"/>
<filter/>
<xmlfilter name=" "><xmlparam value="1"/></xmlfilter>
<filter name="Close Holes"><Param type="RichInt" name="MaxHoleSize" value="30"/>
<Param type="RichBool" name="Selected" value="TRUE "/>
<Param type="RichBool" name="selected" value="true"/>
<Param type="RichInt" name="maxholesize " value="40"/>
<Param type="RichInt" value="40"/></filter>
<filter name="Grow Points"><Param name="factor" value="3"/>
<Param name="Factor" value="4"/></filter>
<filter name="Close Hole"/>
</FilterScript>"""


def test_what_has_no_name_or_two_values_is_found_beside_everything_else(tmp_path, installed):
    path = tmp_path / "old.mlx"
    path.write_text(UNSOUND)
    matching = matched(read_script(path))
    told = [(found.line, found.step, found.severity, found.remedy) for found in matching.findings]
    assert told == [
        (2, 0, NOTE, ""), (3, 1, ERROR, SKIP), (4, 2, ERROR, IGNORE), (4, 2, ERROR, SKIP),
        (8, 3, ERROR, IGNORE), (9, 3, ERROR, IGNORE), (11, 4, ERROR, IGNORE), (12, 5, ERROR, SKIP),
    ]  # fmt: skip
    words = [found.message for found in matching.findings[1:-1]]
    assert words == [
        'this <filter> has no name; write name="..."',
        'this parameter has no name; write name="..."',
        'this <xmlfilter> has no name; write name="..."',
        "parameter 'maxholesize ' is given twice, with different values; keep one",
        'this parameter has no name; write name="..."',
        "parameter 'Factor' is given twice, with different values; keep one",
    ]
    holes, grown = matching.steps[3:5]
    assert holes.values == {"maxholesize": 30, "selected": True}  # the first of the two
    assert grown.values == {"factor": 3.0}
    with pytest.raises(ScriptError, match=f"{path}:3: this <filter> has no name"):
        resolve_script(read_script(path))
