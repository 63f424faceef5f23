"""Which files are scans."""

from __future__ import annotations

from pathlib import Path

import pytest

from meshlab_symrecon.batch.inputs import find_scans, natural
from meshlab_symrecon.errors import FileError

READABLE = ("ply", "obj", "txt")


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in (
        "scans/a10.ply", "scans/a2.ply", "scans/b.OBJ", "scans/notes.txt", "scans/readme.md",
        "scans/.hidden.ply", "scans/deep/a1.ply", "scans/.symrecon-1-x/half.ply", "out/a2.ply",
        "scans/[1].ply",
    ):  # fmt: skip
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(name)
    return tmp_path


def found(*inputs, **how):
    return [str(scan.path) for scan in find_scans(inputs, readable=READABLE, **how)]


def test_folders_have_their_readable_files_in_natural_order(here):
    assert found("scans") == ["scans/[1].ply", "scans/a2.ply", "scans/a10.ply", "scans/b.OBJ"]
    deep = find_scans(["scans"], readable=READABLE, recursive=True)
    assert [str(scan.path) for scan in deep] == [
        "scans/[1].ply", "scans/a2.ply", "scans/a10.ply", "scans/b.OBJ", "scans/deep/a1.ply",
    ]  # fmt: skip
    assert [scan.folder.as_posix() for scan in deep] == [".", ".", ".", ".", "deep"]


def test_patterns_and_files(here):
    assert found("scans/a*.ply") == ["scans/a2.ply", "scans/a10.ply"]
    assert found("**/a*.ply") == [
        "out/a2.ply",
        "scans/a2.ply",
        "scans/a10.ply",
        "scans/deep/a1.ply",
    ]
    assert found("scans/[1].ply") == ["scans/[1].ply"]  # a file of that name
    assert found("scans/notes.txt") == ["scans/notes.txt"]  # named, it is meant
    assert found(here / "scans" / "*" / "*.ply") == [str(here / "scans/deep/a1.ply")]
    assert [scan.folder for scan in find_scans(["scans/**/a1.ply"], readable=READABLE)] == [
        Path("deep")
    ]


def test_results_are_no_scans(here):
    everything = found(".", recursive=True)
    assert "out/a2.ply" in everything
    assert set(everything) - set(found(".", recursive=True, results=Path("out"))) == {"out/a2.ply"}
    assert "out/a2.ply" not in found("**/*.ply", results=Path("out"))
    assert found("out", results=Path("out")) == ["out/a2.ply"]  # refused later, with a reason


def test_a_file_counts_once(here):
    Path("scans/link.ply").symlink_to("a2.ply")
    once = found("scans/a2.ply", "./scans/a2.ply", str(here / "scans/a2.ply"), "scans/a*.ply")
    assert len(once) == 2
    assert len(found("scans")) == 4


def test_what_is_not_there_is_told(here):
    with pytest.raises(FileError, match="scna cannot be read: no such file or folder"):
        found("scans", "scna")
    with pytest.raises(FileError, match=r"no scan fits the pattern 'scans/\*.stl'"):
        found("scans", "scans/*.stl")
    (here / "empty").mkdir()
    with pytest.raises(FileError, match="no scans are in empty"):
        found("empty")


def test_the_natural_order_is_total():
    names = ["b", "a10", "a2", "A2", "2", "10", "a", "a2b", "a02"]
    for shift in range(len(names)):
        turned = names[shift:] + names[:shift]
        assert sorted(turned, key=natural) == sorted(names, key=natural)
    assert sorted(["a10", "a9", "2", "10"], key=natural) == ["2", "10", "a9", "a10"]
