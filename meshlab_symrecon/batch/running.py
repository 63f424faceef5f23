"""A batch from its plan to its report."""

from __future__ import annotations

import time
from collections.abc import Generator, Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path

from meshlab_symrecon.batch.claims import claimed
from meshlab_symrecon.batch.listener import Listener
from meshlab_symrecon.batch.log import Log, opened_log
from meshlab_symrecon.batch.plan import Plan, planned
from meshlab_symrecon.batch.reports import BatchReport, ScanReport
from meshlab_symrecon.batch.request import Batch
from meshlab_symrecon.batch.resumption import Standing, standing
from meshlab_symrecon.batch.work import Job
from meshlab_symrecon.host.atomic import STAGING_PREFIX, remove_dead_staging

__all__ = ["BatchInterruptedError", "run_batch"]

LOOKS, MOMENT = 10, 0.05  # seconds each


class BatchInterruptedError(KeyboardInterrupt):
    """A batch was interrupted; what is done is done, and logged.

    Attributes
    ----------
    done, total : int
        How many scans have an end, and how many there are.
    """

    def __init__(self, done: int, total: int) -> None:
        super().__init__(f"{done} of {total} scans are done")
        self.done, self.total = done, total


def run_batch(batch: Batch, listener: Listener | None = None) -> BatchReport:
    """Do a batch, or go on with it where it stopped; return what became of every scan.

    Parameters
    ----------
    batch : Batch
    listener : Listener, optional
        Told how it goes on.

    Raises
    ------
    FileError, ScriptError, ParameterError
        What is wrong with the whole batch, before any work; another batch makes the same results;
        or the log cannot be written. What is wrong with one scan is in its report.
    HostError
        Workers are ended again and again, or a cluster does not answer.
    BatchInterruptedError
        By Ctrl-C; no process is left, and nothing half-written.
    """
    listener = listener or Listener()
    started = time.monotonic()
    plan = planned(batch)
    results = {job.name: job.shown_output for job in plan.jobs}
    with opened_log(plan.log) as log, claimed(plan.folder, results, listener.said):
        done: dict[str, ScanReport] = {}
        try:
            _go_on(batch, plan, log, done, listener)
        except KeyboardInterrupt as error:
            raise BatchInterruptedError(len(done), len(plan.jobs)) from error
    scans = tuple(done[job.name] for job in plan.jobs)
    return BatchReport(scans, str(plan.log), round(time.monotonic() - started, 3))


def _go_on(
    batch: Batch, plan: Plan, log: Log, done: dict[str, ScanReport], listener: Listener
) -> None:
    listener.planned(len(plan.jobs))
    if log.passed_over:
        several = "1 line is" if log.passed_over == 1 else f"{log.passed_over} lines are"
        listener.said(f"{log.path}: {several} not of a batch, and passed over")
    with _nothing_half_written(plan.folders):
        now = standing(plan.jobs, log.reports, retry=batch.retry, again=batch.again)
        _tell_kept(now, done, listener)
        for job in now.left:
            if job.again is not None:
                listener.said(f"{job.shown_scan} is done again: {job.again}")
        with closing(_engine(batch, plan, now.left, listener)) as reports:
            for report in reports:
                log.append(report)
                done[report.name] = report
                listener.ended(report)


def _tell_kept(now: Standing, done: dict[str, ScanReport], listener: Listener) -> None:
    for report in now.kept.values():
        done[report.name] = report
        listener.ended(report)


def _engine(
    batch: Batch, plan: Plan, jobs: Sequence[Job], listener: Listener
) -> Generator[ScanReport, None, None]:
    if not jobs:
        return
    if batch.scheduler is not None:
        from meshlab_symrecon.batch.cluster import on_cluster

        yield from on_cluster(jobs, batch.scheduler, listener.said)
    else:
        from meshlab_symrecon.batch.cores import on_cores

        yield from on_cores(jobs, plan.count, listener.said)


@contextmanager
def _nothing_half_written(folders: Sequence[Path]) -> Iterator[None]:
    """Remove what processes that were ended have left, before and after."""
    _remove_dead(folders)
    try:
        yield
    except BaseException:
        for _ in range(LOOKS):  # what was killed just now may take a moment to be gone
            if not _remove_dead(folders):
                break
            time.sleep(MOMENT)
        raise
    _remove_dead(folders)


def _remove_dead(folders: Sequence[Path]) -> bool:
    """Remove it; say whether processes that live are writing there still."""
    for folder in folders:
        remove_dead_staging(folder)
    return any(True for folder in folders for _ in folder.glob(f"{STAGING_PREFIX}*"))
