"""What an earlier run has done, by its log and by the files themselves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from joblib import Parallel, delayed

from meshlab_symrecon.batch.checksums import sha256_of
from meshlab_symrecon.batch.further_files import checksums_of, unchanged
from meshlab_symrecon.batch.reports import (
    DONE,
    FAILED,
    KILLED,
    NOT_WRITTEN,
    OUT_OF_MEMORY,
    TIMED_OUT,
    TOO_LARGE,
    ScanReport,
)
from meshlab_symrecon.batch.work import Job

__all__ = ["Standing", "standing"]

PASSING = (NOT_WRITTEN, KILLED)  # may well go the next time
OF_MEMORY = (OUT_OF_MEMORY, TOO_LARGE)  # without a limit, of what was free at that moment
LIMITED = {TIMED_OUT: ("seconds",), OUT_OF_MEMORY: ("memory",), TOO_LARGE: ("memory",)}


@dataclass(frozen=True, slots=True)
class Standing:
    """What is left to do.

    Attributes
    ----------
    kept : mapping of int to ScanReport
        What stays as it is, by the position of the scan.
    left : tuple of Job
    """

    kept: Mapping[int, ScanReport]
    left: tuple[Job, ...]


def standing(
    jobs: Sequence[Job], reports: Sequence[ScanReport], *, retry: bool, again: bool
) -> Standing:
    """Compare jobs with the reports of a log, and with the files that are there.

    A scan is done when the last line on its result says so, for the same contents of the scan and
    the same work, and when the result is still what it was then. A scan that has failed stays so,
    unless it is to be tried again (``retry``), the limit that it met has been raised, or the
    reason was a passing one.
    """
    latest = {report.name: report for report in reports}
    known = [latest.get(job.name) for job in jobs]
    if again:
        reasons = [None if report is None else "it was asked for" for report in known]
    else:
        compared = (
            delayed(_why_again)(job, report, retry) for job, report in zip(jobs, known, strict=True)
        )
        reasons = Parallel(n_jobs=-1, prefer="threads")(compared)
    kept, left = {}, []
    for position, (job, report) in enumerate(zip(jobs, known, strict=True)):
        if report is None or reasons[position] is not None:
            left.append(replace(job, again=reasons[position]))
        else:
            kept[position] = replace(report, scan=job.shown_scan, output=job.shown_output)
    return Standing(kept, tuple(left))


def _why_again(job: Job, report: ScanReport | None, retry: bool) -> str | None:
    """Return why a scan is worked on although the log has a line of it; None when it is not."""
    if report is None:
        return None
    if report.work_sha256 != job.work.sha256:
        return _difference(job, report)
    changed = _why_read_anew(job, report)
    if changed is not None:
        return changed
    most = report.limits.get("points")
    if _points_worked_on(report, most) != _points_worked_on(report, job.limits.points):
        return "the limit of points has been changed"
    if report.status == DONE:
        return _why_made_again(job, report)
    return _why_retried(job, report, retry)


def _why_read_anew(job: Job, report: ScanReport) -> str | None:
    checksum = sha256_of(job.scan)
    if checksum is None and report.input_sha256 is None and report.status != DONE:
        return None  # it can be read as little as before
    if checksum != report.input_sha256 or checksum is None:
        return "the scan can be read now" if report.input_sha256 is None else "the scan has changed"
    if checksums_of(job.further, job.scan.parent) != dict(report.input_files):
        return "a file behind the scan has changed"
    return None


def _why_made_again(job: Job, report: ScanReport) -> str | None:
    checksum = sha256_of(job.output)
    if checksum is None:
        return "its result is gone"
    if checksum != report.output_sha256:
        return "its result has been changed"
    if not unchanged(report.output_files, job.output.parent):
        return "a file of its result is gone or has been changed"
    return None


def _points_worked_on(report: ScanReport, most: object) -> object:
    """Return to how many points a scan is thinned out; the limit itself when nobody knows."""
    if report.points is None:
        return most
    return min(report.points, most) if isinstance(most, int) else report.points


def _difference(job: Job, report: ScanReport) -> str:
    if dict(report.versions) != dict(job.work.versions):
        return "it was made by other versions"
    if report.script_sha256 != job.work.script_sha256:
        return "the script has changed"
    return "the parameters have changed"


def _why_retried(job: Job, report: ScanReport, retry: bool) -> str | None:
    if retry:
        return f"it was {report.status}" if report.status != FAILED else "it had failed"
    unlimited = report.limits.get("memory") is None
    if report.status in PASSING or (report.status in OF_MEMORY and unlimited):
        return f"it was {report.status}, which may pass"
    for name in LIMITED.get(report.status, ()):
        before, now = report.limits.get(name), getattr(job.limits, name)
        if isinstance(before, (int, float)) and (now is None or now > before):
            return f"the limit of {name} has been raised"
    return None
