"""What ``symrecon-server`` checks before anything is touched."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from meshlab_symrecon.cli.server_job import Job
from meshlab_symrecon.errors import FileError, SymReconError

__all__ = ["Checked", "check", "check_on_document"]


@dataclass(frozen=True, slots=True, eq=False)
class Checked:
    """What was read while checking.

    Attributes
    ----------
    scripts : tuple of Script
    findings : tuple of Finding
        Of all scripts.
    projects : mapping of Path to Project
    """

    scripts: tuple[Any, ...]
    findings: tuple[Any, ...]
    projects: dict[Path, Any]


class _Problems:
    """Collects the sentences of everything that is wrong."""

    def __init__(self) -> None:
        self.sentences: list[str] = []

    def of(self, call: Callable[..., Any], *arguments: Any, **options: Any) -> Any:
        """Return what a call returns; None, and a sentence kept, when it refuses."""
        try:
            return call(*arguments, **options)
        except SymReconError as error:
            if str(error) not in self.sentences:
                self.sentences.append(str(error))
            return None


def check(job: Job) -> Checked:
    """Read scripts and projects, and check every file that a job names.

    Raises
    ------
    SymReconError
        Everything that is wrong, one a line.
    SizeError
        The work would need more memory than there is.
    """
    problems = _Problems()
    scripts, findings = _check_scripts(job, problems)
    projects = _check_inputs(job, problems)
    _check_targets(job, problems)
    if problems.sentences:
        raise SymReconError("\n".join(problems.sentences))
    checked = Checked(scripts, findings, projects)
    _check_memory(job, checked)
    return checked


def check_on_document(job: Job, checked: Checked, mesh_set: Any) -> tuple[Any, ...]:
    """Check all scripts in a row, and the memory, on the document that was loaded; run nothing.

    Returns
    -------
    tuple of Finding
        What is no error, or is passed over leniently.

    Raises
    ------
    ScriptError
        Everything that is certainly wrong, one a line.
    SizeError
        What was loaded is larger than its files told, and the scripts need too much memory.
    """
    from meshlab_symrecon.host.checking import check_document
    from meshlab_symrecon.host.document_state import DocumentState
    from meshlab_symrecon.host.findings import check_findings
    from meshlab_symrecon.host.resolution import matched

    # As one long script, since each begins with the document that the one before it leaves.
    steps = [
        (str(script.path), number, step)
        for script in checked.scripts
        for number, step in enumerate(matched(script).steps)
    ]
    found = check_document([step for _, _, step in steps], DocumentState.of(mesh_set))
    findings = tuple(
        replace(finding, file=steps[finding.step][0], step=steps[finding.step][1])
        for finding in found
    )
    check_findings(findings, lenient=job.lenient)
    _check_rest(job, checked, mesh_set)
    return findings


def _check_memory(job: Job, checked: Checked) -> None:
    """Refuse what does not fit into memory before anything is loaded."""
    from meshlab_symrecon.host.size import check_memory

    files: list[Path] = []
    for load in job.loads:
        project = checked.projects.get(load.path)
        files += [load.path] if project is None else [layer.path for layer in project.layers]
    work = "the conversion" if not checked.scripts else "the script"
    if len(checked.scripts) > 1:
        work = "a row of scripts"
    check_memory(files, steps=_steps_of(checked), work=work, option=_thinning(checked))


def _check_rest(job: Job, checked: Checked, mesh_set: Any) -> None:
    """Refuse it after loading, now that the size is known of what did not announce it."""
    from meshlab_symrecon.host.size import check_rest

    sizes = [int(mesh.vertex_number()) for mesh in mesh_set]
    steps = _steps_of(checked)
    if job.loads and sizes and steps:
        last = job.loads[-1].path
        check_rest(last, max(sizes), steps, measured=max(sizes), option=_thinning(checked))


def _steps_of(checked: Checked) -> tuple[str, ...]:
    return tuple(step.name for script in checked.scripts for step in script.steps)


def _thinning(checked: Checked) -> str:
    """Return the command that does the same with fewer points; empty when there is none."""
    return "symrecon run --max-points" if len(checked.scripts) == 1 else ""


def _check_scripts(job: Job, problems: _Problems) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    from meshlab_symrecon.host.findings import check_findings
    from meshlab_symrecon.host.mlx_reading import read_script
    from meshlab_symrecon.host.resolution import matched

    scripts: list[Any] = []
    findings: list[Any] = []
    for path in job.scripts:
        script = problems.of(read_script, path)
        if script is None:
            continue
        matching = matched(script)
        problems.of(check_findings, matching.findings, strict=job.strict, lenient=job.lenient)
        scripts.append(script)
        findings += matching.findings
    return tuple(scripts), tuple(findings)


def _check_inputs(job: Job, problems: _Problems) -> dict[Path, Any]:
    from meshlab_symrecon.host.project_files import read_project

    projects = {}
    for load in job.loads:
        if load.project:
            project = problems.of(read_project, load.path)
            projects[load.path] = project
            for layer in () if project is None else project.layers:
                problems.of(_check_mesh, layer.path)
        else:
            problems.of(_check_mesh, load.path)
    return projects


def _check_mesh(path: Path) -> None:
    from meshlab_symrecon.host.paths import READABLE

    extension = path.suffix.removeprefix(".").lower()
    if not path.is_file():
        raise FileError(f"{path} cannot be read: no such file; check its path")
    if extension not in READABLE:
        message = f"{path} is of no format that can be read; known are {', '.join(READABLE)}"
        raise FileError(message)


def _check_targets(job: Job, problems: _Problems) -> None:
    """Check what will be written: meshes may take the place of inputs, nothing else may."""
    from meshlab_symrecon.host.mask import SAVED
    from meshlab_symrecon.host.paths import check_output

    kept = [*job.scripts, *(load.path for load in job.loads if load.project)]
    meshes = [load.path for load in job.loads if not load.project]
    earlier: list[Path] = []
    for output in job.outputs:
        problems.of(check_output, output.path, [*kept, *earlier], SAVED)
        earlier.append(output.path)
    for project in job.projects:
        problems.of(check_output, project.path, [*job.scripts, *meshes, *earlier], ())
        earlier.append(project.path)
    for path in (job.log, job.dump, job.report):
        if path is not None and not (path == job.log and path.is_char_device()):  # /dev/null
            problems.of(check_output, path, [*kept, *meshes, *earlier], ())
            earlier.append(path)
