"""The shipped scans: loadable, credited, incomplete, small."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pymeshlab
import pytest

DATA = Path(__file__).parents[2] / "examples" / "data"
SCANS = sorted(DATA.glob("*.ply"))
CREDITS = {
    "nefertiti_incomplete": (60_000, ("Al-Badri", "Nelles", "public domain")),
    "nefertiti_small": (3_000, ("Al-Badri", "Nelles", "public domain")),
    "demosthenes_incomplete": (30_000, ("ryanfb", "CC BY 4.0", "changed")),
}


def test_every_shipped_scan_is_known():
    assert {path.stem for path in SCANS} == set(CREDITS)
    assert sum(path.stat().st_size for path in DATA.iterdir()) < 2_000_000


@pytest.mark.parametrize("path", SCANS, ids=lambda path: path.stem)
def test_source_and_licence_stand_in_the_header_and_the_readme(path):
    header = path.read_bytes().split(b"end_header\n")[0].decode("ascii")
    comments = "\n".join(line for line in header.splitlines() if line.startswith("comment "))
    row = next(
        line
        for line in (DATA / "README.md").read_text(encoding="utf-8").splitlines()
        if line.startswith(f"| `{path.name}`")
    )
    for words in CREDITS[path.stem][1]:
        assert words in comments
    assert CREDITS[path.stem][1][-1] in row or "CC BY 4.0" in row


@pytest.mark.parametrize("path", SCANS, ids=lambda path: path.stem)
def test_meshlab_reads_every_scan(path):
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(path))
    points = meshes.current_mesh().vertex_matrix()
    assert points.shape == (CREDITS[path.stem][0], 3)
    assert meshes.current_mesh().face_number() == 0
    raw = path.read_bytes().split(b"end_header\n", 1)[1]
    np.testing.assert_array_equal(points, np.frombuffer(raw, "<f4").reshape(-1, 3))
    assert len(np.unique(points, axis=0)) == len(points)
