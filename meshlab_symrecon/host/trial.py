"""A script tried on a copy of the document, in a child process, before it runs on the document."""

from __future__ import annotations

import tempfile
import warnings
from contextlib import suppress
from pathlib import Path
from typing import Any

from meshlab_symrecon.errors import FileError, SymReconError, SymReconWarning
from meshlab_symrecon.host.files import new_document
from meshlab_symrecon.host.isolation import isolated
from meshlab_symrecon.host.meshset import current_identifier
from meshlab_symrecon.host.mlx import Script
from meshlab_symrecon.host.notices import warn_user
from meshlab_symrecon.host.project_files import read_project
from meshlab_symrecon.host.projects import load_layers, save_project
from meshlab_symrecon.host.script import run_steps
from meshlab_symrecon.host.translation import translated
from meshlab_symrecon.plugin import Progress

__all__ = ["try_script"]


def try_script(mesh_set: Any, script: Script, *, lenient: bool, progress: Progress) -> None:
    """Run a script on a copy; the document itself stays as it is, whatever becomes of the copy.

    Only a crash counts. A copy may lack something, such as rasters, so an error there is no error:
    the real run tells what is wrong, and what the copy would warn of.

    Parameters
    ----------
    mesh_set : pymeshlab.MeshSet
    script : Script
    lenient : bool
        As ``run_script``.
    progress : callable

    Raises
    ------
    HostError
        A step crashed; the message names it.

    Warns
    -----
    SymReconWarning
        No copy could be made, so nothing was tried.
    """
    identifiers = [int(mesh.id()) for mesh in mesh_set]
    with tempfile.TemporaryDirectory(prefix="symrecon-") as folder:
        project = Path(folder, "copy.mlp")
        current = current_identifier(mesh_set)
        position = identifiers.index(current) if current in identifiers else -1
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SymReconWarning)
            problem = _saved(mesh_set, project) if identifiers else ""
            if not problem:
                problem = isolated(_run_copy, project, position, script, lenient, progress=progress)
    if problem:
        warn_user(f"{script.path}: it was not tried on a copy of the document: {problem}")


def _saved(mesh_set: Any, project: Path) -> str:
    """Save every layer; return why that failed, or nothing."""
    try:
        save_project(mesh_set, project)
    except FileError as error:
        return str(error)
    return ""


def _run_copy(
    project: Path, position: int, script: Script, lenient: bool, *, progress: Progress
) -> str:
    """Run a script on a saved document; return why that cannot be read, or nothing."""
    mesh_set = new_document()
    if project.exists():
        progress(0.0, "reading a copy of the document")
        try:
            mesh_set = _read(project)
        except SymReconError as error:
            return str(error)
    if position >= 0:
        mesh_set.set_current_mesh([int(mesh.id()) for mesh in mesh_set][position])
    with suppress(SymReconError):
        run_steps(mesh_set, script, lenient=lenient, progress=progress)
    return ""


def _read(project: Path) -> Any:
    """Return a document with all that its layers had; with less where one of them is empty."""
    mesh_set = new_document()
    try:
        load_layers(read_project(project), mesh_set)
    except FileError:
        mesh_set = new_document()
        with translated(f"{project} cannot be read"):
            mesh_set.load_project(str(project))
    with translated(f"the selections in {project} cannot be read"):
        _count_selections(mesh_set)
    return mesh_set


def _count_selections(mesh_set: Any) -> None:
    """Let MeshLab count what is selected: reading a file it does not, and filters go by that."""
    for mesh in mesh_set:
        if mesh.selected_vertex_number() or mesh.selected_face_number():
            mesh_set.set_current_mesh(mesh.id())
            for _ in range(2):
                mesh_set.apply_selection_inverse(invfaces=True, invverts=True)
