"""What is done with one scan, inside of its own process."""

from __future__ import annotations

import errno
import pickle
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from meshlab_symrecon.batch.further_files import checksums_of, further_files
from meshlab_symrecon.batch.reports import DONE, FAILED, NOT_WRITTEN, OUT_OF_MEMORY, TOO_LARGE
from meshlab_symrecon.batch.request import Limits
from meshlab_symrecon.errors import FileError, HostError, SizeError, SymReconError
from meshlab_symrecon.host.free_memory import available_memory
from meshlab_symrecon.host.versions import versions_of

if TYPE_CHECKING:
    from meshlab_symrecon.plugin import Progress

__all__ = ["Job", "Work", "do_job", "memory_share"]

FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EROFS, errno.ENOMEM)


@dataclass(frozen=True, slots=True)
class Work:
    """What is done with every scan.

    Attributes
    ----------
    name : str
        The script's path, or ``reconstruct``.
    script : bytes
        The checked script, pickled, so that only those who run it need to understand it; empty
        for ``reconstruct``.
    script_sha256 : str or None
    settings : mapping
    strict, lenient : bool
    versions : mapping of str to str
        Of ours, what it stands on, and the distributions that the script's filters come from.
    sha256 : str
        Checksum of all of these.
    """

    name: str
    script: bytes
    script_sha256: str | None
    settings: Mapping[str, Any]
    strict: bool
    lenient: bool
    versions: Mapping[str, str]
    sha256: str


@dataclass(frozen=True, slots=True)
class Job:
    """One scan.

    Attributes
    ----------
    scan, output : Path
        In full.
    name : str
        Of the output, relative to the folder of results.
    shown_scan, shown_output : str
        As the user named them.
    work : Work
    limits : Limits
    again : str or None
        Why it is done again.
    further : tuple of Path
        The files behind the scan: meshes of a project, materials, images.
    share : int or None
        Bytes of memory that a scan without a limit may count on, since others are worked on at
        the same time; what is free when None.
    """

    scan: Path
    output: Path
    name: str
    shown_scan: str
    shown_output: str
    work: Work
    limits: Limits
    again: str | None = None
    further: tuple[Path, ...] = ()
    share: int | None = None

    @property
    def memory(self) -> int | None:
        """Return what estimates are compared with."""
        return self.share if self.limits.memory is None else self.limits.memory


def memory_share(count: int) -> int | None:
    """Return the memory that is free now, for each of as many scans at once; None for one."""
    return None if count == 1 else available_memory() // count


def do_job(job: Job, *, progress: Progress) -> dict[str, Any]:
    """Do it; return the fields of its report that are known in here, whatever comes."""
    found: dict[str, Any] = {}
    try:
        _check_versions(job.work)
        mesh_set = _worked(job, found, progress)
        progress(1.0, f"writing {job.output}")
        _save(mesh_set, job)
        found["output_files"] = checksums_of(further_files(job.output), job.output.parent)
    except SymReconError as error:
        return found | {"status": _status(error), "error": str(error)}
    except MemoryError:
        return found | {"status": OUT_OF_MEMORY}
    except Exception as error:  # noqa: BLE001  whatever a plugin raises; the other scans go on
        words = " ".join(f"{type(error).__name__}: {error}".split())
        return found | {"status": FAILED, "error": words}
    return found | {"status": DONE}


def _worked(job: Job, found: dict[str, Any], progress: Progress) -> Any:
    """Return the document after the work; note what was found and measured."""
    from meshlab_symrecon.host.measures import findings, plain
    from meshlab_symrecon.host.paths import check_input
    from meshlab_symrecon.host.reconstruction import parameters_as_run, whole_method

    _check_links(job)
    check_input(job.scan)
    if not _is_text(job.output):
        message = f"{job.shown_output} cannot be written: this name, or that of a folder above"
        raise FileError(f"{message}, is not in UTF-8, which MeshLab needs; give another name")
    found["parameters"] = {"max_points": job.limits.points}
    if job.work.script:
        found["parameters"] |= {"strict": job.work.strict, "lenient": job.work.lenient}
        mesh_set, report = _scripted(job, found, progress)
        found["steps"] = plain(report.steps)
        found["measures"] = _of_steps(report.steps)
        return mesh_set
    settings, limits = job.work.settings, job.limits
    found["parameters"] |= plain(parameters_as_run(settings))
    result = whole_method(job.scan, settings, progress, limits.points, job.memory)
    found["points"] = result.measured
    found["measures"] = findings(result)
    return result.mesh_set


def _check_links(job: Job) -> None:
    """Refuse a link that leads to no file, which looks as if nothing were there."""
    try:
        job.scan.stat()
    except OSError as error:
        if error.errno == errno.ELOOP:
            message = f"{job.shown_scan} cannot be read: it is in a loop of links"
            raise FileError(f"{message}, which leads to no file; put the scan there") from error
        if error.errno == errno.ENOENT and job.scan.is_symlink():
            message = f"{job.shown_scan} cannot be read: it is a link to {job.scan.readlink()}"
            raise FileError(f"{message}, and no file is there; check its path") from error


def _is_text(path: Path) -> bool:
    try:
        str(path).encode()
    except UnicodeEncodeError:
        return False
    return True


def _scripted(job: Job, found: dict[str, Any], progress: Progress) -> tuple[Any, Any]:
    from meshlab_symrecon.host.files import new_document
    from meshlab_symrecon.host.projects import files_of, load_input
    from meshlab_symrecon.host.script import run_steps
    from meshlab_symrecon.host.size import check_memory
    from meshlab_symrecon.host.thinning import thin_current

    script = pickle.loads(job.work.script)  # noqa: S301  the coordinator's
    most = job.limits.points
    names = [step.name for step in script.steps]
    check_memory(files_of(job.scan), job.memory, most=most, steps=names, work="the script")
    mesh_set = new_document()
    progress(0.0, f"reading {job.scan}")
    load_input(job.scan, mesh_set)
    found["points"] = int(mesh_set.current_mesh().vertex_number())
    if most is not None and found["points"] > most:
        progress(0.0, f"thinning out {found['points']} points")
        thin_current(mesh_set, most)
    how = {"strict": job.work.strict, "lenient": job.work.lenient}
    return mesh_set, run_steps(mesh_set, script, **how, progress=progress)


def _save(mesh_set: Any, job: Job) -> None:
    from meshlab_symrecon.host.files import save_current
    from meshlab_symrecon.host.projects import PROJECT, files_of, save_project
    from meshlab_symrecon.host.records import record_of
    from meshlab_symrecon.host.textures import images_named_by_contents

    most = job.limits.points
    own = {} if most is None else {"max_points": most}  # the others are parameters of the steps
    record = record_of(mesh_set, files_of(job.scan), own)
    try:
        with images_named_by_contents():  # other jobs write into the same folder meanwhile
            if job.output.suffix.lower() == f".{PROJECT}":
                save_project(mesh_set, job.output, files_of(job.scan), record=record)
            else:
                save_current(mesh_set, job.output, record)
    except FileError as error:
        raise _NotWrittenError(str(error)) from error


class _NotWrittenError(FileError):
    """The result could not be written."""


def _status(error: SymReconError) -> str:
    if isinstance(error, SizeError):
        return TOO_LARGE
    causes = _causes(error)
    if any(isinstance(cause, MemoryError) or "bad_alloc" in str(cause) for cause in causes):
        return OUT_OF_MEMORY
    full = any(isinstance(cause, OSError) and cause.errno in FULL for cause in causes)
    return NOT_WRITTEN if full or isinstance(error, _NotWrittenError) else FAILED


def _causes(error: BaseException | None) -> list[BaseException]:
    found: list[BaseException] = []
    while error is not None and error not in found:
        found.append(error)
        error = error.__cause__ or error.__context__
    return found


def _check_versions(work: Work) -> None:
    here = versions_of(work.versions)
    if here != dict(work.versions):
        message = f"this worker has {_listed(here)}, and the batch was started by one that has"
        raise HostError(f"{message} {_listed(work.versions)}; install the same versions on both")


def _listed(known: Mapping[str, str]) -> str:
    return ", ".join(f"{name} {version}" for name, version in known.items())


def _of_steps(steps: Any) -> dict[str, Any]:
    """Return what the steps measured, in one record; of equal names the last one's."""
    from meshlab_symrecon.host.measures import detection, is_detection, plain

    found: dict[str, Any] = {}
    for step in steps:
        found |= plain(step.measures)
        if is_detection(step.measures):
            found |= detection(step.measures)
    return found
