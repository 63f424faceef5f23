"""Batches in one folder: never on one result, and a dead one blocks nobody."""

from __future__ import annotations

import errno
import os
import subprocess
import sys

import pytest
from batch_inputs import cloud

from meshlab_symrecon.batch import Batch, claims, run_batch
from meshlab_symrecon.batch.claims import claimed
from meshlab_symrecon.errors import FileError

HOLD = """
import sys, time
from pathlib import Path
from meshlab_symrecon.batch.claims import claimed
with claimed(Path(sys.argv[1]), {name: name for name in sys.argv[2:]}, print):
    print("held", flush=True)
    time.sleep(600)
"""


def kill(process):
    process.kill()
    process.wait()
    process.stdout.close()


@pytest.fixture
def holder(tmp_path):
    """Return a function that has another process hold names."""
    processes = []

    def hold(*names, folder=tmp_path):
        words = [sys.executable, "-c", HOLD, str(folder), *names]
        process = subprocess.Popen(words, stdout=subprocess.PIPE)
        processes.append(process)
        assert process.stdout.readline() == b"held\n"
        return process

    yield hold
    for process in processes:
        kill(process)


def claim(folder, *names, said=print):
    return claimed(folder, {name: f"out/{name}" for name in names}, said)


def refused(folder, *names, match="another batch"):
    with pytest.raises(FileError, match=match), claim(folder, *names):
        pytest.fail("it should be another's")


def test_one_result_is_made_by_one_batch_until_that_ends_in_any_way(tmp_path, holder):
    first = holder("a.ply", "b.ply")
    second = holder("c.ply")
    refused(tmp_path, "d.ply", "B.PLY", match=r"another batch is at work on out/B\.PLY; wait")
    with claim(tmp_path, "d.ply"):  # nothing is left of what was refused
        pass
    kill(first)
    with claim(tmp_path, "a.ply", "b.ply"):
        refused(tmp_path, "c.ply", match="at work on out/c")
        kill(second)
        refused(tmp_path, "a.ply", "c.ply", match="at work on out/a")  # by this process
    assert list(tmp_path.iterdir()) == []


def test_a_file_of_locks_that_was_removed_meanwhile_holds_nobody(tmp_path, monkeypatch):
    """Its last owner removes it when it ends, maybe just after we have opened it."""
    opened = claims._opened

    def removed_behind(file):
        monkeypatch.setattr(claims, "_opened", opened)
        descriptor = opened(file)
        file.unlink()
        return descriptor

    monkeypatch.setattr(claims, "_opened", removed_behind)
    with claim(tmp_path, "a.ply"):
        refused(tmp_path, "a.ply")


def test_many_names_and_odd_ones(tmp_path):
    names = [f"{number}.ply" for number in range(3000)] + [os.fsdecode(b"\xff.ply"), "a\nb.ply"]
    with claim(tmp_path, *names):
        for name in ("0.ply", "2999.ply", os.fsdecode(b"\xff.ply"), "a\nb.ply"):
            refused(tmp_path, name)


def test_without_locks_the_user_is_told(tmp_path, monkeypatch):
    def refused(*given):
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    monkeypatch.setattr(claims, "_lock", refused)
    sentences = []
    with claim(tmp_path, "a.ply", "b.ply", said=sentences.append):
        (sentence,) = sentences
        assert "its file system has no locks (No locks available); see to it" in sentence


def test_a_folder_that_cannot_be_written_is_told(tmp_path):
    words = r"the folder .*nowhere cannot be written: .*; make room, or give another one with -d"
    refused(tmp_path / "nowhere", "a.ply", match=words)


def test_batches_share_a_folder_but_no_result(tmp_path, script, holder):
    scans = [cloud(tmp_path / "in" / f"{name}.ply", 60) for name in "ab"]
    out = tmp_path / "out"
    out.mkdir()
    other = holder("a.ply", folder=out)
    with pytest.raises(FileError, match=r"another batch is at work on .*out/a\.ply; wait"):
        run_batch(Batch(script, scans, out, jobs=1, log=tmp_path / "1.jsonl"))
    assert [path.name for path in out.iterdir()] == [".batch.lock"]
    rest = Batch(script, scans[1:], out, jobs=1, log=tmp_path / "2.jsonl")
    assert len(run_batch(rest).done) == 1
    kill(other)
    report = run_batch(Batch(script, scans, out, jobs=1, log=tmp_path / "1.jsonl"))
    assert len(report.done) == 2
    assert sorted(path.name for path in out.iterdir()) == ["a.ply", "b.ply"]
