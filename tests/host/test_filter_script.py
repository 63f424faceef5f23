"""A script as an object: read, checked, edited, written, run."""

from __future__ import annotations

import numpy as np
import pymeshlab
import pytest

import meshlab_symrecon
from meshlab_symrecon.errors import ParameterError, ScriptError, UnknownFilterError
from meshlab_symrecon.host.filter_script import FilterScript
from meshlab_symrecon.host.mlx import Param, Step
from meshlab_symrecon.host.native_filters import native_filters
from meshlab_symrecon.host.written_steps import written_step

SCALE = "compute_matrix_from_scaling_or_normalization"


@pytest.fixture
def sphere():
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.create_sphere(subdiv=2)
    return mesh_set


def test_a_script_is_built_written_read_and_run(tmp_path, installed, sphere):
    script = (
        FilterScript()
        .with_step(SCALE, axisx=0.1234567890123456, uniformflag=True)
        .with_step("generate_grown_points", factor=2.0)
    )
    script.write(tmp_path / "made.mlx")
    again = meshlab_symrecon.FilterScript.read(tmp_path / "made.mlx")
    assert again.steps == script.steps
    assert [step.name for step in again] == ["Transform: Scale, Normalize", "Grow Points"]
    assert again.check() == ()
    by_hand = pymeshlab.MeshSet(verbose=False)
    by_hand.create_sphere(subdiv=2)
    by_hand.apply_filter(SCALE, axisx=0.1234567890123456, uniformflag=True)
    report = again.run(sphere)
    assert [step.status for step in report.steps] == ["ran", "ran"]
    np.testing.assert_array_equal(
        sphere.mesh(0).vertex_matrix(), by_hand.current_mesh().vertex_matrix()
    )


def test_steps_are_inserted_changed_and_removed_in_new_scripts(installed):
    script = FilterScript().with_step("Grow Points", factor=3.0).with_step(SCALE, axisx=2.0)
    wider = script.with_step("Close Holes", at=1, maxholesize=7)
    assert [step.name for step in wider] == [
        "Grow Points", "Close Holes", "Transform: Scale, Normalize",
    ]  # fmt: skip
    changed = wider.with_values(1, maxholesize=9, selected=True).with_values(0, factor=4.0)
    texts = {param.name: param.text for param in changed[1].parameters}
    assert texts == {"MaxHoleSize": "9", "Selected": "true"}
    assert {param.name: param.text for param in changed[0].parameters}["factor"] == "4.0"
    assert changed.without_step(-1).without_step(0).steps == (changed[1],)
    assert len(script) == 2  # as it was
    assert wider[1].parameters[0].text == "7"


def test_positions_names_and_values_are_checked(installed):
    script = FilterScript().with_step("Grow Points")
    with pytest.raises(ScriptError, match="has 1 steps, counted from 0; got position 1"):
        script[1]
    with pytest.raises(ScriptError, match="got position -2"):
        script.without_step(-2)
    with pytest.raises(ScriptError, match="got position 2"):
        script.with_step("Close Holes", at=2)
    with pytest.raises(UnknownFilterError, match="did you mean 'Close Holes'"):
        script.with_step("Close Hole")
    with pytest.raises(ParameterError, match="maxholesize"):
        script.with_step("Close Holes", maxholesize="many")
    with pytest.raises(ParameterError, match="facter"):
        script.with_values(0, facter=2.0)


def test_findings_of_a_script_in_memory_name_the_step(installed):
    step = FilterScript().with_step("Close Holes", maxholesize=7)[0]
    broken = FilterScript((step, type(step)("No Such Filter", 0)))
    (finding,) = broken.check()
    assert str(finding).startswith("script: step 2: no filter is called 'No Such Filter'")


def test_a_script_is_checked_against_a_document(sphere):
    script = FilterScript().with_step("get_hausdorff_distance", sampledmesh=0, targetmesh=1)
    assert script.check() == ()
    (finding,) = script.check(sphere)
    assert "'targetmesh' must be the position of a layer" in str(finding)
    sphere.create_cube()
    assert script.check(sphere) == ()


def values_of_every_type(parameter):
    return {
        "RichBool": True,
        "RichInt": 3,
        "RichMesh": 0,
        "RichFloat": 0.1,
        "RichDynamicFloat": 0.1,
        "RichAbsPerc": 0.1,
        "RichEnum": parameter.words[-1] if parameter.words else None,
        "RichString": "x y",
        "RichOpenFile": "a.ply",
        "RichSaveFile": "b.ply",
        "RichColor": [1, 2, 3, 4],
        "RichPosition": [1.5, -2.5, 1e-9],
        "RichDirection": [1.5, -2.5, 1e-9],
        "RichPoint3f": [1.5, -2.5, 1e-9],
        "RichMatrix44f": np.arange(16.0).reshape(4, 4) / 7.0,
    }[parameter.rich_type]


@pytest.mark.parametrize("item", native_filters().values(), ids=lambda item: item.python_name)
def test_every_native_step_is_read_back_to_the_last_bit(tmp_path, item):
    values = {
        parameter.name: values_of_every_type(parameter)
        for parameter in item.parameters
        if parameter.rich_type != "RichShotf"
    }
    step = written_step(item, values)
    FilterScript((step,)).write(tmp_path / "one.mlx")
    again = FilterScript.read(tmp_path / "one.mlx")
    assert again.steps == (step,)


def test_a_value_that_was_given_twice_is_given_once_when_it_is_changed():
    twice = tuple(Param("MaxHoleSize", 0, "RichInt", text) for text in ("3", "4"))
    script = FilterScript((Step("Close Holes", 0, (*twice, Param("Selected", 0, "", "true"))),))
    assert ["given twice" in str(found) for found in script.check()] == [True]
    changed = script.with_values(0, maxholesize=5)
    assert [param.text for param in changed[0].parameters] == ["5", "true"]
    assert changed.check() == ()
    assert script.with_values(0, selected=False)[0].parameters[:2] == twice


COMMENTED = """<!-- by hand -->
<FilterScript>
 <filter name="Close Holes"/>
 <!-- small ones -->
 <filter name="Taubin Smooth"><!-- twice --></filter>
 <filter name="Compact faces"/>
 <!-- the end -->
</FilterScript>
"""


@pytest.fixture
def commented(tmp_path):
    path = tmp_path / "commented.mlx"
    path.write_text(COMMENTED)
    return FilterScript.read(path)


def placed(script, path):
    """Return the comments above each step, and after the last, as they are written and read."""
    script.write(path)
    again = FilterScript.read(path)
    assert again.steps == script.steps
    return [[text.strip() for text in again.comments.get(n, ())] for n in range(len(again) + 1)]


def test_comments_stay_with_their_steps(commented, tmp_path):
    path = tmp_path / "out.mlx"
    assert placed(commented, path) == [["by hand"], ["small ones", "twice"], [], ["the end"]]
    first = path.read_bytes()
    placed(FilterScript.read(path), path)
    assert path.read_bytes() == first
    name = "Invert Selection"
    assert placed(commented.with_values(1, stepsmoothnum=3), path) == placed(commented, path)
    for position, wanted in {
        0: [[], ["by hand"], ["small ones", "twice"], [], ["the end"]],
        1: [["by hand"], [], ["small ones", "twice"], [], ["the end"]],
        2: [["by hand"], ["small ones", "twice"], [], [], ["the end"]],
        None: [["by hand"], ["small ones", "twice"], [], ["the end"], []],
    }.items():
        assert placed(commented.with_step(name, at=position), path) == wanted
    for position, wanted in {
        0: [["by hand", "small ones", "twice"], [], ["the end"]],
        1: [["by hand"], [], ["the end"]],
        -1: [["by hand"], ["small ones", "twice"], ["the end"]],
    }.items():
        assert placed(commented.without_step(position), path) == wanted
    inserted = commented.with_step(name, at=1).without_step(1)
    assert placed(inserted, path) == placed(commented, path)
    assert placed(commented, path)[0] == ["by hand"]  # as it was


def test_comments_are_no_part_of_the_comparison_and_are_explained(commented):
    bare = FilterScript(commented.steps, commented.path)
    assert bare == commented
    assert hash(bare) == hash(commented)
    assert "Its comment: small ones" in commented.explained()
    assert "Its comment" not in bare.explained()


def test_an_upgraded_script_keeps_its_comments_and_says_what_changed(commented, tmp_path):
    path = tmp_path / "new.mlx"
    new = commented.upgraded()
    left_out = "line 6: 'Compact faces' left out: MeshLab does this by itself today"
    assert placed(new, path) == [["by hand"], ["small ones", "twice"], [left_out, "the end"]]
    assert placed(new.upgraded(), path) == placed(new, path)
    assert placed(commented.native_only(), path)[0][0] == "by hand"
