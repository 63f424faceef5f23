"""What MeshLab's exporters refuse is told of the user's path, with the system's reason if any."""

from __future__ import annotations

from pathlib import Path

import pymeshlab
import pytest

from meshlab_symrecon.errors import FileError, HostError
from meshlab_symrecon.host.export_refusals import exporting_to

ASKED = Path("out/ball.ply")


@pytest.fixture
def ball():
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.create_sphere(subdiv=5)
    return mesh_set


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="only Linux has a disk that is full")
@pytest.mark.parametrize("extension", ["ply", "obj", "stl", "off"])
def test_a_full_disk_is_told(tmp_path, ball, extension):
    staged = tmp_path / f"ball.{extension}"
    staged.symlink_to("/dev/full")
    with pytest.raises(FileError) as caught, exporting_to(ASKED, staged):
        ball.save_current_mesh(str(staged))
    assert str(caught.value) == (
        "out/ball.ply cannot be written: No space left on device; make room, or give another path"
    )


def test_the_place_where_it_is_written_first_is_not_told(tmp_path, ball):
    staged = tmp_path / ".hidden one" / "ball.3ds"
    staged.parent.mkdir()
    ball.create_sphere(subdiv=7)  # more points than the format can count
    with pytest.raises(HostError) as caught, exporting_to(ASKED, staged):
        ball.save_current_mesh(str(staged))
    assert str(caught.value).startswith("out/ball.ply cannot be written: You cannot save more than")
    assert "hidden" not in str(caught.value)


def test_without_words_of_meshlab_there_is_a_reason(tmp_path, ball):
    staged = tmp_path / "ball.ply"
    ball.save_current_mesh(str(staged))
    whole = staged.read_bytes()
    with pytest.raises(HostError) as caught, exporting_to(ASKED, staged):
        raise pymeshlab.PyMeshLabException(f"Error encountered while exportering file {staged}:\n")
    assert str(caught.value) == "out/ball.ply cannot be written: MeshLab names no reason"
    assert staged.read_bytes() == whole
