"""A real scheduler on this machine, with two workers in processes of their own."""

from __future__ import annotations

import json
import logging
import subprocess
import sys
import time
from types import SimpleNamespace

import psutil
import pytest
from batch_inputs import SCRIPT, Witness, cloud

from meshlab_symrecon.batch import Batch, run_batch
from meshlab_symrecon.batch import cluster as cluster_module
from meshlab_symrecon.batch.checksums import sha256_of
from meshlab_symrecon.batch.plan import planned
from meshlab_symrecon.batch.reports import ScanReport
from meshlab_symrecon.errors import HostError, SymReconError

distributed = pytest.importorskip("distributed")
COUNT = 6
HANGS = 60  # seconds after which something will never come, on a busy machine, too


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cluster")
    (folder / "halve.mlx").write_text(SCRIPT)
    for number in range(COUNT):
        cloud(folder / "in" / f"s{number}.ply", 77 if number == 4 else 50 + 80 * number, number)
    return folder


@pytest.fixture
def scheduler(tmp_path):
    """Start a scheduler; return its address and a function that starts a worker."""
    started = []

    def start(*words):
        command = [sys.executable, "-m", "dask", *words, "--no-dashboard"]
        process = subprocess.Popen(
            command, cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        started.append(process)
        return process

    told = tmp_path / "scheduler.json"
    start("scheduler", "--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(told))
    address = address_in(told)
    yield address, lambda: start("worker", address, "--nthreads", "1", "--no-nanny")
    for process in started:
        process.kill()
        process.wait()


def address_in(told):
    deadline = time.monotonic() + HANGS
    while time.monotonic() < deadline:
        try:
            return json.loads(told.read_text())["address"]
        except (FileNotFoundError, ValueError):  # it is being written
            time.sleep(0.1)
    raise AssertionError("the scheduler does not start")


def wait_for_workers(address, count):
    from distributed import Client

    with Client(address, set_as_default=False) as client:
        client.wait_for_workers(count, timeout=HANGS)


class Killer(Witness):
    """Kill a worker, with what it is doing, when the first scan is done; then open the gate."""

    def __init__(self, worker, gate):
        super().__init__()
        self.worker, self.gate, self.children = worker, gate, []

    def ended(self, report):
        super().ended(report)
        if self.gate.exists():
            return
        deadline = time.monotonic() + HANGS
        while not self.children and time.monotonic() < deadline:
            time.sleep(0.02)
            self.children = psutil.Process(self.worker.pid).children(recursive=True)
        self.worker.kill()
        self.gate.touch()


def bytes_in(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.suffix != ".jsonl"}


def test_a_worker_that_is_killed_in_the_middle_is_no_end(place, scheduler, monkeypatch):
    address, worker = scheduler
    monkeypatch.setattr(cluster_module, "PATIENCE", HANGS)
    with monkeypatch.context() as impatient:
        wait = distributed.Client.wait_for_workers
        shortly = lambda client, count, timeout: wait(client, count, timeout=0.1)  # noqa: E731
        impatient.setattr(distributed.Client, "wait_for_workers", shortly)
        with pytest.raises(HostError, match="has no workers"):
            run_batch(Batch(place / "halve.mlx", [place / "in"], place / "none", scheduler=address))
    with monkeypatch.context() as gated:
        gated.setenv("AWKWARD_GATE", str(place / "gate"))
        first, _ = worker(), worker()
    wait_for_workers(address, 2)
    killer = Killer(first, place / "gate")
    report = run_batch(
        Batch(place / "halve.mlx", [place / "in"], place / "far", scheduler=address), killer
    )
    assert [one.status for one in report.scans].count("done") == COUNT - 1
    assert report.scans[4].status == "crashed"
    assert any("is gone; its scans are done again by others" in one for one in killer.sentences)
    assert killer.children, "the worker was at work when it was killed"
    _, alive = psutil.wait_procs(killer.children, timeout=HANGS)
    assert all(one.status() == psutil.STATUS_ZOMBIE for one in alive), alive
    near = run_batch(Batch(place / "halve.mlx", [place / "in"], place / "near", jobs=2))
    assert len(near.done) == COUNT - 1
    assert bytes_in(place / "far") == bytes_in(place / "near")
    here = {"meshlab_symrecon": "9.9"}
    monkeypatch.setattr(cluster_module, "_here", lambda: here)
    with pytest.raises(HostError, match=r"has meshlab_symrecon \d.*, and here is 9.9"):
        run_batch(Batch(place / "halve.mlx", [place / "in"], place / "new", scheduler=address))


class Reviver(Killer):
    """Start another worker when all are gone."""

    def __init__(self, worker, gate, start):
        super().__init__(worker, gate)
        self.start = start

    def said(self, sentence):
        super().said(sentence)
        if "all workers" in sentence:
            self.start()


def test_without_workers_the_batch_waits_for_new_ones_and_says_so(place, scheduler, monkeypatch):
    address, worker = scheduler
    monkeypatch.setattr(cluster_module, "PATIENCE", HANGS)
    monkeypatch.setattr(cluster_module, "LOOK", 0.2)
    with monkeypatch.context() as gated:
        gated.setenv("AWKWARD_GATE", str(place / "gate of the only one"))
        only = worker()
    wait_for_workers(address, 1)
    reviver = Reviver(only, place / "gate of the only one", worker)
    scans = [place / "in" / f"s{number}.ply" for number in (0, 2)]
    report = run_batch(
        Batch(place / "halve.mlx", scans, place / "revived", scheduler=address), reviver
    )
    assert len(report.done) == len(scans)
    gone, waits = reviver.sentences
    assert gone.endswith("is gone; its scans are done again by others")
    assert waits == (
        f"all workers of {address} are gone; the batch waits for new ones, Ctrl-C ends it"
    )


def test_dask_keeps_silent_and_gets_its_voice_back():
    voice = logging.getLogger("distributed.client")
    before = voice.level
    with cluster_module._in_silence():
        assert not voice.isEnabledFor(logging.CRITICAL)
    assert voice.level == before


def test_without_the_extra_the_command_that_installs_it_is_told(place, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(SymReconError, match=r"pip install 'meshlab-symrecon\[distributed\]'"):
        run_batch(Batch(place / "halve.mlx", [place / "in"], place / "x", scheduler="tcp://a:1"))


@pytest.mark.parametrize("address", ["", " "])
def test_an_empty_address_starts_no_cluster(address):
    with pytest.raises(HostError, match="the address of the dask scheduler is empty"):
        next(cluster_module.on_cluster([], address, print))


def test_a_client_that_never_connected_says_nothing_when_it_goes(monkeypatch):
    """Dask's own would try to close it for seconds, and print a traceback."""
    closed = []
    monkeypatch.setattr(distributed.Client, "close", lambda *given, **more: closed.append(given))
    client = cluster_module._client()
    client.__new__(client).__del__()
    assert closed == []


class KilledWorker(Exception):
    """As dask's."""


class Task:
    """Becomes what its list of states says, one after the other; an error is a state."""

    def __init__(self, job, states):
        self.job, self.states = job, list(states)

    @property
    def status(self):
        return "error" if isinstance(self.states[0], Exception) else self.states[0]

    def exception(self):
        return self.states[0]

    def result(self):
        if len(self.states) > 1:  # lost while it is fetched; it is waited for
            del self.states[0]
            if isinstance(self.states[0], Exception):
                raise self.states[0]
            raise ConnectionError(f"it is {self.states[0]}")
        return ScanReport(self.job.shown_scan, str(self.job.output), self.job.name, "done")


class Client:
    """Ends as a scheduler's client does when some tasks do."""

    loop = None

    def __init__(self, states):
        self.states, self.submitted, self.cancelled = states, [], []

    def ncores(self):
        return {}

    def submit(self, function, job, pure):
        self.submitted.append(job.name)
        return Task(job, self.states.get(job.name, ["finished"]))

    def cancel(self, tasks, force):
        self.cancelled += tasks


class AsCompleted:
    """Yields tasks; one that is added again has come to its next state by then."""

    def __init__(self, tasks, loop):
        self.tasks = list(tasks)

    def is_empty(self):
        return not self.tasks

    def has_ready(self):
        return True

    def __next__(self):
        return self.tasks.pop(0)

    def add(self, task):
        del task.states[0]
        self.tasks.append(task)


@pytest.fixture
def done(place, monkeypatch):
    """Return what comes of three scans, whose tasks are in these states one after the other."""
    scans = [place / "in" / f"s{number}.ply" for number in range(3)]
    jobs = planned(Batch(place / "halve.mlx", scans, place / "lost", jobs=1)).jobs
    monkeypatch.setattr(
        cluster_module, "_distributed", lambda: SimpleNamespace(as_completed=AsCompleted)
    )

    def done(client):
        return jobs, list(cluster_module._done(client, "tcp://a:1", jobs, print))

    return done


def test_a_scan_that_takes_every_worker_with_it_is_reported(done):
    jobs, reports = done(Client({"s1.ply": [KilledWorker("gone\n thrice")]}))
    assert [one.status for one in reports] == ["done", "killed", "done"]
    assert "every worker that took it was ended: gone thrice; when" in reports[1].error
    assert reports[1].input_sha256 == sha256_of(jobs[1].scan)
    assert reports[1].work_sha256 == jobs[1].work.sha256


@pytest.mark.parametrize(
    "states",
    [
        ["lost", "finished"],
        ["lost", "lost", "finished"],
        ["finished", "lost", "finished"],  # lost while it was fetched
        ["finished", "pending", "finished"],
    ],
)
def test_a_report_that_is_lost_with_its_worker_is_waited_for(done, states):
    client = Client({"s1.ply": states})
    _, reports = done(client)
    assert [(one.name, one.status) for one in reports] == [
        (name, "done") for name in ("s0.ply", "s2.ply", "s1.ply")
    ]
    assert client.submitted == ["s0.ply", "s1.ply", "s2.ply"]  # by us once


def test_a_lost_report_that_takes_every_worker_with_it_is_reported(done):
    for states in (["lost", KilledWorker("gone")], ["finished", KilledWorker("gone")]):
        _, reports = done(Client({"s1.ply": states}))
        assert sorted(one.status for one in reports) == ["done", "done", "killed"]


@pytest.mark.parametrize(
    ("states", "why"),
    [
        ([ValueError("odd")], "odd"),
        (["finished", ValueError("odd")], "odd"),
        (["cancelled"], "cancelled"),
        (["lost", "cancelled"], "cancelled"),
        (["finished", "cancelled"], "it is cancelled"),
    ],
)
def test_what_the_scheduler_gives_up_ends_the_batch(done, states, why):
    client = Client({"s1.ply": states})
    with pytest.raises(HostError, match=rf"s1\.ply: the cluster has given it up: {why}; look at"):
        done(client)
    assert len(client.cancelled) == 3


def test_a_scheduler_that_goes_ends_the_batch(done):
    client = Client({})

    def gone(*given, **more):
        raise OSError("timed out")

    client.ncores = client.cancel = gone
    with pytest.raises(HostError, match=r"the dask scheduler at tcp://a:1 is gone; start it"):
        done(client)
