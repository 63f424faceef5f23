"""What every wheel must do where it is installed; needs nothing of this repository but itself."""

from __future__ import annotations

import importlib
import json
import shutil
import subprocess
import sys
import sysconfig
from importlib import metadata
from importlib.resources import files

import numpy as np
import pymeshlab
import pytest

import meshlab_symrecon
from meshlab_symrecon.geometry.surfaces import topology
from meshlab_symrecon.powercrust import reconstruct
from meshlab_symrecon.symmetry import detect_reflection_planes

NORMAL = np.array([2.0, -1.0, 2.0]) / 3.0
PLANE = np.append(NORMAL, -4.0)


def bust(count: int = 4000) -> np.ndarray:
    """Return a cloud that is its own image across ``PLANE``, but for a part that is missing."""
    drawn = np.random.default_rng(0).normal(size=(count, 3))
    x, y, z = (drawn / np.linalg.norm(drawn, axis=1, keepdims=True)).T
    ears = 0.4 * np.exp(-8.0 * ((abs(x) - 0.6) ** 2 + (y - 0.3) ** 2))
    radius = 1.0 + 0.35 * z + 0.3 * y * z - 0.25 * y**3 + ears + 0.3 * z * x**2
    points = radius[:, np.newaxis] * np.column_stack([x, y, z])
    kept = points[~((points[:, 0] > 0.6) & (points[:, 1] > 0.0))]
    frame, _ = np.linalg.qr(np.column_stack([NORMAL, [1.0, 0, 0], [0, 1.0, 0]]))
    return kept @ frame.T + 4.0 * NORMAL


@pytest.fixture(scope="module")
def scan(tmp_path_factory):
    path = tmp_path_factory.mktemp("scans") / "scan größe.ply"
    mesh_set = pymeshlab.MeshSet()
    mesh_set.add_mesh(pymeshlab.Mesh(bust()))
    mesh_set.save_current_mesh(str(path))
    return path


def command(name, *arguments):
    """Run a command that the installation has put beside Python."""
    program = shutil.which(name, path=sysconfig.get_path("scripts"))
    assert program is not None, f"{name} is not in {sysconfig.get_path('scripts')}"
    return subprocess.run(
        [program, *map(str, arguments)],
        capture_output=True, text=True, encoding="utf-8", check=False,
    )  # fmt: skip


def closed(path):
    mesh_set = pymeshlab.MeshSet()
    mesh_set.load_new_mesh(str(path))
    shape = topology(mesh_set.current_mesh().face_matrix().astype(np.int64))
    return shape.closed and shape.components == 1


def test_the_version_is_that_of_the_installation():
    assert meshlab_symrecon.__version__ == metadata.version("meshlab-symrecon")
    for name in ("symrecon", "symrecon-server"):
        told = command(name, "--version")
        assert told.returncode == 0, told.stderr
        assert meshlab_symrecon.__version__ in told.stdout


def test_the_kernel_is_there_and_works():
    found = detect_reflection_planes(bust())
    sign = np.sign(found.planes[0] @ PLANE)
    assert np.allclose(sign * found.planes[0], PLANE, atol=0.02)
    ball = np.random.default_rng(1).normal(size=(500, 3))
    solid = reconstruct(ball / np.linalg.norm(ball, axis=1, keepdims=True))
    assert solid.topology.closed
    assert solid.topology.genus == 0


def test_the_whole_method_runs_from_the_command_line(scan, tmp_path):
    statue, report = tmp_path / "statue.ply", tmp_path / "report.json"
    done = command("symrecon", "reconstruct", scan, "-o", statue, "--json", report)
    assert done.returncode == 0, done.stderr
    assert closed(statue)
    assert json.loads(report.read_text(encoding="utf-8"))


def test_the_scripts_that_come_along_are_found_and_run(scan, tmp_path):
    listed = subprocess.run(
        [sys.executable, "-m", "meshlab_symrecon.meshlab_scripts", "scan_to_solid"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert listed.returncode == 0, listed.stderr
    statue = tmp_path / "statue.ply"
    done = command("symrecon", "run", listed.stdout.strip(), scan, "-o", statue)
    assert done.returncode == 0, done.stderr
    assert closed(statue)


def test_data_files_types_and_entry_points_are_there():
    package = files("meshlab_symrecon")
    for name in ("py.typed", "_native.pyi", "host/native_filters.json", "host/old_names.json",
                 "pictures/report_page.html", "pictures/report_page.css",
                 "pictures/report_page.js"):  # fmt: skip
        assert package.joinpath(name).is_file(), name
    declared = metadata.entry_points(group="meshlab_symrecon.filters")
    ours = [entry for entry in declared if entry.value.startswith("meshlab_symrecon.filters.")]
    assert ours
    for entry in ours:
        assert importlib.import_module(entry.module).FILTER is entry.load()
