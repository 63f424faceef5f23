"""MeshLab's own filters: every name is found, every value is checked and read from text."""

from __future__ import annotations

import json
import math
import re
from importlib.resources import files
from pathlib import Path

import numpy as np
import pymeshlab
import pytest

from meshlab_symrecon.errors import HostError, ParameterError, UnknownFilterError
from meshlab_symrecon.host.document_state import FACTS
from meshlab_symrecon.host.expectations import expectation
from meshlab_symrecon.host.native_filters import (
    apply_native,
    find_native,
    is_native,
    native_filters,
)
from meshlab_symrecon.host.native_values import NativeParameter, checked_value, parse_native
from meshlab_symrecon.host.translation import script_name_in_python, translated

# Asking pymeshlab for the parameters of these ends the process: they hold a camera.
HOLD_A_CAMERA = {"raster_alignment_mutual_information", "set_camera_per_raster"}


@pytest.fixture
def rich_set():
    """A document with everything that filters ask for when they compute their defaults."""
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.create_cube()
    mesh_set.compute_scalar_by_function_per_face(q="x0")
    mesh_set.compute_scalar_by_function_per_vertex(q="x")
    return mesh_set


def test_the_table_lists_exactly_the_filters_of_pymeshlab():
    assert list(native_filters()) == sorted(pymeshlab.filter_list())
    menus = {item.menu_name.lower() for item in native_filters().values()}
    assert len(menus) == len(native_filters())


def test_the_table_lists_exactly_the_parameters_of_every_filter(rich_set):
    for name, item in native_filters().items():
        if name not in HOLD_A_CAMERA:
            known = list(rich_set.filter_parameter_values(name))
            assert [parameter.name for parameter in item.parameters] == known, name


def test_defaults_of_every_filter_are_of_the_type_in_the_table(rich_set):
    for name, item in native_filters().items():
        if name in HOLD_A_CAMERA:
            continue
        defaults = rich_set.filter_parameter_values(name)
        for parameter in item.parameters:
            if parameter.rich_type == "RichEnum":
                assert defaults[parameter.name] in range(len(parameter.words))
            elif parameter.rich_type != "RichShotf":
                checked_value(parameter, defaults[parameter.name])


def test_every_filter_is_found_by_its_names():
    for item in native_filters().values():
        assert find_native(item.python_name) is item
        assert find_native(f"  {item.menu_name.upper().replace(' ', '  ')} ") is item
        assert is_native(item.menu_name)


def test_an_unknown_filter_is_answered_with_the_nearest_one():
    assert not is_native("create_cub")
    with pytest.raises(UnknownFilterError, match="did you mean 'create_cube'"):
        find_native("create_cub")


def test_parameters_are_found_by_both_names():
    item = find_native("meshing_decimation_quadric_edge_collapse")
    for name in ("targetfacenum", "TargetFaceNum", " TARGETFACENUM "):
        assert item.find(name).script_name == "TargetFaceNum"
    with pytest.raises(ParameterError, match=r"'targetfacenumb' of 'Simplif.*'targetfacenum'\?"):
        item.find("targetfacenumb")
    with pytest.raises(ParameterError, match=r"; known are size$"):
        find_native("create_cube").find("zzzz")
    with pytest.raises(ParameterError, match="this filter has no parameters"):
        find_native("create_icosahedron").find("size")


@pytest.mark.parametrize(
    ("written", "python"),
    [
        ("TargetFaceNum", "targetfacenum"),
        ("Num. of Rays: (+)", "num_of_rays_"),
        ("a/b-c d", "a_b_c_d"),
        ("class", "class_"),
        ("'x',\"y\"", "xy"),
    ],
)
def test_the_rule_for_names_of_parameters(written, python):
    assert script_name_in_python(written) == python


def parameter(rich_type):
    words = ("Center", "On Layer") if rich_type == "RichEnum" else ()
    return NativeParameter("p", "P", rich_type, words)


@pytest.mark.parametrize(
    ("rich_type", "value", "checked"),
    [
        ("RichBool", np.bool_(True), True),
        ("RichInt", 3.0, 3),
        ("RichInt", np.int64(4), 4),
        ("RichMesh", 2, 2),
        ("RichFloat", 2, 2.0),
        ("RichDynamicFloat", np.float32(0.5), 0.5),
        ("RichEnum", "on layer", "On Layer"),
        ("RichEnum", np.int64(0), "Center"),
        ("RichString", "x", "x"),
        ("RichOpenFile", Path("a", "b.ply"), str(Path("a", "b.ply"))),
    ],
)
def test_plain_values(rich_type, value, checked):
    got = checked_value(parameter(rich_type), value)
    assert (got, type(got)) == (checked, type(checked))


def test_lengths_are_absolute_unless_they_say_otherwise():
    length = checked_value(parameter("RichAbsPerc"), 0.25)
    assert isinstance(length, pymeshlab.PureValue)
    assert length.value() == 0.25
    for given in (pymeshlab.PercentageValue(3.0), pymeshlab.PureValue(3.0)):
        assert checked_value(parameter("RichAbsPerc"), given) is given


def test_rows_and_colours():
    np.testing.assert_array_equal(checked_value(parameter("RichPosition"), (1, 2, 3)), [1, 2, 3])
    matrix = np.arange(16.0).reshape(4, 4)
    np.testing.assert_array_equal(checked_value(parameter("RichMatrix44f"), matrix), matrix)
    for given, expected in (((1, 2, 3), [1, 2, 3, 255]), ((1, 2, 3, 4), [1, 2, 3, 4])):
        assert checked_value(parameter("RichColor"), given).to_array4().tolist() == expected
    same = pymeshlab.Color(1, 2, 3, 4)
    assert checked_value(parameter("RichColor"), same) is same


REFUSED = [
    ("RichBool", 1, "true or false"),
    ("RichInt", 2.5, "a whole number"),
    ("RichInt", True, "a whole number"),
    ("RichMesh", "0", "a layer's number"),
    ("RichFloat", math.nan, "a number"),
    ("RichFloat", "1", "a number"),
    ("RichDynamicFloat", math.inf, "a number"),
    ("RichAbsPerc", "5", "a length, or a percentage such as 5%"),
    ("RichEnum", "Centre", "one of 'Center', 'On Layer'"),
    ("RichEnum", 2, "one of 'Center', 'On Layer'"),
    ("RichEnum", True, "one of 'Center', 'On Layer'"),
    ("RichString", 1, "text"),
    ("RichSaveFile", b"x", "a file's path"),
    ("RichColor", "red", "3 or 4 numbers from 0 to 255"),
    ("RichColor", 7, "3 or 4 numbers from 0 to 255"),
    ("RichColor", (1, 2), "3 or 4 numbers from 0 to 255"),
    ("RichColor", (1, 2, 256), "3 or 4 numbers from 0 to 255"),
    ("RichPosition", (1, 2), "3 numbers"),
    ("RichDirection", "up", "3 numbers"),
    ("RichPoint3f", (1, 2, math.nan), "3 numbers"),
    ("RichMatrix44f", np.eye(3), "16 numbers, row by row"),
    ("RichShotf", "x", "left out, since pymeshlab takes no camera from Python"),
]


@pytest.mark.parametrize(("rich_type", "value", "wanted"), REFUSED)
def test_a_bad_value_is_refused(rich_type, value, wanted):
    with pytest.raises(ParameterError) as caught:
        checked_value(parameter(rich_type), value)
    assert str(caught.value) == f"parameter 'p' must be {wanted}; got {value!r:.80}"


@pytest.mark.parametrize(("sign", "digits"), [(1, 400), (-1, 5000)])
@pytest.mark.parametrize("rich_type", ["RichInt", "RichMesh", "RichFloat", "RichAbsPerc"])
def test_a_whole_number_that_no_float_holds_is_refused(rich_type, sign, digits):
    value = sign * 10**digits
    with pytest.raises(ParameterError, match="parameter 'p' must be") as caught:
        checked_value(parameter(rich_type), value)
    assert len(str(caught.value)) < 250


@pytest.mark.parametrize(
    ("rich_type", "value"),
    [
        ("RichColor", (1, 2, math.inf)),
        ("RichColor", (1, 2, 10**400)),
        ("RichPosition", (1, 2, 10**400)),
        ("RichMatrix44f", [10**400] * 16),
    ],
)
def test_rows_of_numbers_that_no_float_holds_are_refused(rich_type, value):
    with pytest.raises(ParameterError, match="parameter 'p' must be"):
        checked_value(parameter(rich_type), value)


@pytest.mark.parametrize(
    ("rich_type", "text", "value"),
    [
        ("RichBool", " True ", True),
        ("RichBool", "0", False),
        ("RichInt", " -3 ", -3),
        ("RichFloat", "1e-3", 0.001),
        ("RichEnum", "1", "On Layer"),
        ("RichEnum", "center", "Center"),
        ("RichString", " as it is ", " as it is "),
        ("RichSaveFile", "a b.ply", "a b.ply"),
    ],
)
def test_text_is_read(rich_type, text, value):
    assert parse_native(parameter(rich_type), text) == value


@pytest.mark.parametrize("text", ["1 2.5 -3", "1,2.5,-3", "[1; 2.5; -3]", " ( 1, 2.5, -3 ) "])
def test_positions_are_read(text):
    np.testing.assert_array_equal(parse_native(parameter("RichPosition"), text), [1.0, 2.5, -3.0])


def test_lengths_and_colours_are_read():
    percentage = parse_native(parameter("RichAbsPerc"), "5.5%")
    assert isinstance(percentage, pymeshlab.PercentageValue)
    assert percentage.value() == 5.5
    length = parse_native(parameter("RichAbsPerc"), "5.5")
    assert isinstance(length, pymeshlab.PureValue)
    for text in ("#0a141e", "10 20 30", "10,20,30,255"):
        colour = parse_native(parameter("RichColor"), text)
        assert colour.to_array4().tolist() == [10, 20, 30, 255]


@pytest.mark.parametrize(
    ("rich_type", "text"),
    [
        ("RichBool", "yes"),
        ("RichInt", "2.0"),
        ("RichFloat", "one"),
        ("RichFloat", "nan"),
        ("RichAbsPerc", "half%"),
        ("RichEnum", "7"),
        ("RichEnum", "9" * 5000),
        ("RichInt", "9" * 5000),
        ("RichFloat", "9" * 400),
        ("RichColor", "1 2 " + "9" * 400),
        ("RichPosition", "1 2"),
        ("RichColor", "#xyz"),
        ("RichMatrix44f", "1 0 0 1"),
    ],
)
def test_text_that_stands_for_nothing_is_refused(rich_type, text):
    with pytest.raises(ParameterError, match="parameter 'p' must be"):
        parse_native(parameter(rich_type), text)


def test_a_filter_runs_with_values_of_many_types(rich_set):
    apply_native(
        rich_set,
        "Transform: Translate, Center, set Origin",
        {"traslMethod": "xyz translation", "axisX": 2, "Freeze": True},
    )
    assert rich_set.current_mesh().bounding_box().min().tolist() == [1.5, -0.5, -0.5]
    apply_native(rich_set, "meshing_merge_close_vertices", {"threshold": 10.0})
    assert rich_set.current_mesh().vertex_number() == 1


def test_measures_come_back(rich_set):
    assert apply_native(rich_set, "get_geometric_measures", {})["mesh_volume"] == 1.0
    assert apply_native(rich_set, "create_cube", {}) == {}


def test_what_meshlab_refuses_becomes_one_sentence_of_ours(cloud_set):
    with pytest.raises(HostError) as caught:
        apply_native(cloud_set, "apply_coord_laplacian_smoothing", {})
    assert isinstance(caught.value.__cause__, pymeshlab.PyMeshLabException)
    assert "Any Faces" in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("raised", "becomes", "sentence"),
    [
        (pymeshlab.InvalidEnumException("Enum 'x'."), ParameterError, "step: Enum 'x'"),
        (
            pymeshlab.PyMeshLabException("Parameter x  not\nfound."),
            ParameterError,
            "step: Parameter x not found",
        ),
        (
            RuntimeError("Unable to cast Python instance of type"),
            ParameterError,
            "step: Unable to cast Python instance of type",
        ),
        (RuntimeError("no"), HostError, "step: no"),
        (RuntimeError(""), HostError, "step: MeshLab raised RuntimeError without a reason"),
        (
            pymeshlab.PyMeshLabException("Something really bad happened.\nPlease report"),
            HostError,
            "step: MeshLab failed without naming a reason; check the input of the filter",
        ),
    ],
)
def test_translation(raised, becomes, sentence):
    with pytest.raises(becomes) as caught, translated("step"):
        raise raised
    assert type(caught.value) is becomes
    assert str(caught.value) == sentence
    assert caught.value.__cause__ is raised


def test_our_own_errors_pass_the_translation():
    ours = ParameterError("mine")
    with pytest.raises(ParameterError) as caught, translated("step"):
        raise ours
    assert caught.value is ours


def test_every_filter_has_a_behaviour_with_known_facts():
    """One filter talks to a server, and was never tried."""
    table = json.loads(files("meshlab_symrecon.host").joinpath("native_filters.json").read_bytes())
    facts = {*FACTS, "layer", "raster", "selection"}
    untried = []
    for name, entry in table.items():
        seen = entry["behaviour"]
        if seen is None:
            untried.append(name)
            continue
        assert set(seen) == {"needs", "layers", "kept", "others", "made"}, name
        assert {need["fact"] for need in seen["needs"]} <= facts, name
        for fates in (seen["kept"], seen["others"], seen["made"]):
            assert set(fates or {}) <= set(FACTS), name
            assert all(re.fullmatch("[yn?]{2}", fate) for fate in (fates or {}).values()), name
    assert untried == ["export_mesh_to_sketchfab"]


def test_every_expectation_names_parameters_and_values_that_there_are():
    for item in native_filters().values():
        expected = expectation(item)
        given = [need.when for need in expected.needs]
        given += [values for need in expected.needs for values in need.unless]
        given += [values for values, _ in expected.exceptions]
        for values in given:
            for name, value in values.items():
                parameter = item.find(name)
                assert value in parameter.words if parameter.words else value in (False, True)
        assert expected.way.removed in ("none", "current", "all", "")
        assert expected.way.most is None or expected.way.most >= expected.way.added


def test_what_meshlab_itself_asks_for_is_in_the_table():
    """The needs of a few filters whose documentation says so."""
    needs = {item.python_name: expectation(item).needs for item in native_filters().values()}
    for name, fact in (
        ("meshing_close_holes", "faces"),
        ("apply_color_inverse_per_vertex", "vertex_colour"),
        ("compute_texcoord_transfer_wedge_to_vertex", "wedge_texture"),
        ("apply_scalar_clamping_per_vertex", "quality"),
        ("set_raster_name", "raster"),
    ):
        assert fact in [need.fact for need in needs[name] if need.applies({})], name
    assert sum("faces" in [need.fact for need in known] for known in needs.values()) > 60


def test_two_exceptions_at_once_were_never_tried():
    cut = expectation(find_native("generate_polyline_from_planar_section"))
    assert cut.way_with({}).added == 1
    assert cut.way_with({"createsectionsurface": True}).added == 2
    both = {"createsectionsurface": True, "splitsurfacewithsection": True}
    assert cut.way_with(both).most is None
