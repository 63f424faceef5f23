"""Whole batches: interrupted in every way, they end with the same bytes."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import psutil
import pytest
from batch_inputs import SCRIPT, Witness, cloud

from meshlab_symrecon.batch import Batch, Limits, run_batch
from meshlab_symrecon.batch.cores import SILENT, _environment
from meshlab_symrecon.batch.log import opened_log
from meshlab_symrecon.batch.plan import planned
from meshlab_symrecon.batch.resumption import standing
from meshlab_symrecon.errors import FileError, HostError, ParameterError, ScriptError
from meshlab_symrecon.host.own_program import own_program

CRASHES, DIVIDES = 77, 80
BAD = {"s2.ply": "crashed", "s4.ply": "failed"}
POINTS = {"s2.ply": CRASHES}
COUNT = 7
AT_REST = 4  # scans that are done when the others wait for the gate, see awkward_filter
HANGS = 60  # seconds after which a process will never end, on a busy machine, too
PROGRAM = (
    "import meshlab_symrecon.cli.main as program; "
    f"program.BATCH_GRACE = {HANGS}; program.main()"
)  # fmt: skip


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A folder with scans, some of them bad, and the results of an uninterrupted batch."""
    folder = tmp_path_factory.mktemp("collection")
    (folder / "halve.mlx").write_text(SCRIPT)
    for number in range(COUNT):
        name = f"s{number}.ply"
        cloud(folder / "in" / name, POINTS.get(name, 40 + 100 * number), number)
    (folder / "in" / "s4.ply").write_bytes(b"ply\nbroken")
    witness = Witness()
    report = run_batch(
        Batch(folder / "halve.mlx", [folder / "in"], folder / "whole", jobs=2), witness
    )
    assert witness.total == COUNT
    assert sorted(one.name for one in witness.reports) == [f"s{n}.ply" for n in range(COUNT)]
    statuses = {one.name: one.status for one in report.scans}
    assert statuses == {f"s{n}.ply": BAD.get(f"s{n}.ply", "done") for n in range(COUNT)}
    return folder


def bytes_in(folder):
    """Return every file but the log, hidden ones too."""
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file() and path.suffix != ".jsonl"
    }


def started(place, out):
    """Start a batch that does not end before there is a gate."""
    words = ["batch", "halve.mlx", "in", "-d", out, "--jobs", "2"]
    return subprocess.Popen(
        [sys.executable, "-c", PROGRAM, *words], cwd=place, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True,
        env=os.environ | {"AWKWARD_GATE": str(place / f"gate of {out}")},
    )  # fmt: skip


def lines(log):
    return log.read_bytes().count(b"\n") if log.exists() else 0


def family(process):
    return psutil.Process(process.pid).children(recursive=True)


def working_at(process, log, count):
    """Wait for lines in the log, and for a scan that is being worked on; return the processes."""
    while process.poll() is None:
        now = family(process)
        if lines(log) >= count and any(map(works_on_a_scan, now)):
            return now
        time.sleep(0.02)
    raise AssertionError(process.communicate())


def works_on_a_scan(process):
    try:
        return "isolated_child" in " ".join(process.cmdline())
    except psutil.Error:
        return False


def all_gone(processes):
    def lives(process):
        try:
            return process.is_running() and process.status() != psutil.STATUS_ZOMBIE
        except psutil.Error:
            return False

    deadline = time.monotonic() + HANGS
    while time.monotonic() < deadline and any(map(lives, processes)):
        time.sleep(0.02)
    return not any(map(lives, processes))


def test_resumed_after_kill_9_the_bytes_are_those_of_an_uninterrupted_batch(place):
    out = place / "killed"
    for count in (1, 3):
        process = started(place, "killed")
        processes = working_at(process, out / "batch.jsonl", count)
        assert list(Path("/dev/shm").glob(f"joblib_*_{process.pid}_*")) == []
        process.kill()
        process.communicate()
        assert all_gone(processes)
    (out / f".symrecon-{process.pid}-feedbeef-x").mkdir()  # of another machine: it stays
    with (out / "batch.jsonl").open("ab") as log:
        log.write(b'{"scan": "in/s6.ply", "outp')
    before = lines(out / "batch.jsonl")
    witness = Witness()
    report = run_batch(Batch(place / "halve.mlx", [place / "in"], out, jobs=2), witness)
    assert report.resumed == before
    assert bytes_in(out) == bytes_in(place / "whole")
    assert len(report.failed) == len(BAD)
    logged = [json.loads(line) for line in (out / "batch.jsonl").read_text().splitlines()]
    assert sorted(line["name"] for line in logged) == [f"s{n}.ply" for n in range(COUNT)]


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_an_interrupted_batch_says_how_to_go_on(place, number, code):
    out = place / f"interrupted by {int(number)}"
    process = started(place, out.name)
    processes = working_at(process, out / "batch.jsonl", 1)
    if number == signal.SIGINT:
        os.killpg(process.pid, number)  # as a terminal does, to all of its processes
    else:
        process.send_signal(number)
    _, said = process.communicate()
    assert process.returncode == code, said
    assert all_gone(processes)
    assert f"of {COUNT} scans are done, and the same command goes on" in said.splitlines()[-1]
    assert "Traceback" not in said
    assert not [path for path in out.iterdir() if path.name.startswith(".")]
    whole = bytes_in(place / "whole")
    assert all(whole[name] == content for name, content in bytes_in(out).items())


@pytest.mark.parametrize("before", [None, "error"])
def test_trackers_do_not_warn_of_what_is_gone_already(monkeypatch, before):
    name, _ = SILENT
    if before is None:
        monkeypatch.delenv(name, raising=False)
    else:
        monkeypatch.setenv(name, before)
    program = [sys.executable, "-c", "import warnings; warnings.warn('it is gone')"]
    with _environment(*SILENT):
        inside = subprocess.run(program, capture_output=True, text=True, check=False)
    assert (inside.returncode, inside.stderr) == (0, "")
    assert os.environ.get(name) == before
    outside = subprocess.run(program, capture_output=True, text=True, check=False)
    assert "it is gone" in outside.stderr


def test_a_worker_that_is_killed_is_no_end(place):
    process = started(place, "worker")
    out = place / "worker"
    processes = working_at(process, out / "batch.jsonl", AT_REST)
    next(filter(works_on_a_scan, processes)).parent().kill()
    (place / "gate of worker").touch()
    _, said = process.communicate()
    assert process.returncode == 1
    assert "a worker process was ended from outside" in said
    assert bytes_in(out) == bytes_in(place / "whole")


def test_what_is_done_again_is_told_why(place, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    script = tmp_path / "halve.mlx"
    script.write_text(SCRIPT)
    for name, count in (("a", 60), ("b", 61), ("c", DIVIDES)):
        cloud(tmp_path / "in" / f"{name}.ply", count)

    run_batch(Batch("halve.mlx", ["in"], "out", jobs=1))

    def reasons(**how):
        """Return why each scan would be done again now."""
        plan = planned(Batch("halve.mlx", ["in"], "out", jobs=1, **how))
        with opened_log(plan.log) as log:
            left = standing(plan.jobs, log.reports, retry=how.get("retry", False), again=False).left
        return {job.shown_scan: job.again for job in left}

    assert reasons() == {}
    assert reasons(limits=Limits(points=1000)) == {}  # none of them has as many
    assert reasons(retry=True) == {"in/c.ply": "it had failed"}
    Path("out/a.ply").unlink()
    Path("out/b.ply").write_bytes(b"edited")
    told = {"in/a.ply": "its result is gone", "in/b.ply": "its result has been changed"}
    assert reasons() == told
    witness = Witness()
    run_batch(Batch("halve.mlx", ["in"], "out", jobs=1), witness)
    assert witness.sentences == [f"{scan} is done again: {why}" for scan, why in told.items()]
    assert [one.name for one in witness.reports if one.resumed] == ["c.ply"]
    assert reasons() == {}
    cloud(tmp_path / "in/a.ply", 62)
    assert reasons() == {"in/a.ply": "the scan has changed"}
    script.write_text(SCRIPT.replace("0.5", "0.25"))
    assert set(reasons().values()) == {"the script has changed"}


def test_what_cannot_be_read_is_worked_on_again_only_when_it_can_be(tmp_path, script, monkeypatch):
    monkeypatch.chdir(tmp_path)
    scans = tmp_path / "in"
    scans.mkdir()
    (scans / "dangling.ply").symlink_to("nowhere.ply")
    (scans / "loop.ply").symlink_to("loop.ply")
    os.mkfifo(scans / "pipe.ply")
    asked = Batch(script, ["in"], "out", jobs=1)
    errors = {one.scan: one.error for one in run_batch(asked).scans}
    assert errors == {
        "in/dangling.ply": "in/dangling.ply cannot be read: it is a link to nowhere.ply, and no "
        "file is there; check its path",
        "in/loop.ply": "in/loop.ply cannot be read: it is in a loop of links, which leads to no "
        "file; put the scan there",
        "in/pipe.ply": "in/pipe.ply cannot be read: it is not an ordinary file; give a mesh file",
    }
    witness = Witness()
    assert run_batch(asked, witness).resumed == len(errors)
    assert witness.sentences == []
    (scans / "loop.ply").unlink()
    cloud(scans / "loop.ply", 60)
    witness = Witness()
    (done,) = run_batch(asked, witness).done
    assert done.scan == "in/loop.ply"
    assert witness.sentences == ["in/loop.ply is done again: the scan can be read now"]
    (scans / "loop.ply").unlink()
    witness = Witness()
    run_batch(replace(asked, inputs=["in/dangling.ply", "in/pipe.ply"], retry=True), witness)
    assert witness.sentences == [
        f"in/{name}.ply is done again: it had failed" for name in ("dangling", "pipe")
    ]


def test_no_file_of_a_batch_is_written_over(tmp_path, script, monkeypatch):
    """Found by a folder, through links, by another spelling: whatever leads to one file."""
    monkeypatch.chdir(tmp_path)
    scan = cloud(tmp_path / "in/a.ply", 60)
    cloud(tmp_path / "in/b.ply", 60)
    (tmp_path / "twice").mkdir()
    (tmp_path / "twice/a.ply").symlink_to("b.ply")
    (tmp_path / "folded/x").mkdir(parents=True)
    (tmp_path / "folded/y").symlink_to("x")
    for place in "xy":
        cloud(tmp_path / "tree" / place / "c.ply", 60)
    (tmp_path / "hard.json").hardlink_to(scan)
    (tmp_path / "soft.json").symlink_to("in/b.ply")
    before = {path: path.read_bytes() for path in tmp_path.rglob("*.ply") if path.is_file()}
    tree = {"folder": "folded", "recursive": True, "name": "{folder}/{stem}.ply"}
    for how, words in (
        ({"summary": "in/a.ply"}, "the summary in/a.ply would overwrite"),
        ({"summary": "hard.json"}, "the summary hard.json would overwrite"),
        ({"summary": "soft.json"}, "the summary soft.json would overwrite"),
        ({"summary": "out/b.ply"}, "the summary out/b.ply would overwrite"),
        ({"summary": "out/batch.jsonl"}, "the summary out/batch.jsonl would overwrite"),
        ({"summary": script}, "the summary .*halve.mlx would overwrite"),
        ({"log": "hard.json"}, "the log hard.json would overwrite"),
        ({"summary": "nowhere/r.json"}, "no directory is at"),
        ({"folder": "twice"}, "twice/a.ply and twice/b.ply are one file, through a link"),
        ({"inputs": ["tree"], **tree}, "folded/x/c.ply and folded/y/c.ply are one file"),
    ):
        with pytest.raises(FileError, match=words):
            run_batch(Batch(**({"script": script, "inputs": ["in"], "folder": "out"} | how)))
    assert {path: path.read_bytes() for path in before} == before


def test_the_checks_of_a_batch_with_results_grow_as_its_scans_do(tmp_path, script, monkeypatch):
    """Thousands of scans with results of an earlier run are compared by sets, not in pairs."""
    looks, stat = [], os.stat

    def counted(*given, **more):
        looks.append(given)
        return stat(*given, **more)

    monkeypatch.setattr(os, "stat", counted)
    counts = []
    for scans in (50, 100):
        for number in range(scans):
            cloud(tmp_path / "in" / f"{number}.ply", 1)
            (tmp_path / f"out {scans}").mkdir(exist_ok=True)
            (tmp_path / f"out {scans}" / f"{number}.ply").write_bytes(b"older")
        looks.clear()
        planned(Batch(script, [tmp_path / "in"], tmp_path / f"out {scans}"))
        counts.append(len(looks))
    assert counts[0] <= counts[1] <= 2.1 * counts[0]


def test_numbers_of_numpy_are_numbers(tmp_path):
    scan = cloud(tmp_path / "in/a.ply", 60)
    works = [
        planned(Batch("reconstruct", [scan], tmp_path / "out", settings={"randomseed": seed})).jobs
        for seed in (3, np.int64(3))
    ]
    assert works[0][0].work == works[1][0].work
    assert json.dumps(works[1][0].work.settings) == '{"randomseed": 3}'


def test_a_batch_that_is_wrong_starts_nothing(tmp_path, script, monkeypatch):
    monkeypatch.setattr("meshlab_symrecon.batch.cluster.PATIENCE", 0.5)
    scan = cloud(tmp_path / "in/a.ply", 60)
    before = scan.read_bytes()
    out = tmp_path / "out"
    link = tmp_path / "linked"
    link.mkdir()
    (link / "a.ply").symlink_to(scan)
    wrong = script.with_name("wrong.mlx")
    wrong.write_text(SCRIPT.replace("Be Awkward", "Be Nice"))
    for how, error, words in (
        ({"folder": scan.parent}, FileError, "would overwrite a scan"),
        ({"folder": scan.parent, "name": "{stem}_x.ply"}, FileError, "among the scans"),
        ({"folder": link}, FileError, "would overwrite a scan"),
        ({"folder": scan}, FileError, "cannot be made"),
        ({"log": scan}, FileError, "would overwrite a file of the batch"),
        ({"script": wrong}, ScriptError, "Be Nice"),
        ({"strict": True, "lenient": True}, ParameterError, "contradict"),
        ({"jobs": 2, "scheduler": "tcp://x:1"}, ParameterError, "give one of jobs and scheduler"),
        ({"settings": {"paint": True}}, ParameterError, "write them in the script"),
        ({"script": "reconstruct", "lenient": True}, ParameterError, "are for scripts"),
        ({"script": "reconstruct", "settings": {"randomseed": -1}}, ParameterError, "randomseed"),
        ({"script": "reconstruct", "settings": {"randomsed": 1}}, ParameterError, "'randomseed'"),
        ({"limits": Limits(points=5)}, ParameterError, "100"),
        ({"scheduler": "tcp://127.0.0.1:9"}, HostError, "no dask scheduler answers at"),
    ):
        with pytest.raises(error, match=words):
            run_batch(Batch(**({"script": script, "inputs": [scan], "folder": out} | how)))
    assert scan.read_bytes() == before
    assert not (out / "a.ply").exists()


@pytest.mark.skipif(sys.version_info < (3, 11), reason="Python 3.10 knows no PYTHONSAFEPATH")
def test_modules_in_the_users_folder_are_not_run(place, tmp_path):
    for name in ("json", "random", "numpy", "meshlab_symrecon"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit(3)")
    words = ["batch", place / "halve.mlx", place / "in", "-d", "out", "--jobs", "2", "-q"]
    command = [*own_program("meshlab_symrecon.cli.main"), *map(str, words)]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 1, done.stderr
    assert bytes_in(tmp_path / "out") == bytes_in(place / "whole")
