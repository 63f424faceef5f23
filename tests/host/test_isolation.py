"""Work in a child process: what comes back, and what a crash becomes."""

from __future__ import annotations

import shutil
import sys
import warnings
from pathlib import Path

import numpy as np
import pymeshlab
import pytest
import survival_inputs as inputs

from meshlab_symrecon.errors import FileError, HostError, ScriptError, SymReconWarning
from meshlab_symrecon.host import isolated_child
from meshlab_symrecon.host.atomic import remove_staging, replacing
from meshlab_symrecon.host.file_job import Manner, run_on_files
from meshlab_symrecon.host.files import load
from meshlab_symrecon.host.filter_script import FilterScript
from meshlab_symrecon.host.mlx import Script
from meshlab_symrecon.host.projects import save_project
from meshlab_symrecon.host.trial import try_script
from meshlab_symrecon.plugin.filter import silent

PLUGIN = Path(__file__).parents[1] / "foreign_plugin" / "crashing_filter.py"
CRASH = '<filter name="Crash Here"/>'
HALVE = (
    '<filter name="Transform: Scale, Normalize">'
    '<Param type="RichFloat" name="axisX" value="0.5"/></filter>'
)
MEASURE = '<filter name="Compute Geometric Measures"/>'
HOW = {"manner": Manner(isolate=True), "progress": silent}


@pytest.fixture
def crashing_plugin(tmp_path, monkeypatch):
    """Install a package whose filter ends the process, for this process and its children."""
    folder = tmp_path / "site"
    information = folder / "crashing-1.0.dist-info"
    information.mkdir(parents=True)
    shutil.copy(PLUGIN, folder)
    (information / "METADATA").write_text("Metadata-Version: 2.1\nName: crashing\nVersion: 1.0\n")
    (information / "entry_points.txt").write_text(
        "[meshlab_symrecon.filters]\ncrash = crashing_filter:FILTER\n"
    )
    monkeypatch.syspath_prepend(folder)
    monkeypatch.setenv("PYTHONPATH", str(folder))
    from meshlab_symrecon.host.registration import registry

    registry(refresh=True)
    yield
    monkeypatch.undo()
    registry(refresh=True)


@pytest.fixture
def sphere(tmp_path):
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.create_sphere(subdiv=2)
    mesh_set.save_current_mesh(str(tmp_path / "sphere.ply"))
    return tmp_path / "sphere.ply"


def script_of(tmp_path, *steps):
    path = tmp_path / "scan.mlx"
    path.write_text("<FilterScript>\n" + "\n".join(steps) + "\n</FilterScript>\n")
    return path


def test_a_child_gives_the_same_bytes_and_the_same_report(tmp_path, sphere):
    script = script_of(tmp_path, HALVE, MEASURE)
    told = []
    here, there = tmp_path / "here.ply", tmp_path / "there.ply"
    near = run_on_files(script, [sphere], here, **HOW | {"manner": Manner()})
    far = run_on_files(
        script, [sphere], there, **HOW | {"progress": lambda *what: told.append(what)}
    )
    assert here.read_bytes() == there.read_bytes()
    assert [step.filter for step in far.steps] == [step.filter for step in near.steps]
    expected, got = near.steps[1].measures, far.steps[1].measures
    assert set(expected) == set(got)
    assert got["surface_area"] == expected["surface_area"]
    np.testing.assert_array_equal(got["inertia_tensor"], expected["inertia_tensor"])
    np.testing.assert_array_equal(got["bbox"].max(), expected["bbox"].max())
    assert got["bbox"].diagonal() == pytest.approx(expected["bbox"].diagonal(), rel=1e-15)
    assert (0.5, f"{script}:3: 'Compute Geometric Measures'") in told


def test_a_crash_is_an_error_that_names_the_step(tmp_path, sphere, crashing_plugin):
    script = script_of(tmp_path, HALVE, CRASH, HALVE)
    before = sorted(path for path in tmp_path.rglob("*") if "__pycache__" not in path.parts)
    with pytest.raises(HostError) as caught:
        run_on_files(script, [sphere], tmp_path / "out.ply", **HOW)
    message = str(caught.value)
    assert message.startswith(f"{script}:3: 'Crash Here'")
    assert "ended the process by SIGSEGV; nothing was written" in message
    assert sorted(path for path in tmp_path.rglob("*") if "__pycache__" not in path.parts) == before


def test_errors_and_warnings_of_the_child_are_ours(tmp_path, sphere):
    script = script_of(tmp_path, HALVE)
    with pytest.raises(FileError, match="no such file"):
        run_on_files(script, [tmp_path / "none.ply"], tmp_path / "out.ply", **HOW)
    with pytest.raises(ScriptError, match=r"scan.mlx:2: .*Crash Here"):
        run_on_files(script_of(tmp_path, CRASH), [sphere], tmp_path / "out.ply", **HOW)
    assert not (tmp_path / "out.ply").exists()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        run_on_files(script_of(tmp_path, HALVE), [sphere], tmp_path / "out.xyz", **HOW)
    assert [one.category for one in caught] == [SymReconWarning]
    assert "holds points only" in str(caught[0].message)


@pytest.mark.skipif(sys.platform != "linux", reason="the limit is one of Linux")
def test_many_cores_leave_a_child_its_memory(monkeypatch):
    """BLAS maps memory for a thread of each core, which nothing touches."""
    import resource

    set_limits = []
    monkeypatch.setattr(resource, "setrlimit", lambda what, limits: set_limits.append(limits[0]))
    monkeypatch.setattr(resource, "getrlimit", lambda what: (-1, resource.RLIM_INFINITY))
    for cores in (1, 64):
        monkeypatch.setattr(isolated_child.os, "cpu_count", lambda cores=cores: cores)
        isolated_child._bound(400 << 20)
    few, many = set_limits
    assert 400 << 20 < few < 1 << 30
    assert many - few > 63 * 2 * (40 << 20)  # numpy's and scipy's


def test_only_what_the_crashed_process_staged_is_removed(tmp_path):
    other, mine = tmp_path / ".symrecon-99-x", tmp_path / ".symrecon-9-y"
    other.mkdir()
    mine.mkdir()
    (mine / "half.ply").write_text("ply")
    remove_staging(tmp_path, 9)
    assert sorted(tmp_path.iterdir()) == [other]
    with replacing(tmp_path / "out.txt") as staged:
        staged.write_text("whole")
    assert (tmp_path / "out.txt").read_text() == "whole"


def test_a_script_that_crashes_on_a_copy_leaves_the_document_alone(tmp_path, crashing_plugin):
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.create_sphere(subdiv=2)
    mesh_set.create_cube()
    mesh_set.set_current_mesh(0)
    before = mesh_set.mesh(0).vertex_matrix()
    script = FilterScript.read(script_of(tmp_path, HALVE, CRASH))
    with pytest.raises(HostError, match=r"scan.mlx:3: 'Crash Here'.* by SIGSEGV"):
        script.run(mesh_set, isolate=True)
    np.testing.assert_array_equal(mesh_set.mesh(0).vertex_matrix(), before)
    told = []
    report = script.without_step(1).run(
        mesh_set, isolate=True, progress=lambda fraction, message: told.append(fraction)
    )
    assert [step.status for step in report.steps] == ["ran"]
    np.testing.assert_allclose(mesh_set.mesh(0).vertex_matrix(), before / 2, rtol=1e-7)
    assert mesh_set.mesh(1).bounding_box().diagonal() == pytest.approx(3**0.5)
    assert told == sorted(told)
    assert told[-1] == 1.0


def test_a_script_on_an_empty_document_is_tried_as_well(tmp_path):
    script = FilterScript().with_step("create_cube", size=2.0)
    mesh_set = pymeshlab.MeshSet(verbose=False)
    script.run(mesh_set, isolate=True)
    assert mesh_set.current_mesh().vertex_number() == 8
    with pytest.raises(ScriptError, match="step 1: 'Close Holes' needs a layer"):
        FilterScript().with_step("Close Holes").run(pymeshlab.MeshSet(verbose=False), isolate=True)


def marked_sphere():
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.create_sphere(subdiv=2)
    mesh_set.compute_new_custom_scalar_attribute_per_vertex(name="mine", expr="x")
    mesh_set.compute_new_custom_scalar_attribute_per_face(name="ours", expr="x0")
    mesh_set.compute_selection_by_condition_per_face(condselect="x0 > 0")
    mesh_set.compute_selection_by_condition_per_vertex(condselect="x > 0")
    return mesh_set


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("compute_scalar_by_function_per_vertex", {"q": "mine*2"}),
        ("compute_scalar_by_function_per_face", {"q": "ours*2"}),
        ("compute_matrix_by_fitting_to_plane", {}),
        ("generate_polyline_from_selection_perimeter", {}),
    ],
)
def test_the_copy_has_attributes_and_selections(crashing_plugin, name, values):
    """The crash behind the step is reached only when the step has what it needs."""
    mesh_set = marked_sphere()
    script = FilterScript().with_step(name, **values)
    crashing = script.with_step("create_cube").with_step("get_crash")
    with pytest.raises(HostError, match=r"step \d: .* by SIGSEGV"):
        try_script(mesh_set, Script(crashing.path, crashing.steps), lenient=False, progress=silent)
    with warnings.catch_warnings():
        warnings.simplefilter("error", SymReconWarning)
        report = script.run(mesh_set, isolate=True)
    assert [step.status for step in report.steps] == ["ran"]


def test_the_copy_has_textures(tmp_path, crashing_plugin):
    inputs.png(tmp_path / "a.png", 0)
    (tmp_path / "in.mtl").write_text("newmtl stone\nmap_Kd a.png\n")
    (tmp_path / "in.obj").write_text(
        "mtllib in.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\n"
        "usemtl stone\nf 1/1 2/2 3/3\n"
    )
    mesh_set = load(tmp_path / "in.obj")
    script = FilterScript().with_step("transfer_texture_to_color_per_vertex")
    crashing = script.with_step("create_cube").with_step("get_crash")
    with pytest.raises(HostError, match=r"step \d: .* by SIGSEGV"):
        try_script(mesh_set, Script(crashing.path, crashing.steps), lenient=False, progress=silent)
    script.run(mesh_set, isolate=True)
    assert mesh_set.mesh(0).has_vertex_color()


def test_an_empty_layer_does_not_keep_a_script_from_being_tried(crashing_plugin):
    mesh_set = marked_sphere()
    mesh_set.create_cube()
    mesh_set.set_selection_all()
    mesh_set.meshing_remove_selected_vertices()
    crashing = FilterScript().with_step("create_cube").with_step("get_crash")
    with pytest.raises(HostError, match=r"step \d: .* by SIGSEGV"):
        try_script(mesh_set, Script(crashing.path, crashing.steps), lenient=False, progress=silent)


def test_what_fails_on_the_copy_alone_is_no_error(monkeypatch):
    """A copy that cannot be written or read is told; what fails on it is not."""
    mesh_set = marked_sphere()
    script = FilterScript().with_step("compute_scalar_by_function_per_vertex", q="mine*2")

    def without_attributes(mesh_set, path):
        plain = pymeshlab.MeshSet(verbose=False)
        plain.create_cube()
        save_project(plain, path)

    def damaged(mesh_set, path):
        path.write_text("no project")

    def refused(mesh_set, path):
        raise FileError("no room")

    monkeypatch.setattr("meshlab_symrecon.host.trial.save_project", without_attributes)
    assert script.run(mesh_set, isolate=True).steps[0].status == "ran"
    monkeypatch.setattr("meshlab_symrecon.host.trial.save_project", damaged)
    with pytest.warns(SymReconWarning, match="was not tried on a copy .* cannot be read"):
        script.run(mesh_set, isolate=True)
    monkeypatch.setattr("meshlab_symrecon.host.trial.save_project", refused)
    with pytest.warns(SymReconWarning, match="was not tried on a copy of the document: no room"):
        assert script.run(mesh_set, isolate=True).steps[0].status == "ran"
