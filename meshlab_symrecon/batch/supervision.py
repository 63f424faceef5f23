"""One scan at a time, in a child process within its limits: what a worker does.

A worker stays small: it imports neither pymeshlab nor numpy.
"""

from __future__ import annotations

import os
import platform
import signal
import threading
import time
from collections.abc import Callable
from datetime import datetime, timezone
from typing import Any

from meshlab_symrecon.batch.checksums import sha256_of
from meshlab_symrecon.batch.further_files import checksums_of
from meshlab_symrecon.batch.reports import (
    CRASHED,
    DONE,
    FAILED,
    KILLED,
    OUT_OF_MEMORY,
    TIMED_OUT,
    TOO_LARGE,
    ScanReport,
)
from meshlab_symrecon.batch.request import in_bytes
from meshlab_symrecon.batch.work import Job, do_job
from meshlab_symrecon.errors import HostError
from meshlab_symrecon.host.child_watch import ABANDONED, Bounds
from meshlab_symrecon.host.isolation import Ending, crash_in_words, run_child
from meshlab_symrecon.host.thread_variables import VARIABLES

__all__ = ["lost_with_workers", "supervised", "supervised_for"]

FROM_OUTSIDE = ("SIGKILL", "SIGTERM", "SIGINT", "SIGHUP")
NO_MEMORY = ("bad_alloc", "MemoryError", "Cannot allocate memory")  # last words of a process
LOOK = 0.2  # seconds between two looks at the coordinator
_watching = threading.Event()


def supervised_for(coordinator: int, job: Job) -> ScanReport:
    """Do a job of a coordinator on this machine, and end with it.

    Parameters
    ----------
    coordinator : int
        Its process, which is our parent, or ourselves.
    job : Job
    """
    if coordinator == os.getpid():
        return supervised(job)
    if not _watching.is_set():
        _watching.set()
        threading.Thread(target=_end_with, args=(coordinator,), daemon=True).start()
    return supervised(job, lambda: os.getppid() == coordinator)


def _silent(fraction: float, message: str) -> None:
    """Tell nobody."""


def _end_with(coordinator: int) -> None:
    """End this worker, and by that its child, as soon as the coordinator is no more."""
    while os.getppid() == coordinator:
        time.sleep(LOOK)
    time.sleep(LOOK)  # for the child to be ended, and what it staged to be removed
    os._exit(1)


def supervised(job: Job, wanted: Callable[[], bool] | None = None) -> ScanReport:
    """Do a job in a child process; return its report, whatever became of it.

    Raises
    ------
    HostError
        Nobody wants the result any more.
    """
    known = _known(job)
    bounds = Bounds(
        seconds=job.limits.seconds,
        memory=job.limits.memory,
        environment=_environment(job.limits.threads),
        **({} if wanted is None else {"wanted": wanted}),
    )
    ending = run_child(
        do_job, job, progress=_silent, folders=[job.output.parent], bounds=bounds, keep_words=True
    )
    if ending.stopped == ABANDONED:
        raise HostError(f"{job.shown_scan}: the batch has ended; start it again to go on")
    found = _fields(job, ending)
    if found["status"] == DONE:
        found["output_sha256"] = sha256_of(job.output)
    if found.get("error"):
        found["error"] = _named_shortly(job, found["error"]) + _older(job)
    return ScanReport(
        **known,
        warnings=tuple(
            _named_shortly(job, sentence)
            for sentence in (ending.answer.warnings if ending.answer else ())
        ),
        seconds=round(ending.seconds, 3),
        peak_memory_bytes=ending.peak_memory,
        machine=platform.node(),
        **found,
    )


def lost_with_workers(job: Job, why: str) -> ScanReport:
    """Return the report of a job whose workers were ended from outside, one after the other."""
    error = f"{job.shown_scan}: every worker that took it was ended: {why}"
    words = f"{error}; when for want of memory, give them more, or thin it out with --max-points"
    return ScanReport(status=KILLED, error=words, **_known(job))


def _known(job: Job) -> dict[str, Any]:
    """Return the fields of a report that are known before the work."""
    return {
        "scan": job.shown_scan,
        "output": job.shown_output,
        "name": job.name,
        "input_sha256": sha256_of(job.scan),
        "input_files": checksums_of(job.further, job.scan.parent),
        "script": job.work.name,
        "script_sha256": job.work.script_sha256,
        "work_sha256": job.work.sha256,
        "limits": limits_as_data(job),
        "versions": job.work.versions,
        "again": job.again,
        "started": datetime.now(timezone.utc).isoformat(timespec="milliseconds"),
    }


def limits_as_data(job: Job) -> dict[str, Any]:
    """Return the limits as the log has them."""
    limits = job.limits
    return {"seconds": limits.seconds, "memory": limits.memory, "points": limits.points}


def _environment(threads: int | None) -> dict[str, str]:
    return {} if threads is None else dict.fromkeys(VARIABLES, str(threads))


def _fields(job: Job, ending: Ending) -> dict[str, Any]:
    """Return status, error and all that the child told."""
    found = dict(ending.answer.result) if ending.answer and ending.answer.result else {}
    if not found:
        status, error = _without_answer(job, ending)
        found = {"status": status, "error": error}
    if found["status"] == OUT_OF_MEMORY:
        found["error"] = _no_memory(job, ending)
    if found["status"] == TOO_LARGE:
        found["error"] += _whose_limit(job)
    return found


def _whose_limit(job: Job) -> str:
    """Return words on the limit that a scan is too large for; none when the machine has no more."""
    if job.limits.memory is not None:
        return f" (--memory-limit is {in_bytes(job.limits.memory)})"
    if job.share is not None:
        return " (scans at once share what is free: fewer --jobs leave more for each)"
    return ""


def _older(job: Job) -> str:
    """Return words on a file that looks like a result of this work, and is none."""
    if not job.output.exists():
        return ""
    return f"; {job.shown_output} is still there, from before"


def _without_answer(job: Job, ending: Ending) -> tuple[str, str]:
    if ending.answer is not None and ending.answer.error is not None:
        return FAILED, str(ending.answer.error)
    if ending.stopped == TIMED_OUT:
        limit = f"{job.limits.seconds:g} s"
        error = f"{job.shown_scan}: it takes longer than {limit}{_while(ending)}"
        return TIMED_OUT, f"{error}; raise --time-limit, or simplify it first"
    if ending.stopped == OUT_OF_MEMORY or any(word in ending.words for word in NO_MEMORY):
        return OUT_OF_MEMORY, ""
    if ending.code < 0 and ending.code in [-getattr(signal, n, 0) for n in FROM_OUTSIDE]:
        error = f"{job.shown_scan}: its process was ended from outside{_while(ending)}"
        return KILLED, f"{error}; when the system did, for want of memory, run fewer jobs at once"
    lines = ending.words.strip().splitlines()
    if ending.code == 1 and lines and "Traceback" in ending.words:
        return FAILED, " ".join(lines[-1].split())
    return CRASHED, f"{job.shown_scan}: {crash_in_words(ending)}"


def _no_memory(job: Job, ending: Ending) -> str:
    limit = job.limits.memory
    if limit is None:
        error = f"{job.shown_scan}: the memory of the machine does not suffice{_while(ending)}"
        return f"{error}; give fewer --jobs, thin it out with --max-points, or simplify it first"
    error = f"{job.shown_scan}: it needs more than {in_bytes(limit)} of memory{_while(ending)}"
    return f"{error}; raise --memory-limit, thin it out with --max-points, or simplify it first"


def _while(ending: Ending) -> str:
    return f" ({ending.doing})" if ending.doing else ""


def _named_shortly(job: Job, sentence: str) -> str:
    """Return a sentence in which files are called as the user called them."""
    for path, shown in ((str(job.output), job.shown_output), (str(job.scan), job.shown_scan)):
        for spelling in (path, path.encode("utf-8", "replace").decode()):  # not in UTF-8: with ?
            sentence = sentence.replace(spelling, shown)
    return sentence
