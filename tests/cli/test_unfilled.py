"""What is said of holes on both sides, of clutter and of a plinth: nothing where there is none."""

from __future__ import annotations

import dataclasses
import json
import re

import numpy as np
import pytest

from meshlab_symrecon.cli.deviation import Deviation
from meshlab_symrecon.cli.reconstruct_findings import in_words
from meshlab_symrecon.cli.report import scene_of
from meshlab_symrecon.cli.report_words import words_of
from meshlab_symrecon.cli.unfilled import holes, left_alone, place, width
from meshlab_symrecon.host.files import load, new_document, save_current
from meshlab_symrecon.host.meshset import add_layer
from meshlab_symrecon.host.reconstruction import whole_method
from meshlab_symrecon.plugin import Layer

TWO = np.array([[10.0, 20.0, -30.0, 0.84], [512345.678, 4.0, 5.0, 0.0421]])


@pytest.fixture(scope="module")
def result(scans):
    return whole_method(scans / "statue 1.ply", {"randomseed": 0}, lambda fraction, message: None)


def told(result, scan, **measures):
    """Return printed lines, summary and sections of a result with other measures."""
    plain = {"scattered": 0, "plinth": 0, "open_rims": np.zeros((0, 4))}
    other = dataclasses.replace(result, completed={**result.completed, **plain, **measures})
    words = words_of(scan, other, scene_of(other), Deviation(), "symrecon")
    return in_words(scan, other), words.summary, {part.heading: part for part in words.sections}


def test_nothing_is_said_where_there_is_nothing(result, statue):
    lines, summary, sections = told(result, statue)
    assert not any(line.startswith("not ") for line in lines)
    assert not any("bridges" in sentence or "Not mirrored" in sentence for sentence in summary)
    assert "Missing on both sides" not in sections
    assert ("Holes missing on both sides", "0") in sections["Numbers"].content[0].rows


def test_a_scan_without_a_plane_says_nothing():
    counts = {"measured": 10, "mirrored": 0}
    assert holes(counts).shape == (0, 4)
    assert left_alone(counts) == []


def test_a_few_stray_points_are_counted_but_not_told(result, statue):
    few = int(0.005 * result.completed["measured"])
    lines, summary, sections = told(result, statue, scattered=few)
    assert not any(line.startswith("not ") for line in lines)
    assert not any("Not mirrored" in sentence for sentence in summary)
    rows = sections["Numbers"].content[0].rows
    assert ("Points not mirrored, since they lie on no surface", str(few)) in rows
    assert "not mirrored    " in "".join(told(result, statue, scattered=few + 1)[0])


def test_holes_are_told_with_width_and_place(result, statue):
    lines, summary, sections = told(result, statue, open_rims=TWO)
    wanted = "not filled      2 holes, the widest 0.84 wide at (10.00, 20.00, -30.00): "
    assert wanted + "missing on both sides of the plane" in lines
    (sentence,) = (one for one in summary if "missing on both sides" in one)
    assert sentence.startswith("2 holes are missing on both sides of the statue")
    assert sentence.endswith("The widest is 0.84 wide, in the file's unit, at "
                             "(10.00, 20.00, -30.00).")  # fmt: skip
    table, explained = sections["Missing on both sides"].content
    assert table.rows == (
        ("1", "0.84", "(10.00, 20.00, -30.00)"),
        ("2", "0.042", "(512345.678, 4.000, 5.000)"),
    )
    assert "neither measured nor mirrored" in explained
    assert ("Holes missing on both sides", "2") in sections["Numbers"].content[0].rows


def test_one_hole_is_one(result, statue):
    lines, summary, _ = told(result, statue, open_rims=TWO[:1])
    assert any(line.startswith("not filled      1 hole 0.84 wide at (10.00,") for line in lines)
    assert any(one.startswith("One hole, 0.84 wide, in the file's unit,") for one in summary)


def test_what_was_not_mirrored_is_told(result, statue):
    lines, summary, sections = told(result, statue, scattered=401, plinth=3210)
    assert "not mirrored    401 scattered points on no surface" in lines
    phrase = "points of a plinth that is not its own mirror image"
    assert f"not mirrored    3210 {phrase}" in lines
    assert f"Not mirrored: 401 scattered points on no surface and 3,210 {phrase}." in summary
    rows = sections["Numbers"].content[0].rows
    assert ("Points not mirrored, since they lie on no surface", "401") in rows
    assert ("Points not mirrored, of a plinth that is not its own mirror image", "3,210") in rows


@pytest.mark.parametrize(
    ("wide", "shown", "where"),
    [
        (0.0005, "0.0005", "(1.23457, -2.00000, 0.00000)"),
        (3.3, "3.3", "(1.2, -2.0, 0.0)"),
        (25.0, "25", "(1, -2, 0)"),
        (99.7, "100", "(1, -2, 0)"),
        (412.0, "412", "(1, -2, 0)"),
        (41234.0, "41234", "(1, -2, 0)"),
    ],
)
def test_places_are_as_fine_as_the_hole_is_small(wide, shown, where):
    hole = [1.234567, -2.0, 0.0, wide]
    assert (width(hole), place(hole)) == (shown, where)


def test_it_is_what_the_filter_measured(run, scans, tmp_path):
    """Cut off straight through the plane, a statue has an open end that no image fills."""
    mesh_set = load(scans / "statue 1.ply")
    points = mesh_set.current_mesh().vertex_matrix()
    heights = (points - points.mean(axis=0)) @ np.array([1.0, 2.0, 0.0]) / np.sqrt(5.0)
    cut = new_document()
    layer = Layer(points[heights < 0.6], np.zeros((0, 3), dtype=np.int64), "cloud")
    add_layer(cut, layer, current=True)
    save_current(cut, tmp_path / "cut.ply")
    ended = run(
        "reconstruct", tmp_path / "cut.ply", "-o", tmp_path / "a.ply",
        "--json", tmp_path / "a.json",
    )  # fmt: skip
    assert ended.exit_code == 0, ended.stderr
    measured = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))["completion"]
    (line,) = (one for one in ended.stdout.splitlines() if one.startswith("not filled"))
    found = re.match(r"not filled +(\d+) holes?,? .*?([\d.]+) wide at \((.*)\):", line)
    assert found is not None
    assert int(found[1]) == len(measured["open_rims"]) >= 1
    *centre, wide = measured["open_rims"][0]
    assert float(found[2]) == pytest.approx(wide, rel=0.05)
    assert np.allclose([float(one) for one in found[3].split(", ")], centre, atol=0.1 * wide)
