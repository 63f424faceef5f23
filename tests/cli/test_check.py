"""``symrecon check``: every finding at once, and nothing runs."""

from __future__ import annotations

import json

import numpy as np
import pymeshlab
import pytest

NOTES = '<filter name="Remove Duplicated Vertex"/>'
EMPTIES = '<filter name="Remove Unreferenced Vertices"/>'
UNKNOWN = '<filter name="Close Hole"/>'
EXTRA = '<filter name="Box/Cube"><Param type="RichFloat" name="sise" value="2"/></filter>'


@pytest.fixture
def cloud(tmp_path):
    mesh_set = pymeshlab.MeshSet(verbose=False)
    points = np.random.default_rng(0).normal(size=(30, 3))
    mesh_set.add_mesh(pymeshlab.Mesh(vertex_matrix=points), "scan")
    mesh_set.save_current_mesh(str(tmp_path / "scan.ply"))
    return tmp_path / "scan.ply"


@pytest.fixture
def script(tmp_path, monkeypatch):
    """Return a function that writes a script of one filter a line, from line 2 on."""
    monkeypatch.chdir(tmp_path)

    def write(*filters):
        text = "<FilterScript>\n" + "\n".join(filters) + "\n</FilterScript>\n"
        (tmp_path / "scan.mlx").write_text(text)
        return "scan.mlx"

    return write


def test_a_script_that_can_run(run, script):
    result = run("check", script('<filter name="Box/Cube"/>'))
    assert (result.exit_code, result.stdout) == (0, "1 step: it can run\n")
    assert result.stderr == ""


def test_all_findings_at_once(run, script):
    result = run("check", script(NOTES, UNKNOWN, EXTRA))
    assert result.exit_code == 1
    assert result.stdout.splitlines() == [
        "scan.mlx:2: note: 'Remove Duplicated Vertex' is 'Remove Duplicate Vertices' today",
        "scan.mlx:3: error: no filter is called 'Close Hole'; did you mean 'Close Holes'?",
        "scan.mlx:4: error: unknown parameter 'sise' of 'Box/Cube'; did you mean 'size'?",
        "3 steps, 2 errors, 1 note: it cannot run",
    ]


def test_inputs_tell_what_the_script_alone_does_not(run, script, cloud):
    name = script(EMPTIES)
    assert run("check", name).exit_code == 0
    result = run("check", name, cloud)
    assert result.exit_code == 1
    assert result.stdout.splitlines() == [
        "scan.mlx:2: error: 'Remove Unreferenced Vertices' would delete all the 30 points of layer "
        "'scan.ply', which has no faces; reconstruct a surface first, or run leniently to pass "
        "over the step",
        "1 step, 1 error: it cannot run",
    ]


def test_inputs_are_layers_in_their_order(run, script, cloud):
    second = (
        '<filter name="Change the current layer"><Param type="RichMesh" name="mesh" value="1"/>'
    )
    name = script(second + "</filter>")
    assert run("check", name).exit_code == 0
    assert run("check", name, cloud, cloud).exit_code == 0
    result = run("check", name, cloud)
    assert result.exit_code == 1
    assert "the document has 1 layer at this step" in result.stdout


def test_strict_counts_notes_and_lenient_passes_over_errors(run, script, cloud):
    name = script(NOTES, EMPTIES, UNKNOWN, EXTRA)
    strict = run("check", name, cloud, "--strict")
    assert strict.exit_code == 1
    assert strict.stdout.splitlines()[-1] == "4 steps, 4 errors: it cannot run"
    lenient = run("check", name, cloud, "--lenient")
    assert lenient.exit_code == 0
    verdicts = [line.split(": ")[1] for line in lenient.stdout.splitlines()[:-1]]
    assert verdicts == ["note", "skipped", "skipped", "ignored"]
    assert lenient.stdout.splitlines()[-1] == "4 steps, 2 skipped, 1 ignored, 1 note: it can run"


def test_what_a_lenient_check_promises_a_lenient_run_does(run, script, cloud, tmp_path):
    name = script(NOTES, EMPTIES, UNKNOWN, EXTRA)
    assert run("check", name, cloud, "--lenient").exit_code == 0
    result = run("run", name, cloud, "-o", "out.ply", "--lenient", "--json", "r.json")
    assert result.exit_code == 0
    steps = json.loads((tmp_path / "r.json").read_text())["steps"]
    assert [step["status"] for step in steps] == ["mapped", "skipped", "skipped", "mapped"]


def test_findings_as_json(run, script, cloud, tmp_path):
    result = run("check", script(NOTES, EMPTIES), cloud, "--json", "r.json")
    assert result.exit_code == 1
    report = json.loads((tmp_path / "r.json").read_text(encoding="utf-8"))
    assert (report["script"], report["inputs"]) == ("scan.mlx", [str(cloud)])
    assert report["runs"] is False
    told = [(f["file"], f["line"], f["step"], f["verdict"]) for f in report["findings"]]
    assert told == [("scan.mlx", 2, 0, "note"), ("scan.mlx", 3, 1, "error")]
    assert report["findings"][1]["remedy"] == "skip"


def test_a_script_that_cannot_be_read(run, script, tmp_path):
    script()
    (tmp_path / "scan.mlx").write_text("<FilterScript>\n<filter\n")
    result = run("check", "scan.mlx", "--json", "r.json")
    assert result.exit_code == 1
    assert result.stderr.startswith("error: scan.mlx:")
    assert result.stdout == ""
    report = json.loads((tmp_path / "r.json").read_text())
    (found,) = report.pop("findings")
    assert report == {"script": "scan.mlx", "inputs": [], "runs": False}
    assert result.stderr == f"error: scan.mlx:{found['line']}: {found['message']}\n"
    assert (found["line"], found["step"], found["verdict"]) == (2, -1, "error")
    assert found["message"].startswith("this is not XML: ")
    assert run("check", "scan.mlx", "--lenient", "--json", "r.json").exit_code == 1
    assert run("check", "none.mlx", "--json", "none.json").exit_code == 1
    assert not (tmp_path / "none.json").exists()


def test_what_leaves_the_xml_readable_hides_no_other_finding(run, script, cloud):
    twice = EXTRA.replace("sise", "size").replace("</filter>", "") + "\n"
    twice += '<Param type="RichFloat" name="Size" value="3"/></filter>'
    name = script(UNKNOWN, '<filter name=""/>', twice, EMPTIES)
    result = run("check", name)
    assert result.exit_code == 1
    assert result.stdout.splitlines()[1:] == [
        'scan.mlx:3: error: this <filter> has no name; write name="..."',
        "scan.mlx:5: error: parameter 'Size' is given twice, with different values; keep one",
        "4 steps, 3 errors: it cannot run",
    ]
    assert "4 steps, 2 skipped, 1 ignored" in run("check", name, "--lenient").stdout
    done = run("run", name, cloud, "-o", "out.ply", "--lenient")
    assert done.exit_code == 0, done.stderr


def test_inputs_stay_as_they_are_and_are_not_overwritten(run, script, cloud):
    before = cloud.read_bytes()
    assert run("check", script(EMPTIES), cloud, "--json", cloud).exit_code == 1
    assert cloud.read_bytes() == before


def test_wrong_usage(run, script):
    assert run("check").exit_code == 2
    result = run("check", script(NOTES), "--strict", "--lenient")
    assert result.exit_code == 2
    assert "contradict each other" in result.stderr
