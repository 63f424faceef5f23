"""A script on files, from reading them to writing the result."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from meshlab_symrecon.host.files import WRITABLE, check_output, new_document, save_current
from meshlab_symrecon.host.isolation import isolated
from meshlab_symrecon.host.mlx import Script
from meshlab_symrecon.host.projects import PROJECT, files_of, load_input, save_project
from meshlab_symrecon.host.records import record_of
from meshlab_symrecon.host.script import ScriptReport, checked_script, run_steps
from meshlab_symrecon.plugin import Progress

__all__ = ["run_on_files"]


def run_on_files(
    script: Path,
    inputs: Sequence[Path],
    output: Path,
    *,
    strict: bool,
    lenient: bool,
    isolate: bool,
    progress: Progress,
) -> ScriptReport:
    """Run a script on files, and save the current layer, or all layers as a project.

    Parameters
    ----------
    script : Path
    inputs : sequence of Path
        Meshes and projects, whose layers come in this order; the last one is the current one.
        Without any, the script has to make the first layer.
    output : Path
        With the extension ``.mlp``, every layer is saved beside the project.
    strict, lenient : bool
        As ``run_script``.
    isolate : bool
        Work in a child process, whose crash is an error.
    progress : callable

    Raises
    ------
    FileError
        A file cannot be read or written.
    ScriptError
        As ``run_script``; nothing was written.
    HostError
        A step crashed in the child process; nothing was written.
    """
    kept = [script, *(file for path in inputs for file in files_of(path))]
    check_output(output, kept, (*WRITABLE, PROJECT))
    # Before reading inputs, which is long; and once only, since a script may come through a pipe.
    steps = checked_script(script, strict=strict, lenient=lenient)
    job = (steps, tuple(inputs), tuple(kept), output, strict, lenient)
    if not isolate:
        return _done(*job, progress=progress)
    report: ScriptReport = isolated(_done, *job, progress=progress, folders=[output.parent])
    return report


def _done(
    script: Script,
    inputs: Sequence[Path],
    kept: Sequence[Path],
    output: Path,
    strict: bool,
    lenient: bool,
    *,
    progress: Progress,
) -> ScriptReport:
    mesh_set = new_document()
    for path in inputs:
        progress(0.0, f"reading {path}")
        load_input(path, mesh_set)
    report = run_steps(mesh_set, script, strict=strict, lenient=lenient, progress=progress)
    progress(1.0, f"writing {output}")
    record = record_of(mesh_set, kept[1:])  # all but the script
    if output.suffix.lower() == f".{PROJECT}":
        save_project(mesh_set, output, kept, record=record)
    else:
        save_current(mesh_set, output, record)
    return report
