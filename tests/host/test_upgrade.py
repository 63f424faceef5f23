"""Old scripts in today's names: what is written, what is said, what is left out."""

from __future__ import annotations

import numpy as np
import pymeshlab
import pytest

from meshlab_symrecon.errors import ScriptError
from meshlab_symrecon.host.explanation import explained
from meshlab_symrecon.host.filter_script import FilterScript
from meshlab_symrecon.host.mlx import Param, Step
from meshlab_symrecon.host.mlx_reading import read_script
from meshlab_symrecon.host.mlx_writing import script_text, write_script
from meshlab_symrecon.host.native_only import (
    checked_for_the_window,
    for_the_window,
    without_plugins,
)
from meshlab_symrecon.host.python_script import python_script
from meshlab_symrecon.host.resolution import matched
from meshlab_symrecon.host.step_of_today import as_written
from meshlab_symrecon.host.upgrade import checked, upgraded

OLD = """<!DOCTYPE FilterScript>
<!-- for the head -->
<FilterScript>
 <filter name="Remove Duplicated Vertex"/>
 <filter name="Compact vertices"/>
 <filter name="Merge Close Vertices ">
  <Param type="RichFloat" value="0.02" min="0" name="Threshold" max="3.46"/> <!-- narrow -->
 </filter>
 <xmlfilter name="Screened Poisson Surface Reconstruction">
  <xmlparam name="depth" value="6"/>
 </xmlfilter>
 <filter name="Grow Points"><Param type="RichFloat" name="Factor" value="3"/></filter>
 <!-- the end -->
</FilterScript>
"""
NEW = """<!DOCTYPE FilterScript>
<FilterScript>
 <!-- for the head -->
 <!-- line 4: 'Remove Duplicated Vertex' is 'Remove Duplicate Vertices' today -->
 <filter name="Remove Duplicate Vertices" />
 <!-- line 5: 'Compact vertices' left out: MeshLab does this by itself today -->
 <!-- narrow -->
 <!-- line 6: was 'Merge Close Vertices ' -->
 <!-- line 7: parameter 'Threshold' was a RichFloat -->
 <filter name="Merge Close Vertices">
  <Param type="RichAbsPerc" name="Threshold" value="0.02" min="0.0" max="3.46" />
 </filter>
 <!-- line 9: was an <xmlfilter> -->
 <!-- line 9: 'Screened Poisson Surface Reconstruction' is 'Surface Reconstruction: Screened \
Poisson' today -->
 <!-- line 9: the layer that it makes becomes current; up to MeshLab 2016.12 the old one stayed \
current -->
 <filter name="Surface Reconstruction: Screened Poisson">
  <Param type="RichInt" name="depth" value="6" />
 </filter>
 <!-- line 12: written with their defaults: randomseed, mode, keep, title -->
 <filter name="Grow Points">
  <Param type="RichFloat" name="factor" value="3.0" />
  <Param type="RichInt" name="randomseed" value="0" />
  <Param type="RichEnum" name="mode" value="0" enum_cardinality="2" enum_val0="plain" \
enum_val1="Loud" />
  <Param type="RichBool" name="keep" value="false" />
  <Param type="RichString" name="title" value="grown" />
 </filter>
 <!-- the end -->
</FilterScript>
"""


@pytest.fixture
def script(tmp_path):
    """Return a function that writes a script and reads it."""

    def make(*steps, whole=""):
        path = tmp_path / "old.mlx"
        path.write_text(whole or "<FilterScript>\n" + "\n".join(steps) + "\n</FilterScript>\n")
        return read_script(path)

    return make


def today(script, **how):
    return upgraded(script, checked(script, **how))


def text_of(script, **how):
    new = today(script, **how)
    return script_text(new.steps, script.path, new.comments)


def merge(value, attributes='min="0" max="1"'):
    param = f'<Param type="RichAbsPerc" name="Threshold" value="{value}" {attributes}/>'
    return f'<filter name="Merge Close Vertices">{param}</filter>'


def test_everything_that_changed_is_said_above_its_step(script, installed):
    assert text_of(script(whole=OLD)) == NEW


def test_a_script_of_today_stays_as_it_is(script, installed):
    new = today(script(whole=NEW))
    assert new.unchanged
    assert not today(script(whole=OLD)).unchanged
    assert not today(script('<filter name="Close Holes "/>')).unchanged
    assert today(script('<filter name="Close Holes"/><!-- all -->')).unchanged


def test_comments_are_not_doubled_when_one_step_is_added(script, tmp_path):
    change = (
        '<filter name="Change the current layer"><Param type="RichMesh" name="mesh" value="0"/>'
    )
    first = text_of(script(change + "</filter>"))
    assert first.count("the current layer changes, by position") == 1
    longer = first.replace("</FilterScript>", '<filter name="Compact faces"/></FilterScript>')
    second = text_of(script(whole=longer))
    assert second.count("the current layer changes, by position") == 1
    assert "'Compact faces' left out" in second


@pytest.mark.parametrize(
    ("written", "value", "low", "high"),
    [
        (merge("0.02"), "0.02", "0.0", "1.0"),
        (merge("0.1000000000000000055", 'min="-5" max="3.46"'), "0.1", "-5.0", "3.46"),
        (merge("1e-7", ""), "1e-07", "0.0", "1.0"),
        (merge("4"), "4.0", "0.0", "8.0"),  # above its range
        (merge("4", 'min="0" max="nan"'), "4.0", "0.0", "8.0"),
        (merge("0", 'min="0" max="0"'), "0.0", "0.0", "1.0"),
        (merge("-2", 'min="0" max="wide"'), "-2.0", "-2.0", "1.0"),
    ],
)
def test_lengths_keep_their_value_and_a_sound_range(script, written, value, low, high):
    (step,) = today(script(written)).steps
    (param,) = step.parameters
    assert (param.text, dict(param.attributes)) == (value, {"min": low, "max": high})


def test_a_percentage_stays_one(script):
    (step,) = today(script(merge("5%"))).steps
    assert step.parameters[0].text == "5.0%"


def test_lengths_that_are_not_those_that_were_written():
    value = pymeshlab.PureValue(0.5)
    assert as_written(value, None) == 0.5
    assert as_written(value, Param("Threshold", 1, "RichAbsPerc", "0.75")) == 0.5
    narrow = pymeshlab.PureValue(0.1)
    assert narrow.value() != 0.1
    assert as_written(narrow, Param("Threshold", 1, "RichAbsPerc", " 0.1 ")) == 0.1


def test_names_of_parameters_that_the_table_has_in_lower_case_only_keep_theirs(script):
    param = '<Param type="RichMesh" name="ControlMesh" value="1"/>'
    (step,) = today(script(f'<filter name="MLS projection (APSS)">{param}</filter>')).steps
    assert step.parameters == (Param("ControlMesh", 0, "RichMesh", "1"),)


def test_other_untyped_steps_become_plain_filters(script):
    new = today(script('<xmlfilter name="Geometric Measures"/>'))
    assert new.steps == (Step("Compute Geometric Measures", 0),)


def test_mistakes_are_all_told(script):
    wrong = script(
        '<filter name="No Such Filter"/>',
        '<filter name="Close Holes"><Param type="RichInt" name="MaxHoleSize" value="x"/></filter>',
    )
    with pytest.raises(ScriptError, match=r"old.mlx:2: no filter.*\n.*old.mlx:3: parameter 'max"):
        checked(wrong)


def test_what_cannot_run_is_left_out_with_a_comment(script):
    wrong = script(
        '<filter name="No -- Such-"/>',
        '<filter name="Close Holes"><Param type="RichInt" name="MaxHoleSize" value="x"/></filter>',
    )
    text = text_of(wrong, lenient=True)
    assert "<!-- line 2: this step was left out: no filter is called 'No - - Such-'" in text
    assert (
        "<!-- line 3: left out: parameter 'maxholesize' must be a whole number; got 'x' -->" in text
    )
    assert text.count("<filter") == 1


@pytest.mark.parametrize("attributes", ['name="mesh" value="x"', 'name="which" value="1"'])
def test_a_change_to_no_layer_is_left_out(script, attributes):
    param = f'<Param type="RichMesh" {attributes}/>'
    wrong = script(f'<filter name="Change the current layer">{param}</filter>')
    assert today(wrong, lenient=True).steps == ()
    assert "MISTAKE" in explained(wrong, matched(wrong))
    assert "set_current_mesh" not in python_script(wrong, checked(wrong, lenient=True))


def test_comments_are_written_where_they_belong_and_made_safe(tmp_path):
    path = tmp_path / "a.mlx"
    steps = (Step("One", 0), Step("Two", 0))
    write_script(steps, path, {0: ["---"], 1: ["b", "c-"], 2: ["d"]})
    again = read_script(path)
    assert again.steps == steps
    assert again.comments == {0: ["- - - "], 1: ["b", "c- "], 2: ["d"]}
    with pytest.raises(ScriptError, match="XML cannot hold the character"):
        write_script(steps, path, {0: ["\x00"]})


def test_steps_of_plugins_are_left_out_of_native_scripts(script, installed):
    mixed = script('<filter name="Grow Points"/>', '<filter name="Close Holes"/>')
    for leave_out in (for_the_window, without_plugins):
        matching = leave_out(mixed, matched(mixed))
        assert [step and step.python_name for step in matching.steps] == [
            None,
            "meshing_close_holes",
        ]
        finding = matching.findings[0]
        assert str(finding).endswith(
            "old.mlx:2: 'Grow Points' left out: it is no filter of MeshLab's own"
        )
        new = upgraded(mixed, matching)
        assert [step.name for step in new.steps] == ["Close Holes"]
        assert "'Grow Points' left out" in new.comments[0][0]


@pytest.mark.parametrize("leave_out", [for_the_window, without_plugins])
@pytest.mark.parametrize("step", ['<filter name="Grow Points"/>', '<filter name="Compact faces"/>'])
def test_a_script_of_which_nothing_is_left(script, installed, leave_out, step):
    ours = script(step)
    with pytest.raises(ScriptError, match=r"old.mlx:1: no step that can run is a filt"):
        leave_out(ours, matched(ours))


@pytest.mark.parametrize("leave_out", [for_the_window, without_plugins])
def test_of_a_script_without_steps_nothing_is_left_out(script, leave_out):
    empty = script()
    assert leave_out(empty, matched(empty)).steps == ()
    assert upgraded(empty, leave_out(empty, matched(empty))).unchanged
    assert FilterScript().native_only().steps == ()


def test_the_layer_that_a_deletion_would_meet_in_the_window(script):
    poisson = '<filter name="Screened Poisson"/>'
    delete = '<filter name="Delete Current Mesh"/>'
    apart = script(poisson, '<filter name="Close Holes"/>', delete)
    assert all(
        finding.severity == "note" for finding in for_the_window(apart, matched(apart)).findings
    )
    kept = script(poisson, '<filter name="Compact faces"/>', delete)
    assert matched(kept).steps[0].keeps_current
    with pytest.raises(ScriptError, match=r"old.mlx:4: in MeshLab's window this deletes the lay"):
        checked_for_the_window(kept)
    new = upgraded(kept, checked_for_the_window(kept, lenient=True))
    assert [step.name for step in new.steps] == ["Surface Reconstruction: Screened Poisson"]


def test_the_window_gets_the_defaults_that_it_does_not_fill_in(script):
    plain = script('<filter name="Close Holes"><Param type="RichInt" name="MaxHoleSize" value="9"/>'
                   "</filter>")  # fmt: skip
    matching = checked_for_the_window(plain)
    assert [finding.message for finding in matching.findings] == [
        "not given, since chosen when it runs: Selected, RefineHoleEdgeLen; MeshLab's window "
        "may want it"
    ]
    (step,) = upgraded(plain, matching).steps
    assert {param.name: param.text for param in step.parameters} == {
        "MaxHoleSize": "9",
        "NewFaceSelected": "true",
        "SelfIntersection": "true",
        "RefineHole": "false",
    }


def test_the_object_has_all_of_it(script, installed, tmp_path):
    old = FilterScript.read(script('<filter name="Grow Points "/>', merge("0.02"),
                                   '<filter name="Zzz"/>').path)  # fmt: skip
    for refuse in (old.upgraded, old.native_only, old.to_python):
        with pytest.raises(ScriptError, match=r"old.mlx:4: no filter is called 'Zzz'"):
            refuse()
    assert [step.name for step in old.upgraded(lenient=True)] == [
        "Grow Points",
        "Merge Close Vertices",
    ]
    assert [step.name for step in old.native_only(lenient=True)] == ["Merge Close Vertices"]
    assert "ms.generate_grown_points()" in old.to_python(lenient=True)
    assert "MISTAKE: no filter is called 'Zzz'" in old.explained()
    percent = FilterScript().with_step(
        "meshing_merge_close_vertices", threshold=pymeshlab.PercentageValue(3)
    )
    with pytest.raises(ScriptError, match="script: step 1: parameter 'threshold' is a percent"):
        percent.native_only()
    assert percent.native_only(lenient=True).steps == (Step("Merge Close Vertices", 0),)


def test_scripts_made_in_memory_have_no_lines(installed):
    made = FilterScript((Step("Compact faces", 0), Step("Close Holes ", 0)))
    new = today(made._script)
    assert new.comments == {
        0: (" 'Compact faces' left out: MeshLab does this by itself today ", " was 'Close Holes ' ")
    }


def test_a_matrix_keeps_every_digit(script):
    numbers = np.random.default_rng(3).normal(size=16)
    attributes = " ".join(f'val{place}="{value!r}"' for place, value in enumerate(numbers.tolist()))
    param = f'<Param type="RichMatrix44f" name="TransformMatrix" {attributes}/>'
    (step,) = today(
        script(f'<filter name="Matrix: Set/Copy Transformation">{param}</filter>')
    ).steps
    written = [float(step.parameters[0].attributes[f"val{place}"]) for place in range(16)]
    assert written == numbers.tolist()


STRICT = """<filter name="Conditional Vertex Selection"><!-- mine -->
<Param type="RichString" name="condSelect" value="(z &gt; 0)"/>
<Param type="RichBool" name="strictSelect" value="{}"/></filter>"""


@pytest.mark.parametrize("word", ["true", "false"])
def test_what_an_old_parameter_did_is_a_step_of_its_own(script, word):
    old = script(STRICT.format(word), '<filter name="Delete Selected Faces"/>')
    for matching in (checked(old), checked_for_the_window(old)):
        new = upgraded(old, matching)
        first, second, last = new.steps
        assert [param.name for param in first.parameters] == ["condSelect"]
        assert second == Step(
            "Select Faces from Vertices", 0, (Param("Inclusive", 0, "RichBool", word),)
        )
        assert last.name == "Delete Selected Faces"
        assert new.comments[0][0] == " mine "
        assert new.comments[1] == (
            " line 2: 'Conditional Vertex Selection' did this by itself; leave 'Select Faces from "
            "Vertices' out for clouds ",
        )
        assert 2 not in new.comments
    text = explained(old, matched(old))
    assert "Then, on a layer with faces, runs: Select Faces from Vertices" in text
    assert f"- Inclusive = {'yes' if word == 'true' else 'no'}" in text


def test_what_an_old_parameter_did_is_no_step_when_its_value_is_none(script):
    old = script(STRICT.format("maybe"))
    with pytest.raises(ScriptError, match="must be true or false; got 'maybe'"):
        checked(old)
    assert [step.name for step in today(old, lenient=True).steps] == [
        "Conditional Vertex Selection"
    ]


def test_a_step_made_in_memory_is_followed_without_a_line():
    step = Step("Conditional Vertex Selection", 0, (
        Param("condSelect", 0, "RichString", "(x > 0)"),
        Param("strictSelect", 0, "RichBool", "true"),
    ))  # fmt: skip
    new = today(FilterScript((step,))._script)
    assert new.comments[1][0].startswith(" 'Conditional Vertex Selection' did this by itself; ")


def test_a_step_without_a_name_is_left_out_and_explained(script):
    wrong = script("<filter/>", '<filter name="Close Holes"/>')
    text = text_of(wrong, lenient=True)
    assert "<!-- line 2: this step was left out: this <filter> has no name; " in text
    assert text.count('<filter name="') == 1
    assert "1. A step without a name (line 2)\n   Does not run.\n   MISTAKE: this <f" in explained(
        wrong, matched(wrong)
    )
    assert "this step was left out: this <filter>" in python_script(
        wrong, checked(wrong, lenient=True)
    )
