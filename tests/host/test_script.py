"""Scripts: what is found before anything runs, what old names became, what runs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pymeshlab
import pytest

from meshlab_symrecon.errors import (
    FileError,
    ParameterError,
    PluginError,
    ScriptError,
    SymReconWarning,
    UnknownFilterError,
)
from meshlab_symrecon.host import filter_names, resolution
from meshlab_symrecon.host.mlx import step_of
from meshlab_symrecon.host.mlx_reading import read_script
from meshlab_symrecon.host.mlx_writing import write_script
from meshlab_symrecon.host.native_filters import (
    find_native,
    native_filters,
)
from meshlab_symrecon.host.native_values import NativeParameter
from meshlab_symrecon.host.resolution import find_any
from meshlab_symrecon.host.script import run_script
from meshlab_symrecon.plugin import Outcome, ParameterSet, layer, number
from meshlab_symrecon.plugin.registry import PluginFailure

DECIMATION = "Simplification: Quadric Edge Collapse Decimation"


def written(tmp_path: Path, *filters: str, name: str = "scan.mlx") -> Path:
    """Write a script whose first filter is on line 2, one line each."""
    path = tmp_path / name
    path.write_text("<FilterScript>\n" + "\n".join(filters) + "\n</FilterScript>\n")
    return path


def step(name: str, *parameters: str) -> str:
    return f'<filter name="{name}">{"".join(parameters)}</filter>'


def param(name: str, value: str, rich_type: str = "RichFloat") -> str:
    return f'<Param type="{rich_type}" name="{name}" value="{value}"/>'


@pytest.fixture
def sphere():
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.create_sphere(subdiv=2)
    return mesh_set


@pytest.mark.parametrize(
    ("filters", "words"),
    [
        (step("Grow Points", param("facter", "3")),
         "unknown parameter 'facter' of 'Grow Points'; did you mean 'factor'?"),
        (step("Grow Points", param("zzzz", "3")),
         "unknown parameter 'zzzz' of 'Grow Points'; known are factor, randomseed, mode, keep, "
         "title"),
        (step("Do Nothing", param("zzzz", "3")),
         "unknown parameter 'zzzz' of 'Do Nothing'; this filter has no parameters"),
        (step("Grow Points", param("factor", "three")),
         "parameter 'factor' must be a number of at least 0; got 'three'"),
        (step("Grow Points", param("factor", "-1")),
         "parameter 'factor' must be a number of at least 0; got -1.0"),
        (step("Grow Points", param("mode", "2", "RichEnum")),
         "parameter 'mode' must be one of 'plain', 'Loud'; got 2"),
        (step("Grow Points", '<Param type="RichFloat" name="factor"/>'),
         "parameter 'factor' has no value"),
        (step("Grow Pionts"), "no filter is called 'Grow Pionts'; did you mean 'Grow Points'?"),
        (step("zzzzzzzzzz"),
         "no filter is called 'zzzzzzzzzz'; 'symrecon filters --all' lists them"),
        (step("Close Hole"), "no filter is called 'Close Hole'; did you mean 'Close Holes'?"),
        (step("Close Holes", param("MaxHoleSzie", "30", "RichInt")),
         "unknown parameter 'MaxHoleSzie' of 'Close Holes'; did you mean 'maxholesize'?"),
        (step("Close Holes", param("MaxHoleSize", "30.5", "RichInt")),
         "parameter 'maxholesize' must be a whole number; got '30.5'"),
        (step("Close Holes", param("Selected", "yes", "RichBool")),
         "parameter 'selected' must be true or false; got 'yes'"),
        (step(DECIMATION, param("TargetPerc", "nan")),
         "parameter 'targetperc' must be a number; got nan"),
        (step("Change the current layer"), "needs the parameter 'mesh'"),
        (step("Change the current layer", param("which", "1", "RichMesh")),
         "unknown parameter 'which' of 'Change the current layer'; known is 'mesh'"),
        (step("Change the current layer", param("mesh", "-1", "RichMesh")),
         "parameter 'mesh' must be a layer's position; got -1"),
    ],
)  # fmt: skip
def test_mistakes_are_found_before_anything_runs(tmp_path, installed, sphere, filters, words):
    path = written(tmp_path, step("Grow Points"), filters)
    with pytest.raises(ScriptError) as caught:
        run_script(sphere, path)
    assert str(caught.value).startswith(f"{path}:3: ")
    assert words in str(caught.value)
    assert sphere.mesh_number() == 1  # the good first step did not run


def test_every_mistake_is_told_on_its_own_line(tmp_path, installed, sphere):
    path = tmp_path / "scan.mlx"
    path.write_text(
        "<FilterScript>\n"
        '<filter name="Close Hole"/>\n'
        '<filter name="Grow Points">\n'
        ' <Param type="RichFloat" name="facter" value="3"/>\n'
        ' <Param type="RichFloat" name="factor" value="x"/>\n'
        "</filter>\n"
        '<filter name="Compute curvature principal directions"/>\n'
        "</FilterScript>\n"
    )
    with pytest.raises(ScriptError) as caught:
        run_script(sphere, path)
    lines = str(caught.value).splitlines()
    assert [line.removeprefix(f"{path}:").split(":")[0] for line in lines] == ["2", "4", "5"]


def test_checks_across_parameters_are_made_before_anything_runs(
    tmp_path, install, grow_filter, sphere
):
    def refuse(parameters):
        if parameters.factor > 5 and parameters.keep:
            raise ParameterError("'keep' needs a factor of at most 5")

    install(replace(grow_filter, check=refuse))
    path = written(tmp_path, step("Grow Points", param("factor", "6"), param("keep", "True")))
    with pytest.raises(ScriptError, match=r"scan.mlx:2: .*'keep' needs a factor of at most 5"):
        run_script(sphere, path)


def test_filters_that_draw_are_refused_before_anything_runs(tmp_path, installed, sphere):
    drawing = next(item.menu_name for item in native_filters().values() if item.display)
    path = written(tmp_path, step("Grow Points"), step(drawing))
    with pytest.raises(ScriptError, match=r"scan.mlx:3: .*draws with OpenGL"):
        run_script(sphere, path)
    assert sphere.mesh_number() == 1


def test_plugins_that_cannot_be_loaded_are_named(tmp_path, install, sphere):
    install(failures=[PluginFailure("power_crust", "plugin 'power_crust' cannot be imported")])
    path = written(tmp_path, step("Surface Reconstruction: Power Crust"))
    with pytest.raises(ScriptError, match=r"scan.mlx:2: .*cannot be imported"):
        run_script(sphere, path)
    with pytest.raises(PluginError):
        find_any("Surface Reconstruction: Power Crust")


def test_scripts_that_cannot_be_read(tmp_path, sphere):
    with pytest.raises(FileError, match="cannot be read"):
        run_script(sphere, tmp_path / "none.mlx")
    path = written(tmp_path, "<filter>")
    with pytest.raises(ScriptError, match=r"scan.mlx:3: this is not XML: mismatched tag"):
        run_script(sphere, path)


@pytest.mark.parametrize(
    "name", ["Grow Points", " grow  POINTS ", "generate_grown_points", "grow_points"]
)
def test_our_filters_run_by_every_name(tmp_path, installed, sphere, name):
    path = written(
        tmp_path,
        step(name, param("Factor", "0.1234567890123456789"), param("KEEP", "True", "RichBool")),
    )
    report = run_script(sphere, str(path))
    (done,) = report.steps
    assert (done.file, done.line, done.name) == (str(path), 2, name)
    assert (done.filter, done.status, done.notes) == ("generate_grown_points", "ran", ())
    assert done.measures["factor"] == 0.1234567890123456789
    assert done.seconds > 0
    assert report.seconds >= done.seconds
    assert sphere.current_mesh_id() == 0


def test_floats_of_native_filters_keep_every_digit(tmp_path, sphere):
    value = 0.12345678901234567
    path = written(
        tmp_path,
        step(
            "Transform: Scale, Normalize",
            param("axisX", repr(value)),
            param("unitFlag", "false", "RichBool"),
            param("Freeze", "true", "RichBool"),
            param("uniformFlag", "1", "RichBool"),
        ),
    )
    before = sphere.current_mesh().vertex_matrix()
    run_script(sphere, path)
    assert np.allclose(sphere.current_mesh().vertex_matrix(), before * value, rtol=1e-15)


@pytest.mark.parametrize("number_or_word", ["1", "word"])
def test_choices_by_number_and_by_word(tmp_path, sphere, number_or_word):
    words = find_native("meshing_repair_non_manifold_edges").find("method").words
    text = words[1].upper() if number_or_word == "word" else number_or_word
    path = written(tmp_path, step("Repair non Manifold Edges", param("Method", text, "RichEnum")))
    resolved = resolution.resolve_script(read_script(path))
    assert resolved[0].values == {"method": words[1]}
    assert run_script(sphere, path).steps[0].status == "ran"


def test_values_in_several_attributes(tmp_path, sphere):
    path = written(
        tmp_path,
        step(
            "Vertex Color Filling",
            '<Param type="RichColor" name="color1" r="255" g="0" b="51" a="255"/>',
        ),
        step(
            "Matrix: Set/Copy Transformation",
            '<Param type="RichMatrix44f" name="TransformMatrix" '
            + " ".join(f'val{n}="{float(n % 5 == 0) * 2}"' for n in range(16))
            + "/>",
            param("Freeze", "false", "RichBool"),
        ),
    )
    run_script(sphere, path)
    assert np.allclose(sphere.current_mesh().vertex_color_matrix()[0], [1, 0, 0.2, 1])
    assert np.allclose(np.diag(sphere.current_mesh().transform_matrix())[:3], 2)


def test_a_colour_without_its_alpha_is_opaque(tmp_path, sphere):
    path = written(
        tmp_path,
        step("Vertex Color Filling", '<Param type="RichColor" name="color1" r="0" g="51" b="0"/>'),
    )
    run_script(sphere, path)
    assert np.allclose(sphere.current_mesh().vertex_color_matrix()[0], [0, 0.2, 0, 1])


def test_a_camera_is_ignored_and_said_so(tmp_path):
    path = written(tmp_path, step("Set Mesh Camera", '<Param type="RichShotf" name="Shot"/>'))
    (resolved,) = resolution.resolve_script(read_script(path))
    assert resolved.values == {}
    (note,) = resolved.notes
    assert note.message == "parameter 'Shot' ignored: pymeshlab takes no camera from outside"


def test_attributes_that_are_missing(tmp_path, sphere):
    path = written(
        tmp_path,
        step("Vertex Color Filling", '<Param type="RichColor" name="color1" r="255" g="0" a="2"/>'),
    )
    with pytest.raises(ScriptError, match="parameter 'color1' has no attribute 'b'; write all of"):
        run_script(sphere, path)


class Source(ParameterSet):
    """A layer."""

    source: int = layer(-1, "Source", "The layer to look at.")
    factor: float = number(1.0, "Factor", "f")


def look(layers, parameters, progress):
    return Outcome(measures={"label": layers.get(parameters.source).label})


def test_numbers_of_layers_are_positions(tmp_path, install, grow_filter):
    install(replace(grow_filter, parameters=Source, run=look))
    mesh_set = pymeshlab.MeshSet(verbose=False)
    for _ in range(3):
        mesh_set.create_cube()
    mesh_set.set_current_mesh(0)
    mesh_set.delete_current_mesh()
    assert [mesh.id() for mesh in mesh_set] == [1, 2]
    for position, mesh in enumerate(mesh_set):
        mesh.set_label(f"at {position}")
    path = written(
        tmp_path,
        step("Grow Points", param("source", "1", "RichMesh")),
        step("Change the current layer", param("mesh", "0", "RichMesh")),
        step("Rename Current Mesh", param("newName", "zero", "RichString")),
    )
    report = run_script(mesh_set, path)
    assert report.steps[0].measures == {"label": "at 1"}
    assert mesh_set.current_mesh_id() == 1
    assert [mesh.label() for mesh in mesh_set] == ["zero", "at 1"]
    assert report.steps[1].status == "ran"


@pytest.mark.parametrize(
    "filters",
    [
        step("Grow Points", param("source", "2", "RichMesh")),
        step("Change the current layer", param("mesh", "2", "RichMesh")),
        step("Hausdorff Distance", param("SampledMesh", "2", "RichMesh")),
    ],
)
def test_positions_without_a_layer_are_no_crash(tmp_path, install, grow_filter, sphere, filters):
    install(replace(grow_filter, parameters=Source, run=look))
    path = written(tmp_path, step("Duplicate Current layer"), filters)
    with pytest.raises(
        ScriptError, match=r"scan.mlx:3: .*got 2; the document has 2 layers at this"
    ):
        run_script(sphere, path)


def test_old_names_and_parameters_are_mapped_and_told(tmp_path, sphere):
    path = written(
        tmp_path,
        step("Quadric Edge Collapse Decimation ", param("TargetFaceNum", "50.0", "RichInt")),
        step("Compact vertices"),
        step("Transform: Move, Translate, Center", param("toAll", "false", "RichBool"),
             param("centerFlag", "false", "RichBool")),
    )  # fmt: skip
    first, second, third = run_script(sphere, path).steps
    assert sphere.current_mesh().face_number() == 50
    assert first.filter == "meshing_decimation_quadric_edge_collapse"
    assert first.status == second.status == third.status == "mapped"
    assert first.notes == (f"'Quadric Edge Collapse Decimation' is '{DECIMATION}' today",)
    assert second.filter == "no operation"
    assert third.notes[1:] == (
        "parameter 'toAll' is 'alllayers' today",
        "parameter 'centerFlag' ignored: 'false' says nothing today",
    )


def test_values_that_old_names_stood_for(tmp_path, sphere):
    path = written(tmp_path, step("Repair non Manifold Edges by splitting vertices"))
    (done,) = run_script(sphere, path).steps
    assert done.filter == "meshing_repair_non_manifold_edges"
    assert "'method' set to" in done.notes[1]


OLD_POISSON = (
    '<xmlfilter name="Screened Poisson"><xmlparam name="depth" value="5"/>'
    '<xmlparam name="threads" value="1"/></xmlfilter>'
)
NEW_POISSON = step(
    "Surface Reconstruction: Screened Poisson",
    param("depth", "5", "RichInt"), param("threads", "1", "RichInt"),
)  # fmt: skip
SAMPLES = step("Poisson-disk Sampling", param("SampleNum", "50", "RichInt"))


@pytest.mark.parametrize(
    ("maker", "label"),
    [(OLD_POISSON, "Poisson mesh"), (NEW_POISSON, "Poisson mesh"),
     (SAMPLES, "Poisson-disk Samples")],
)  # fmt: skip
def test_deleting_the_current_layer_after_making_one_deletes_the_old_one(
    tmp_path, sphere, maker, label
):
    made, deleted = run_script(sphere, written(tmp_path, maker, step("Delete Current Mesh"))).steps
    assert made.status == "mapped"
    assert "stays current, as in the MeshLab of such scripts" in made.notes[-1]
    assert deleted.status == "ran"
    assert [mesh.label() for mesh in sphere] == [label]


@pytest.mark.parametrize("maker", [OLD_POISSON, NEW_POISSON, SAMPLES])
@pytest.mark.parametrize("after", ["", step("Compact vertices"), step("Rename Current Mesh")])
def test_otherwise_a_new_layer_becomes_the_current_one(tmp_path, sphere, maker, after):
    made = run_script(sphere, written(tmp_path, maker, after)).steps[0]
    assert sphere.current_mesh_id() == 1
    assert made.status == ("mapped" if maker == OLD_POISSON else "ran")


def test_copies_are_made_and_deleted_as_written(tmp_path, sphere):
    path = written(tmp_path, step("Duplicate Current layer"), step("Delete Current Mesh"))
    run_script(sphere, path)
    assert [mesh.label() for mesh in sphere] == ["Sphere"]


def test_expressions_of_old_scripts_select_the_same(tmp_path, sphere):
    path = written(
        tmp_path,
        step("Conditional Vertex Selection", param("condSelect", "(x>0) and if(y>0, 1, z>0)",
                                                   "RichString")),
    )  # fmt: skip
    (selected,) = run_script(sphere, path).steps
    x, y, z = sphere.current_mesh().vertex_matrix().T
    expected = (x > 0) & ((y > 0) | (z > 0))
    np.testing.assert_array_equal(sphere.current_mesh().vertex_selection_array(), expected)
    assert "is '(x>0) && ((y>0) ? (1) : (z>0))' today" in selected.notes[-1]


def test_a_cloud_is_not_deleted_by_cleaning(tmp_path, cloud_set):
    path = written(tmp_path, step("Remove Unreferenced Vertices"), step("Laplacian Smooth"))
    with pytest.raises(
        ScriptError, match=r"scan.mlx:2: .*delete all the 40 points of layer 'scan'"
    ):
        run_script(cloud_set, path)
    assert cloud_set.current_mesh().vertex_number() == 40


def test_a_lenient_run_passes_over_what_cannot_run_and_says_so(tmp_path, cloud_set):
    path = written(
        tmp_path,
        step("Remove Unreferenced Vertices"),
        step("No Such Filter"),
        step(
            "Transform: Scale, Normalize",
            param("axisX", "wide"),
            param("axisY", "3"),
            param("uniformFlag", "false", "RichBool"),
        ),
    )
    before = cloud_set.current_mesh().vertex_matrix()
    deleting, unknown, scaled = run_script(cloud_set, path, lenient=True).steps
    assert (deleting.status, unknown.status, scaled.status) == ("skipped", "skipped", "mapped")
    assert "would delete all the 40 points" in deleting.notes[0]
    assert unknown.filter == ""
    assert unknown.notes[0].startswith("no filter is called 'No Such Filter'")
    assert scaled.notes == ("parameter 'axisx' must be a number; got 'wide'; ignored",)
    np.testing.assert_allclose(cloud_set.current_mesh().vertex_matrix(), before * [1, 3, 1])


def test_a_strict_run_refuses_what_would_be_mapped(tmp_path, sphere):
    path = written(tmp_path, step("Quadric Edge Collapse Decimation"), step("Laplacian Smooth"))
    with pytest.raises(ScriptError, match=rf"scan.mlx:2: .* is '{DECIMATION}' today"):
        run_script(sphere, path, strict=True)
    assert sphere.current_mesh().face_number() == 320


def test_files_that_a_script_reads_are_looked_for_first(tmp_path, monkeypatch, installed, sphere):
    """No filter of today's table reads a file; one that does stands in."""
    parameters = (NativeParameter("file", "File", "RichOpenFile"),)
    reader = replace(
        find_native("meshing_close_holes"), menu_name="Read File", parameters=parameters
    )
    monkeypatch.setattr(filter_names, "is_native", lambda name: name == "Read File")
    monkeypatch.setattr(filter_names, "find_native", lambda name: reader)
    path = written(
        tmp_path, step("Grow Points"), step("Read File", param("File", "no.ply", "RichOpenFile"))
    )
    with pytest.raises(ScriptError, match=r"scan.mlx:3: .*names no file; got 'no.ply'"):
        run_script(sphere, path)


def test_warnings_of_a_step_are_notes_and_warnings(tmp_path, installed, sphere):
    path = written(tmp_path, step("Grow Points", param("mode", "loud", "RichEnum")))
    with pytest.warns(SymReconWarning, match="it is loud"):
        report = run_script(sphere, path)
    assert report.steps[0].notes == ("it is loud",)
    assert report.steps[0].status == "ran"


def test_a_step_that_fails_is_named_and_ends_the_script(tmp_path, installed):
    empty = pymeshlab.MeshSet(verbose=False)
    path = written(tmp_path, step("Do Nothing"), step("Grow Points"), step("Do Nothing"))
    with pytest.raises(ScriptError, match=r"scan.mlx:3: 'Grow Points': .*needs a layer"):
        run_script(empty, path)
    with pytest.raises(ScriptError, match=r"scan.mlx:2: "):
        run_script(empty, written(tmp_path, step("Close Holes")))


def test_progress_goes_from_0_to_1(tmp_path, installed, sphere):
    told = []
    path = written(tmp_path, step("Grow Points"), step("Close Holes"))
    run_script(sphere, path, progress=lambda fraction, message: told.append((fraction, message)))
    assert [fraction for fraction, _ in told] == sorted(fraction for fraction, _ in told)
    assert told[0] == (0.0, f"{path}:2: 'Grow Points'")
    assert (0.5, f"{path}:2: 'Grow Points', grown") in told
    assert told[-1][0] == 1.0


def test_an_empty_script_does_nothing(tmp_path, sphere):
    report = run_script(sphere, written(tmp_path))
    assert report.steps == ()
    assert sphere.mesh_number() == 1


def test_what_is_written_runs_the_same(tmp_path, installed, grow_filter, sphere):
    path = tmp_path / "größe.mlx"
    factor = 1.0 / 3.0
    write_script([step_of(grow_filter, {"factor": factor, "title": 'a "b" <c>'})], path)
    report = run_script(sphere, path)
    assert report.steps[0].measures["factor"] == factor
    assert sphere.current_mesh().label() == 'a "b" <c>'


def test_the_history_of_a_document_runs_as_a_script(tmp_path, plugins):
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.create_sphere(subdiv=2)
    mesh_set.generate_grown_points(factor=1.0 / 3.0)
    mesh_set.meshing_decimation_quadric_edge_collapse(targetfacenum=40)
    path = tmp_path / "history.mlx"
    mesh_set.save_filter_script(str(path))
    again = pymeshlab.MeshSet(verbose=False)
    run_script(again, path)
    assert np.array_equal(
        again.current_mesh().vertex_matrix(), mesh_set.current_mesh().vertex_matrix()
    )


def test_any_filter_is_found_by_any_name(installed):
    assert find_any("grow_points").menu_name == "Grow Points"
    assert find_any("close holes").python_name == "meshing_close_holes"
    with pytest.raises(UnknownFilterError, match="did you mean 'grow_points'"):
        find_any("grow_pionts")


def test_what_meshlab_says_is_said_once(tmp_path, sphere):
    path = written(tmp_path, step("Vertex Quality from Camera"))
    with pytest.raises(ScriptError) as caught:
        run_script(sphere, path)
    assert str(caught.value) == (
        f"{path}:2: 'Vertex Quality from Camera': Mesh has not a valid camera"
    )


@pytest.mark.parametrize(("strict", "corners"), [("true", 3), ("false", 1)])
def test_a_selection_of_vertices_selected_faces_too_in_old_scripts(
    tmp_path, sphere, strict, corners
):
    path = written(
        tmp_path,
        step("Conditional Vertex Selection", param("condSelect", "x > 0", "RichString"),
             param("strictSelect", strict, "RichBool")),
        step("Delete Selected Faces and Vertices"),
    )  # fmt: skip
    mesh = sphere.current_mesh()
    inside = (mesh.vertex_matrix()[:, 0] > 0)[mesh.face_matrix()].sum(axis=1)
    selected, _ = run_script(sphere, path).steps
    assert selected.status == "mapped"
    assert sphere.current_mesh().face_number() == np.count_nonzero(inside < corners)
    assert 0 < np.count_nonzero(inside < corners) < len(inside)
    broken = written(
        tmp_path,
        step("Conditional Vertex Selection", param("strictSelect", "maybe", "RichBool")),
    )
    with pytest.raises(ScriptError, match=r"'strictSelect'|'inclusive' must be true or false"):
        run_script(sphere, broken)


def test_a_mesh_that_lost_its_faces_is_cleaned_as_meshlab_does(tmp_path, sphere):
    path = written(
        tmp_path,
        step("Select All"), step("Delete Selected Faces"), step("Remove Unreferenced Vertices"),
    )  # fmt: skip
    with pytest.warns(SymReconWarning, match="deleted every point: no face was left"):
        report = run_script(sphere, path)
    assert [done.status for done in report.steps] == ["ran"] * 3
    assert sphere.current_mesh().vertex_number() == 0
    assert "no face was left" in report.steps[2].notes[0]


def test_samples_of_a_mesh_are_a_cloud_that_is_not_deleted(tmp_path, sphere):
    path = written(tmp_path, step("Montecarlo Sampling"), step("Remove Unreferenced Vertices"))
    with pytest.raises(ScriptError, match=r"scan.mlx:3: .*would delete all the points"):
        run_script(sphere, path)
    assert sphere.mesh_number() == 1  # nothing ran


@pytest.mark.parametrize("refine", ["", param("RefineFlag", "false", "RichBool")])
def test_a_layer_that_is_not_looked_at_need_not_be_there(tmp_path, sphere, refine):
    samples = step("Poisson-disk Sampling", param("SampleNum", "50", "RichInt"), refine,
                   param("RefineMesh", "7", "RichMesh"))  # fmt: skip
    (done,) = run_script(sphere, written(tmp_path, samples)).steps
    assert done.status == "ran"
    wanted = samples.replace('value="false"', 'value="true"')
    if wanted != samples:
        with pytest.raises(ScriptError, match="'refinemesh' must be the position of a layer"):
            run_script(sphere, written(tmp_path, wanted))
