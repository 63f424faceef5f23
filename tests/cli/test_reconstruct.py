"""The whole method on files."""

from __future__ import annotations

import inspect
import json
import sys

import numpy as np
import pymeshlab
import pytest

import meshlab_symrecon
from meshlab_symrecon.cli import reconstruct_outputs
from meshlab_symrecon.errors import GeometryError
from meshlab_symrecon.host import reconstruction
from meshlab_symrecon.host.files import load
from meshlab_symrecon.host.meshset import read_layer
from meshlab_symrecon.host.reconstruction import DETECT
from meshlab_symrecon.host.registration import load_plugins, unload_plugins
from meshlab_symrecon.pictures import main_job
from meshlab_symrecon.provenance import colours_by_share


def only_layer(path):
    mesh_set = load(path)
    return read_layer(mesh_set, mesh_set.current_mesh_id())


@pytest.fixture(scope="module")
def done(scans, tmp_path_factory):
    """One run with every output, in a process of its own."""
    import subprocess

    folder = tmp_path_factory.mktemp("out größe 1")
    ended = subprocess.run(
        [
            sys.executable, "-m", "meshlab_symrecon.cli.main", "reconstruct",
            scans / "statue 1.ply", "-o", folder / "the statue.ply", "--project", folder / "p.mlp",
            "--json", folder / "r.json", "--seed", "3",
        ],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    return folder, ended


def test_it_says_what_it_found(done, plane):
    folder, ended = done
    assert ended.returncode == 0, ended.stderr
    assert ended.stderr == ""  # no progress bar in a pipe, no warning
    lines = ended.stdout.splitlines()
    written = next(line for line in lines if line.startswith("mirror plane")).split()
    assert np.allclose([float(word) for word in written[2:6]], plane, atol=0.01)
    assert "confidence" in ended.stdout
    assert any("measured" in line and "mirrored" in line for line in lines)
    assert any(line.startswith("surface         closed, genus 0, 1 component,") for line in lines)
    assert str(folder / "the statue.ply") in lines[-1]


def test_nothing_else_is_left(done):
    folder, _ = done
    assert sorted(path.name for path in folder.iterdir()) == [
        "p-completed-points.ply", "p-reflection-planes.ply", "p-scan.ply", "p-surface.ply",
        "p.mlp", "r.json", "the statue.ply",
    ]  # fmt: skip


def test_the_report_is_the_contracts(done, plane):
    report = json.loads((done[0] / "r.json").read_text(encoding="utf-8"))
    best = report["planes"][0]
    assert list(best) == ["plane", "support", "residual", "confidence"]
    assert np.isclose(np.linalg.norm(best["plane"][:3]), 1.0, atol=1e-12)
    assert np.allclose(best["plane"], plane, atol=0.01)
    assert report["converged"] is True
    assert report["surface"]["closed"] is True
    assert report["surface"]["genus"] == 0
    assert report["surface"]["components"] == 1
    assert report["measured"] == len(only_layer(report["input"]).points)
    assert report["mirrored"] > 0
    assert report["output"] == str(done[0] / "the statue.ply")
    assert report["seconds"] > 0
    assert report["versions"]["meshlab_symrecon"] == meshlab_symrecon.__version__
    parameters = report["parameters"]
    assert parameters["randomseed"] == parameters[DETECT]["randomseed"] == 3


def test_the_surface_is_closed_and_faces_outward(done):
    layer = only_layer(done[0] / "the statue.ply")
    edges = np.concatenate([layer.faces[:, [0, 1]], layer.faces[:, [1, 2]], layer.faces[:, [2, 0]]])
    forward = set(map(tuple, edges.tolist()))
    assert len(forward) == len(edges)
    assert forward == {(b, a) for a, b in forward}
    corners = layer.points[layer.faces] - layer.points.mean(axis=0)
    assert np.linalg.det(corners).sum() > 0
    assert layer.quality is not None
    assert layer.quality.min() == 0.0
    assert layer.quality.max() == pytest.approx(1.0, abs=1e-12)


def test_the_project_holds_every_step(done):
    folder, _ = done
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.load_project(str(folder / "p.mlp"))
    labels = [mesh.label() for mesh in mesh_set]
    assert labels == ["scan", "reflection planes", "completed points", "surface"]
    scan, _, completed, surface = (read_layer(mesh_set, mesh.id()) for mesh in mesh_set)
    report = json.loads((folder / "r.json").read_text(encoding="utf-8"))
    measured = report["measured"]
    assert np.array_equal(completed.points[:measured], scan.points)
    assert len(completed.points) == measured + report["mirrored"]
    assert not completed.quality[:measured].any()
    assert completed.quality[measured:].all()
    assert np.array_equal(surface.points, only_layer(folder / "the statue.ply").points)


def test_the_same_as_in_python(done, statue, tmp_path):
    load_plugins()
    try:
        mesh_set = pymeshlab.MeshSet()
        mesh_set.load_new_mesh(str(statue))
        mesh_set.compute_normal_for_point_clouds()
        mesh_set.generate_reflection_planes(randomseed=3)
        mesh_set.generate_mirror_completed_points()
        mesh_set.generate_surface_reconstruction_power_crust()
        by_hand = read_layer(mesh_set, mesh_set.current_mesh_id())
    finally:
        unload_plugins()
    by_command = only_layer(done[0] / "the statue.ply")
    for name in ("points", "faces", "quality"):
        assert np.array_equal(getattr(by_command, name), getattr(by_hand, name)), name


def test_equal_seeds_give_equal_bytes(run, done, statue, tmp_path):
    assert run("reconstruct", statue, "-o", tmp_path / "a.ply", "--seed", 3).exit_code == 0
    assert (tmp_path / "a.ply").read_bytes() == (done[0] / "the statue.ply").read_bytes()


def test_paint_shows_what_was_invented(run, done, statue, tmp_path):
    painted = tmp_path / "painted.ply"
    report = tmp_path / "r.json"
    assert run("reconstruct", statue, "-o", painted, "--paint", "--json", report).exit_code == 0
    surface, plain = only_layer(painted), only_layer(done[0] / "the statue.ply")
    assert np.array_equal(surface.points, plain.points)
    expected = colours_by_share(surface.quality) / 255.0
    np.testing.assert_allclose(surface.colours[:, :3], expected, atol=0.51 / 255)
    assert plain.colours is None
    assert json.loads(report.read_text())["parameters"]["paint"] is True


def test_without_a_plane_it_closes_what_was_measured(shell, lopsided, tmp_path):
    ended = shell(
        "reconstruct", lopsided, "-o", tmp_path / "a.ply", "--json", tmp_path / "a.json",
        "--project", tmp_path / "p.mlp",
    )  # fmt: skip
    assert ended.returncode == 0, ended.stderr
    (warning,) = ended.stderr.splitlines()
    assert warning.startswith("warning: no reflection plane was found")
    assert "mirror plane    none" in ended.stdout
    report = json.loads((tmp_path / "a.json").read_text())
    assert report["planes"] == []
    assert report["mirrored"] == 0
    assert report["surface"]["closed"] is True
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {"a.ply", "a.json", "p.mlp", "p-scan.ply", "p-surface.ply"}


@pytest.mark.parametrize(
    ("extra", "words"),
    [
        (["-o", "{scan}"], "would overwrite"),
        (["-o", "a.abc"], "extension '.abc', which cannot be written"),
        (["-o", "none/a.ply"], "no directory is at"),
        (["-o", "a.ply", "--json", "a.ply"], "would overwrite"),
        (["-o", "a.ply", "--json", "none/a.json"], "no directory is at"),
        (["-o", "a.ply", "--json", "{scan}"], "would overwrite"),
        (["-o", "a.ply", "--project", "p.ply"], "known are mlp"),
        (["-o", "a.ply", "--preview", "p.pdf"], "known are png"),
        (["-o", "a.ply", "--report", "r.pdf"], "known are html, htm"),
        (["-o", "a.ply", "--report", "none/r.html"], "no directory is at"),
        (["-o", "a.ply", "--json", "r.html", "--report", "r.html"], "would overwrite"),
        (["-o", "p-scan.ply", "--project", "p.mlp"], "would overwrite"),
    ],
)
def test_bad_outputs_are_refused_before_the_work(run, statue, tmp_path, monkeypatch, extra, words):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(
        reconstruction, "whole_method", lambda *given, **more: pytest.fail("the work started")
    )
    before = statue.read_bytes()
    result = run("reconstruct", statue, *(word.format(scan=statue) for word in extra))
    assert result.exit_code == 1
    assert result.stderr.startswith("error: ")
    assert words in result.stderr
    assert len(result.stderr.splitlines()) == 1
    assert list(tmp_path.iterdir()) == []
    assert statue.read_bytes() == before


@pytest.mark.parametrize("name", ["statue", "lopsided"])
def test_the_preview_gets_every_layer(run, request, tmp_path, monkeypatch, name):
    """Drawing takes seconds and has its own tests; what it is given is looked at here."""
    declared = inspect.signature(main_job.main_job_picture)
    given = []

    def draw(*positional, **named):
        given.append(declared.bind(*positional, **named).arguments)
        given[0]["path"].write_bytes(b"drawn")

    monkeypatch.setattr(main_job, "main_job_picture", draw)
    scan, output = request.getfixturevalue(name), tmp_path / "a.ply"
    result = run("reconstruct", scan, "-o", output, "--preview", tmp_path / "a.PNG")
    assert result.exit_code == 0, result.stderr
    assert (tmp_path / "a.PNG").read_bytes() == b"drawn"
    (seen,) = given
    measured, surface = only_layer(scan).points, only_layer(output)
    assert np.array_equal(seen["scan_points"], measured)
    assert len(seen["planes"]) == (1 if name == "statue" else 0)
    assert np.array_equal(seen["completed_points"][: len(measured)], measured)
    assert not seen["mirrored_mask"][: len(measured)].any()
    assert seen["mirrored_mask"][len(measured) :].all()
    assert len(seen["mirrored_mask"]) == len(seen["completed_points"])
    assert np.array_equal(seen["surface_points"], surface.points)
    assert np.array_equal(seen["surface_faces"], surface.faces)
    assert len(seen["surface_share_invented"]) == len(surface.points)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.PNG", "a.ply"]


@pytest.mark.parametrize(
    ("option", "name", "library"),
    [
        ("--preview", "a.png", "matplotlib"),
        ("--report", "a.html", "matplotlib"),
        ("--report", "a.html", "plotly"),
    ],
)
def test_a_missing_library_is_named_first(
    run, statue, tmp_path, monkeypatch, option, name, library
):
    monkeypatch.setattr(
        reconstruct_outputs, "find_spec", lambda asked: None if asked == library else asked
    )
    monkeypatch.setattr(
        reconstruction, "whole_method", lambda *given, **more: pytest.fail("the work started")
    )
    result = run("reconstruct", statue, "-o", tmp_path / "a.ply", option, tmp_path / name)
    assert result.exit_code == 1
    assert f"{option} needs {library}, which is not installed" in result.stderr
    assert "pip install 'meshlab-symrecon[report]'" in result.stderr
    assert len(result.stderr.splitlines()) == 1


def test_an_error_in_the_middle_leaves_nothing(run, statue, tmp_path, monkeypatch):
    def fail(*given, **more):
        raise GeometryError("4 points are needed; got 3; scan again")

    monkeypatch.setattr(reconstruction, "whole_method", fail)
    result = run("reconstruct", statue, "-o", tmp_path / "a.ply", "--json", tmp_path / "a.json")
    assert result.exit_code == 1
    assert result.stderr == "error: 4 points are needed; got 3; scan again\n"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "words",
    [
        [],
        ["-o", "a.ply"],
        ["in.ply"],
        ["in.ply", "-o", "a.ply", "--seed", "x"],
        ["in.ply", "-o", "a.ply", "--seed", "-1"],
        ["in.ply", "-o", "a.ply", "--sede", "1"],
    ],
)
def test_wrong_usage_is_2(run, words):
    result = run("reconstruct", *words)
    assert result.exit_code == 2
    assert "Usage: symrecon reconstruct" in result.stderr


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("cut.ply", b"ply\nformat ascii 1.0\nelement vertex 9\nproperty float x\nproperty float y\n"
                    b"property float z\nend_header\n0 0 0\n"),
        ("empty.ply", b""),
        ("folder.ply", None),
        ("scan.txt.gz", b"x"),
        ("two.xyz", b"0 0 0\n1 1 1\n"),
        ("one.xyz", b"0 0 0\n"),
        ("flat.xyz", b"0 0 0\n1 0 0\n0 1 0\n1 1 0\n2 1 0\n"),
        ("same.xyz", b"1 2 3\n" * 30),
    ],
)  # fmt: skip
def test_bad_scans_end_in_one_sentence(shell, tmp_path, name, content):
    scan = tmp_path / name
    scan.mkdir() if content is None else scan.write_bytes(content)
    ended = shell("reconstruct", scan, "-o", tmp_path / "a.ply", "--json", tmp_path / "a.json")
    assert ended.returncode == 1
    *warnings, error = ended.stderr.splitlines()
    assert error.startswith("error: ")
    assert all(line.startswith("warning: ") for line in warnings)
    assert [path.name for path in tmp_path.iterdir()] == [name]
