"""Filter scripts through a MeshSet's own methods: any script in, exact steps out."""

from __future__ import annotations

import gc
import re
import weakref
from pathlib import Path

import numpy as np
import pymeshlab
import pytest

from meshlab_symrecon.errors import FileError, ScriptError, SymReconWarning
from meshlab_symrecon.host import exact_steps, history, registration
from meshlab_symrecon.host.filter_script import FilterScript
from meshlab_symrecon.host.history import read_history
from meshlab_symrecon.host.mlx import Step
from meshlab_symrecon.host.mlx_reading import read_script
from meshlab_symrecon.host.resolution import resolve_script
from meshlab_symrecon.host.script_history import recorded_script

THIRD = 1.0 / 3.0
OLD = """<FilterScript>
 <filter name="Transform: Scale">
  <Param type="RichFloat" name="axisX" value="0.12345678901234567"/>
  <Param type="RichBool" name="uniformFlag" value="TRUE"/>
 </filter>
 <filter name="Compact vertices"/>
 <filter name="grow_points"><Param type="RichFloat" name="FACTOR" value="0.1"/></filter>
 <xmlfilter name="Screened Poisson"><xmlparam name="depth" value="4"/>
  <xmlparam name="threads" value="1"/></xmlfilter>
 <filter name="Change the current layer"><Param type="RichMesh" name="mesh" value="0"/></filter>
</FilterScript>
"""


def sphere():
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.create_sphere(subdiv=3)
    mesh_set.clear_filter_script()
    return mesh_set


def values_in(path):
    return [dict(step.values) for step in resolve_script(read_script(path))]


def contents(mesh_set):
    return [(mesh.label(), mesh.vertex_matrix(), mesh.face_matrix()) for mesh in mesh_set]


def assert_same_bits(first, second):
    for one, other in zip(contents(first), contents(second), strict=True):
        assert one[0] == other[0]
        np.testing.assert_array_equal(one[1], other[1])
        np.testing.assert_array_equal(one[2], other[2])


def work(mesh_set):
    """Run native steps of most types with awkward values, and ours between them."""
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = turn, [THIRD, 1e-7 / 3, -1e5 / 7]
    mesh_set.set_matrix(transformmatrix=matrix)
    mesh_set.compute_matrix_from_rotation(
        rotaxis="custom axis", customaxis=np.array([1.0, THIRD, 0.1]), angle=100.0 / 7.0
    )
    mesh_set.grow_points(factor=0.1 + 0.2, title="a")
    mesh_set.compute_matrix_from_scaling_or_normalization(axisx=THIRD, uniformflag=True)
    mesh_set.meshing_isotropic_explicit_remeshing(
        iterations=2, targetlen=pymeshlab.PercentageValue(100.0 / 13.0)
    )
    mesh_set.set_color_per_vertex(color1=pymeshlab.Color(10, 20, 30, 40))
    mesh_set.compute_selection_by_condition_per_vertex(condselect="(x > 0.1) && (y < 0.3)")
    mesh_set.grow_points(factor=THIRD, title="b")


def test_a_saved_script_repeats_every_step_to_the_last_bit(plugins, tmp_path):
    by_hand, again = sphere(), sphere()
    work(by_hand)
    path = tmp_path / "steps.mlx"
    by_hand.save_filter_script(str(path))
    again.load_filter_script(str(path))
    report = again.apply_filter_script()
    assert [step.status for step in report.steps] == ["ran"] * 8
    assert_same_bits(by_hand, again)
    np.testing.assert_array_equal(
        by_hand.current_mesh().vertex_color_matrix(), again.current_mesh().vertex_color_matrix()
    )


def test_six_digits_would_not_have_repeated_it(plugins, tmp_path):
    """What the exact steps are for: the native file of the same history gives other bits."""
    by_hand, again = sphere(), sphere()
    by_hand.compute_matrix_from_scaling_or_normalization(axisx=THIRD, uniformflag=True)
    history.NATIVE_SAVE(by_hand, str(tmp_path / "native.mlx"))
    again.load_filter_script(str(tmp_path / "native.mlx"))
    again.apply_filter_script()
    assert not np.array_equal(by_hand.mesh(0).vertex_matrix(), again.mesh(0).vertex_matrix())


def test_given_and_default_values_are_written_in_full(plugins, tmp_path):
    mesh_set = sphere()
    mesh_set.compute_matrix_from_scaling_or_normalization(axisx=THIRD)
    mesh_set.create_cube(size=0.7)
    defaults = mesh_set.filter_parameter_values("get_hausdorff_distance", sampledmesh=1)
    mesh_set.get_hausdorff_distance(sampledmesh=1)
    path = tmp_path / "steps.mlx"
    mesh_set.save_filter_script(path)  # a path is as good as a text
    scale, _, distance = values_in(path)
    assert scale["axisx"] == THIRD
    assert np.float32(distance["maxdist"].value()) == np.float32(defaults["maxdist"])
    assert float(f"{defaults['maxdist']:g}") != defaults["maxdist"]
    assert distance.keys() == defaults.keys()


def test_a_number_that_meshlab_cut_down_is_written_as_it_ran(plugins):
    mesh_set = sphere()
    mesh_set.compute_matrix_from_rotation(angle=1000.0, customaxis=np.array([THIRD, 0.0, 0.0]))
    (step,) = resolve_script(recorded_script(mesh_set))
    assert step.values["angle"] == 360.0
    assert step.values["customaxis"].tolist() == [THIRD, 0.0, 0.0]
    assert step.values["snapangle"] == 30.0
    huge = {"axisx": 1e300}  # infinite in single precision
    most = mesh_set.filter_parameter_values("compute_matrix_from_translation", **huge)["axisx"]
    mesh_set.compute_matrix_from_translation(**huge)
    written = resolve_script(recorded_script(mesh_set))[-1].values["axisx"]
    assert np.float32(written) == np.float32(most)


def test_layers_are_written_by_position(plugins, tmp_path):
    """A MeshSet numbers its layers for good; a script counts those that are there."""
    mesh_set = pymeshlab.MeshSet(verbose=False)
    for _ in range(3):
        mesh_set.create_cube()
    mesh_set.set_current_mesh(0)
    mesh_set.delete_current_mesh()
    mesh_set.clear_filter_script()
    mesh_set.get_hausdorff_distance(sampledmesh=2, targetmesh=1)
    mesh_set.save_filter_script(tmp_path / "steps.mlx")
    (values,) = values_in(tmp_path / "steps.mlx")
    assert (values["sampledmesh"], values["targetmesh"]) == (1, 0)
    again = pymeshlab.MeshSet(verbose=False)
    again.create_cube()
    again.create_cube()
    again.load_filter_script(tmp_path / "steps.mlx")
    (step,) = again.apply_filter_script().steps
    assert step.measures["max"] == 0.0


def test_steps_from_before_the_plugins_were_loaded_keep_six_digits(install, grow_filter, tmp_path):
    mesh_set = sphere()
    mesh_set.compute_matrix_from_scaling_or_normalization(axisx=THIRD)
    install(grow_filter)
    registration.load_plugins()
    mesh_set.compute_matrix_from_scaling_or_normalization(axisx=THIRD)
    mesh_set.grow_points(factor=THIRD)
    first, second, ours = (dict(step.values) for step in resolve_script(recorded_script(mesh_set)))
    assert (first["axisx"], second["axisx"], ours["factor"]) == (0.333333, THIRD, THIRD)


def test_a_step_that_failed_is_in_neither_record(plugins):
    mesh_set = sphere()
    with pytest.raises(pymeshlab.MissingComponentException):
        mesh_set.compute_color_from_scalar_per_face()
    with pytest.raises(RuntimeError):
        mesh_set.create_cube(size="large")
    mesh_set.create_cube(size=THIRD)
    assert [step.name for step in recorded_script(mesh_set).steps] == ["Box/Cube"]
    assert len(exact_steps.notes_of(mesh_set).steps) == 1


def test_the_last_notes_are_dropped():
    """Which are the means of a filter of ours, such as the one that writes quality."""
    step = Step("Box/Cube", 0)
    mesh_set = sphere()
    for count, left in ((0, 3), (2, 1), (2, 0)):
        exact_steps.replace(mesh_set, exact_steps.Notes())
        for _ in range(3):
            exact_steps.note(mesh_set, exact_steps.Note(step, step))
        exact_steps.drop_last(mesh_set, count)
        if left == 0:
            exact_steps.drop_last(mesh_set, count)
        assert len(exact_steps.notes_of(mesh_set).steps) == left


def test_pymeshlab_itself_reads_what_was_saved(plugins, tmp_path):
    by_hand = sphere()
    by_hand.compute_matrix_from_rotation(rotaxis="Z axis", angle=100.0 / 7.0)
    by_hand.meshing_merge_close_vertices(threshold=pymeshlab.PureValue(THIRD))
    by_hand.set_color_per_vertex(color1=pymeshlab.Color(1, 2, 3))
    path = tmp_path / "steps.mlx"
    by_hand.save_filter_script(str(path))
    shown = read_history(by_hand)
    registration.unload_plugins()
    plain = sphere()
    plain.load_filter_script(str(path))
    for one, other in zip(shown, read_history(plain), strict=True):
        assert one.menu_name == other.menu_name
        assert one.texts == other.texts
    plain.apply_filter_script()
    np.testing.assert_allclose(
        plain.mesh(0).vertex_matrix(), by_hand.mesh(0).vertex_matrix(), atol=1e-5
    )


def test_a_change_of_the_current_layer_between_steps_is_a_step_of_the_script(plugins, tmp_path):
    """pymeshlab's own history does not know of it, so that its replay works on other layers."""

    def do(mesh_set):
        mesh_set.create_cube(size=2.0)
        mesh_set.set_current_mesh(0)
        mesh_set.compute_matrix_from_scaling_or_normalization(axisx=THIRD, uniformflag=True)
        mesh_set.grow_points(factor=3.0)
        mesh_set.set_current_mesh(1)
        mesh_set.grow_points(factor=5.0)

    by_hand, again = sphere(), sphere()
    do(by_hand)
    by_hand.save_filter_script(tmp_path / "steps.mlx")
    with pytest.warns(SymReconWarning, match="the current layer changes, by position"):
        again.load_filter_script(tmp_path / "steps.mlx")
    again.apply_filter_script()
    assert_same_bits(by_hand, again)
    names = [step.name for step in read_script(tmp_path / "steps.mlx").steps]
    change, scale = "Change the current layer", "Transform: Scale, Normalize"
    assert names == ["Box/Cube", change, scale, "Grow Points", change, "Grow Points"]
    again.save_filter_script(tmp_path / "again.mlx")
    assert read_script(tmp_path / "again.mlx").steps == read_script(tmp_path / "steps.mlx").steps


def test_layers_that_no_step_made_are_named_when_a_script_is_saved(plugins, points, tmp_path):
    mesh_set = sphere()
    mesh_set.grow_points()
    mesh_set.add_mesh(pymeshlab.Mesh(vertex_matrix=points))
    mesh_set.grow_points()
    with pytest.warns(SymReconWarning, match="between 'Grow Points' and 'Grow Points' layers came"):
        mesh_set.save_filter_script(tmp_path / "steps.mlx")
    assert [step.name for step in read_script(tmp_path / "steps.mlx").steps] == ["Grow Points"] * 2


def test_a_script_object_is_made_of_what_ran(plugins):
    by_hand, again = sphere(), sphere()
    work(by_hand)
    script = FilterScript.of(by_hand)
    assert script.check() == ()
    assert [step.name for step in script] == [step.menu_name for step in read_history(by_hand)]
    script.run(again)
    assert_same_bits(by_hand, again)


# --- reading --------------------------------------------------------------------------------------


def loaded(mesh_set, path, text=OLD):
    path.write_text(text, encoding="utf-8")
    with pytest.warns(SymReconWarning) as caught:
        mesh_set.load_filter_script(str(path))
    return [str(warning.message) for warning in caught]


def test_an_old_mixed_script_is_loaded_and_run(plugins, tmp_path):
    path = tmp_path / "old.mlx"
    mesh_set, by_hand = sphere(), sphere()
    told = loaded(mesh_set, path)
    assert told[0].startswith(f"{path}:2: 'Transform: Scale' is 'Transform: Scale, Normalize'")
    assert [step.menu_name for step in read_history(mesh_set)] == [
        "Transform: Scale, Normalize", "Compact vertices", "Grow Points",
        "Surface Reconstruction: Screened Poisson", "Change the current layer",
    ]  # fmt: skip
    report = mesh_set.apply_filter_script()
    assert [(step.line, step.status) for step in report.steps] == [
        (2, "mapped"), (6, "mapped"), (7, "ran"), (8, "mapped"), (10, "ran"),
    ]  # fmt: skip
    by_hand.compute_matrix_from_scaling_or_normalization(
        axisx=0.12345678901234567, uniformflag=True
    )
    by_hand.grow_points(factor=0.1)
    by_hand.generate_surface_reconstruction_screened_poisson(depth=4, threads=1)
    assert_same_bits(mesh_set, by_hand)
    assert mesh_set.current_mesh_id() == 0


def test_a_loaded_script_is_saved_under_the_names_of_today(plugins, tmp_path):
    mesh_set = sphere()
    loaded(mesh_set, tmp_path / "old.mlx", OLD.replace('"depth" value="4"', '"depth" value="5"'))
    with pytest.warns(SymReconWarning) as caught:
        mesh_set.save_filter_script(tmp_path / "new.mlx")
    told = [str(warning.message) for warning in caught]
    assert [re.sub(r".*old.mlx", "", sentence) for sentence in told] == [
        ":6: 'Compact vertices' was left out: MeshLab does this by itself today",
    ]
    script = read_script(tmp_path / "new.mlx")
    assert [step.name for step in script.steps] == [
        "Transform: Scale, Normalize", "Grow Points", "Surface Reconstruction: Screened Poisson",
        "Change the current layer",
    ]  # fmt: skip
    assert not any(step.from_xml_plugin for step in script.steps)
    scale, grow, poisson, _ = values_in(tmp_path / "new.mlx")
    assert scale == {"axisx": 0.12345678901234567, "uniformflag": True}
    assert (grow["factor"], grow["title"]) == (0.1, "grown")
    assert poisson == {"depth": 5, "threads": 1}


def test_a_percentage_that_was_loaded_is_kept_and_named(plugins, tmp_path):
    text = (
        '<FilterScript><filter name="Merge Close Vertices">'
        '<Param type="RichAbsPerc" name="Threshold" value="2.5%"/></filter></FilterScript>'
    )
    (tmp_path / "share.mlx").write_text(text, encoding="utf-8")
    mesh_set = sphere()
    mesh_set.load_filter_script(tmp_path / "share.mlx")
    with pytest.warns(SymReconWarning, match=r"keeps Threshold=2.5%, which only we read"):
        mesh_set.save_filter_script(tmp_path / "again.mlx")
    (values,) = values_in(tmp_path / "again.mlx")
    assert values["threshold"].value() == 2.5


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("<FilterScript>\n<filter name='Grow Pionts'/></FilterScript>", r":2: no filter is called"),
        ("<FilterScript>\n<filter name='Ambient Occlusion'/></FilterScript>", r":2: .*OpenGL"),
        ("<FilterScript>\n\n<filter name='a'></FilterScript>", r":3: this is not XML"),
        ("<Project/>", r":1: the outermost element must be <FilterScript>"),
        (
            "<FilterScript><filter name='Grow Points'>\n"
            "<Param type='RichFloat' name='factor' value='-1'/></filter></FilterScript>",
            r":2: parameter 'factor' must be a number of at least 0",
        ),
    ],
)
def test_a_script_that_cannot_run_is_refused_and_the_history_stays(plugins, tmp_path, text, reason):
    mesh_set = sphere()
    mesh_set.grow_points(factor=THIRD)
    before = read_history(mesh_set), recorded_script(mesh_set)
    (tmp_path / "bad.mlx").write_text(text, encoding="utf-8")
    with pytest.raises(ScriptError, match=reason):
        mesh_set.load_filter_script(str(tmp_path / "bad.mlx"))
    with pytest.raises(FileError, match=r"missing\.mlx cannot be read"):
        mesh_set.load_filter_script(str(tmp_path / "missing.mlx"))
    assert (read_history(mesh_set), recorded_script(mesh_set)) == before


def test_a_step_that_fails_is_named_with_file_and_line_and_nothing_is_forgotten(plugins, tmp_path):
    text = "<FilterScript>\n<filter name='Box/Cube'/>\n<filter name='Hausdorff Distance'>\n"
    text += "<Param type='RichMesh' name='SampledMesh' value='7'/></filter></FilterScript>"
    (tmp_path / "far.mlx").write_text(text, encoding="utf-8")
    mesh_set = sphere()
    mesh_set.load_filter_script(tmp_path / "far.mlx")
    before = read_history(mesh_set), exact_steps.notes_of(mesh_set)
    with pytest.raises(ScriptError, match=r"far.mlx:3: .*'sampledmesh' must be the position"):
        mesh_set.apply_filter_script()
    assert mesh_set.mesh_number() == 1  # nothing ran
    assert (read_history(mesh_set), exact_steps.notes_of(mesh_set)) == before


# --- the rest -------------------------------------------------------------------------------------


def test_steps_after_a_loaded_script_follow_it(plugins, tmp_path):
    mesh_set = sphere()
    loaded(mesh_set, tmp_path / "old.mlx")
    mesh_set.create_cube(size=THIRD)
    steps = recorded_script(mesh_set).steps
    assert [step.name for step in steps][-2:] == ["Change the current layer", "Box/Cube"]
    assert steps[-1].parameters[0].text == repr(THIRD)


def test_a_replay_tells_its_progress_and_changes_no_record(plugins):
    mesh_set = sphere()
    mesh_set.grow_points(factor=THIRD)
    mesh_set.create_cube(size=THIRD)
    before = read_history(mesh_set), exact_steps.notes_of(mesh_set)
    heard = []
    mesh_set.apply_filter_script(progress=lambda *news: heard.append(news))
    assert [fraction for fraction, _ in heard] == [0.0, 0.5, 0.5, 0.5, 1.0]
    told = ("Grow", "grown", "adding layers", "Box/Cube", "done")
    for (_, message), words in zip(heard, told, strict=True):
        assert words in message
    assert (read_history(mesh_set), exact_steps.notes_of(mesh_set)) == before


def test_clearing_forgets_everything(plugins):
    mesh_set = sphere()
    mesh_set.grow_points()
    mesh_set.clear_filter_script()
    assert read_history(mesh_set) == ()
    assert exact_steps.notes_of(mesh_set) == exact_steps.Notes()
    assert mesh_set.apply_filter_script().steps == ()


def test_a_history_is_printed_in_full_under_names_that_can_be_called(plugins, capsys):
    mesh_set = sphere()
    mesh_set.compute_matrix_from_rotation(rotaxis="Z axis", angle=THIRD)
    mesh_set.grow_points(factor=THIRD)
    mesh_set.print_filter_script()
    lines = capsys.readouterr().out.splitlines()
    assert lines[:3] == ["Filter Script Size : 2", "", "0: compute_matrix_from_rotation"]
    for line in (
        "\trotaxis : str = 'Z axis'", "\tangle : float (bounded) = 0.3333333333333333",
        "\tcustomaxis : numpy.ndarray[numpy.float64[3]] = [0.0, 0.0, 0.0]",
        "\tfreeze : bool = True", "1: generate_grown_points",
        "\tfactor : float = 0.3333333333333333",
        "\tmode : str = 'plain'", "\ttitle : str = 'grown'", "\trandomseed : int = 0",
    ):  # fmt: skip
        assert line in lines


def test_a_step_that_is_gone_is_printed_as_it_was_written(plugins, capsys):
    mesh_set = sphere()
    history.restore(mesh_set, [history.Step("No Such Filter", ({"name": "a", "value": "b"},))])
    mesh_set.print_filter_script()
    assert capsys.readouterr().out == "Filter Script Size : 1\n\n0: No Such Filter\n\n"


def test_a_step_that_is_gone_cannot_be_saved(plugins, tmp_path):
    mesh_set = sphere()
    history.restore(mesh_set, [history.Step("No Such Filter", ())])
    with pytest.raises(ScriptError, match="no filter is called 'No Such Filter'"):
        mesh_set.save_filter_script(tmp_path / "steps.mlx")
    assert not Path(tmp_path, "steps.mlx").exists()


def test_notes_die_with_their_mesh_set(plugins):
    mesh_set = sphere()
    mesh_set.grow_points()
    gone = weakref.ref(mesh_set)
    gc.collect()
    kept = len(exact_steps._kept)
    del mesh_set
    gc.collect()
    assert gone() is None
    assert len(exact_steps._kept) == kept - 1


@pytest.mark.filterwarnings("ignore::meshlab_symrecon.errors.SymReconWarning")
@pytest.mark.parametrize("strict", ["true", "false"])
def test_a_step_that_two_filters_do_today_is_two_in_the_history(plugins, tmp_path, strict):
    (tmp_path / "old.mlx").write_text(
        "<FilterScript><filter name='Conditional Vertex Selection'>"
        "<Param type='RichString' name='condSelect' value='(z &gt; 0.123456789)'/>"
        f"<Param type='RichBool' name='strictSelect' value='{strict}'/></filter>"
        "<filter name='Delete Selected Faces'/></FilterScript>"
    )
    by_runner, by_history, again = sphere(), sphere(), sphere()
    script = FilterScript.read(tmp_path / "old.mlx")
    script.run(by_runner)
    by_history.load_filter_script(tmp_path / "old.mlx")
    names = ["Conditional Vertex Selection", "Select Faces from Vertices", "Delete Selected Faces"]
    for mesh_set in (by_runner, by_history):
        assert [step.menu_name for step in read_history(mesh_set)] == names
        assert [step.name for step in recorded_script(mesh_set).steps] == names
    by_history.save_filter_script(tmp_path / "new.mlx")
    by_history.apply_filter_script()
    assert 0 < by_history.current_mesh().face_number() < sphere().current_mesh().face_number()
    assert_same_bits(by_runner, by_history)
    FilterScript.read(tmp_path / "new.mlx").run(again, strict=True)
    assert_same_bits(by_runner, again)
    assert FilterScript.read(tmp_path / "new.mlx").steps == script.upgraded().steps
