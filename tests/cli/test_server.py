"""Whole runs of command lines of meshlabserver."""

from __future__ import annotations

import json
import re
import subprocess
import sys

import numpy as np
import pytest

from meshlab_symrecon import __version__
from meshlab_symrecon.cli import server_run
from meshlab_symrecon.cli.server import LOUD, main
from meshlab_symrecon.cli.server_job import FLAGS
from meshlab_symrecon.host import size
from meshlab_symrecon.host.files import load, new_document
from meshlab_symrecon.host.mask import SAVED
from meshlab_symrecon.host.native_filters import native_filters
from meshlab_symrecon.host.paths import READABLE
from meshlab_symrecon.host.projects import load_project

HEAD = "<!DOCTYPE FilterScript>\n<FilterScript>\n"
MOVE = (
    '<filter name="Transform: Translate, Center, set Origin"><Param type="RichDynamicFloat" '
    'name="axisX" value="{x}" min="-99" max="99"/></filter>\n'
)
COPY = '<filter name="Duplicate Current layer"/>\n'
CUT = (
    '<filter name="Simplification: Quadric Edge Collapse Decimation"><Param type="RichInt" '
    'name="TargetFaceNum" value="{faces}"/></filter>\n'
)
SELECT_LAYER = (
    '<filter name="Change the current layer"><Param type="RichMesh" name="mesh" '
    'value="{layer}"/></filter>\n'
)
HAUSDORFF = (
    '<filter name="Hausdorff Distance"><Param type="RichMesh" name="SampledMesh" '
    'value="1"/><Param type="RichMesh" name="TargetMesh" value="0"/></filter>\n'
)


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A folder that is the current one, with 'cube.ply', 'ball 1.PLY' (coloured), 'copy.mlx'."""
    monkeypatch.chdir(tmp_path)
    mesh_set = new_document()
    mesh_set.create_cube()
    mesh_set.save_current_mesh("cube.ply")
    mesh_set.create_sphere(subdiv=2)
    mesh_set.compute_color_by_function_per_vertex(x="x*90+99", y="y*90+99", z="z*90+99")
    mesh_set.compute_scalar_by_function_per_vertex(q="x+2*y")
    mesh_set.save_current_mesh("ball 1.PLY")
    script(tmp_path / "copy.mlx", COPY)
    return tmp_path


def script(path, *steps):
    path.write_text(HEAD + "".join(steps) + "</FilterScript>\n")
    return path


@pytest.fixture
def serve(capfd, monkeypatch):
    """Return a function that runs a command line; it returns exit code, output and errors."""
    monkeypatch.setenv("QT_LOGGING_RULES", LOUD)  # as the program does, but for this test alone

    def call(*words):
        capfd.readouterr()
        with pytest.raises(SystemExit) as ended:
            main([str(word) for word in words])
        captured = capfd.readouterr()
        return ended.value.code, captured.out, captured.err

    return call


def counts(path):
    mesh_set = load(path)
    return [(mesh.vertex_number(), mesh.face_number()) for mesh in mesh_set]


def corner(path):
    mesh_set = load(path)
    return mesh_set.mesh(0).vertex_matrix().min(axis=0).round(6).tolist()


def names(folder):
    return sorted(path.name for path in folder.iterdir())


POINTS = ("xyz", "e57")
ROUND_TRIP = [name for name in SAVED if name in READABLE]


@pytest.mark.parametrize("extension", SAVED)
def test_conversion_into_every_format(serve, place, extension):
    code, out, err = serve("-i", "cube.ply", "-o", f"b.{extension}")
    assert code == 0, err
    assert "cube.ply loaded as layer 0 (8 vn 12 fn)" in out
    assert f"layer 'cube.ply' saved as b.{extension} (8 vn 12 fn)" in out
    assert (err != "") == (extension in POINTS)
    if extension in ROUND_TRIP:
        points, faces = counts(f"b.{extension}")[0]
        assert points in (8, 24, 36)  # some formats cut along edges
        assert faces == (0 if extension in POINTS else 12)
        assert corner(f"b.{extension}") == [-0.5] * 3
    assert [name for name in names(place) if name.startswith(".")] == []


@pytest.mark.parametrize("extension", ROUND_TRIP)
def test_conversion_from_every_format(serve, place, extension):
    assert serve("-i", "cube.ply", "-o", f"a.{extension.upper()}")[0] == 0
    code, _, err = serve("-i", f"a.{extension.upper()}", "-o", "c.ply")
    assert code == 0, err
    assert corner("c.ply") == [-0.5] * 3


def test_without_m_coordinates_and_faces_alone(serve, place):
    assert serve("-i", "ball 1.PLY", "-o", "a.ply")[0] == 0
    header = (place / "a.ply").read_bytes().partition(b"end_header")[0].decode()
    assert re.findall(r"property .*?(\w+)\n", header) == ["x", "y", "z", "vertex_indices"]
    assert serve("-i", "ball 1.PLY", "-o", "b.ply", "-m", "vc", "sa")[0] == 0
    text = (place / "b.ply").read_text()
    assert "property uchar red" in text
    assert "quality" not in text


def test_scripts_run_in_order_on_the_last_mesh_whatever_the_order_of_options(serve, place):
    script(place / "one.mlx", MOVE.format(x=1))
    script(place / "ten.mlx", MOVE.format(x=2), COPY, MOVE.format(x=4))
    words = ["-o", "last.ply", "-s", "one.mlx", "-i", "cube.ply", "-o", "first.ply", "-l", "0"]
    words += ["-s", "ten.mlx", "-o", "one.ply", "-l", "x"]
    code, out, err = serve(*words)
    assert code == 0, err
    assert corner("first.ply")[0] == 2.5
    assert corner("last.ply") == corner("one.ply") == [6.5, -0.5, -0.5]
    steps = re.findall(r"^(\S+\.mlx:\d+): (\w+)", out, re.MULTILINE)
    assert [place for place, _ in steps] == ["one.mlx:3", "ten.mlx:3", "ten.mlx:4", "ten.mlx:5"]
    assert out.index("cube.ply loaded") < out.index("one.mlx:3") < out.index("saved as last.ply")


def test_layers_are_positions(serve, place):
    lines = [SELECT_LAYER.format(layer=1), COPY, SELECT_LAYER.format(layer=0)]
    script(place / "s.mlx", *lines)
    words = ["-i", "cube.ply", "ball 1.PLY", "cube.ply", "-s", "s.mlx"]
    words += ["-o", "c.ply", "-o", "cc.ply", "-l", "c", "-o", "x.ply", "-l", "x"]
    words += ["-o", "l.ply", "-l", "l", "-o", "1.ply", "-l", "1", "-o", "2.ply", "-l", "2"]
    code, _, err = serve(*words)
    assert code == 0, err
    cube, ball = [(8, 12)], [(162, 320)]
    found = {name: counts(f"{name}.ply") for name in ("c", "cc", "x", "l", "1", "2")}
    assert found == {"c": cube, "cc": cube, "x": ball, "l": ball, "1": ball, "2": cube}


def test_several_files_behind_one_o_are_the_first_layers(serve, place):
    assert serve("-i", "cube.ply", "ball 1.PLY", "-o", "a.off", "b.off")[0] == 0
    assert counts("a.off") + counts("b.off") == [(8, 12), (162, 320)]


def test_a_document_that_stays_empty_has_no_layer(serve, place):
    script(place / "s.mlx")
    for layer in ("c", "x", "0"):
        code, _, err = serve("-s", "s.mlx", "-o", "a.ply", "-l", layer)
        assert code == 1
        assert err == "error: a.ply cannot be written: there is no layer; load one (-i)\n"


def test_the_log_may_be_a_device(serve, place):
    assert serve("-l", "/dev/null", "-i", "cube.ply", "-o", "a.ply")[0] == 0


@pytest.mark.parametrize("step", ["Select All", "Normalize Vertex Normals"])
def test_textures_are_copied(serve, place, step):
    mesh_set = load("ball 1.PLY")
    mesh_set.compute_texcoord_parametrization_triangle_trivial_per_wedge(textdim=128)
    mesh_set.compute_texmap_from_color(textname="a.png", textw=128, texth=128)
    mesh_set.save_current_mesh("t.obj")
    marked = (place / "a.png").read_bytes() + b"mark"  # behind the picture, where none looks
    (place / "a.png").write_bytes(marked)
    script(place / "s.mlx", f'<filter name="{step}"/>\n')
    (place / "out").mkdir()
    code, _, err = serve("-i", "t.obj", "-s", "s.mlx", "-o", "out/t.obj", "-m", "wt")
    assert code == 0, err
    assert (place / "out" / "a.png").read_bytes() == marked
    assert names(place / "out") == ["a.png", "t.obj", "t.obj.mtl"]


def test_a_script_may_make_the_first_layer(serve, place):
    script(place / "s.mlx", '<filter name="Icosahedron"/>\n')
    assert serve("-s", "s.mlx", "-o", "a.ply")[0] == 0
    assert counts("a.ply") == [(12, 20)]


def test_in_place(serve, place):
    script(place / "s.mlx", CUT.format(faces=100))
    code, _, err = serve("-i", "ball 1.PLY", "-o", "ball 1.PLY", "-s", "s.mlx", "-m", "vc", "vq")
    assert code == 0, err
    assert counts("ball 1.PLY")[0][1] == 100
    before = (place / "ball 1.PLY").read_bytes()
    script(place / "s.mlx", SELECT_LAYER.format(layer=3))
    assert serve("-i", "ball 1.PLY", "-o", "ball 1.PLY", "-s", "s.mlx")[0] == 1
    assert (place / "ball 1.PLY").read_bytes() == before


def test_one_output_that_fails_leaves_the_others(serve, place):
    script(place / "s.mlx", '<filter name="Icosahedron"/>\n', COPY)
    words = [
        "-i",
        "cube.ply",
        "-s",
        "s.mlx",
        "-o",
        "a.ply",
        "-o",
        "b.ply",
        "-l",
        "7",
        "-o",
        "c.ply",
    ]
    code, out, err = serve(*words, "--json", "r.json", "-l", "log.txt")
    assert code == 1
    assert err == (
        "error: b.ply cannot be written: there is no layer 7 (-l); the document has layers 0 to 2\n"
    )
    assert "saved as c.ply" in out
    assert names(place) == sorted(
        ["ball 1.PLY", "cube.ply", "copy.mlx", "s.mlx", "a.ply", "c.ply", "r.json", "log.txt"]
    )
    report = json.loads((place / "r.json").read_text())
    assert [entry["written"] for entry in report["outputs"]] == [True, False, True]
    assert report["exit_code"] == 1
    assert err.strip() in (place / "log.txt").read_text()


def test_a_writer_that_fails_leaves_the_process_where_it_was(serve, place):
    function = '<Param type="RichString" name="q" value="x+5"/>'
    script(place / "s.mlx", f'<filter name="Per Vertex Quality Function">{function}</filter>\n')
    (place / "out").mkdir()
    words = ["-i", "cube.ply", "-s", "s.mlx", "-o", "out/a.e57", "-m", "vq", "-o", "out/b.ply"]
    code, _, err = serve(*words, "--json", "r.json", "-l", "log.txt")
    assert code == 1
    assert "error: out/a.e57 cannot be written" in err
    assert names(place / "out") == ["b.ply"]
    assert {"r.json", "log.txt"} <= set(names(place))


def test_the_log_of_a_reader_that_fails_is_where_it_should_be(serve, place):
    (place / "in").mkdir()
    (place / "in" / "bad.off").write_text("hello")
    code, _, err = serve("-l", "log.txt", "-i", "in/bad.off", "-o", "a.ply")
    assert code == 1
    assert err.strip() in (place / "log.txt").read_text()
    assert names(place / "in") == ["bad.off"]


def test_a_layer_that_cannot_be_is_refused_before_anything_is_written(serve, place):
    code, _, err = serve("-i", "cube.ply", "-o", "a.ply", "-o", "b.ply", "-l", "1")
    assert code == 1
    assert "there is no layer 1 (-l); the document has layers 0 to 0" in err
    assert names(place) == ["ball 1.PLY", "copy.mlx", "cube.ply"]


def test_everything_is_checked_first_and_told_at_once(serve, place):
    script(place / "bad.mlx", '<filter name="Close Hole"/>\n')
    (place / "broken.mlx").write_text("<FilterScript>")
    (place / "p.mlp").write_text('<MeshLabProject><MLMesh filename="gone.ply"/></MeshLabProject>')
    before = names(place)
    words = [
        "-i",
        "none.ply",
        "cube.doc",
        "cube.ply",
        "-p",
        "p.mlp",
        "-s",
        "bad.mlx",
        "broken.mlx",
        "no.mlx",
    ]
    words += ["-o", "a.gts", "-o", "x/y.ply", "-o", "copy.mlx", "-o", "b.ply", "-o", "b.ply"]
    words += ["-w", "cube.ply.mlp", "-l", "none/log.txt", "--json", "cube.ply", "-d", "b.ply"]
    code, out, err = serve(*words)
    assert (code, out) == (1, "")
    lines = err.splitlines()
    assert lines[0].startswith("error: ")
    for words in (
        "bad.mlx:3: no filter is called 'Close Hole'; did you mean 'Close Holes'?",
        "broken.mlx:1: this is not XML",
        "script no.mlx cannot be read: No such file",
        "none.ply cannot be read: no such file",
        "cube.doc cannot be read: no such file",
        "project p.mlp names 1 mesh files that are not there: gone.ply",
        "a.gts has the extension '.gts', which cannot be written",
        "x/y.ply cannot be written: no directory",
        "copy.mlx has the extension '.mlx'",
        "b.ply would overwrite b.ply",
        "none/log.txt cannot be written: no directory",
        "cube.ply would overwrite cube.ply",
    ):
        assert sum(words in line for line in lines) >= 1, words
    assert names(place) == before


def test_an_input_of_no_known_format(serve, place):
    (place / "a.doc").write_text("x")
    code, _, err = serve("-i", "a.doc", "-o", "b.ply")
    assert code == 1
    assert "a.doc is of no format that can be read" in err


@pytest.mark.parametrize("words", [[], ["-o", "a.ply"], ["-q"], ["-i", "cube.ply", "-m", "xx"]])
def test_wrong_usage_is_2(serve, place, words):
    code, out, err = serve(*words)
    assert (code, out) == (2, "")
    assert err.startswith("Error: ")
    assert len(err.splitlines()) == 1


def test_flags_that_a_format_cannot_hold_are_told(serve, place):
    code, _, err = serve("-i", "ball 1.PLY", "-o", "a.stl", "-m", "vc", "vq")
    assert code == 0
    assert err == "warning: a.stl: .stl holds no vc, vq; they were left out\n"


def test_keep_all_keeps_what_the_layer_has(serve, place):
    script(
        place / "s.mlx",
        '<filter name="Define New Per Vertex Custom Scalar Attribute">'
        '<Param type="RichString" name="name" value="mine"/>'
        '<Param type="RichString" name="expr" value="x"/></filter>\n',
    )
    assert serve("-i", "ball 1.PLY", "-s", "s.mlx", "-o", "a.ply", "--keep-all")[0] == 0
    before, after = load("ball 1.PLY"), load("a.ply")
    for method in ("vertex_color_matrix", "vertex_scalar_array", "vertex_matrix", "face_matrix"):
        old, new = (getattr(document.mesh(0), method)() for document in (before, after))
        assert np.array_equal(old, new), method
    assert b"property double mine" in (place / "a.ply").read_bytes()


MATRIX = np.array([[0.0, -1, 0, 5], [1, 0, 0, 0], [0, 0, 1, 0.1], [0, 0, 0, 1]])


def project(place):
    text = " ".join(map(repr, MATRIX.ravel().tolist()))
    path = place / "p.mlp"
    path.write_text(
        f'<MeshLabProject><MeshGroup><MLMesh label="a" filename="cube.ply"><MLMatrix44>{text}'
        '</MLMatrix44></MLMesh><MLMesh label="b" filename="ball 1.PLY"/></MeshGroup>'
        "</MeshLabProject>"
    )
    return path


def test_matrices_stay_out_of_meshes_unless_baked(serve, place):
    project(place)
    assert serve("-p", "p.mlp", "-o", "a.ply", "-l", "0")[0] == 0
    assert corner("a.ply") == [-0.5, -0.5, -0.5]
    assert serve("-p", "p.mlp", "-o", "b.ply", "-l", "0", "--bake", "-w", "baked.mlp")[0] == 0
    assert corner("b.ply") == [4.5, -0.5, -0.4]
    baked = load_project(place / "baked.mlp")
    assert np.array_equal(baked.mesh(0).transform_matrix(), np.eye(4))
    np.testing.assert_allclose(baked.mesh(0).vertex_matrix().min(axis=0), [4.5, -0.5, -0.4])


def test_projects_in_and_out(serve, place):
    project(place)
    script(place / "s.mlx", SELECT_LAYER.format(layer=0), COPY)
    words = ["-p", "p.mlp", "-i", "cube.ply", "-s", "s.mlx", "-w", "o.mlp", "-w", "q"]
    code, out, err = serve(*words)
    assert code == 0, err
    assert "the project is written as q.mlp" in out
    for name, middle in (("o.mlp", "_out"), ("q.mlp", "_out1")):
        written = load_project(place / name)
        assert [mesh.label() for mesh in written] == ["a", "b", "cube.ply", "a_copy"]
        assert np.array_equal(written.mesh(0).transform_matrix(), MATRIX)
        assert np.array_equal(written.mesh(3).transform_matrix(), MATRIX)
        assert written.mesh(1).has_vertex_color()
        for file in (f"cube{middle}.ply", f"ball 1{middle}.PLY", f"a_copy{middle}.ply"):
            assert (place / file).exists()
    assert counts("cube.ply") == [(8, 12)]


def test_hidden_layers_are_not_merged(serve, place):
    written = project(place).read_text()
    (place / "p.mlp").write_text(written.replace('label="a"', 'label="a" visible="0"'))
    script(place / "s.mlx", '<filter name="Flatten Visible Layers"/>\n')
    code, _, err = serve("-p", "p.mlp", "-s", "s.mlx", "-o", "a.ply", "-w", "o.mlp")
    assert code == 0, err
    hidden, shown = counts("cube.ply"), counts("ball 1.PLY")
    assert counts("a.ply") == shown
    written = load_project(place / "o.mlp")
    assert [mesh.is_visible() for mesh in written] == [False, True]
    assert written.mesh(0).vertex_number() == hidden[0][0]


def test_x_overwrites_the_files_of_the_layers(serve, place):
    script(place / "s.mlx", CUT.format(faces=200))
    code, _, err = serve("-i", "cube.ply", "ball 1.PLY", "-s", "s.mlx", "-w", "o.mlp", "-x")
    assert code == 0, err
    assert counts("ball 1.PLY")[0][1] == 200
    assert names(place) == ["ball 1.PLY", "copy.mlx", "cube.ply", "o.mlp", "s.mlx"]


def test_a_project_that_fails_is_an_error_and_outputs_are_written(serve, place):
    assert serve("-i", "cube.ply", "-o", "cube.stl")[0] == 0
    script(
        place / "s.mlx",
        SELECT_LAYER.format(layer=0),
        '<filter name="Select All"/><filter name="Delete Selected Faces"/>\n',
    )
    words = ["-i", "cube.stl", "ball 1.PLY", "-s", "s.mlx", "-w", "o.mlp", "-o", "b.ply", "-l", "1"]
    code, _, err = serve(*words)
    assert code == 1
    assert "cube_out.stl: .stl holds faces only" in err
    for name in ("o.mlp", "cube_out.stl", "ball 1_out.PLY"):
        assert not (place / name).exists()
    assert (place / "b.ply").exists()


def test_the_log_is_appended_with_everything(serve, place):
    (place / "log.txt").write_text("before\n")
    script(place / "old.mlx", '<filter name="Remove Duplicated Vertex"/>\n')
    words = ["-l", "log.txt", "-i", "cube.ply", "-o", "a.obj", "-m", "vq", "-s", "old.mlx"]
    code, out, err = serve(*words)
    assert code == 0, err
    lines = (place / "log.txt").read_text().splitlines()
    assert lines[0] == "before"
    assert re.fullmatch(
        rf"\d{{4}}-.* symrecon-server {re.escape(__version__)} -l log.txt .*", lines[1]
    )
    assert [
        line for line in lines[2:] if line and not line.startswith("warning")
    ] == out.splitlines()
    assert "warning: a.obj: .obj holds no vq; they were left out" in lines
    assert any(line.startswith("old.mlx:3: mapped") and line.endswith("s)") for line in lines)
    assert any("Remove Duplicate Vertices" in line for line in lines)
    script(place / "bad.mlx", SELECT_LAYER.format(layer=9))
    code, _, err = serve("-l", "log.txt", "-i", "cube.ply", "-s", "bad.mlx")
    assert code == 1
    assert err.strip() in (place / "log.txt").read_text()


def test_strict_and_lenient(serve, place):
    script(place / "s.mlx", '<filter name="Remove Duplicated Vertex"/><filter name="No Such"/>\n')
    assert serve("-i", "cube.ply", "-s", "s.mlx", "-o", "a.ply")[0] == 1
    code, out, _ = serve("-i", "cube.ply", "-s", "s.mlx", "-o", "a.ply", "--lenient")
    assert code == 0
    assert "skipped No Such" in out
    script(place / "s.mlx", '<filter name="Remove Duplicated Vertex"/>\n')
    assert serve("-i", "cube.ply", "-s", "s.mlx", "-o", "b.ply")[0] == 0
    code, _, err = serve("-i", "cube.ply", "-s", "s.mlx", "-o", "c.ply", "--strict")
    assert code == 1
    assert err.startswith("error: s.mlx:3: ")
    assert not (place / "c.ply").exists()


def test_dry_run_does_nothing(serve, place):
    before = names(place)
    words = ["-i", "cube.ply", "-s", "copy.mlx", "-o", "a.ply", "-w", "o.mlp", "--dry-run"]
    code, out, err = serve(*words, "-l", "log.txt", "-d", "list.txt", "--json", "r.json")
    assert (code, err) == (0, "")
    for word in ("cube.ply", "copy.mlx: 1 step", "a.ply", "o.mlp", "log.txt", "list.txt", "r.json"):
        assert word in out
    assert names(place) == before
    assert "copy.mlx: 1 step would run" in out
    assert serve("-i", "none.ply", "-o", "a.ply", "--dry-run")[0] == 1


@pytest.mark.parametrize("dry", [[], ["--dry-run"]])
def test_all_scripts_are_checked_in_a_row_on_what_was_loaded(serve, place, dry):
    """The second script needs what the first does not make, or does."""
    script(place / "cut.mlx", CUT.format(faces=4))
    script(place / "third.mlx", SELECT_LAYER.format(layer=2), COPY)
    words = ["-i", "cube.ply", "-o", "a.ply", *dry]
    assert serve("-s", "copy.mlx", "-s", "copy.mlx", "-s", "third.mlx", *words)[0] == 0
    before = names(place)
    code, out, err = serve("-s", "cut.mlx", "-s", "copy.mlx", "-s", "third.mlx", *words)
    assert code == 1
    assert "error: third.mlx:3: " in err
    assert "the document has 2 layers at this step" in err
    assert "ran" not in out
    assert names(place) == before


def test_dry_run_reads_the_inputs(serve, place):
    (place / "bad.ply").write_text("ply\nnothing\n")
    code, _, err = serve("-i", "bad.ply", "-o", "a.ply", "--dry-run")
    assert code == 1
    assert "bad.ply is damaged" in err
    code, _, err = serve("-i", "cube.ply", "-o", "a.ply", "-l", "1", "--dry-run")
    assert code == 1
    assert "there is no layer 1 (-l); the document has layers 0 to 0" in err
    script(place / "s.mlx", SELECT_LAYER.format(layer=5))
    words = ["-i", "cube.ply", "-s", "copy.mlx", "s.mlx", "-o", "a.ply", "--dry-run"]
    assert serve(*words)[0] == 1
    code, out, err = serve(*words, "--lenient")
    assert (code, err) == (0, "")
    assert "    s.mlx:3: parameter 'mesh' must be the position of a layer" in out


def test_report(serve, place):
    script(place / "s.mlx", HAUSDORFF, '<filter name="Compute Geometric Measures"/>\n')
    words = ["-i", "cube.ply", "ball 1.PLY", "-s", "s.mlx", "-o", "a.ply", "-m", "vc", "vn"]
    code, _, err = serve(*words, "--json", "r.json")
    assert code == 0, err
    report = json.loads((place / "r.json").read_text())
    assert report["inputs"] == ["cube.ply", "ball 1.PLY"]
    (ran,) = report["scripts"]
    assert [step["filter"] for step in ran["steps"]] == [
        "get_hausdorff_distance", "get_geometric_measures",
    ]  # fmt: skip
    assert ran["steps"][0]["measures"]["max"] == 0.5
    assert report["outputs"] == [
        {"path": "a.ply", "flags": ["vc", "vn"], "written": True, "layer": "ball 1.PLY",
         "points": 162, "faces": 320}
    ]  # fmt: skip
    assert report["exit_code"] == 0


def test_every_filter_is_dumped_and_listed(serve, place):
    assert serve("-d", "list.txt")[0] == 0
    text = (place / "list.txt").read_text()
    code, out, _ = serve("--list-filters")
    assert code == 0
    for item in native_filters().values():
        assert f"\n{item.menu_name}\n{item.python_name}\n" in text
        assert item.python_name in out
        for parameter in item.parameters:
            assert f"- {parameter.script_name} : {parameter.rich_type}" in text
    assert text.startswith("Detect Reflection Planes (AP)\ngenerate_reflection_planes\n")


def test_help_names_every_option_and_flag(serve, place):
    code, out, _ = serve("--help")
    assert code == 0
    options = "-i -p -s -o -l -m -w -x -d -om --keep-all --bake --strict --lenient --dry-run"
    options += " --json --list-filters --help --version"
    for word in (*options.split(), *FLAGS):
        assert re.search(rf"(^|\s){word}\b", out), word
    assert max(map(len, out.splitlines())) <= 100
    assert serve("--version")[1] == f"symrecon-server {__version__}\n"


def run(*words, **options):
    command = [sys.executable, "-m", "meshlab_symrecon.cli.server", *words]
    return subprocess.run(command, capture_output=True, text=True, check=False, **options)


def test_scripts_that_read_measures_from_the_output(place):
    """The lines that MeshLab's filters log stand on the output, bare, and in the log file."""
    script(place / "s.mlx", HAUSDORFF)
    ended = run("-s", "s.mlx", "-i", "cube.ply", "ball 1.PLY", "-l", "log.txt", cwd=place)
    assert ended.returncode == 0, ended.stderr
    lines = ended.stdout.splitlines()
    found = lines.index("Hausdorff Distance computed")
    assert re.match(r"\s*Sampled 162 pts", lines[found + 1])
    numbers = re.match(r"\D+(\d+\.\d+)\D+(\d+\.\d+)\D+(\d+\.\d+)\D+(\d+\.\d+)", lines[found + 2])
    low, high, mean, rms = map(float, numbers.groups())
    assert (high, low < mean < rms < high) == (0.5, True)
    assert lines[found] in (place / "log.txt").read_text().splitlines()
    assert ended.stderr == ""
    assert found < next(i for i, line in enumerate(lines) if line.startswith("s.mlx:3: ran"))


def test_a_shell_script_works_by_changing_one_word(place):
    lines = (
        "set -e\nfor f in *.ply *.PLY; do\n"
        '  meshlabserver -i "$f" -o "${f%.*}.obj" -m vc vn -s copy.mlx 2>/dev/null\n'
        '  [ -f "${f%.*}.obj" ]\ndone\n'
        "meshlabserver -i none.ply -o none.obj 2>/dev/null || echo failed $?\n"
    )
    lines = lines.replace("meshlabserver", f"{sys.executable} -m meshlab_symrecon.cli.server")
    ended = subprocess.run(
        ["sh", "-c", lines], cwd=place, capture_output=True, text=True, check=False
    )
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout.splitlines()[-1] == "failed 1"
    assert counts("ball 1.obj") == [(162, 320)]


def announcing(path, points):
    """Write a cloud of zeros that takes no room on the disk."""
    lines = ["ply", "format binary_little_endian 1.0", f"element vertex {points}"]
    lines += ["property float x", "property float y", "property float z", "end_header", ""]
    head = "\n".join(lines).encode()
    with path.open("wb") as file:
        file.write(head)
        file.truncate(len(head) + 12 * points)
    return path


REFUSED = (
    r"error: large\.ply has 4000000 points; {work} needs about [23]\.\d GB and 2\.0 GB are free; "
    r"{out}, or use a machine with more memory\n"
)


@pytest.fixture
def little(monkeypatch, place):
    """Two gigabytes of memory, a large cloud, a project that names it, 'crust.mlx'."""
    monkeypatch.setattr(size, "available_memory", lambda: 2 * 10**9)
    announcing(place / "large.ply", 4_000_000)
    (place / "p.mlp").write_text(
        "<!DOCTYPE MeshLabDocument><MeshLabProject><MeshGroup>"
        '<MLMesh label="a" filename="large.ply"/></MeshGroup></MeshLabProject>'
    )
    script(place / "points.mlx", '<filter name="Mirror-Complete Points"/>\n')
    return place


@pytest.mark.parametrize("words", [("-i", "large.ply"), ("-p", "p.mlp"), ("--dry-run", "p.mlp")])
def test_what_does_not_fit_into_memory_is_told_before_it_is_read(serve, little, words, monkeypatch):
    monkeypatch.setattr(server_run, "load_item", lambda *given: pytest.fail("it was read"))
    words = (words[0], "-i", words[1]) if words[0] == "--dry-run" else words
    before = names(little)
    code, out, err = serve(*words, "-s", "points.mlx", "-o", "a.ply")
    out_of_it = r"run it with symrecon run --max-points \d+, which thins the scan out evenly first"
    assert (code, out) == (1, "")
    assert re.fullmatch(REFUSED.format(work="the script", out=out_of_it), err)
    code, out, err = serve(*words, "-s", "points.mlx", "points.mlx", "-o", "a.ply")
    out_of_it = r"simplify it to \d+ points first \(symrecon apply .*\)"
    assert re.fullmatch(REFUSED.format(work="a row of scripts", out=out_of_it), err)
    assert names(little) == before


def test_inputs_add_up_in_memory(serve, little):
    announcing(little / "c.ply", 2_500_000)
    code, _, err = serve("-i", *["c.ply"] * 9, "-o", "a.ply")
    assert code == 1
    assert err.startswith("error: c.ply has 2500000 points; reading them alone needs about ")
    assert "beside the other inputs; " in err


def test_what_its_file_did_not_tell_is_told_after_loading(serve, little, monkeypatch):
    monkeypatch.setattr(size, "announced_points", lambda path: None)
    monkeypatch.setattr(size, "used_memory", lambda: 10**9)
    monkeypatch.setattr(size, "available_memory", lambda: 3 * 10**8)
    script(little / "crust.mlx", '<filter name="Surface Reconstruction: Power Crust"/>\n')
    announcing(little / "c.ply", 200_000)
    code, _, err = serve("-i", "c.ply", "-s", "crust.mlx", "-o", "a.ply")
    assert code == 1
    assert re.search(
        r"c\.ply: \d+ points need about 0\.\d GB more in .*; run it with symrecon run", err
    )
    assert not (little / "a.ply").exists()
