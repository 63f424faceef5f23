"""Scripts on files."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from meshlab_symrecon.host.files import load
from meshlab_symrecon.host.meshset import read_layer
from meshlab_symrecon.host.mlx_reading import read_script
from meshlab_symrecon.host.projects import load_project
from meshlab_symrecon.host.registration import registry
from meshlab_symrecon.host.resolution import resolve_script

SHIPPED = sorted(Path(__file__).parents[2].joinpath("meshlab_scripts").glob("*.mlx"))


def without_record(path):
    """Return the bytes of a PLY file but for what it says about how it was made."""
    header, end, body = path.read_bytes().partition(b"end_header\n")
    kept = [
        line for line in header.splitlines() if not line.startswith(b"comment meshlab_symrecon")
    ]
    assert len(kept) < len(header.splitlines())
    return kept, end, body


def test_the_shipped_script_gives_the_same_surface_to_the_last_bit(run, statue, tmp_path):
    script = next(path for path in SHIPPED if path.name == "scan_to_solid.mlx")
    by_script, by_command = tmp_path / "a.ply", tmp_path / "b.ply"
    result = run("run", script, statue, "-o", by_script, "--json", tmp_path / "r.json")
    assert result.exit_code == 0, result.stderr
    assert run("reconstruct", statue, "-o", by_command).exit_code == 0
    # The script has one step more in its record: it looks for duplicates first.
    by_script, by_command = (without_record(path) for path in (by_script, by_command))
    assert by_script == by_command
    report = json.loads((tmp_path / "r.json").read_text(encoding="utf-8"))
    assert [step["status"] for step in report["steps"]] == ["ran"] * 5
    assert [step["filter"] for step in report["steps"]][2:] == [
        "generate_reflection_planes",
        "generate_mirror_completed_points",
        "generate_surface_reconstruction_power_crust",
    ]
    assert report["steps"][-1]["measures"]["closed"] is True
    assert report["inputs"] == [str(statue)]
    for step in report["steps"]:
        assert step["file"] == str(script)
        assert step["name"] in script.read_text(encoding="utf-8").splitlines()[step["line"] - 1]
        assert step["seconds"] >= 0


@pytest.mark.parametrize("script", SHIPPED, ids=lambda path: path.name)
def test_shipped_scripts_name_every_parameter_with_its_default(script):
    assert len(SHIPPED) == 6
    for step in resolve_script(read_script(script)):
        assert step.notes == ()
        if step.python_name in registry():
            assert dict(step.values) == step.filter.bind({}).values()
            assert list(step.values) == [p.name for p in step.filter.parameters.declared()]


@pytest.mark.parametrize("script", SHIPPED, ids=lambda path: path.name)
def test_shipped_scripts_run(run, statue, tmp_path, script):
    result = run("run", script, statue, "-o", tmp_path / "a.ply")
    assert result.exit_code == 0, result.stderr
    assert f"{script}:" in result.stdout
    layer = read_layer(load(tmp_path / "a.ply"), 0)
    measured = len(read_layer(load(statue), 0).points)
    if script.name == "detect.mlx":
        assert len(layer.points) == measured
    elif script.name == "deviation.mlx":
        assert len(layer.points) == measured
        assert layer.quality.min() < 0.0 < layer.quality.max()
        assert layer.colours is not None
    elif script.name == "complete.mlx":
        assert np.array_equal(np.unique(layer.quality), [0.0, 1.0])
        assert np.count_nonzero(layer.quality == 0) == measured
    elif script.name == "simplify.mlx":
        assert len(layer.points) == round(measured / 10)
    else:
        assert len(layer.faces) > measured


def test_inputs_are_layers_in_their_order(run, statue, lopsided, tmp_path):
    script = tmp_path / "a.mlx"
    script.write_text(
        '<FilterScript><filter name="Change the current layer">'
        '<Param type="RichMesh" name="mesh" value="0"/></filter></FilterScript>'
    )
    (tmp_path / "b.mlx").write_text("<FilterScript/>")
    for name, expected in (("a.mlx", statue), ("b.mlx", lopsided)):
        result = run("run", tmp_path / name, statue, lopsided, "-o", tmp_path / "out.ply")
        assert result.exit_code == 0, result.stderr
        kept = read_layer(load(tmp_path / "out.ply"), 0).points
        assert np.array_equal(kept, read_layer(load(expected), 0).points)


def test_mistakes_are_told_with_file_and_line(run, statue, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("scan.mlx").write_text(
        '<FilterScript>\n<filter name="Detect Reflection Planes (AP)">\n'
        '<Param type="RichFloat" name="minconfidenec" value="0.5"/></filter>\n'
        '<filter name="Close Hole"/></FilterScript>\n'
    )
    result = run("run", "scan.mlx", statue, "-o", "a.ply", "--json", "r.json")
    assert result.exit_code == 1
    assert result.stderr.splitlines() == [
        "error: scan.mlx:3: unknown parameter 'minconfidenec' of 'Detect Reflection Planes (AP)'; "
        "did you mean 'minconfidence'?",
        "scan.mlx:4: no filter is called 'Close Hole'; did you mean 'Close Holes'?",
    ]
    assert [path.name for path in tmp_path.iterdir()] == ["scan.mlx"]


def test_a_step_that_fails_leaves_nothing(run, tmp_path):
    flat = tmp_path / "flat.xyz"
    flat.write_text("".join(f"{i % 7} {i // 7} 0\n" for i in range(49)))
    script = next(path for path in SHIPPED if path.name == "complete.mlx")
    result = run("run", script, flat, "-o", tmp_path / "a.ply", "--json", tmp_path / "r.json")
    assert result.exit_code == 1
    assert "complete.mlx:" in result.stderr
    assert "in one plane" in result.stderr
    assert list(tmp_path.iterdir()) == [flat]


def test_without_a_plane_the_shipped_script_closes_what_was_measured(run, lopsided, tmp_path):
    script = next(path for path in SHIPPED if path.name == "scan_to_solid.mlx")
    result = run("run", script, lopsided, "-o", tmp_path / "a.ply")
    assert result.exit_code == 0, result.stderr
    assert "nothing was mirrored" in result.stderr
    closed = read_layer(load(tmp_path / "a.ply"), 0)
    assert run("reconstruct", lopsided, "-o", tmp_path / "b.ply").exit_code == 0
    plain = read_layer(load(tmp_path / "b.ply"), 0)
    assert np.array_equal(closed.points, plain.points)
    assert np.array_equal(closed.faces, plain.faces)


def test_a_lenient_run_passes_over_steps_and_says_so(run, statue, tmp_path):
    script = tmp_path / "s.mlx"
    script.write_text(
        '<FilterScript>\n<filter name="No Such Filter"/>\n'
        '<filter name="Remove Unreferenced Vertices"/>\n</FilterScript>\n'
    )
    words = ("run", script, statue, "-o", tmp_path / "a.ply", "--json", tmp_path / "r.json")
    refused = run(*words)
    assert refused.exit_code == 1
    assert refused.stderr.startswith(f"error: {script}:2: no filter is called 'No Such Filter'")
    result = run(*words, "--lenient")
    assert result.exit_code == 0, result.stderr
    assert f"{script}:2: skipped 'No Such Filter'" in result.stdout
    assert "2 steps (2 skipped) in" in result.stdout
    report = json.loads((tmp_path / "r.json").read_text(encoding="utf-8"))
    assert [step["status"] for step in report["steps"]] == ["skipped", "skipped"]
    assert "every point would be deleted" in report["steps"][1]["notes"][0]
    kept = read_layer(load(tmp_path / "a.ply"), 0).points
    assert np.array_equal(kept, read_layer(load(statue), 0).points)


def test_a_strict_run_wants_a_script_of_today(run, statue, tmp_path):
    script = tmp_path / "s.mlx"
    script.write_text('<FilterScript>\n<filter name="Compact vertices"/>\n</FilterScript>\n')
    assert run("run", script, statue, "-o", tmp_path / "a.ply").exit_code == 0
    result = run("run", script, statue, "-o", tmp_path / "b.ply", "--strict")
    assert result.exit_code == 1
    assert f"{script}:2: MeshLab does this by itself today" in result.stderr
    assert not (tmp_path / "b.ply").exists()
    both = run("run", script, statue, "-o", tmp_path / "b.ply", "--strict", "--lenient")
    assert both.exit_code == 2


def test_a_child_process_gives_the_same_bytes(run, statue, tmp_path):
    script = tmp_path / "s.mlx"
    script.write_text(
        '<FilterScript><filter name="Compute normals for point sets"/></FilterScript>'
    )
    for name, options in (("a.ply", []), ("b.ply", ["--isolate"])):
        result = run("run", script, statue, "-o", tmp_path / name, *options)
        assert result.exit_code == 0, result.stderr
    assert (tmp_path / "a.ply").read_bytes() == (tmp_path / "b.ply").read_bytes()


def test_all_layers_are_saved_as_a_project(run, statue, lopsided, tmp_path):
    (tmp_path / "s.mlx").write_text("<FilterScript/>")
    result = run("run", tmp_path / "s.mlx", statue, lopsided, "-o", tmp_path / "all.mlp")
    assert result.exit_code == 0, result.stderr
    assert len(list(tmp_path.glob("all-*.ply"))) == 2


def test_what_was_saved_as_a_project_is_an_input(run, statue, lopsided, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    move = (
        '<filter name="set_matrix"><Param type="RichMatrix44f" name="TransformMatrix" val0="1" '
        'val1="0" val2="0" val3="5" val4="0" val5="1" val6="0" val7="0" val8="0" val9="0" '
        'val10="1" val11="0" val12="0" val13="0" val14="0" val15="1"/>'
        '<Param type="RichBool" name="Freeze" value="false"/></filter>'
    )
    Path("move.mlx").write_text(f"<FilterScript>{move}</FilterScript>")
    Path("last.mlx").write_text(
        '<FilterScript><filter name="Change the current layer"><Param type="RichMesh" '
        'name="mesh" value="1"/></filter></FilterScript>'
    )
    assert run("run", "move.mlx", statue, lopsided, "-o", "all.mlp").exit_code == 0
    names = [path.name for path in (statue, lopsided)]
    assert [mesh.label() for mesh in load_project("all.mlp")] == names
    checked = run("check", "last.mlx", "all.mlp")
    assert checked.exit_code == 0, checked.stdout
    beyond = Path("last.mlx").read_text().replace('value="1"', 'value="2"')
    Path("beyond.mlx").write_text(beyond)
    checked = run("check", "beyond.mlx", "all.mlp")
    assert checked.exit_code == 1
    assert "the document has 2 layers" in checked.stdout
    for options in ([], ["--isolate"]):
        result = run("run", "last.mlx", "all.mlp", statue, "-o", "again.mlp", *options)
        assert result.exit_code == 0, result.stderr
        again = load_project("again.mlp")
        assert [mesh.label() for mesh in again] == [*names, "statue 1(1).ply"]
        shifts = [mesh.transform_matrix()[0, 3] for mesh in again]
        assert shifts == [0.0, 5.0, 0.0]
    result = run("run", "last.mlx", "all.mlp", "-o", "moved.ply")
    assert result.exit_code == 0, result.stderr
    documents = [load(path) for path in (lopsided, "moved.ply")]
    before, after = (document.current_mesh().vertex_matrix() for document in documents)
    np.testing.assert_allclose(after, before + np.array([5.0, 0.0, 0.0]), rtol=1e-12)


def test_files_of_a_project_are_kept(run, statue, tmp_path):
    script = tmp_path / "s.mlx"
    script.write_text("<FilterScript/>")
    assert run("run", script, statue, "-o", tmp_path / "a.mlp").exit_code == 0
    (mesh,) = tmp_path.glob("a-*.ply")
    before = mesh.read_bytes()
    for words in (["-o", mesh], ["-o", tmp_path / "a.mlp"], ["-o", "x.ply", "--json", mesh]):
        result = run("run", script, tmp_path / "a.mlp", *words)
        assert result.exit_code == 1
        assert "would overwrite" in result.stderr
    result = run("check", script, tmp_path / "a.mlp", "--json", mesh)
    assert result.exit_code == 1
    assert "would overwrite" in result.stderr
    mesh.rename(tmp_path / "gone.ply")
    for command in (
        ["run", script, tmp_path / "a.mlp", "-o", mesh],
        ["check", script, tmp_path / "a.mlp"],
    ):
        result = run(*command)
        assert result.exit_code == 1
        assert "names 1 mesh files that are not there" in result.stderr
    assert (tmp_path / "gone.ply").read_bytes() == before


@pytest.mark.parametrize("isolated", [[], ["--isolate"]])
def test_a_script_may_make_the_first_layer(run, tmp_path, isolated):
    script = tmp_path / "s.mlx"
    script.write_text('<FilterScript><filter name="Box/Cube"/></FilterScript>')
    result = run("run", script, "-o", tmp_path / "a.ply", *isolated)
    assert result.exit_code == 0, result.stderr
    assert load(tmp_path / "a.ply").current_mesh().face_number() == 12
    script.write_text('<FilterScript><filter name="Close Holes"/></FilterScript>')
    result = run("run", script, "-o", tmp_path / "b.ply", *isolated)
    assert result.exit_code == 1
    assert "s.mlx:1: 'Close Holes' needs a layer" in result.stderr
    script.write_text("<FilterScript/>")
    result = run("run", script, "-o", tmp_path / "b.ply", *isolated)
    assert result.exit_code == 1
    assert "the document is empty" in result.stderr
    assert not (tmp_path / "b.ply").exists()


@pytest.mark.parametrize("words", [["a.mlx"], ["a.mlx", "b.ply"], []])
def test_wrong_usage_is_2(run, words):
    assert run("run", *words).exit_code == 2


def test_missing_script_and_overwritten_script(run, statue, tmp_path):
    result = run("run", tmp_path / "none.mlx", statue, "-o", tmp_path / "a.ply")
    assert result.exit_code == 1
    assert "none.mlx cannot be read" in result.stderr
    script = tmp_path / "s.mlx"
    script.write_text("<FilterScript/>")
    result = run("run", script, statue, "-o", tmp_path / "a.ply", "--json", script)
    assert result.exit_code == 1
    assert script.read_text() == "<FilterScript/>"


@pytest.mark.parametrize("isolated", [[], ["--isolate"]])
def test_everything_that_a_step_measures_is_in_the_report(run, lopsided, tmp_path, isolated):
    (tmp_path / "s.mlx").write_text(
        '<FilterScript><filter name="Convex Hull"/><xmlfilter name="Compute Geometric Measures"/>'
        "</FilterScript>"
    )
    result = run(
        "run", tmp_path / "s.mlx", lopsided, "-o", tmp_path / "a.ply",
        "--json", tmp_path / "r.json", *isolated,
    )  # fmt: skip
    assert result.exit_code == 0, result.stderr
    report = json.loads((tmp_path / "r.json").read_text(encoding="utf-8"))
    measures = report["steps"][1]["measures"]
    points = read_layer(load(lopsided), 0).points
    np.testing.assert_allclose(measures["bbox"]["min"], points.min(axis=0))
    np.testing.assert_allclose(measures["bbox"]["max"], points.max(axis=0))
    assert measures["mesh_volume"] > 0
    assert np.shape(measures["inertia_tensor"]) == (3, 3)
    assert "mesh_volume:" in result.stdout


SMOOTH = (
    "<!DOCTYPE FilterScript><FilterScript>"
    '<filter name="Remove Duplicate Vertices"/><filter name="Compute normals for point sets"/>'
    "</FilterScript>"
)


@pytest.fixture
def normals(tmp_path):
    path = tmp_path / "normals.mlx"
    path.write_text(SMOOTH)
    return path


def test_inputs_are_thinned_out_first_and_that_is_told(run, normals, statue, tmp_path):
    small, out, report = (tmp_path / name for name in ("small.xyz", "o.mlp", "r.json"))
    small.write_text("".join(f"{x} {x * x} {x % 7}\n" for x in range(300)))
    whole = {tuple(row) for row in read_layer(load(statue), 0).points.tolist()}
    words = ("run", normals, statue, small, "-o", out, "--json", report, "--max-points", 1000)
    for more in ((), ("--isolate",)):
        result = run(*words, *more)
        assert result.exit_code == 0, result.stderr
        told = json.loads(report.read_text(encoding="utf-8"))
        (thinned,) = told["thinned"]
        assert told["max_points"] == 1000
        assert (thinned["path"], thinned["measured"]) == (str(statue), len(whole))
        assert 900 < thinned["points"] <= 1000
        numbers = f"thinned out from {len(whole)} to {thinned['points']} points"
        assert f"{statue}: {numbers}\n" in result.stdout
        layers = [mesh.vertex_matrix() for mesh in load_project(out)]
        assert [len(points) for points in layers] == [thinned["points"], 300]
        assert {tuple(row) for row in layers[0].tolist()} < whole
    written = next(path for path in tmp_path.glob("o*.ply"))
    assert re.search(rb"max_points\W+1000", written.read_bytes().partition(b"end_header")[0])


def test_too_few_points_to_thin_out_to(run, normals, statue, tmp_path):
    result = run("run", normals, statue, "-o", tmp_path / "o.ply", "--max-points", 99)
    assert (result.exit_code, result.stdout) == (2, "")
    assert "99 is not in the range x>=100" in result.stderr


def test_layers_whose_order_would_change_are_not_thinned_out(run, normals, statue, tmp_path):
    (tmp_path / "few.xyz").write_text("".join(f"{x} {x * x} {x % 7}\n" for x in range(300)))
    both = tmp_path / "both.mlp"
    assert run("run", normals, statue, tmp_path / "few.xyz", "-o", both).exit_code == 0
    result = run("run", normals, both, "-o", tmp_path / "o.ply", "--max-points", 1000)
    assert result.exit_code == 1
    assert f"error: {both} holds 2 layers, and another one than the last has" in result.stderr
    assert run("run", normals, both, "-o", tmp_path / "o.ply").exit_code == 0


def sparse(path, points):
    """Write a file of many points, all of them in a hole of the file."""
    header = f"ply\nformat binary_little_endian 1.0\nelement vertex {points}\n"
    header += "".join(f"property float {axis}\n" for axis in "xyz") + "end_header\n"
    with path.open("wb") as file:
        file.write(header.encode())
        file.truncate(len(header) + 12 * points)
    return path


@pytest.mark.parametrize("more", [(), ("--isolate",), ("--max-points", "1000")])
def test_a_scan_that_is_too_large_is_refused_before_it_is_read(run, normals, tmp_path, more):
    scan = sparse(tmp_path / "large.ply", 3 * 10**9)
    result = run("run", normals, scan, "-o", tmp_path / "o.ply", *more)
    assert (result.exit_code, result.stdout) == (1, "")
    assert result.stderr.startswith(f"error: {scan} has 3000000000 points; reading them alone")
    assert not (tmp_path / "o.ply").exists()


def test_a_size_that_was_not_announced_is_checked_after_loading(run, statue, tmp_path, monkeypatch):
    made = tmp_path / "crust.mlx"
    made.write_text(SMOOTH.replace("</Filt", '<filter name="power_crust_reconstruct"/></Filt'))
    monkeypatch.setattr("meshlab_symrecon.host.size.announced_points", lambda path: None)
    monkeypatch.setattr("meshlab_symrecon.host.size.available_memory", lambda: 10**6)
    result = run("run", made, statue, "-o", tmp_path / "o.ply")
    assert result.exit_code == 1
    assert re.match(rf"error: {re.escape(str(statue))}: \d+ points need about ", result.stderr)


def test_no_memory_is_asked_for_without_inputs(run, tmp_path, monkeypatch):
    monkeypatch.setattr("meshlab_symrecon.host.size.available_memory", lambda: 0)
    script = tmp_path / "cube.mlx"
    script.write_text('<FilterScript><filter name="Box/Cube"/></FilterScript>')
    assert run("run", script, "-o", tmp_path / "o.ply").exit_code == 0
