"""What the documents say is what the package does."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import warnings
from importlib import metadata
from pathlib import Path

import numpy as np
import pymeshlab

import meshlab_symrecon
from meshlab_symrecon.errors import SymReconWarning
from meshlab_symrecon.geometry.surfaces import topology
from meshlab_symrecon.host.script import run_script

ROOT = Path(__file__).parents[1]
README = ROOT.joinpath("README.md").read_text(encoding="utf-8")
DETECTION = ROOT.joinpath("docs/detection.md").read_text(encoding="utf-8")


def test_every_document_names_this_version():
    assert metadata.version("meshlab_symrecon") == meshlab_symrecon.__version__
    citation = ROOT.joinpath("CITATION.cff").read_text(encoding="utf-8")
    assert f"\nversion: {meshlab_symrecon.__version__}\n" in citation
    changes = ROOT.joinpath("CHANGELOG.md").read_text(encoding="utf-8")
    assert f"\n## {meshlab_symrecon.__version__}\n" in changes


def test_the_python_of_the_readme_runs(tmp_path):
    code = re.search(r"```python\n(import pymeshlab.*?)```", README, re.DOTALL)
    assert code is not None
    scan = ROOT / "examples/data/nefertiti_small.ply"
    script = code[1].replace("examples/data/nefertiti_incomplete.ply", str(scan))
    (tmp_path / "first.py").write_text(script + "print(found['planes'].shape)\n", encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "first.py"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "(1, 4)"
    mesh_set = pymeshlab.MeshSet()
    mesh_set.load_new_mesh(str(tmp_path / "statue.ply"))
    shape = topology(mesh_set.current_mesh().face_matrix().astype(np.int64))
    assert shape.closed
    assert shape.vertex_manifold
    assert shape.components == 1


def test_the_kernel_of_the_readme_runs():
    code = re.search(r"```python\n(from meshlab_symrecon.powercrust.*?)```", README, re.DOTALL)
    assert code is not None
    mesh_set = pymeshlab.MeshSet()
    mesh_set.load_new_mesh(str(ROOT / "examples/data/nefertiti_small.ply"))
    names = {"points": mesh_set.current_mesh().vertex_matrix()}
    exec(code[1], names)
    assert names["solid"].topology.closed


def test_the_drawn_plane_of_the_detection_page_is_refined(tmp_path):
    code = re.search(r"```python\n(.*?)```", DETECTION, re.DOTALL)
    assert code is not None
    scan = ROOT / "examples/data/nefertiti_small.ply"
    script = code[1].replace("examples/data/nefertiti_incomplete.ply", str(scan))
    script += "np.savetxt('planes.txt', found['planes'])\nms.save_current_mesh('completed.ply')\n"
    (tmp_path / "draw.py").write_text(script, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "draw.py"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    plane = np.loadtxt(tmp_path / "planes.txt")
    shown = re.search(r"mirror plane +([-\d. ]+)\(A B C D\)", README)
    assert shown is not None
    true = np.array(shown[1].split(), dtype=float)
    assert np.degrees(np.linalg.norm(np.cross(plane[:3], true[:3]))) < 1.0
    mesh_set = pymeshlab.MeshSet()
    mesh_set.load_new_mesh(str(tmp_path / "completed.ply"))
    assert mesh_set.current_mesh().vertex_number() > 3_000


def test_the_script_of_the_detection_page_selects_and_runs(tmp_path):
    text = re.search(r"```xml\n(.*?)```", DETECTION, re.DOTALL)
    assert text is not None
    (tmp_path / "select.mlx").write_text(text[1], encoding="utf-8")
    mesh_set = pymeshlab.MeshSet()
    mesh_set.load_new_mesh(str(ROOT / "examples/data/nefertiti_small.ply"))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SymReconWarning)  # there may be no plane
        report = run_script(mesh_set, tmp_path / "select.mlx")
    assert [step.status for step in report.steps] == ["ran"] * 3
    scan = mesh_set.mesh(0)
    expected = scan.vertex_matrix()[:, 1] > 150.0
    assert 0 < np.count_nonzero(expected) < len(expected)
    assert np.array_equal(scan.vertex_selection_array(), expected)


def test_the_scripts_page_shows_what_its_commands_do(tmp_path):
    page = ROOT.joinpath("docs/scripts.md").read_text(encoding="utf-8")
    old, new = re.findall(r"```xml\n(.*?)```", page, re.DOTALL)
    (words,) = re.findall(r"```text\n(.*?)```", page, re.DOTALL)
    program, in_python = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    (tmp_path / "old.mlx").write_text(old, encoding="utf-8")
    scan = ROOT / "examples/data/nefertiti_small.ply"
    (tmp_path / "scan.ply").write_bytes(scan.read_bytes())
    (tmp_path / "in_python.py").write_text(in_python, encoding="utf-8")
    commands = "".join(re.findall(r"```sh\n(.*?)```", page, re.DOTALL)).splitlines()
    said = {}
    for command in (*commands, "python in_python.py"):
        first, *rest = command.split()
        module = ["-m", "meshlab_symrecon.cli.main"] if first == "symrecon" else []
        done = subprocess.run(
            [sys.executable, *module, *rest],
            cwd=tmp_path, capture_output=True, text=True, check=False,
        )  # fmt: skip
        assert done.returncode == 0, f"{command}\n{done.stderr}"
        said[command] = done.stdout
    assert said["symrecon upgrade old.mlx --explain"] == words
    assert (tmp_path / "same.py").read_text(encoding="utf-8") == program
    assert (tmp_path / "new.mlx").read_text(encoding="utf-8") == new
    report = json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))
    for key in (*report, *report["steps"][0]):
        assert f"`{key}`" in page
    made, same = (pymeshlab.MeshSet(verbose=False) for _ in range(2))
    made.load_new_mesh(str(tmp_path / "web.ply"))
    same.load_new_mesh(str(tmp_path / "same.ply"))
    assert made.current_mesh().face_number() == 2000
    assert np.array_equal(made.current_mesh().vertex_matrix(), same.current_mesh().vertex_matrix())


def test_no_placeholder_is_left():
    assert re.findall(r"@[A-Z]+@", README) == []


def test_links_of_the_documents_lead_somewhere():
    for path in (ROOT / "README.md", *ROOT.glob("docs/**/*.md"), ROOT / "examples/data/README.md"):
        text = path.read_text(encoding="utf-8")
        for target in re.findall(r"\]\((?!https?:)([^)#]+)", text):
            assert (path.parent / target).exists(), f"{path.name}: {target}"
