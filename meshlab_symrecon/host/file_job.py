"""A script on files, from reading them to writing the result."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from meshlab_symrecon.errors import FileError
from meshlab_symrecon.host.files import new_document, save_current
from meshlab_symrecon.host.formats import WRITABLE
from meshlab_symrecon.host.isolation import isolated
from meshlab_symrecon.host.mlx import Script
from meshlab_symrecon.host.paths import check_output
from meshlab_symrecon.host.projects import PROJECT, files_of, load_input, save_project
from meshlab_symrecon.host.records import record_of
from meshlab_symrecon.host.script import StepReport, checked_script, run_steps
from meshlab_symrecon.host.size import check_memory, check_rest
from meshlab_symrecon.host.thinning import check_most, thin_current
from meshlab_symrecon.plugin import Progress

__all__ = ["FileReport", "Manner", "Thinned", "run_on_files"]


@dataclass(frozen=True, slots=True)
class Thinned:
    """An input that was thinned out: its points in the file, and those that the script met."""

    path: str
    measured: int
    points: int


@dataclass(frozen=True, slots=True)
class FileReport:
    """What became of a script on files, and of the inputs that were too large for ``most``."""

    script: str
    steps: tuple[StepReport, ...]
    seconds: float
    thinned: tuple[Thinned, ...] = ()


@dataclass(frozen=True, slots=True)
class Manner:
    """How a script is run on files.

    Attributes
    ----------
    strict, lenient : bool
        As ``run_script``.
    isolate : bool
        Work in a child process, whose crash is an error.
    most : int or None
        An input with more points is thinned out evenly to these when it has been read.
    """

    strict: bool = False
    lenient: bool = False
    isolate: bool = False
    most: int | None = None


@dataclass(frozen=True, slots=True)
class _Job:
    """What is done, maybe in a child process."""

    script: Script
    inputs: tuple[Path, ...]
    kept: tuple[Path, ...]  # files that must stay as they are: the script's first
    output: Path
    manner: Manner

    @property
    def steps(self) -> tuple[str, ...]:
        """The names of the steps, as they are written."""
        return tuple(step.name for step in self.script.steps)


def run_on_files(
    script: Path,
    inputs: Sequence[Path],
    output: Path,
    manner: Manner,
    progress: Progress,
) -> FileReport:
    """Run a script on files, and save the current layer, or all layers as a project.

    Parameters
    ----------
    script : Path
    inputs : sequence of Path
        Meshes and projects, whose layers come in this order; the last one is the current one.
        Without any, the script has to make the first layer.
    output : Path
        With the extension ``.mlp``, every layer is saved beside the project.
    manner : Manner
    progress : callable

    Raises
    ------
    FileError
        A file cannot be read or written, or has several layers that would have to be thinned out.
    ParameterError
        ``manner.most`` is too small.
    SizeError
        The work would need more memory than there is; nothing was written.
    ScriptError
        As ``run_script``; nothing was written.
    HostError
        A step crashed in the child process; nothing was written.
    """
    kept = [script, *(file for path in inputs for file in files_of(path))]
    check_output(output, kept, (*WRITABLE, PROJECT))
    if manner.most is not None:
        check_most(manner.most)
    # Before reading inputs, which is long; and once only, since a script may come through a pipe.
    steps = checked_script(script, strict=manner.strict, lenient=manner.lenient)
    job = _Job(steps, tuple(inputs), tuple(kept), output, manner)
    check_memory(job.kept[1:], most=manner.most, steps=job.steps, work="the script")
    if not manner.isolate:
        return _done(job, progress=progress)
    report: FileReport = isolated(_done, job, progress=progress, folders=[output.parent])
    return report


def _done(job: _Job, *, progress: Progress) -> FileReport:
    mesh_set, manner = new_document(), job.manner
    thinned: list[Thinned] = []
    for path in job.inputs:
        progress(0.0, f"reading {path}")
        thinned += _loaded(path, mesh_set, manner.most, progress)
    _check_size(job, mesh_set)
    how = {"strict": manner.strict, "lenient": manner.lenient}
    report = run_steps(mesh_set, job.script, **how, progress=progress)
    progress(1.0, f"writing {job.output}")
    settings = {} if manner.most is None else {"max_points": manner.most}
    record = record_of(mesh_set, job.kept[1:], settings)  # all but the script
    if job.output.suffix.lower() == f".{PROJECT}":
        save_project(mesh_set, job.output, job.kept, record=record)
    else:
        save_current(mesh_set, job.output, record)
    return FileReport(report.script, report.steps, report.seconds, tuple(thinned))


def _loaded(path: Path, mesh_set: Any, most: int | None, progress: Progress) -> list[Thinned]:
    """Load an input and thin it out; return what was thinned."""
    before = {int(mesh.id()) for mesh in mesh_set}
    load_input(path, mesh_set)
    sizes = {int(mesh.id()): int(mesh.vertex_number()) for mesh in mesh_set}
    new = [identifier for identifier in sizes if identifier not in before]
    large = [identifier for identifier in new if most is not None and sizes[identifier] > most]
    if most is None or not large:
        return []
    if large != new[-1:]:  # what is thinned out becomes the last layer, and scripts count layers
        message = (
            f"{path} holds {len(new)} layers, and another one than the last has more than {most} "
            "points; thin out its layers one by one, or leave --max-points out"
        )
        raise FileError(message)
    progress(0.0, f"thinning out {path}")
    mesh_set.set_current_mesh(large[0])
    return [Thinned(str(path), sizes[large[0]], thin_current(mesh_set, most))]


def _check_size(job: _Job, mesh_set: Any) -> None:
    """Check the memory again, now that the size is known of what did not announce it."""
    if not job.inputs or not job.steps:
        return
    sizes = [int(mesh.vertex_number()) for mesh in mesh_set]
    if sizes:
        check_rest(job.inputs[-1], max(sizes), job.steps, measured=max(sizes))
