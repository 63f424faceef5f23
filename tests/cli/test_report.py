"""The page of ``symrecon reconstruct --report``: it says what happened, and how to repeat it."""

from __future__ import annotations

import hashlib
import html
import json
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import warnings
from importlib.metadata import version
from types import SimpleNamespace

import numpy as np
import pytest

from meshlab_symrecon.cli import deviation as measuring
from meshlab_symrecon.cli.deviation import DEVIATION, Deviation, measured_deviation
from meshlab_symrecon.cli.report import scene_of, write_report
from meshlab_symrecon.cli.report_tables import _value, percent, rounded
from meshlab_symrecon.cli.report_words import words_of
from meshlab_symrecon.errors import FileError, GeometryError, SymReconWarning
from meshlab_symrecon.host import reconstruction
from meshlab_symrecon.host.files import load, new_document
from meshlab_symrecon.host.history import read_history
from meshlab_symrecon.host.meshset import add_layer, read_layer
from meshlab_symrecon.host.reconstruction import (
    PLANES,
    SCAN,
    noted,
    parameters_as_run,
    whole_method,
)
from meshlab_symrecon.host.registration import registry
from meshlab_symrecon.pictures import report_stills

NAME = "<script>alert(1)<b> größe & 'co'.ply"


def shown(page):
    """Return the words of a page, without its scripts and styles."""
    body = re.sub(r"<(script|style)\b.*?</\1>", " ", page, flags=re.DOTALL)
    return " ".join(html.unescape(re.sub(r"<[^>]+>", " ", body)).split())


def listings(page):
    return [
        html.unescape(text) for text in re.findall(r"<code>(.*?)</code></pre>", page, re.DOTALL)
    ]


@pytest.fixture(autouse=True)
def _small(monkeypatch):
    """Stills of a tenth of the size."""
    monkeypatch.setattr(report_stills, "HEIGHT", 64)
    monkeypatch.setattr(report_stills, "WIDTHS", (36, 90))


@pytest.fixture(scope="module")
def made(scans, tmp_path_factory):
    """One run with a report, and a strangely named scan."""
    from click.testing import CliRunner

    from meshlab_symrecon.cli.main import main

    folder = tmp_path_factory.mktemp("out größe 1")
    scan = folder / NAME
    shutil.copyfile(scans / "statue 1.ply", scan)
    words = ["reconstruct", scan, "-o", folder / "a.ply", "--json", folder / "a.json",
             "--report", folder / "a page.html", "--seed", "3"]  # fmt: skip
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(report_stills, "HEIGHT", 64)
        patch.setattr(report_stills, "WIDTHS", (36, 90))
        ended = CliRunner().invoke(main, [str(word) for word in words])
    assert ended.exit_code == 0, ended.stderr
    page = (folder / "a page.html").read_text(encoding="utf-8")
    found = json.loads((folder / "a.json").read_text(encoding="utf-8"))
    return SimpleNamespace(folder=folder, scan=scan, page=page, found=found, words=words)


def test_the_summary_says_what_was_found(made):
    text, found = shown(made.page), made.found
    assert f"In this scan of {found['measured']:,} points one mirror plane was found" in text
    assert f"(confidence {found['planes'][0]['confidence']:.2f})" in text
    assert f"{found['mirrored']:,} points were invented" in text
    share = found["mirrored"] / (found["measured"] + found["mirrored"])
    assert f"{percent(share)} of the {found['measured'] + found['mirrored']:,} points" in text
    assert "The surface is closed (it bounds a solid), in one piece, without handles" in text
    assert f"{found['surface']['faces']:,} triangles" in text
    area = re.search(r"(\d+)(?:\.\d)? % of its area is invented", text)
    assert area is not None
    assert 1 <= int(area[1]) <= 60


def test_the_numbers_are_those_of_the_json(made):
    text, found = shown(made.page), made.found
    for name, value in found["surface"].items():
        if name != "seconds":
            assert f" {_value(value)} " in text, name
    for number in found["planes"][0]["plane"]:
        assert f"{number:.8g}" in text
    assert "seconds" not in text  # what differs from run to run


def test_every_parameter_and_version_is_told(made):
    text = shown(made.page)
    for name, values in parameters_as_run({"randomseed": 3}).items():
        if name == "randomseed":
            continue
        item = registry().find(name)
        assert item.menu_name in text
        section = text[text.index(f". {item.menu_name}") :]
        for parameter in item.parameters.declared():
            value = values[parameter.name]
            words = {True: "yes", False: "no"}[value] if isinstance(value, bool) else value
            row = f"{parameter.label} {parameter.name} {words} {parameter.unit}".rstrip()
            assert row in section
            assert parameter.tooltip in section
    assert "Compute normals for point sets" in text
    assert "Neighbour num K 10 The number of neighbors" in text
    for library in ("meshlab_symrecon", "pymeshlab", "numpy", "scipy", "scikit-learn", "plotly"):
        assert f"{library} {version(library)}" in text
    assert hashlib.sha256(made.scan.read_bytes()).hexdigest() in text


def test_a_strange_name_is_text(made):
    assert NAME in shown(made.page)
    assert "<script>alert" not in made.page
    assert f"<h1>{html.escape(NAME)}</h1>" in made.page


def test_the_command_repeats_everything_byte_for_byte(made, run):
    line, *_ = listings(made.page)
    program, *words = shlex.split(line)
    assert program == "symrecon"
    assert words == [str(word) for word in made.words]
    names = ("a.ply", "a page.html")
    before = [(made.folder / name).read_bytes() for name in names]
    assert run(*words).exit_code == 0
    assert [(made.folder / name).read_bytes() for name in names] == before


def test_the_python_repeats_the_surface(made, tmp_path):
    _, python, _ = listings(made.page)
    assert max(map(len, python.splitlines())) <= 120
    (tmp_path / "again.py").write_text(python, encoding="utf-8")
    subprocess.run([sys.executable, "again.py"], cwd=tmp_path, check=True)
    again, first = tmp_path / "statue.ply", made.folder / "a.ply"
    layers = []
    for path in (again, first):
        mesh_set = load(path)
        layers.append(read_layer(mesh_set, mesh_set.current_mesh_id()))
    for name in ("points", "faces", "quality"):
        assert np.array_equal(getattr(layers[0], name), getattr(layers[1], name)), name


def test_the_script_repeats_the_surface(made, run, tmp_path):
    *_, script = listings(made.page)
    (tmp_path / "steps.mlx").write_text(script, encoding="utf-8")
    ended = run("run", tmp_path / "steps.mlx", made.scan, "-o", tmp_path / "a.ply")
    assert ended.exit_code == 0, ended.stderr
    assert (tmp_path / "a.ply").read_bytes() == (made.folder / "a.ply").read_bytes()


def test_without_a_plane_the_page_says_so(run, lopsided, tmp_path):
    page = tmp_path / "r.htm"
    ended = run("reconstruct", lopsided, "-o", tmp_path / "a.ply", "--report", page)
    assert ended.exit_code == 0, ended.stderr
    assert ended.stderr.count("warning: no reflection plane was found") == 1
    text = shown(page.read_text(encoding="utf-8"))
    assert "3,000 points no mirror plane was found that can be trusted, so nothing was" in text
    assert "No reflection plane was found: the points show no mirror symmetry" in text
    assert "Mirror-Complete Points" not in text.split("Steps")[1].split("Repeat it")[0]
    assert "of its area is invented" not in text
    assert "both sides were measured" not in text


@pytest.fixture(scope="module")
def result(scans):
    return whole_method(scans / "statue 1.ply", {"randomseed": 0}, lambda fraction, message: None)


def test_doubts_are_warnings(result, statue):
    import dataclasses

    doubtful = dataclasses.replace(
        result,
        found={**result.found, "confidence": np.array([0.61]), "converged": False},
        warnings=("the scan was odd",),
        surface={**result.surface, "closed": False, "components": 2, "genus": -1},
        completed={
            **result.completed,
            "missing_on_both_sides": 0.0312,
            "holes": np.arange(3),
            "rims": [],
        },
    )
    words = words_of(statue, doubtful, scene_of(doubtful), Deviation(), "symrecon")
    assert words.warnings[0] == "The scan was odd."
    assert words.warnings[1].startswith("The clustering stopped before it had converged")
    assert words.warnings[2].startswith("The best mirror plane has a confidence of 0.61 only")
    assert "NOT closed (it has open edges), in 2 pieces, and has" in words.summary[1]
    rows = dict(words.sections[0].content[0].rows)
    assert rows["Missing on both sides"] == "0.0312"  # a measure that this page does not know
    assert rows["Holes"] == "0, 1, 2"
    assert rows["Rims"] == "none"
    assert words_of(statue, result, scene_of(result), Deviation(), "symrecon").warnings == ()


def test_the_deviation_is_that_of_the_filter_and_changes_nothing(made, result):
    before = read_layer(result.mesh_set, result.layers[SCAN])
    history, deviation = read_history(result.mesh_set), measured_deviation(result)
    after = read_layer(result.mesh_set, result.layers[SCAN])
    assert after.attributes.keys() == before.attributes.keys()
    assert (after.quality is None) is (before.quality is None)
    assert read_history(result.mesh_set) == history
    known = deviation.distances[np.isfinite(deviation.distances)]
    assert np.median(np.abs(known)) == pytest.approx(deviation.measures["median"], rel=1e-6)
    missing = 1.0 - len(known) / len(deviation.distances)
    assert missing == pytest.approx(deviation.measures["without_counterpart"], abs=1e-9)
    assert 0.02 < missing < 0.5
    text = shown(made.page)
    item = registry().find(DEVIATION)
    assert f"For this report: {item.menu_name} {item.summary}" in text
    for parameter in item.parameters.declared():
        assert parameter.tooltip in text
    sentence = re.search(r"both sides were measured, they differ by ([\d.]+) \(median", text)
    assert sentence is not None
    assert 0.0 < float(sentence[1]) < 0.05  # of a bust of size 3
    assert 'id="show-deviation"' in made.page


def test_a_deviation_without_sign_is_shown_without(statue, result, tmp_path, monkeypatch):
    found = measured_deviation(result)
    texts = []
    for signed in (True, False):
        distances = found.distances if signed else np.abs(found.distances)
        made_up = Deviation(distances, {**found.measures, "signed": signed}, found.steps)
        monkeypatch.setattr(measuring, "measured_deviation", lambda _, deviation=made_up: deviation)
        write_report(tmp_path / "r.html", statue, result, "symrecon")
        texts.append(shown((tmp_path / "r.html").read_text(encoding="utf-8")))
    assert ["(inside) to +" in text for text in texts] == [True, False]
    assert ["deviation from 0 to" in text for text in texts] == [False, True]


def test_a_deviation_that_cannot_be_measured_is_said(result, statue):
    import dataclasses

    far = result.mesh_set.mesh(result.layers[PLANES]).vertex_matrix() + 100.0
    apart = new_document()
    layers = {}
    for label in (SCAN, PLANES):
        layer = read_layer(result.mesh_set, result.layers[label])
        points = far if label == PLANES else layer.points
        layers[label] = add_layer(
            apart, dataclasses.replace(layer, points=points, identifier=-1), current=False
        )
    moved = dataclasses.replace(result, mesh_set=apart, layers=layers)
    deviation = measured_deviation(moved)
    assert deviation.distances is None
    words = words_of(statue, result, scene_of(result), deviation, "symrecon")
    (warning,) = words.warnings
    assert warning.startswith("The deviation was not measured: the mirror image across plane 0")
    assert not any("both sides were measured" in sentence for sentence in words.summary)


def test_warnings_are_kept_and_given(recwarn):
    with noted() as sentences:
        warnings.warn("the scan is odd", SymReconWarning, stacklevel=1)
        warnings.warn("numpy is strange", UserWarning, stacklevel=1)
        assert sentences == []
    assert sentences == ["the scan is odd"]  # a page has ours only
    assert [str(given.message) for given in recwarn] == ["the scan is odd", "numpy is strange"]


def test_warnings_are_given_before_an_error(recwarn):
    @noted()
    def fail():
        warnings.warn("the scan is odd", SymReconWarning, stacklevel=1)
        raise GeometryError("4 points are needed; got 3; scan again")

    with pytest.raises(GeometryError):
        fail()
    assert [str(given.message) for given in recwarn] == ["the scan is odd"]


@pytest.mark.parametrize(
    ("number", "words"),
    [
        (0.0, "0"),
        (0.5, "0.5"),
        (12345.678, "12,346"),
        (-1234567.0, "-1,234,600"),
        (3.2e-7, "3.2000e-07"),
        (5e12, "5.0000e+12"),
    ],
)
def test_numbers_are_written_to_be_read(number, words):
    assert rounded(number) == words


@pytest.mark.parametrize(
    ("share", "words"),
    [(0.0, "0 %"), (0.00123, "0.1 %"), (0.0312, "3.1 %"), (0.0998, "10 %"), (1.0, "100 %")],
)
def test_shares_are_written_to_be_read(share, words):
    assert percent(share) == words


def test_a_scan_that_vanishes_is_one_sentence(result, tmp_path):
    with pytest.raises(FileError, match="cannot be read again: No such file or directory"):
        words_of(tmp_path / "gone.ply", result, scene_of(result), Deviation(), "symrecon")


def test_a_folder_that_cannot_be_written_is_one_sentence(
    run, statue, result, tmp_path, monkeypatch
):
    monkeypatch.setattr(reconstruction, "whole_method", lambda *given, **more: result)
    page = tmp_path / "no" / "r.html"
    page.parent.mkdir()
    make = tempfile.mkdtemp

    def refuse(*given, **named):
        if str(named.get("dir")) == str(page.parent):
            raise PermissionError(13, "Permission denied")
        return make(*given, **named)

    monkeypatch.setattr(tempfile, "mkdtemp", refuse)
    ended = run("reconstruct", statue, "-o", tmp_path / "a.ply", "--report", page)
    assert ended.exit_code == 1
    assert (
        ended.stderr == f"error: {page} cannot be written: Permission denied; nothing was changed\n"
    )
    assert list(page.parent.iterdir()) == []
