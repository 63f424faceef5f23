"""Folders of temporary files go after their process, and never before."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from meshlab_symrecon.host import temporary_folders
from meshlab_symrecon.host.temporary_folders import SIGN, kept_alive, remove_dead_folders

pytestmark = pytest.mark.skipif(os.name != "posix", reason="there are no such locks on Windows")

PROGRAM = """
import sys, tempfile, time
from pathlib import Path
from meshlab_symrecon.host.interruption import interruptible
with interruptible():
    Path(tempfile.gettempdir(), "large").write_bytes(bytes(100))
    print(tempfile.gettempdir(), flush=True)
    sys.stdin.readline()
"""


@pytest.fixture
def start(tmp_path):
    """Return a function that starts a program in its own folder for temporary files."""
    started = []

    def begin():
        process = subprocess.Popen(
            [sys.executable, "-c", PROGRAM], text=True, env=os.environ | {"TMPDIR": str(tmp_path)},
            stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        )  # fmt: skip
        started.append(process)
        return process, Path(process.stdout.readline().strip())

    yield begin
    for process in started:
        process.kill()
        process.communicate()


def test_what_a_killed_process_left_goes_with_the_next_one(tmp_path, start):
    killed, left = start()
    living, kept = start()
    killed.kill()
    killed.wait()
    assert (left / "large").exists()
    _, third = start()
    assert sorted(tmp_path.iterdir()) == sorted([kept, third])
    assert (kept / "large").exists()
    living.communicate("\n")
    assert list(tmp_path.iterdir()) == [third]


def folder_of(parent, name="symrecon-1-0a1b2c3d"):
    folder = parent / name
    folder.mkdir()
    (folder / "large").write_bytes(bytes(100))
    return folder


def abandoned(parent, name="symrecon-1-0a1b2c3d"):
    folder = folder_of(parent, name)
    with kept_alive(folder):
        pass
    return folder


def test_a_folder_goes_when_nobody_holds_it(tmp_path):
    folder = folder_of(tmp_path)
    with kept_alive(folder):
        remove_dead_folders(tmp_path)
        assert sorted(path.name for path in folder.iterdir()) == [SIGN, "large"]
    remove_dead_folders(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_what_may_be_of_others_stays(tmp_path, monkeypatch):
    folder_of(tmp_path, "symrecon-1-00000000")  # without a sign
    abandoned(tmp_path, "symrecon-x-0a1b2c3d")
    abandoned(tmp_path, "symrecon-1-0a1b2c3d.bak")
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (tmp_path / "symrecon-2-00000000").symlink_to(abandoned(elsewhere))
    linked = folder_of(tmp_path, "symrecon-3-00000000")
    (linked / SIGN).symlink_to(elsewhere / "symrecon-1-0a1b2c3d" / SIGN)
    pipe = folder_of(tmp_path, "symrecon-4-00000000")
    os.mkfifo(pipe / SIGN)
    (tmp_path / "symrecon-5-00000000").write_text("a file")
    monkeypatch.setattr(temporary_folders, "_kernel", lambda: b"another machine")
    abandoned(tmp_path, "symrecon-6-00000000")
    monkeypatch.undo()
    before = sorted(tmp_path.rglob("*"))
    remove_dead_folders(tmp_path)
    assert sorted(tmp_path.rglob("*")) == before
    ours = abandoned(tmp_path)
    monkeypatch.setattr(os, "geteuid", lambda: os.getuid() + 1)
    remove_dead_folders(tmp_path)
    assert ours.exists()
    monkeypatch.undo()
    remove_dead_folders(tmp_path)
    assert sorted(tmp_path.rglob("*")) == before


def test_without_locks_or_a_folder_there_is_no_sign(tmp_path, monkeypatch):
    def refused(*given):
        raise OSError

    with kept_alive(tmp_path / "missing"):
        remove_dead_folders(tmp_path / "missing")
    monkeypatch.setattr("fcntl.flock", refused)
    folder = abandoned(tmp_path)
    monkeypatch.undo()
    remove_dead_folders(tmp_path)
    assert folder.exists()


def test_where_the_kernel_does_not_tell_its_start_the_machine_has_a_name(tmp_path, monkeypatch):
    monkeypatch.setattr(temporary_folders, "KERNEL", tmp_path / "none")
    folder = abandoned(tmp_path)
    monkeypatch.setattr("platform.node", lambda: "another")
    remove_dead_folders(tmp_path)
    assert folder.exists()
    monkeypatch.undo()
    monkeypatch.setattr(temporary_folders, "KERNEL", tmp_path / "none")
    remove_dead_folders(tmp_path)
    assert not folder.exists()
