"""The plan of a batch: everything that can be checked before the work starts."""

from __future__ import annotations

import os
import pickle
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from meshlab_symrecon.batch.checksums import sha256_of, sha256_of_data
from meshlab_symrecon.batch.further_files import further_files
from meshlab_symrecon.batch.inputs import find_scans
from meshlab_symrecon.batch.names import folded, named
from meshlab_symrecon.batch.request import RECONSTRUCT, Batch, Limits
from meshlab_symrecon.batch.work import Job, Work, memory_share
from meshlab_symrecon.errors import FileError, ParameterError
from meshlab_symrecon.host.atomic import check_target, flush_folder, reason
from meshlab_symrecon.host.versions import versions_of_filters, versions_of_results

__all__ = ["Plan", "planned"]

LOG = "batch.jsonl"


@dataclass(frozen=True, slots=True)
class Plan:
    """What is to be done.

    Attributes
    ----------
    jobs : tuple of Job
        One a scan, in order.
    folder : Path
        Of the results; they may be in folders in it.
    log : Path
    count : int
        How many scans are worked on at once, on this machine.
    """

    jobs: tuple[Job, ...]
    folder: Path
    log: Path
    count: int

    @property
    def folders(self) -> tuple[Path, ...]:
        """Return the folders that results are written to."""
        return tuple(sorted({job.output.parent for job in self.jobs}))


def planned(batch: Batch) -> Plan:
    """Check a batch, and make the folders of its results; nothing else is written.

    Raises
    ------
    FileError
        A path that does not exist, or that cannot be written; a result would overwrite a scan.
    ScriptError
        The script has mistakes.
    ParameterError
        The template, the number of jobs, or the settings are wrong.
    """
    from meshlab_symrecon.host.formats import WRITABLE
    from meshlab_symrecon.host.paths import READABLE
    from meshlab_symrecon.host.projects import PROJECT
    from meshlab_symrecon.host.thinning import check_most

    if batch.limits.points is not None:
        check_most(batch.limits.points)
    work = _work(batch)
    count = _count(batch)
    folder = Path(batch.folder)
    scans = find_scans(batch.inputs, readable=READABLE, recursive=batch.recursive, results=folder)
    names = named(batch.name, scans, script=work.name, writable=(*WRITABLE, PROJECT))
    limits = _limits(batch.limits, count, batch.scheduler)
    share = None if batch.scheduler is not None else memory_share(min(count, len(scans)))
    jobs = tuple(
        Job(_absolute(scan.path), _absolute(folder / name), name.as_posix(), str(scan.path),
            str(folder / name), work, limits, share=share,
            further=further_files(_absolute(scan.path)))
        for scan, name in zip(scans, names, strict=True)
    )  # fmt: skip
    log = Path(batch.log) if batch.log is not None else folder / LOG
    kept = [] if work.name == RECONSTRUCT else [_absolute(Path(batch.script))]
    _check_places(jobs, kept)
    _check_written(jobs, kept, log, None if batch.summary is None else Path(batch.summary))
    plan = Plan(jobs, folder, log, count)
    for place in plan.folders:
        _make(place)
    for job in jobs:
        check_target(job.output)
    if batch.log is None:
        _make(folder)
    check_target(log)
    if batch.summary is not None:
        check_target(Path(batch.summary))
    return plan


def _work(batch: Batch) -> Work:
    """Return what is to be done, checked as far as that is possible without a scan."""
    from meshlab_symrecon.host.script import checked_script

    if batch.strict and batch.lenient:
        raise ParameterError("strict and lenient contradict each other; give one")
    versions = versions_of_results()
    settings: dict[str, Any] = {}
    script, checksum, name = b"", None, os.fspath(batch.script)
    if name == RECONSTRUCT:
        if batch.strict or batch.lenient:
            raise ParameterError("strict and lenient are for scripts; leave them out")
        settings = _checked_settings(batch.settings)
    else:
        if batch.settings:
            listed = ", ".join(batch.settings)
            message = f"a script holds its own parameters; got {listed} besides"
            raise ParameterError(f"{message}; write them in the script")
        steps = checked_script(name, strict=batch.strict, lenient=batch.lenient)
        script, checksum = pickle.dumps(steps), sha256_of(Path(name))
        versions |= versions_of_filters(step.name for step in steps.steps)
    made_of: dict[str, Any] = {
        "script": name if checksum is None else checksum,
        "settings": settings,
        "strict": batch.strict,
        "lenient": batch.lenient,
        "versions": versions,
    }
    return Work(
        name=name,
        script=script,
        script_sha256=checksum,
        settings=settings,
        strict=batch.strict,
        lenient=batch.lenient,
        versions=versions,
        sha256=sha256_of_data(made_of),
    )


def _checked_settings(settings: Mapping[str, object]) -> dict[str, Any]:
    """Return the settings of the whole method as plain data."""
    from meshlab_symrecon.host.measures import plain
    from meshlab_symrecon.host.reconstruction import parameters_as_run
    from meshlab_symrecon.plugin.parameters import nearest_names

    given: dict[str, Any] = plain(dict(settings))
    bound = (values for name, values in parameters_as_run(given).items() if name not in given)
    known = sorted({parameter for values in bound for parameter in values})
    for name in given:
        if name not in known:
            message = f"no filter of the method has a parameter '{name}'"
            raise ParameterError(f"{message}{nearest_names(name, known)}")
    return given


def _count(batch: Batch) -> int:
    if batch.jobs is not None and batch.scheduler is not None:
        message = f"jobs is {batch.jobs}, but a cluster's workers say how much runs at once"
        raise ParameterError(f"{message}; give one of jobs and scheduler")
    if batch.jobs is not None:
        return batch.jobs
    from joblib import cpu_count

    return int(cpu_count())


def _limits(limits: Limits, count: int, scheduler: str | None) -> Limits:
    """Return the limits of each scan: one thread when several are worked on at once."""
    if limits.threads is None and (count > 1 or scheduler is not None):
        return replace(limits, threads=1)
    return limits


def _absolute(path: Path) -> Path:
    return Path(os.path.abspath(path))  # noqa: PTH100  links stay what they are


def _check_places(jobs: Iterable[Job], others: Iterable[Path]) -> None:
    """Refuse results among the scans, which a later run would take for scans, and equal ones."""
    first: dict[str, Job] = {}
    scans = {os.path.realpath(job.scan): job for job in jobs}
    among = {os.path.dirname(path): job for path, job in scans.items()}  # noqa: PTH120
    behind = (file for job in jobs for file in job.further)
    kept = set(scans) | {os.path.realpath(path) for path in (*others, *behind)}
    inodes = _inodes(scans)
    for job in jobs:
        target = os.path.realpath(job.output)
        if target in kept or _inode(target) in inodes:
            message = f"{job.shown_output} would overwrite a scan or the script"
            raise FileError(f"{message}; give another folder for the results")
        neighbour = among.get(os.path.dirname(target))  # noqa: PTH120
        if neighbour is not None:
            message = f"the results would lie among the scans, beside {neighbour.shown_scan}"
            raise FileError(f"{message}; give a folder of their own with -d")
        other = first.setdefault(folded(target), job)
        if other is not job:
            message = f"{other.shown_output} and {job.shown_output} are one file, through a link"
            raise FileError(f"{message}; give another folder for the results")


def _check_written(
    jobs: Iterable[Job], others: Iterable[Path], log: Path, summary: Path | None
) -> None:
    """Refuse a log or a summary in the place of another file of the batch."""
    files = [file for job in jobs for file in (job.scan, job.output, *job.further)]
    used = {folded(os.path.realpath(file)) for file in (*files, *others)}
    inodes = _inodes(job.scan for job in jobs)
    for what, path in (("log", log), ("summary", summary)):
        if path is None:
            continue
        place = folded(os.path.realpath(path))
        if place in used or _inode(path) in inodes:
            message = f"the {what} {path} would overwrite a file of the batch"
            raise FileError(f"{message}; give another path")
        used.add(place)


def _inodes(files: Iterable[str | Path]) -> set[tuple[int, int]]:
    """Return what hard links to these files have in common with them."""
    return {inode for file in files if (inode := _inode(file)) is not None}


def _inode(file: str | Path) -> tuple[int, int] | None:
    try:
        status = os.stat(file)  # noqa: PTH116  a text, mostly
    except (OSError, ValueError):
        return None
    return status.st_dev, status.st_ino


def _make(folder: Path) -> None:
    """Make a folder that is missing, so that a loss of power does not undo it."""
    if folder.is_dir():
        return
    try:
        folder.mkdir(parents=True, exist_ok=True)
        flush_folder(folder.parent)
    except OSError as error:
        message = f"the folder {folder} cannot be made: {reason(error)}"
        raise FileError(f"{message}; give another one with -d") from error
