"""Child processes that do our work, where the user's folder has modules with names of others'."""

from __future__ import annotations

import subprocess
import sys

import pymeshlab
import pytest

from meshlab_symrecon.host.file_job import Manner, run_on_files
from meshlab_symrecon.host.inspection_trial import try_in_child
from meshlab_symrecon.host.own_program import own_program
from meshlab_symrecon.plugin.filter import silent

NOT_OURS = ("json", "random", "numpy", "pymeshlab", "meshlab_symrecon")


@pytest.fixture
def sphere(tmp_path, monkeypatch):
    """Be in a folder with modules that must not be run; return a file in it."""
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.create_sphere(subdiv=1)
    mesh_set.save_current_mesh(str(tmp_path / "sphere.wrl"))
    for name in NOT_OURS:
        (tmp_path / f"{name}.py").write_text("raise SystemExit(3)")
    monkeypatch.chdir(tmp_path)
    return tmp_path / "sphere.wrl"


def test_modules_of_the_users_folder_would_be_run(sphere):
    """That is what the others are about."""
    ended = subprocess.run([sys.executable, "-c", "import json"], check=False)
    assert ended.returncode == 3


def test_a_program_of_ours_imports_ours(sphere):
    ended = subprocess.run([*own_program("meshlab_symrecon.cli.main"), "--version"], check=False)
    assert ended.returncode == 0


@pytest.mark.parametrize("unbuffered", [False, True])
def test_a_file_is_tried_anywhere(sphere, monkeypatch, unbuffered):
    monkeypatch.delenv("PYTHONUNBUFFERED", raising=False)
    if unbuffered:
        monkeypatch.setenv("PYTHONUNBUFFERED", "1")
    assert try_in_child(sphere) == 42


def test_a_script_is_run_in_a_child_anywhere(sphere, tmp_path):
    script = tmp_path / "s.mlx"
    script.write_text(
        '<!DOCTYPE FilterScript><FilterScript><filter name="Compute Geometric Measures"/>'
        "</FilterScript>"
    )
    output = tmp_path / "out.ply"
    run_on_files(script, [sphere], output, manner=Manner(isolate=True), progress=silent)
    assert output.stat().st_size > 0
