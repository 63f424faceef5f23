"""A script tried on a copy of the document, in a child process, before it runs on the document."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

from meshlab_symrecon.host.files import new_document
from meshlab_symrecon.host.isolation import isolated
from meshlab_symrecon.host.meshset import current_identifier
from meshlab_symrecon.host.mlx import Script
from meshlab_symrecon.host.projects import save_project
from meshlab_symrecon.host.script import run_steps
from meshlab_symrecon.host.translation import translated
from meshlab_symrecon.plugin import Progress

__all__ = ["try_script"]


def try_script(mesh_set: Any, script: Script, *, lenient: bool, progress: Progress) -> None:
    """Run a script on a copy; the document itself stays as it is, whatever becomes of the copy.

    Parameters
    ----------
    mesh_set : pymeshlab.MeshSet
    script : Script
    lenient : bool
        As ``run_script``.
    progress : callable

    Raises
    ------
    ScriptError, FileError
        As ``run_script``.
    HostError
        A step crashed; the message names it.
    """
    identifiers = [int(mesh.id()) for mesh in mesh_set]
    with tempfile.TemporaryDirectory(prefix="symrecon-") as folder:
        project = Path(folder, "copy.mlp")
        if identifiers:
            save_project(mesh_set, project)
        current = current_identifier(mesh_set)
        position = identifiers.index(current) if current in identifiers else -1
        isolated(_run_copy, project, position, script, lenient, progress=progress)


def _run_copy(
    project: Path, position: int, script: Script, lenient: bool, *, progress: Progress
) -> None:
    mesh_set = new_document()
    if project.exists():
        progress(0.0, "reading a copy of the document")
        with translated(f"{project} cannot be read"):
            mesh_set.load_project(str(project))
    if position >= 0:
        mesh_set.set_current_mesh([int(mesh.id()) for mesh in mesh_set][position])
    run_steps(mesh_set, script, lenient=lenient, progress=progress)
