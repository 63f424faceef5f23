"""One filter on files."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from click.testing import CliRunner

from meshlab_symrecon.arrays import as_planes
from meshlab_symrecon.cli.apply import RESERVED
from meshlab_symrecon.cli.main import main
from meshlab_symrecon.geometry.plane_quads import planes_as_quads
from meshlab_symrecon.host.files import load, new_document, save_current
from meshlab_symrecon.host.meshset import add_layer, read_layer
from meshlab_symrecon.host.native_filters import native_filters
from meshlab_symrecon.host.registration import registry
from meshlab_symrecon.plugin import Layer


def only_layer(path):
    mesh_set = load(path)
    return read_layer(mesh_set, mesh_set.current_mesh_id())


@pytest.mark.parametrize(
    "name",
    [
        "generate_reflection_planes",
        "detect_reflection_planes",
        "Detect Reflection Planes (AP)",
        " detect reflection planes (ap) ",
    ],
)
def test_a_detection_by_every_name(run, statue, tmp_path, plane, name):
    result = run(
        "apply", name, statue, "-o", tmp_path / "planes.ply", "--json", tmp_path / "r.json"
    )
    assert result.exit_code == 0, result.stderr
    report = json.loads((tmp_path / "r.json").read_text())
    assert list(report) == ["planes", "converged", "filter", "parameters", "versions"]
    assert report["filter"] == "generate_reflection_planes"
    assert report["converged"] is True
    best = report["planes"][0]
    assert list(best) == ["plane", "support", "residual", "confidence"]
    assert np.allclose(best["plane"], plane, atol=0.01)
    sheets = only_layer(tmp_path / "planes.ply")
    assert len(sheets.faces) == 2 * len(report["planes"])
    assert np.allclose(sheets.points[:4] @ best["plane"][:3] + best["plane"][3], 0, atol=1e-6)
    assert np.allclose(sheets.face_quality[:2], best["confidence"])


def test_no_plane_is_an_honest_result(run, lopsided, tmp_path):
    output = tmp_path / "p.ply"
    result = run("apply", "detect_reflection_planes", lopsided, "-o", output,
                 "--json", tmp_path / "r.json")  # fmt: skip
    assert result.exit_code == 0
    (sentence,) = result.stderr.splitlines()
    assert sentence.startswith("warning: no reflection plane was found")
    assert sentence.endswith(f"{output} was not written")
    report = json.loads((tmp_path / "r.json").read_text())
    assert (report["planes"], report["converged"]) == ([], True)
    assert [path.name for path in tmp_path.iterdir()] == ["r.json"]


def test_parameters_reach_the_filter(run, statue, tmp_path):
    common = ("apply", "detect_reflection_planes", statue, "--json", tmp_path / "r.json")
    assert run(*common, "--minconfidence", "1.0", "--seed", "5").exit_code == 0
    assert json.loads((tmp_path / "r.json").read_text())["planes"] == []
    assert run(*common, "--MaxPlanes=1", "--minconfidence", "0.1").exit_code == 0
    assert len(json.loads((tmp_path / "r.json").read_text())["planes"]) == 1


def test_the_layer_that_became_current_is_saved(run, statue, tmp_path):
    result = run("apply", "power_crust_reconstruct", statue, "-o", tmp_path / "a.ply",
                 "--medialaxis", "TRUE", "--json", tmp_path / "r.json")  # fmt: skip
    assert result.exit_code == 0, result.stderr
    report = json.loads((tmp_path / "r.json").read_text())
    assert report["closed"] is True
    assert len(only_layer(tmp_path / "a.ply").faces) == report["faces"]
    assert "closed: yes" in result.stdout


def test_native_filters_take_their_own_parameters(run, tmp_path):
    sphere, thin = tmp_path / "s.ply", tmp_path / "thin.ply"
    assert run("apply", "create_sphere", "-o", sphere, "--subdiv", "3").exit_code == 0
    result = run("apply", "Simplification: Quadric Edge Collapse Decimation", sphere, "-o", thin,
                 "--TargetFaceNum", "100")  # fmt: skip
    assert result.exit_code == 0, result.stderr
    assert len(only_layer(thin).faces) == 100
    result = run("apply", "get_geometric_measures", thin, "--json", tmp_path / "r.json")
    assert result.exit_code == 0, result.stderr
    report = json.loads((tmp_path / "r.json").read_text())
    assert report["mesh_volume"] == pytest.approx(4.0 * np.pi / 3.0, rel=0.1)
    assert len(report["inertia_tensor"]) == 3
    assert report["bbox"]["max"][0] == pytest.approx(1.0, abs=0.1)


def test_several_inputs_become_layers(run, statue, tmp_path):
    planes = tmp_path / "planes.ply"
    run("apply", "detect_reflection_planes", statue, "-o", planes)
    out = tmp_path / "c.ply"
    result = run("apply", "mirror_complete_points", planes, statue, "-o", out, "--planes", "0")
    assert result.exit_code == 0, result.stderr
    measured = only_layer(statue).points
    assert np.array_equal(only_layer(out).points[: len(measured)], measured)


def test_a_drawn_plane_is_refined_on_files(run, statue, tmp_path, plane):
    drawn, refined = tmp_path / "drawn.ply", tmp_path / "refined.ply"
    tilted = as_planes([np.add(plane, [0.1, 0.0, 0.0, 0.05])])
    corners, faces = planes_as_quads(tilted, only_layer(statue).points)
    mesh_set = new_document()
    add_layer(mesh_set, Layer(corners, faces, "drawn"), current=True)
    save_current(mesh_set, drawn)
    asked = ("--refine", "true", "--planes", "0", "--minconfidence", "0")
    result = run("apply", "detect_reflection_planes", drawn, statue, "-o", refined,
                 "--json", tmp_path / "r.json", *asked)  # fmt: skip
    assert result.exit_code == 0, result.stderr
    (found,) = json.loads((tmp_path / "r.json").read_text())["planes"]
    assert np.allclose(found["plane"], plane, atol=0.01)
    assert len(only_layer(refined).faces) == 2
    wrong = run("apply", "detect_reflection_planes", statue, drawn, "-o", tmp_path / "a.ply",
                "--refine", "true", "--planes", "1")  # fmt: skip
    assert wrong.exit_code == 1
    said = " ".join(wrong.stderr.split())
    assert "got layer 1 'drawn.ply', which it reads beside the scan" in said
    assert not (tmp_path / "a.ply").exists()


def test_help_shows_every_declared_parameter(run):
    for item in registry():
        for name in (item.python_name, item.menu_name):
            result = run("apply", name, "--help")
            assert result.exit_code == 0
            words = " ".join(result.stdout.split())
            assert " ".join(item.summary.split()) in words
            for parameter in item.parameters.declared():
                assert f"--{parameter.name}" in words
                assert " ".join(parameter.tooltip.split()) in words
                assert f"default: {parameter.default}" in words


def test_help_of_every_native_filter(run):
    for item in native_filters().values():
        result = run("apply", item.python_name, "--help")
        assert result.exit_code == 0
        flags = set(re.findall(r"--([\w-]+)", result.stdout))
        for parameter in item.parameters:
            plain = parameter.name.replace("_", "-").strip("-")
            assert (f"parameter-{plain}" if plain in RESERVED else plain) in flags


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["detcet_reflection_plane", "x.ply"], 1,
         "no filter is called 'detcet_reflection_plane'; did you mean 'detect_reflection_planes'?"),
        (["detect_reflection_planes", "none.ply", "-o", "a.ply"], 1, "no such file"),
        (["detect_reflection_planes", "x.ply"], 2, "give -o OUT, or --json R.json, or both"),
        (["detect_reflection_planes", "-o", "a.ply"], 2, "Missing argument"),
        (["-o", "a.ply"], 2, "give a FILTER; 'symrecon filters' lists them"),
        (["-o", "a.ply", "--"], 2, "give a FILTER; 'symrecon filters' lists them"),
        (["--maxplanes", "1", "detect_reflection_planes", "x.ply"], 2,
         "no option '--maxplanes' before FILTER; the filter's own options stand behind its name"),
        (["--json", "r.json", "-o"], 2, "requires an argument"),
        (["--max-points", "5", "detect_reflection_planes", "x.ply"], 2, "not in the range x>=100"),
        (["--max-points", "500", "create_cube", "-o", "a.ply"], 2, "--max-points"),
        (["detect_reflection_planes", "x.ply", "-o", "a.ply", "--maxplnes", "1"], 2, "--maxplanes"),
        (["detect_reflection_planes", "x.ply", "-o", "a.ply", "--maxplanes", "0"], 2, "got 0"),
        (["detect_reflection_planes", "x.ply", "-o", "a.ply", "--maxplanes", "x"], 2, "got 'x'"),
        (["detect_reflection_planes", "x.ply", "-o", "x.ply"], 1, "would overwrite"),
        (["detect_reflection_planes", "x.ply", "-o", "a.ply", "--json", "a.ply"], 1, "overwrite"),
        (["meshing_close_holes", "x.ply", "-o", "a.ply", "--maxholesize", "x"], 2, "got 'x'"),
    ],
)  # fmt: skip
def test_mistakes(run, tmp_path, monkeypatch, words, code, said):
    monkeypatch.chdir(tmp_path)
    result = run("apply", *words)
    assert result.exit_code == code
    assert said in " ".join(result.stderr.split())
    assert list(tmp_path.iterdir()) == []


def test_without_a_filter_there_is_help(run):
    shown = run("apply", "--help").stdout
    assert "FILTER IN... -o OUT" in shown
    assert "'symrecon apply FILTER --help'" in " ".join(shown.split())
    assert {f"--{name}" for name in RESERVED} <= set(re.findall(r"--[\w-]+", shown))


def test_options_of_every_filter_stand_before_its_name_too(run, statue, tmp_path):
    sheets = [tmp_path / "behind.ply", tmp_path / "before.ply"]
    reports = [tmp_path / "behind.json", tmp_path / "before.json"]
    log = tmp_path / "l.txt"
    name = "detect_reflection_planes"
    for number in range(2):
        shared = ["-o", sheets[number], "--max-points=2000", "--json", reports[number]]
        shared += ["--log", log, "--threads", 1, "-q"]
        own = ["--maxplanes", 1, statue]
        words = [*shared, "--", name, *own] if number else [name, *own, *shared]
        result = run("apply", *words)
        assert (result.exit_code, result.stdout, result.stderr) == (0, "", "")
    assert sheets[0].read_bytes() == sheets[1].read_bytes()
    assert reports[0].read_bytes() == reports[1].read_bytes()
    assert log.read_text().count("done after") == 2


def completed(words, monkeypatch):
    monkeypatch.setenv("_SYMRECON_COMPLETE", "bash_complete")
    monkeypatch.setenv("COMP_WORDS", words)
    monkeypatch.setenv("COMP_CWORD", str(len(words.split(" ")) - 1))
    result = CliRunner().invoke(main, [])
    assert (result.exit_code, result.stderr) == (0, "")
    return {line.rpartition(",")[2] for line in result.stdout.splitlines()}


def test_the_shell_completes_filters_and_their_options(monkeypatch):
    every = {name for item in registry() for name in (item.python_name, *item.aliases)}
    every |= set(native_filters())
    assert completed("symrecon apply ", monkeypatch) == every
    beginning = {name for name in every if name.startswith("generate_re")}
    assert completed("symrecon apply generate_re", monkeypatch) == beginning
    assert completed("symrecon apply --m", monkeypatch) == {"--max-points"}
    for before in ("", "-o x.ply "):
        words = f"symrecon apply {before}detect_reflection_planes --max"
        assert completed(words, monkeypatch) == {"--max-points", "--maxplanes"}
    assert completed("symrecon apply nope --max", monkeypatch) == {"--max-points"}


def test_what_stands_behind_the_filter_counts(run, tmp_path):
    words = ("apply", "-o", tmp_path / "a.ply", "create_cube", "-o", tmp_path / "b.ply")
    assert run(*words).exit_code == 0
    assert [path.name for path in tmp_path.iterdir()] == ["b.ply"]
