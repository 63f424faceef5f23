"""One scan in its own process: whatever becomes of it is a report."""

from __future__ import annotations

import os
import pickle
import resource
import signal
import sys
import threading
import time
from dataclasses import replace
from pathlib import Path

import psutil
import pytest
from batch_inputs import SCRIPT, cloud

from meshlab_symrecon.batch import Batch, Limits
from meshlab_symrecon.batch.plan import planned
from meshlab_symrecon.batch.resumption import standing
from meshlab_symrecon.batch.supervision import _fields, supervised
from meshlab_symrecon.errors import HostError
from meshlab_symrecon.host.child_watch import TIMED_OUT
from meshlab_symrecon.host.isolation import Ending
from meshlab_symrecon.host.versions import versions_of_results

CRASHES, SWELLS, GRASPS, DIVIDES, SLEEPS = 77, 78, 79, 80, 81


@pytest.fixture
def job(tmp_path, script):
    """Return a function that makes the job of a scan with a number of points."""

    def make(count, limits=None, **how):
        scan = cloud(tmp_path / "in" / f"{count}.ply", count)
        batch = Batch(script, [scan], tmp_path / "out", limits=limits or Limits(), jobs=1, **how)
        return planned(batch).jobs[0]

    return make


def children():
    """Return the processes that work on scans; joblib's workers of other tests wait a while."""

    def works(process):
        try:
            return "isolated_child" in str(process.cmdline())
        except psutil.Error:  # it has just ended
            return False

    return [one for one in psutil.Process().children() if works(one)]


def left_in(folder):
    return sorted(path.name for path in Path(folder).iterdir())


def test_a_good_scan(tmp_path, job):
    one = job(60)
    before = one.scan.read_bytes()
    report = supervised(one)
    assert report.status == "done"
    assert report.error is None
    assert report.points == 60
    assert report.measures["points"] == 60
    assert [step["status"] for step in report.steps] == ["ran", "ran"]
    assert report.peak_memory_bytes > 30 << 20
    assert report.input_sha256 != report.output_sha256 is not None
    assert report.versions["pymeshlab"]
    assert one.scan.read_bytes() == before
    assert left_in(tmp_path / "out") == ["60.ply"]
    assert supervised(one).output_sha256 == report.output_sha256


def test_names_that_meshlab_cannot_take(tmp_path, job):
    """They are told before the work, and called as the user called them."""
    one = job(60)
    odd = os.fsdecode(b"\xff")
    there, shown = tmp_path / odd / "x.ply", f"{odd}/x.ply"
    there.parent.mkdir()
    written = supervised(replace(one, output=there, shown_output=shown))
    assert written.status == "failed"
    assert written.error.startswith(f"{shown} cannot be written: this name, or that of a folder")
    there.write_bytes(one.scan.read_bytes())
    read = supervised(replace(one, scan=there, shown_scan=shown))
    assert read.status == "failed"
    assert read.error.startswith(f"{shown} cannot be read: its name is not UTF-8")


@pytest.mark.parametrize(
    ("count", "limits", "status", "words"),
    [
        (CRASHES, {}, "crashed", "ended the process by SIGSEGV"),
        (SWELLS, {"memory": 400 << 20}, "out of memory", "it needs more than 400 MiB of memory"),
        (GRASPS, {"memory": 400 << 20}, "out of memory", "raise --memory-limit, thin it out with"),
        (DIVIDES, {}, "failed", "ZeroDivisionError"),
        (SLEEPS, {"seconds": 1.5}, "timed out", "it takes longer than 1.5 s"),
    ],
)
def test_a_bad_scan(tmp_path, job, monkeypatch, count, limits, status, words):
    one = job(count, Limits(**limits))
    monkeypatch.chdir(tmp_path)
    report = supervised(one)
    shown = (report.error or "").replace(f"{tmp_path}{os.sep}", "")
    assert report.status == status, report.error
    assert words in shown
    assert "Traceback" not in shown
    assert report.output_sha256 is None
    assert left_in(tmp_path / "out") == []
    assert children() == []


def test_what_a_scan_was_at_when_its_time_was_over_is_told(job):
    one = replace(job(SLEEPS, Limits(seconds=8.0)), shown_scan="in/81.ply")
    ending = Ending(None, -9, TIMED_OUT, "halve.mlx:2: 'Be Awkward'", 8.1, 1 << 20)
    assert _fields(one, ending) == {
        "status": "timed out",
        "error": "in/81.ply: it takes longer than 8 s (halve.mlx:2: 'Be Awkward'); raise "
        "--time-limit, or simplify it first",
    }


def test_a_scan_that_is_too_large_is_told_before_the_work(tmp_path, job):
    one = job(60, Limits(memory=1 << 30))
    one.scan.write_bytes(one.scan.read_bytes().replace(b"vertex 60", b"vertex 4000000"))
    with one.scan.open("ab") as file:
        file.truncate(6 * 4_000_000 + 1000)  # what so many points take at least
    report = supervised(one)
    assert report.status == "too large"
    assert "4000000 points" in report.error
    assert " and the limit leaves 1.1 GB; run it with --max-points " in report.error
    assert report.error.endswith(", or raise the limit (--memory-limit is 1 GiB)")


def test_without_a_limit_what_is_free_is_shared_and_a_want_of_it_may_pass(
    tmp_path, job, script, monkeypatch
):
    one = job(60)
    for count in (61, 62):
        cloud(tmp_path / "in" / f"{count}.ply", count)
    batch = Batch(script, [tmp_path / "in"], tmp_path / "out", jobs=2)
    monkeypatch.setattr("meshlab_symrecon.batch.work.available_memory", lambda: 12 << 30)
    for jobs, share in ((1, None), (2, 6 << 30), (9, 4 << 30)):  # there are three scans only
        plan = planned(replace(batch, jobs=jobs))
        assert [each.share for each in plan.jobs] == [share] * 3
    one.scan.write_bytes(one.scan.read_bytes().replace(b"vertex 60", b"vertex 4000000"))
    with one.scan.open("ab") as file:
        file.truncate(6 * 4_000_000 + 1000)  # what so many points take at least
    report = supervised(replace(one, share=1 << 30))
    assert report.status == "too large"
    assert "the limit leaves 1.1 GB; " in report.error
    assert report.error.endswith(
        ", or raise the limit (scans at once share what is free: fewer --jobs leave more for each)"
    )
    for status in ("too large", "out of memory"):
        again = why_again(one, replace(report, status=status))
        assert again == f"it was {status}, which may pass"
        limited = replace(one, limits=Limits(memory=1 << 30))
        known = replace(report, status=status, limits={"memory": 1 << 30, "points": None})
        assert why_again(limited, known) is None
        assert why_again(one, known) == "the limit of memory has been raised"


def why_again(job, report):
    left = standing([job], [report], retry=False, again=False).left
    return left[0].again if left else None


def test_an_older_result_that_is_still_there_is_told(tmp_path, job, monkeypatch):
    monkeypatch.chdir(tmp_path)
    one = replace(job(60), shown_output="out/60.ply")
    one.output.write_text("older")
    one.scan.write_bytes(b"ply\nbroken")
    report = supervised(one)
    assert report.status == "failed"
    assert report.error.endswith("; out/60.ply is still there, from before")
    assert one.output.read_text() == "older"


def test_a_process_that_is_killed_from_outside(tmp_path, job):
    one = job(SLEEPS)

    def kill():
        while not children():
            time.sleep(0.05)
        children()[0].send_signal(signal.SIGKILL)

    thread = threading.Thread(target=kill)
    thread.start()
    report = supervised(one)
    thread.join()
    assert report.status == "killed"
    assert "its process was ended from outside" in report.error
    assert left_in(tmp_path / "out") == []


def test_what_nobody_wants_is_ended(tmp_path, job):
    asked = []

    def wanted():
        asked.append(True)
        return len(asked) < 5

    with pytest.raises(HostError, match="the batch has ended"):
        supervised(job(SLEEPS), wanted)
    assert children() == []


def test_damaged_files_are_told(tmp_path, script):
    for name, content in (("a.ply", b""), ("b.ply", b"ply\nnothing"), ("c.obj", b"\xff" * 100)):
        (tmp_path / "in").mkdir(exist_ok=True)
        (tmp_path / "in" / name).write_bytes(content)
    (tmp_path / "in" / "d.ply").symlink_to("nowhere.ply")
    os.mkfifo(tmp_path / "in" / "e.ply")
    plan = planned(Batch(script, [tmp_path / "in"], tmp_path / "out", jobs=1))
    reports = {Path(job.scan).name: supervised(job) for job in plan.jobs}
    assert {name: report.status for name, report in reports.items()} == dict.fromkeys(
        ("a.ply", "b.ply", "c.obj", "d.ply", "e.ply"), "failed"
    )
    assert reports["a.ply"].error == f"{tmp_path}/in/a.ply is empty; write or download it again"
    assert reports["e.ply"].input_sha256 is None
    assert left_in(tmp_path / "out") == []


def test_a_full_disk_is_told_in_the_systems_words(tmp_path, job):
    one = job(3000)
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    ignored = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, before[1]))  # of the child too
    try:
        report = supervised(one)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, ignored)
    assert report.status == "not written"
    assert report.error == (
        f"{one.shown_output} cannot be written: File too large; make room, or give another path"
    )
    assert left_in(tmp_path / "out") == []


def test_a_scan_is_thinned_out_first(tmp_path, job):
    report = supervised(job(1000, Limits(points=500)))
    assert report.status == "done"
    assert report.points == 1000
    assert 450 <= report.measures["points"] <= 500


def test_a_worker_of_another_version_refuses(job):
    one = job(60)
    other = replace(one.work, versions=dict(one.work.versions) | {"pymeshlab": "2031.1"})
    report = supervised(replace(one, work=other))
    assert report.status == "failed"
    assert "pymeshlab 2031.1" in report.error
    assert "install the same versions on both" in report.error


def test_the_versions_are_those_of_the_records_and_of_the_scripts_filters(job, script, tmp_path):
    one = job(60)
    assert one.work.versions == versions_of_results() | {"awkward": "1.0"}
    done = replace(supervised(one), status="failed")
    assert standing([one], [done], retry=False, again=False).left == ()
    script.write_text(SCRIPT.replace(' <filter name="Be Awkward"/>\n', ""))
    assert job(60).work.versions == versions_of_results()
    script.write_text(SCRIPT)
    metadata = (
        Path(sys.modules["awkward_filter"].__file__).parent / "awkward-1.0.dist-info/METADATA"
    )
    before = metadata.read_text()
    try:
        metadata.write_text(before.replace("Version: 1.0", "Version: 2.0"))
        newer = job(60)
        assert newer.work.versions["awkward"] == "2.0"
        left = standing([newer], [done], retry=False, again=False).left
        assert [again.again for again in left] == ["it was made by other versions"]
        assert "awkward 2.0, and the batch was started by one that has" in supervised(one).error
    finally:
        metadata.write_text(before)


def test_threads_are_told_before_libraries_are_loaded(job, monkeypatch):
    from meshlab_symrecon.batch import supervision

    told = []
    monkeypatch.setattr(
        supervision, "run_child", lambda *_, bounds, **__: told.append(bounds) or 1 / 0
    )
    with pytest.raises(ZeroDivisionError):
        supervised(job(60, Limits(threads=3)))
    assert told[0].environment["OMP_NUM_THREADS"] == "3"


def test_jobs_travel(job):
    one = job(60)
    assert pickle.loads(pickle.dumps(one)) == one
