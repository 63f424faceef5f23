"""What jobs need: estimates that are never too small, and words when there is too little."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import pymeshlab
import pytest

from meshlab_symrecon.errors import SizeError, SymReconWarning
from meshlab_symrecon.host import reconstruction, size
from meshlab_symrecon.host.fewest_points import FEWEST_POINTS
from meshlab_symrecon.host.files import load, save_current
from meshlab_symrecon.host.meshset import read_layer
from meshlab_symrecon.host.size import (
    RECONSTRUCT,
    check_memory,
    check_rest,
    memory_needed,
)

GIGABYTE = 10**9
DETECT = RECONSTRUCT[:2]


def announcing(folder, points, faces=0, name="scan.ply"):
    """Write a file whose header announces points, with a hole of their size behind it."""
    path = folder / name
    header = (
        f"ply\nformat ascii 1.0\nelement vertex {points}\nproperty float x\nproperty float y\n"
        f"property float z\nelement face {faces}\nproperty list uchar int vertex_indices\n"
        "end_header\n"
    )
    with path.open("wb") as file:
        file.write(header.encode())
        file.truncate(len(header) + 6 * points + 2 * faces)
    return path


def refusal(*given, **options):
    with pytest.raises(SizeError) as caught:
        check_memory(*given, **options)
    return str(caught.value)


@pytest.mark.parametrize("steps", [(), DETECT, RECONSTRUCT, ("meshing_poly_to_tri",), ("???",)])
def test_more_points_faces_and_steps_need_more(steps):
    sizes = [0, 10, 10_000, 10**6, 10**7, 10**9]
    needed = [memory_needed(size, 0, steps) for size in sizes]
    assert all(fewer < more for fewer, more in pairwise(needed))
    assert memory_needed(10**6, 10**6, steps) > memory_needed(10**6, 0, steps)
    assert memory_needed(10**6, 0, (*steps, RECONSTRUCT[-1])) > memory_needed(10**6, 0, ())


def test_filters_are_known_by_all_their_names():
    names = ("power_crust_reconstruct", "Surface Reconstruction: Power Crust", RECONSTRUCT[-1])
    assert len({memory_needed(10**6, 0, (name,)) for name in names}) == 1
    assert memory_needed(10**6, 0, names[:1]) > memory_needed(10**6, 0, ("no such filter",))


def test_after_a_simplification_nobody_knows_the_size():
    crust = RECONSTRUCT[-1]
    for name in ("generate_simplified_points", "Poisson-disk Sampling", "no such filter"):
        assert memory_needed(10**7, 0, (name, crust)) == memory_needed(10**7, 0, (name, crust) * 2)
        assert memory_needed(10**7, 0, (name, crust)) < memory_needed(10**7, 0, (crust,))
    for name in ("Remove Duplicate Vertices", "compute_normal_for_point_clouds"):
        assert memory_needed(10**7, 0, (name, crust)) == memory_needed(10**7, 0, (crust,))


MEASURED = """
import json, sys
from pathlib import Path
from meshlab_symrecon.host.reconstruction import whole_method
whole_method(Path(sys.argv[1]), {}, lambda fraction, message: None)
lines = Path("/proc/self/status").read_text().splitlines()
print(json.dumps(next(int(line.split()[1]) for line in lines if line.startswith("VmHWM")) * 1024))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="the peak of a process is told on Linux")
def test_the_estimate_holds_for_a_small_scan(tmp_path):
    rng = np.random.default_rng(0)
    points = rng.normal(size=(12_000, 3)) * [1.0, 0.7, 0.5]
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    points = points[(points[:, 0] < 0.6) | (points[:, 1] < 0.3)] * [1.0, 1.4, 1.2]
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.add_mesh(pymeshlab.Mesh(points))
    path = tmp_path / "scan.ply"
    save_current(mesh_set, path)
    done = subprocess.run(
        [sys.executable, "-c", MEASURED, str(path)], capture_output=True, text=True, check=True
    )
    peak, needed = json.loads(done.stdout), memory_needed(len(points))
    assert 0.5 * needed < peak < needed


def test_what_fits_is_let_through(tmp_path):
    path = announcing(tmp_path, 10_000)
    check_memory(path)
    check_memory(path, memory_needed(10_000))
    check_memory(str(path), memory_needed(10_000, 0, DETECT), steps=DETECT)
    check_memory([], 0)


def test_what_does_not_fit_is_told_with_a_number_of_points_that_does(tmp_path):
    path = announcing(tmp_path, 12_000_000)
    told = refusal(path, 14 * GIGABYTE)
    pattern = (
        r"(.*) has 12000000 points; reconstruct needs about (\d+) GB and the limit leaves 14 GB; "
        r"run it with --max-points (\d+), which thins the scan out evenly first, or raise the limit"
    )
    name, needed, fitting = re.fullmatch(pattern, told).groups()
    assert name == str(path)
    assert int(needed) == round(memory_needed(12_000_000) / GIGABYTE)
    check_memory(path, 14 * GIGABYTE, most=int(fitting))
    more = refusal(path, 14 * GIGABYTE, most=round(1.2 * int(fitting)))
    assert f"reconstruct on {round(1.2 * int(fitting))} of them needs" in more
    assert f"--max-points {fitting}, " in more


def test_a_job_is_called_by_its_name_and_a_limit_counts_in_full(tmp_path):
    path = announcing(tmp_path, 5_000_000)
    enough = memory_needed(5_000_000, 0, DETECT)
    check_memory(path, enough, steps=DETECT)
    told = refusal(path, enough - 1, steps=DETECT, work="detect.mlx", option="")
    assert "; detect.mlx needs about" in told
    assert "points first (symrecon apply generate_simplified_point_cloud IN -o OUT" in told


def test_a_file_too_large_to_be_read_is_to_be_split(tmp_path):
    told = refusal(announcing(tmp_path, 10**9), 14 * GIGABYTE, most=1_000)
    assert "reading them alone needs about" in told
    assert "split the file into parts" in told


@pytest.mark.parametrize("more", [0, FEWEST_POINTS - 1])
def test_too_little_for_any_size_is_no_matter_of_points(tmp_path, monkeypatch, more):
    path = announcing(tmp_path, 1000)
    told = refusal(path, memory_needed(more))
    assert told.endswith("and the limit leaves 0.4 GB; raise the limit")
    monkeypatch.setattr(size, "available_memory", lambda: memory_needed(more))
    told = refusal(path)
    assert told.endswith(
        "and 0.4 GB are free; close other programs, or use a machine with more memory"
    )


def test_what_the_machine_lacks_is_no_limit(tmp_path, monkeypatch):
    """Without a limit, the words are of what is free, and of another machine."""
    monkeypatch.setattr(size, "available_memory", lambda: 14 * GIGABYTE)
    for points, words in ((12_000_000, "which thins the scan out"), (10**9, "split the file")):
        told = refusal(announcing(tmp_path, points))
        assert " and 14 GB are free; " in told
        assert words in told
        assert told.endswith(", or use a machine with more memory")
        assert refusal(announcing(tmp_path, points), 14 * GIGABYTE) == told.replace(
            "14 GB are free", "the limit leaves 14 GB"
        ).replace("use a machine with more memory", "raise the limit")


def test_files_of_one_document_count_together(tmp_path):
    paths = [announcing(tmp_path, 10**6, name=f"{number}.ply") for number in range(5)]
    alone = memory_needed(10**6, 0, DETECT)
    check_memory(paths[:1], alone, steps=DETECT)
    assert str(paths[0]) in refusal(paths, alone, steps=DETECT)
    assert "and the limit leaves 0.2 GB beside the other inputs; " in refusal(
        paths, alone, steps=DETECT
    )
    check_memory(paths, alone + 4 * memory_needed(10**6, 0, ()), steps=DETECT)
    assert "has 1000000 points; " in refusal(paths[:1] * 5, alone, steps=DETECT)


def test_an_estimate_from_a_sample_is_called_one(tmp_path):
    path = tmp_path / "scan.xyz"
    path.write_text("0.125 0.25 0.5\n" * 200_000, encoding="ascii")
    assert re.search(r"has about (199|200)\d{3} points; ", refusal(path, GIGABYTE // 4))


def test_files_that_do_not_tell_are_let_through_to_the_reader(tmp_path):
    path = tmp_path / "scan.fbx"
    path.write_bytes(b"anything")
    check_memory([path, tmp_path / "missing.ply"], 0)


def test_the_rest_of_a_job_is_checked_again():
    check_rest(Path("scan.3ds"), 10_000, RECONSTRUCT, measured=10_000)
    with pytest.raises(SizeError) as caught:
        check_rest(Path("scan.3ds"), 3 * 10**6, RECONSTRUCT[-1:], GIGABYTE, measured=10**6)
    fitting = int(re.search(r"--max-points (\d+)", str(caught.value))[1])
    assert str(caught.value).startswith("scan.3ds: 3000000 points need about ")
    assert 0 < fitting < 10**6


@pytest.fixture
def statue(tmp_path):
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.create_sphere(subdiv=4)
    path = tmp_path / "ball.ply"
    save_current(mesh_set, path)
    return path


def silent(fraction, message):
    pass


def test_the_whole_method_refuses_before_it_reads(statue, monkeypatch):
    monkeypatch.setattr(reconstruction, "load", lambda path: pytest.fail("it was read"))
    with pytest.raises(SizeError, match=r"ball\.ply has 2562 points; reading them alone needs"):
        reconstruction.whole_method(statue, {}, silent, limit=10**6)


def test_the_whole_method_refuses_what_the_file_did_not_tell(statue, monkeypatch):
    monkeypatch.setattr(reconstruction, "check_memory", lambda *given, **options: None)
    with pytest.raises(SizeError, match=r"ball\.ply: 2562 points need about"):
        reconstruction.whole_method(statue, {}, silent, limit=10**6)


def test_the_whole_method_thins_out_first(statue):
    whole = {tuple(row) for row in read_layer(load(statue), 0).points.tolist()}
    with pytest.warns(SymReconWarning, match="without its 5120 faces"):
        result = reconstruction.whole_method(statue, {}, silent, most=600)
    scan = result.mesh_set.mesh(result.layers[reconstruction.SCAN])
    assert result.measured == 2_562
    assert result.points == scan.vertex_number() <= 600
    assert {tuple(row) for row in scan.vertex_matrix().tolist()} < whole
    assert result.completed["measured"] == result.points
    assert result.surface["closed"]
    assert list(result.layers) == [
        label for label in reconstruction.LABELS if label in result.layers
    ]
