"""The log: whole lines, one writer, and an end that is mended."""

from __future__ import annotations

import errno
import json
import os
import subprocess
import sys

import pytest

from meshlab_symrecon.batch.log import opened_log
from meshlab_symrecon.batch.reports import ScanReport
from meshlab_symrecon.errors import FileError

FIRST = ScanReport("a.ply", "out/a.ply", "a.ply", "done", work_sha256="w", measures={"x": [1.5]})
SECOND = ScanReport("größe.ply", "out/b.ply", "b.ply", "failed", "no \n points", work_sha256="w")


def written(path, *reports):
    with opened_log(path) as log:
        for report in reports:
            log.append(report)
    return path


def read(path):
    with opened_log(path) as log:
        return log.reports, log.passed_over


def test_reports_come_back(tmp_path):
    path = written(tmp_path / "batch.jsonl", FIRST, SECOND)
    lines = path.read_bytes().splitlines()
    assert [json.loads(line)["scan"] for line in lines] == ["a.ply", "größe.ply"]
    reports, passed_over = read(path)
    assert [report.as_data() for report in reports] == [
        json.loads(json.dumps(report.as_data())) for report in (FIRST, SECOND)
    ]
    assert all(report.resumed for report in reports)
    assert passed_over == 0


def test_any_half_line_at_the_end_is_mended(tmp_path):
    whole = written(tmp_path / "whole.jsonl", FIRST).read_bytes()
    last = written(tmp_path / "last.jsonl", SECOND).read_bytes()
    path = tmp_path / "half.jsonl"
    for length in range(len(last)):
        path.write_bytes(whole + last[:length])
        reports, passed_over = read(path)
        all_there = length == len(last) - 1  # only the end of the line is missing
        assert len(reports) == 1 + all_there
        assert passed_over == 0
        assert path.read_bytes() == (whole + last if all_there else whole)


def test_zeros_after_a_loss_of_power_are_removed(tmp_path):
    path = written(tmp_path / "batch.jsonl", FIRST)
    whole = path.read_bytes()
    path.write_bytes(whole + b"\0" * 4096)
    assert len(read(path)[0]) == 1
    assert path.read_bytes() == whole


@pytest.mark.parametrize(
    "line",
    [
        b"# a note", b"{}", b"[1, 2]", b"null", b"\xff\xfe", b'{"scan": 1}', b"[" * 100_000,
        json.dumps(SECOND.as_data() | {"limits": 3}).encode(),
        json.dumps(SECOND.as_data() | {"name": None}).encode(),
        json.dumps(SECOND.as_data() | {"seconds": "long"}).encode(),
        json.dumps(SECOND.as_data() | {"measures": [1]}).encode(),
        json.dumps(SECOND.as_data() | {"steps": [1]}).encode(),
        json.dumps(SECOND.as_data() | {"peak_memory_bytes": "much"}).encode(),
    ],
)  # fmt: skip
def test_other_lines_are_kept_and_passed_over(tmp_path, line):
    path = written(tmp_path / "batch.jsonl", FIRST)
    whole = path.read_bytes()
    path.write_bytes(line + b"\n" + whole + line)
    reports, passed_over = read(path)
    assert [report.name for report in reports] == ["a.ply"]
    assert passed_over == 2 - line.startswith(b'{"scan": "')  # at the end it looks like a half one
    assert path.read_bytes().startswith(line + b"\n" + whole)
    written(path, SECOND)
    assert [report.name for report in read(path)[0]] == ["a.ply", "b.ply"]


def test_a_damaged_line_is_passed_over_and_what_is_not_known_is_left_out(tmp_path):
    """A block was lost within the first line; the second is of an older version of ours."""
    path = written(tmp_path / "batch.jsonl", FIRST, SECOND)
    first, second = path.read_bytes().splitlines(keepends=True)
    older = json.loads(second)
    del older["output_files"], older["points"]
    older |= {"measures": None, "word": 1}
    path.write_bytes(first[:60] + first)  # glued to the next
    assert [len(read(path)[0]), read(path)[1]] == [0, 1]
    path.write_bytes(first[:40] + bytes(300) + b"\n" + json.dumps(older).encode() + b"\n")
    (report,), passed_over = read(path)
    assert passed_over == 1
    assert (report.name, report.measures, report.output_files) == ("b.ply", {}, {})


@pytest.mark.parametrize(
    "content",
    [b"ply\nformat ascii 1.0\n" + b"\0" * 99, b"2026-01-01 work began\n", b"{}\n" * 3, b"\x7fELF",
     b'note\n{"scan": "in/s9.ply", "outp', b"\n\nnote"],
)  # fmt: skip
def test_what_is_no_log_is_refused_and_stays(tmp_path, content):
    path = tmp_path / "precious.bin"
    path.write_bytes(content)
    with pytest.raises(FileError, match=r"precious.bin holds something else than the log"):
        read(path)
    assert path.read_bytes() == content


@pytest.mark.parametrize("content", [b"", b"\n", b"\0" * 4096, b'{"scan": "in/s9.ply", "outp'])
def test_a_log_whose_first_line_was_never_whole_begins_anew(tmp_path, content):
    path = tmp_path / "batch.jsonl"
    path.write_bytes(content)
    written(path, FIRST)
    assert [report.name for report in read(path)[0]] == ["a.ply"]


HOLD = """
import sys, time
from pathlib import Path
from meshlab_symrecon.batch.log import opened_log
with opened_log(Path(sys.argv[1])):
    print("open", flush=True)
    time.sleep(600)
"""


def test_two_batches_do_not_share_a_log_and_the_lock_dies_with_its_process(tmp_path):
    path = written(tmp_path / "batch.jsonl", FIRST)
    holder = subprocess.Popen([sys.executable, "-c", HOLD, str(path)], stdout=subprocess.PIPE)
    try:
        assert holder.stdout.readline() == b"open\n"
        with pytest.raises(FileError, match="another batch is at work on the log"):
            read(path)
    finally:
        holder.kill()
        holder.communicate()
    assert len(read(path)[0]) == 1


def test_a_full_disk_leaves_the_log_as_it_was(tmp_path, monkeypatch):
    path = written(tmp_path / "batch.jsonl", FIRST)
    whole = path.read_bytes()
    with opened_log(path) as log:
        monkeypatch.setattr(os, "write", _twice_then_full(os.write))
        with pytest.raises(FileError, match="cannot be written: No space left on device; what it"):
            log.append(SECOND)
        monkeypatch.undo()
    assert path.read_bytes() == whole


def _twice_then_full(write):
    calls = []

    def filling(descriptor, data):
        calls.append(data)
        if len(calls) > 2:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return write(descriptor, data[:20])

    return filling


def test_a_log_that_cannot_be_opened_is_told(tmp_path):
    with pytest.raises(FileError, match=r"the log .* cannot be opened"):
        read(tmp_path)


def test_a_log_that_cannot_be_locked_is_told(tmp_path, monkeypatch):
    def refused(*given):
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    monkeypatch.setattr("fcntl.flock", refused)
    with pytest.raises(FileError, match="cannot be locked: No locks available; give a path on"):
        read(tmp_path / "batch.jsonl")
