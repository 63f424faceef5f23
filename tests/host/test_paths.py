"""Paths that are refused before any work is done."""

from __future__ import annotations

import pytest

from meshlab_symrecon.errors import FileError
from meshlab_symrecon.host.paths import check_output


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("a.abc", "extension '.abc', which cannot be written; known are ply, obj"),
        ("a", "no extension"),
        ("none/a.ply", "no directory is at"),
        ("folder.ply", "is not an ordinary file"),
        ("in.ply", "would overwrite"),
        ("./../{here}/in.ply", "would overwrite"),
        ("link.ply", "would overwrite"),
        ("a\0.ply", "cannot be written"),
    ],
)
def test_outputs_are_refused_before_any_work(tmp_path, name, words):
    (tmp_path / "folder.ply").mkdir()
    (tmp_path / "in.ply").write_text("scan")
    (tmp_path / "link.ply").symlink_to("in.ply")
    path = tmp_path / name.format(here=tmp_path.name)
    with pytest.raises(FileError, match=words):
        check_output(path, [tmp_path / "other.ply", tmp_path / "in.ply"])
    assert (tmp_path / "in.ply").read_text() == "scan"


def test_devices_are_refused():
    with pytest.raises(FileError, match="is not an ordinary file"):
        check_output("/dev/null", known=())
