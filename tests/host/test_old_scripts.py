"""Old scripts run, and do the same upgraded, as Python programs, and in pymeshlab's own reader."""

from __future__ import annotations

import ast
import warnings
from pathlib import Path

import numpy as np
import pymeshlab
import pytest

from meshlab_symrecon.errors import ScriptError, SymReconWarning
from meshlab_symrecon.host import registration
from meshlab_symrecon.host.current_layer import KEPT
from meshlab_symrecon.host.explanation import explained
from meshlab_symrecon.host.meshset import attribute_names
from meshlab_symrecon.host.mlx_reading import read_script
from meshlab_symrecon.host.mlx_writing import write_script
from meshlab_symrecon.host.native_only import checked_for_the_window
from meshlab_symrecon.host.python_script import python_script
from meshlab_symrecon.host.resolution import matched, resolve_script
from meshlab_symrecon.host.script import run_script
from meshlab_symrecon.host.upgrade import upgraded

SCRIPTS = sorted(Path(__file__).parent.joinpath("old_scripts").glob("*.mlx"))
IN_NO_WINDOW = {  # they change the current layer, lean on which one is, or have a percentage
    "a_change_of_layer",
    "a_deleted_layer",
    "a_percentage",
    "ours_by_an_alias",
    "poisson_and_the_cloud_deleted",
    "poisson_and_the_cloud_deleted_again",
    "poisson_and_the_surface",
}
SINGLE = 1e-6  # numbers go through single precision in pymeshlab's own reader of scripts

READ = (
    "vertex_matrix", "vertex_normal_matrix", "vertex_color_matrix", "vertex_scalar_array",
    "vertex_selection_array", "face_selection_array", "face_color_matrix", "face_scalar_array",
    "transform_matrix",
)  # fmt: skip

every_script = pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.stem)


@pytest.fixture
def document():
    """Return a function that makes two lopsided layers, the second one current."""

    def make():
        mesh_set = pymeshlab.MeshSet(verbose=False)
        mesh_set.create_sphere(subdiv=3)
        mesh_set.compute_coord_by_function(x="x*(1+0.3*z)", y="y*(1+0.2*x)", z="z")
        mesh_set.compute_color_by_function_per_vertex(x="x*100+100", y="50", z="z*99+99")
        mesh_set.create_sphere(subdiv=3, radius=0.8)
        mesh_set.compute_coord_by_function(x="x+0.4", y="y*(1+0.3*z)", z="z")
        return mesh_set

    return make


def ran(mesh_set, path):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SymReconWarning)  # some find nothing
        report = run_script(mesh_set, path)
    measures = [
        {name: value for name, value in step.measures.items() if name != "bbox"}  # has no equality
        for step in report.steps
        if step.measures
    ]
    return mesh_set, measures


def assert_same(first, second, tolerance=0.0):
    """Compare everything that pymeshlab tells of two documents."""
    assert first.mesh_number() == second.mesh_number()
    assert current_position(first) == current_position(second)
    for one, other in zip(first, second, strict=True):
        assert one.label() == other.label()
        assert np.array_equal(one.face_matrix(), other.face_matrix())
        assert attribute_names(first, one.id()) == attribute_names(second, other.id())
        for name in READ:
            wanted, got = content(one, name), content(other, name)
            assert (wanted is None) == (got is None), name
            if wanted is not None:
                np.testing.assert_allclose(got, wanted, rtol=tolerance, atol=tolerance)


def current_position(mesh_set):
    return [mesh.id() for mesh in mesh_set].index(mesh_set.current_mesh_id())


def content(mesh, name):
    """Return one array of a layer; None where it is absent, for which pymeshlab raises."""
    if name.startswith("face_color") and not mesh.has_face_color():
        return None
    if name.startswith("face_scalar") and not mesh.has_face_scalar():
        return None
    return np.asarray(getattr(mesh, name)(), dtype=float)


def test_there_are_enough_scripts_of_every_form():
    assert len(SCRIPTS) >= 45
    texts = [path.read_text(encoding="utf-8") for path in SCRIPTS]
    for form in (
        "RichBool", "RichInt", "RichFloat", "RichString", "RichEnum", "RichDynamicFloat",
        "RichAbsPerc", "RichMesh", "RichPosition", "RichPoint3f", "RichColor", "RichMatrix44f",
        "<xmlfilter", "<Param name", 'value="True"', '%"', "Compact vertices", "(AP)",
    ):  # fmt: skip
        assert any(form in text for text in texts), form


@every_script
def test_the_upgraded_script_does_the_same(path, document, tmp_path):
    script = read_script(path)
    new = upgraded(script, matched(script))
    write_script(new.steps, tmp_path / "new.mlx", new.comments)
    old_run, old_measures = ran(document(), path)
    new_run, new_measures = ran(document(), tmp_path / "new.mlx")
    assert_same(old_run, new_run)
    np.testing.assert_equal(new_measures, old_measures)


@every_script
def test_upgrading_twice_changes_nothing(path, tmp_path):
    first, second = tmp_path / "first.mlx", tmp_path / "second.mlx"
    script = read_script(path)
    once = upgraded(script, matched(script))
    write_script(once.steps, first, once.comments)
    assert read_script(first).steps == once.steps
    assert "xmlfilter>" not in first.read_text().replace("was an <xmlfilter>", "")
    again = upgraded(read_script(first), matched(read_script(first)))
    assert again.unchanged
    write_script(again.steps, second, again.comments)
    assert second.read_bytes() == first.read_bytes()


@every_script
def test_an_upgraded_script_is_of_today(path, tmp_path):
    script = read_script(path)
    write_script(upgraded(script, matched(script)).steps, tmp_path / "new.mlx")
    for step in resolve_script(read_script(tmp_path / "new.mlx")):
        assert {note.message for note in step.notes} <= {KEPT}
        if not isinstance(step.filter, str):
            assert step.step.name == step.filter.menu_name
            for param in step.step.parameters:
                known = step.filter.find(param.name)
                assert param.rich_type == getattr(known, "rich_type", None) or known.kind.rich_type


@every_script
def test_the_python_program_does_the_same(path, document):
    script = read_script(path)
    text = python_script(script, matched(script))
    assert max(map(len, text.splitlines())) <= 100
    imported = {
        alias.name
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Import)
        for alias in node.names
    }
    used = {node.id for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Name)}
    assert ("meshlab_symrecon" in imported) == path.stem.startswith("ours")
    assert ("numpy" in imported) == ("np" in used)
    names = {"__name__": "generated"}
    made = document()
    try:
        exec(compile(text, path.name, "exec"), names)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SymReconWarning)
            names["apply_script"](made)
    finally:
        registration.unload_plugins()
    assert_same(ran(document(), path)[0], made)


@every_script
def test_what_is_native_runs_in_the_own_reader_of_pymeshlab(path, document, tmp_path):
    script = read_script(path)
    if path.stem in IN_NO_WINDOW:
        words = rf"{path.stem}.mlx:\d+: .*MeshLab's (scripts|window)"
        with pytest.raises(ScriptError, match=words):
            checked_for_the_window(script)
    matching = checked_for_the_window(script, lenient=True)
    new = upgraded(script, matching)
    target = tmp_path / "native.mlx"
    write_script(new.steps, target, new.comments)
    native = document()
    native.load_filter_script(str(target))
    native.apply_filter_script()
    assert_same(ran(document(), target)[0], native, SINGLE)
    if path.stem not in IN_NO_WINDOW and not path.stem.startswith("ours"):
        assert_same(ran(document(), path)[0], native, SINGLE)


@every_script
def test_every_script_is_explained(path):
    script = read_script(path)
    text = explained(script, matched(script))
    assert "MISTAKE" not in text
    for number, step in enumerate(script.steps, start=1):
        assert f"\n{number}. " in text
        assert f"(line {step.line})" in text
    for line in text.splitlines():
        assert len(line) <= 80 or " " not in line.strip()
