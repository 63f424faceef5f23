"""``symrecon upgrade``: old scripts in today's names, in words, as programs."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pymeshlab
import pytest

from meshlab_symrecon.host.files import load
from meshlab_symrecon.host.meshset import read_layer

STEPS = {
    "good": """<filter name="Quadric Edge Collapse Decimation">
<Param type="RichInt" name="TargetFaceNum" value="100"/></filter>""",
    "ours": """<filter name="Detect Reflection Planes (AP)">
<Param type="RichInt" name="samples" value="100"/></filter>""",
    "change": """<filter name="Change the current layer">
<Param type="RichMesh" name="mesh" value="0"/></filter>""",
    "unknown": '<filter name="No Such Filter"/>',
    "untyped": """<xmlfilter name="Screened Poisson"><xmlparam name="depth" value="4"/>
<xmlparam name="threads" value="1"/></xmlfilter>""",
}


@pytest.fixture
def old(tmp_path):
    """Return a function that writes 'old.mlx' with steps of the table above."""

    def make(*names):
        path = tmp_path / "old.mlx"
        steps = "\n".join(STEPS[name] for name in names)
        path.write_text(f"<!DOCTYPE FilterScript>\n<FilterScript>\n{steps}\n</FilterScript>\n")
        return path

    return make


@pytest.fixture
def ball(tmp_path):
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.create_sphere(subdiv=3)
    mesh_set.save_current_mesh(str(tmp_path / "ball.ply"))
    return tmp_path / "ball.ply"


def test_the_new_script_does_what_the_old_one_did(run, old, ball, tmp_path):
    path, new = old("untyped", "good", "ours"), tmp_path / "new.mlx"
    before = path.read_bytes()
    result = run("upgrade", path, new)
    assert result.exit_code == 0, result.stderr
    assert f"{path}:5: 'Quadric Edge Collapse Decimation' is 'Simplif" in result.stdout
    assert result.stdout.endswith(f"\nwritten {new}\n")
    assert path.read_bytes() == before
    for script, out in ((path, "a.ply"), (new, "b.ply")):
        done = run("run", script, ball, "-o", tmp_path / out)
        assert done.exit_code == 0, done.stderr
    assert (tmp_path / "a.ply").read_bytes() == (tmp_path / "b.ply").read_bytes()


def test_without_a_new_name_the_script_is_printed(run, old, tmp_path):
    path = old("good", "change")
    printed = run("upgrade", path)
    assert printed.exit_code == 0
    assert run("upgrade", path, tmp_path / "new.mlx").exit_code == 0
    assert printed.stdout == (tmp_path / "new.mlx").read_text()
    assert run("upgrade", tmp_path / "new.mlx").stdout == printed.stdout


def test_a_script_of_today_is_copied_letter_by_letter(run, tmp_path):
    text = '<FilterScript >\n <filter   name="Close Holes"></filter>\n</FilterScript>'
    (tmp_path / "new.mlx").write_text(text)
    assert run("upgrade", tmp_path / "new.mlx", tmp_path / "copy.mlx").exit_code == 0
    assert (tmp_path / "copy.mlx").read_text() == text


@pytest.mark.parametrize("option", [(), ("--to-python",), ("--native-only",)])
def test_mistakes_are_told_and_nothing_is_written(run, old, tmp_path, option):
    path = old("unknown", "good", "unknown")
    result = run("upgrade", path, tmp_path / "new", *option)
    assert result.exit_code == 1
    assert result.stdout == ""
    assert result.stderr.startswith(f"error: {path}:3: no filter is called 'No Such Filter'")
    assert f"\n{path}:6: no filter" in result.stderr
    assert [file.name for file in tmp_path.iterdir()] == ["old.mlx"]


def test_what_cannot_run_is_left_out_when_asked(run, old):
    result = run("upgrade", old("unknown", "good"), "--lenient")
    assert result.exit_code == 0
    assert "<!-- line 3: this step was left out: no filter is called 'No Such" in result.stdout
    assert result.stdout.count("<filter") == 1


def test_the_old_script_is_never_written_to(run, old, tmp_path):
    path = old("good")
    (tmp_path / "link.mlx").symlink_to(path)
    before = path.read_bytes()
    for target in (path, tmp_path / "link.mlx", tmp_path / "." / "old.mlx"):
        result = run("upgrade", path, target)
        assert result.exit_code == 1
        assert "would overwrite" in result.stderr
    assert path.read_bytes() == before


def test_a_script_in_words(run, old, tmp_path):
    path = old("good", "unknown", "ours")
    result = run("upgrade", path, "--explain")
    assert result.exit_code == 0
    assert "1. Simplification: Quadric Edge Collapse Decimation (line 3)" in result.stdout
    assert "MISTAKE: no filter is called 'No Such Filter'" in result.stdout
    assert "3. Detect Reflection Planes (AP) (line 6)" in result.stdout
    assert run("upgrade", path, tmp_path / "words.txt", "--explain").exit_code == 0
    assert (tmp_path / "words.txt").read_text() == result.stdout


def test_a_script_in_words_without_ours(run, old):
    path = old("good", "ours", "change")
    result = run("upgrade", path, "--explain", "--native-only")
    assert result.exit_code == 0
    assert "2. Detect Reflection Planes (AP) (line 5)\n   Does not run.\n" in result.stdout
    assert "MISTAKE: MeshLab's scripts cannot change the current layer" in result.stdout


def test_the_program_does_what_the_script_does(run, old, ball, tmp_path):
    path = old("good", "untyped", "ours", "change")
    assert run("upgrade", path, tmp_path / "same.py", "--to-python").exit_code == 0
    command = [sys.executable, "same.py", ball.name, "a.ply"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert run("run", path, ball, "-o", tmp_path / "b.ply").exit_code == 0
    made, expected = (read_layer(load(tmp_path / name), 0) for name in ("a.ply", "b.ply"))
    assert len(expected.faces) == 100
    assert np.array_equal(made.points, expected.points)
    assert np.array_equal(made.faces, expected.faces)


def test_a_program_without_ours(run, old):
    path = old("good", "ours", "change")
    result = run("upgrade", path, "--to-python", "--native-only")
    assert result.exit_code == 0
    assert "load_plugins" not in result.stdout
    assert "ms.set_current_mesh(" in result.stdout
    assert "# line 5: 'Detect Reflection Planes (AP)' left out" in result.stdout
    assert result.stderr.startswith(f"{path}:5: 'Detect Reflection Planes (AP)' left out: it is no")


def test_a_native_script_names_what_was_left_out(run, old, tmp_path):
    path, new = old("ours", "untyped", "good"), tmp_path / "new.mlx"
    result = run("upgrade", path, new, "--native-only")
    assert result.exit_code == 0
    assert result.stderr == (
        f"{path}:3: 'Detect Reflection Planes (AP)' left out: it is no filter of MeshLab's own\n"
        f"{path}:7: not given, since chosen when it runs: Selected; MeshLab's window may "
        "want it\n"
    )
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.create_sphere(subdiv=3)
    mesh_set.load_filter_script(str(new))
    mesh_set.apply_filter_script()
    assert mesh_set.current_mesh().face_number() == 100


def test_what_a_native_script_cannot_hold(run, old, tmp_path):
    path = old("good", "change")
    result = run("upgrade", path, tmp_path / "new.mlx", "--native-only")
    assert result.exit_code == 1
    assert result.stderr.endswith(
        f"error: {path}:5: MeshLab's scripts cannot change the current layer; click on it\n"
    )
    assert not (tmp_path / "new.mlx").exists()
    result = run("upgrade", path, tmp_path / "new.mlx", "--native-only", "--lenient")
    assert result.exit_code == 0
    assert f"{path}:5: MeshLab's scripts cannot" in result.stderr
    assert "Change the current layer" not in (tmp_path / "new.mlx").read_text()


@pytest.mark.parametrize("option", [(), ("--to-python",), ("--explain",)])
def test_a_native_script_of_which_nothing_is_left(run, old, option):
    result = run("upgrade", old("ours", "change"), "--native-only", *option)
    assert result.exit_code == 1
    assert "old.mlx:1: no step that can run is a filter of MeshLab's own" in result.stderr


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        ((), 2, "Missing argument 'OLD.mlx'"),
        (("a", "b", "c"), 2, "unexpected extra argument"),
        (("a", "--to-python", "--explain"), 2, "--explain and --to-python exclude each other"),
        (("a", "--strict"), 2, "No such option"),
        (("nowhere.mlx",), 1, "nowhere.mlx cannot be read: No such file"),
        (("nowhere.mlx", "no/folder/new.mlx"), 1, "no directory is at"),
    ],
)
def test_wrong_usage_and_wrong_paths(run, words, code, message):
    result = run("upgrade", *words)
    assert result.exit_code == code
    assert message in result.stderr


def test_broken_xml_is_an_error_with_its_line(run, tmp_path):
    (tmp_path / "old.mlx").write_text("<FilterScript>\n<filter name='A'>\n</FilterScript>")
    for option in ((), ("--explain",), ("--to-python",), ("--native-only",)):
        result = run("upgrade", tmp_path / "old.mlx", *option)
        assert result.exit_code == 1
        assert "old.mlx:3: this is not XML" in result.stderr


def test_the_help_has_an_example(run):
    result = run("upgrade", "--help")
    assert result.exit_code == 0
    assert "symrecon upgrade old.mlx new.mlx" in result.stdout


def test_a_script_through_a_pipe(shell):
    text = '<FilterScript><filter name="Close Holes"/></FilterScript>'
    done = shell("upgrade", "/dev/stdin", input=text)
    assert done.returncode == 0, done.stderr
    assert '<filter name="Close Holes" />' in done.stdout


def test_an_upgraded_change_of_layer_passes_a_strict_run(run, old, ball, tmp_path):
    path, new = old("change", "good"), tmp_path / "new.mlx"
    assert run("upgrade", path, new).exit_code == 0
    assert "<!-- line 3: the current layer changes, by position -->" in new.read_text()
    checked = run("check", new, ball, "--strict")
    assert checked.exit_code == 0
    assert f"{new}:4: note: the current layer changes, by position" in checked.stdout
    done = run("run", new, ball, "-o", tmp_path / "out.ply", "--strict")
    assert done.exit_code == 0, done.stderr
    assert run("run", path, ball, "-o", tmp_path / "out.ply", "--strict").exit_code == 1


def test_of_a_script_without_steps_an_empty_one_is_left(run, old, tmp_path):
    path, new = old(), tmp_path / "new.mlx"
    for options in (("--native-only",), ("--native-only", "--to-python"), ()):
        result = run("upgrade", path, new, *options)
        assert result.exit_code == 0, result.stderr
        assert ("pass" in new.read_text()) is ("--to-python" in options)
    assert new.read_bytes() == path.read_bytes()
