"""Scans on the workers of a running dask scheduler.

Each scan is a task of its own, by the client and not by joblib's backend for it: that one works in
this process when the cluster has a single thread, and waits for ever for a task that the scheduler
has given up.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from functools import cache
from importlib import import_module
from typing import Any

from meshlab_symrecon.batch.reports import ScanReport
from meshlab_symrecon.batch.supervision import lost_with_workers, supervised
from meshlab_symrecon.batch.work import Job, memory_share
from meshlab_symrecon.errors import HostError, SymReconError
from meshlab_symrecon.host.versions import versions_of_results

__all__ = ["on_cluster"]

PATIENCE = 5.0  # seconds for the scheduler to answer
LOOK, MOMENT = 2.0, 0.05  # seconds between looks at the workers, and at the tasks
TOOK_ALL = "KilledWorker"  # dask's error for a task with which worker after worker ends
ON_THE_WAY = ("executing", "long-running")
FINISHED, AGAIN = "finished", ("lost", "pending")  # of dask's states of a task
SILENCE = logging.CRITICAL + 1
INSTALL = "run pip install 'meshlab-symrecon[distributed]'"


def on_cluster(
    jobs: Sequence[Job], address: str, said: Callable[[str], None]
) -> Generator[ScanReport, None, None]:
    """Yield the reports of jobs as they end on the workers of a cluster.

    A worker that is lost is no end of its scans: the scheduler has others do them again, also one
    that was done when its report is lost with the worker. A scan that takes one worker with it
    after the other is reported as killed.

    Raises
    ------
    SymReconError
        The extra ``distributed`` is not installed.
    HostError
        The address is empty or nothing answers there, it has no workers, they have other versions,
        the scheduler has given a scan up, or it is gone itself.
    """
    with _connected(address) as client:
        _check_workers(client, address)
        yield from _done(client, address, jobs, said)


def _done(
    client: Any, address: str, jobs: Sequence[Job], said: Callable[[str], None]
) -> Generator[ScanReport, None, None]:
    by_task = {client.submit(supervised_there, job, pure=False): job for job in jobs}
    try:
        workers = _Workers(client, address, said)
        ended = _distributed().as_completed(by_task, loop=client.loop)
        for task in _as_they_end(ended, workers.look):
            workers.look()
            report = _report(task, by_task[task])
            if report is None:
                ended.add(task)
            else:
                yield report
    finally:
        with suppress(*_unanswered()):  # without a scheduler nobody wants them any more
            client.cancel(list(by_task), force=True)


def _as_they_end(ended: Any, look: Callable[[], None]) -> Iterator[Any]:
    """Yield tasks as they end; look at the workers now and then, since without any none does."""
    while not ended.is_empty():
        until = time.monotonic() + LOOK
        while not ended.has_ready() and time.monotonic() < until:
            time.sleep(MOMENT)
        if ended.has_ready():
            yield next(ended)
        else:
            look()


class _Workers:
    """The workers that are there, and word of those that were."""

    def __init__(self, client: Any, address: str, said: Callable[[str], None]) -> None:
        self.client, self.address, self.said = client, address, said
        self.there = _present(client, address)

    def look(self) -> None:
        """Say which ones are gone since the last look, and when none is left."""
        now = _present(self.client, self.address)
        for worker in sorted(self.there - now):
            self.said(f"the worker at {worker} is gone; its scans are done again by others")
        if self.there and not now:
            message = f"all workers of {self.address} are gone"
            self.said(f"{message}; the batch waits for new ones, Ctrl-C ends it")
        self.there = now


def _present(client: Any, address: str) -> set[str]:
    """Return the addresses of the workers."""
    try:
        return set(client.ncores())
    except _unanswered() as error:
        message = f"the dask scheduler at {address} is gone"
        raise HostError(f"{message}; start it again, and give the same command again") from error


def _report(task: Any, job: Job) -> ScanReport | None:
    """Return the report of a task; None when it is lost, and the scheduler has it done again.

    It is when its worker went before it could hand the report on.
    """
    fetching: Exception | None = None
    if task.status == FINISHED:
        try:
            report: ScanReport = task.result()
        except Exception as error:  # noqa: BLE001  of the task, when it went wrong the second time
            fetching = error
        else:
            return report
    if task.status in AGAIN:
        return None
    if task.status == "error" and type(task.exception()).__name__ == TOOK_ALL:
        return lost_with_workers(job, _in_words(task.exception()))
    why = _in_words(task.exception() if task.status == "error" else fetching) or task.status
    message = f"{job.shown_scan}: the cluster has given it up: {why}"
    raise HostError(f"{message}; look at its workers, and give the same command again")


def _in_words(error: BaseException | None) -> str:
    return "" if error is None else " ".join(str(error).split())


def supervised_there(job: Job) -> ScanReport:
    """Do a job on a worker, for as long as its batch wants it."""
    worker = _distributed().get_worker()
    key = worker.get_current_task()

    def wanted() -> bool:
        task = worker.state.tasks.get(key)
        return task is not None and task.state in ON_THE_WAY

    return supervised(replace(job, share=_share(worker.state.nthreads)), wanted)


@cache
def _share(count: int) -> int | None:
    """Return what each scan of a worker may count on: of what is free when it begins."""
    return memory_share(count)


def _distributed() -> Any:
    try:
        return import_module("distributed")
    except ImportError as error:
        message = "a cluster needs the extra 'distributed', which is not installed"
        raise SymReconError(f"{message}; {INSTALL}") from error


def _unanswered(*others: type[Exception]) -> tuple[type[Exception], ...]:
    """Return what dask raises without an answer: in Python 3.10 its timeouts are no OSError."""
    return OSError, import_module("asyncio").TimeoutError, *others


@contextmanager
def _connected(address: str) -> Iterator[Any]:
    if not address.strip():  # for which dask would start a cluster of its own
        message = "the address of the dask scheduler is empty"
        raise HostError(f"{message}; give the one that 'dask scheduler' tells when it starts")
    _distributed()  # what it sets its voices to is known from here on
    with _in_silence():
        try:
            client = _client()(address, timeout=PATIENCE, set_as_default=False)
        except _unanswered(ValueError, TypeError) as error:
            message = f"no dask scheduler answers at {address}"
            raise HostError(
                f"{message}; start one with 'dask scheduler', and give the address that it tells"
            ) from error
        try:
            yield client
        finally:
            with suppress(*_unanswered()):  # all reports are here
                client.close(timeout=PATIENCE)


def _client() -> Any:
    """Return dask's class of clients, without its last words on one that was never connected."""

    class Client(_distributed().Client):  # type: ignore[misc]
        def __del__(self) -> None:
            """Leave it: we close what was connected."""

    return Client


@contextmanager
def _in_silence() -> Iterator[None]:
    """Keep dask from logging: what matters we say ourselves."""
    names = [name for name in logging.root.manager.loggerDict if name.startswith("distributed")]
    before = {name: logging.getLogger(name).level for name in names}  # dask sets some of its own
    try:
        for name in names:
            logging.getLogger(name).setLevel(SILENCE)
        yield
    finally:
        for name, level in before.items():
            logging.getLogger(name).setLevel(level)


def _check_workers(client: Any, address: str) -> None:
    try:
        client.wait_for_workers(1, timeout=PATIENCE)
        there = client.run(versions_of_results)
    except import_module("asyncio").TimeoutError as error:
        message = f"the dask scheduler at {address} has no workers"
        raise HostError(f"{message}; start some with 'dask worker {address}'") from error
    except ImportError as error:
        message = f"a worker of {address} cannot import what it shall do: {error}"
        raise HostError(f"{message}; install meshlab-symrecon there, too") from error
    here = _here()
    for worker, known in sorted(there.items()):
        for name, version in here.items():
            if known.get(name) != version:
                message = f"the worker at {worker} has {name} {known.get(name)}, and here is"
                raise HostError(f"{message} {version}; install the same versions on both")


def _here() -> dict[str, str]:
    return versions_of_results()
