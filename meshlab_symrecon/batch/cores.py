"""Scans on the cores of this machine, by joblib's loky."""

from __future__ import annotations

import os
import signal
import tempfile
import warnings
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager
from multiprocessing import resource_tracker
from typing import Any

from joblib import Parallel, delayed
from joblib.externals.loky.backend import resource_tracker as loky_tracker
from joblib.externals.loky.process_executor import TerminatedWorkerError

from meshlab_symrecon.batch.reports import ScanReport
from meshlab_symrecon.batch.supervision import supervised_for
from meshlab_symrecon.batch.work import Job
from meshlab_symrecon.errors import HostError

__all__ = ["on_cores"]

# For processes that are started: trackers do not warn of what was removed before they came, and a
# numpy.py in the folder where the user is is not ours (from Python 3.11 on).
SILENT = ("PYTHONWARNINGS", "ignore")
OWN_MODULES = ("PYTHONSAFEPATH", "1")
PATIENCE = 5  # pools that may break one after the other without a single result


def on_cores(
    jobs: Sequence[Job], count: int, said: Callable[[str], None]
) -> Generator[ScanReport, None, None]:
    """Yield the reports of jobs as they end, ``count`` at once, each in a process of its own.

    When a worker is killed from outside, a fresh pool of workers goes on with what is left.

    Raises
    ------
    HostError
        Workers are killed again and again.
    """
    left = {job.name: job for job in jobs}
    barren = 0
    while left:
        try:
            for report in _pooled(tuple(left.values()), count):
                del left[report.name]
                barren = 0
                yield report
        except TerminatedWorkerError as error:
            barren += 1
            if barren == PATIENCE:
                message = "the worker processes are ended from outside again and again"
                raise HostError(
                    f"{message}; the same command goes on, with fewer --jobs when memory is short"
                ) from error
            said(f"a worker process was ended from outside; {len(left)} scans are still to do")


def _pooled(jobs: Sequence[Job], count: int) -> Generator[ScanReport, None, None]:
    pool = Parallel(
        n_jobs=min(count, len(jobs)),
        backend="loky",
        batch_size=1,  # a report comes as soon as its scan is done
        return_as="generator_unordered",
        temp_folder=tempfile.gettempdir(),  # where nothing is made; elsewhere it would be
        max_nbytes=None,
    )
    coordinator = os.getpid()
    # What is started in here does not see a Ctrl-C: we end it.
    with _environment(*OWN_MODULES), _interruptions_held():
        reports = pool(delayed(supervised_for)(coordinator, job) for job in jobs)
    try:
        yield from reports
    finally:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # joblib's, of results nobody asked for
            reports.close()


@contextmanager
def _interruptions_held() -> Iterator[None]:
    """Hold signals back from this thread, and for ever from the processes it starts meanwhile."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    with _environment(*SILENT):
        for tracker in (resource_tracker, loky_tracker):
            tracker.ensure_running()  # now, since that lets signals through again
    before: Any = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _environment(name: str, value: str) -> Iterator[None]:
    """Give a variable to the processes that begin in this block."""
    before = os.environ.get(name)
    os.environ[name] = value
    try:
        yield
    finally:
        if before is None:
            del os.environ[name]
        else:
            os.environ[name] = before
