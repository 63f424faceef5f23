"""Filter scripts on a MeshSet: everything is checked first, then the steps run one by one.

pymeshlab's own runner passes over what it does not know, cuts floats down to six digits and may
end the process; nothing of it is used here.
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from meshlab_symrecon.errors import ParameterError, ScriptError, SymReconError
from meshlab_symrecon.host.guards import reason_to_skip
from meshlab_symrecon.host.meshset import current_identifier
from meshlab_symrecon.host.mlx import read_script
from meshlab_symrecon.host.native_filters import apply_native
from meshlab_symrecon.host.old_names import CHANGE_LAYER, POISSON
from meshlab_symrecon.host.resolution import ResolvedStep, resolve_script
from meshlab_symrecon.host.steps import run_filter
from meshlab_symrecon.plugin import Filter, Progress
from meshlab_symrecon.plugin.filter import silent

__all__ = ["ScriptReport", "StepReport", "run_script"]


@dataclass(frozen=True, slots=True)
class StepReport:
    """What became of one step.

    Attributes
    ----------
    file, line : str, int
        Where it is written.
    name : str
        As it was written.
    filter : str
        Python name of the filter it became.
    status : str
        ``ran``, or ``mapped`` when it ran otherwise than it was written.
    notes : tuple of str
        What was mapped or ignored and why, and what the filter warned of.
    seconds : float
    measures : mapping
        What the filter returned.
    """

    file: str
    line: int
    name: str
    filter: str
    status: str
    notes: tuple[str, ...] = ()
    seconds: float = 0.0
    measures: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class ScriptReport:
    """What became of a script."""

    script: str
    steps: tuple[StepReport, ...]
    seconds: float


def run_script(
    mesh_set: Any, path: str | Path, *, progress: Progress | None = None
) -> ScriptReport:
    """Check a whole script, then run it step by step.

    Parameters
    ----------
    mesh_set : pymeshlab.MeshSet
    path : str or Path
        Numbers of layers in it are positions, counted from 0 when the step runs.
    progress : callable, optional
        Called with a fraction 0..1 of the whole script, and a message.

    Raises
    ------
    FileError
        The script cannot be read.
    ScriptError
        It has mistakes, all of which are listed and nothing has run; or a step failed, after which
        the later ones do not run.
    """
    report = progress or silent
    started = time.perf_counter()
    script = read_script(path)
    steps = resolve_script(script)
    reports = []
    for number, resolved in enumerate(steps):
        report(number / len(steps), resolved.step.name.strip())
        share = _share(report, number, len(steps))
        reports.append(_run(mesh_set, script.path, resolved, share))
    report(1.0, "done")
    return ScriptReport(str(script.path), tuple(reports), time.perf_counter() - started)


def _share(progress: Progress, number: int, count: int) -> Progress:
    return lambda fraction, message: progress((number + fraction) / count, message)


def _run(mesh_set: Any, path: Path, resolved: ResolvedStep, progress: Progress) -> StepReport:
    step = resolved.step
    notes = [*resolved.notes]
    started = time.perf_counter()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            measures = _applied(mesh_set, resolved, notes, progress)
        except SymReconError as error:
            raise ScriptError(f"{path}:{step.line}: {_named(resolved, error)}") from error
    mapped = bool(notes)
    for warning in caught:
        notes.append(str(warning.message))
        warnings.warn_explicit(warning.message, warning.category, warning.filename, warning.lineno)
    return StepReport(
        str(path), step.line, step.name, resolved.python_name, "mapped" if mapped else "ran",
        tuple(notes), time.perf_counter() - started, measures,
    )  # fmt: skip


def _named(resolved: ResolvedStep, error: SymReconError) -> str:
    """Return the error's words, with the name of the step unless they have it."""
    name = resolved.step.name.strip()
    words = str(error)
    return words if name in words else f"'{name}': {words}"


def _applied(
    mesh_set: Any, resolved: ResolvedStep, notes: list[str], progress: Progress
) -> Mapping[str, Any]:
    values = dict(resolved.values)
    for name in resolved.layers:
        values[name] = _identifier_at(mesh_set, name, values[name])
    if isinstance(resolved.filter, Filter):
        return run_filter(mesh_set, resolved.filter, values, progress)
    if isinstance(resolved.filter, str):
        if resolved.filter == CHANGE_LAYER:
            mesh_set.set_current_mesh(values["mesh"])
        return {}
    name = resolved.filter.python_name
    reason = reason_to_skip(mesh_set, resolved.filter)
    if reason:
        notes.append(f"nothing was done: {reason}")
        return {}
    before = current_identifier(mesh_set)
    measures = apply_native(mesh_set, name, values)
    if resolved.step.from_xml_plugin and name == POISSON:
        mesh_set.set_current_mesh(before)
        notes.append("the cloud stays the current layer, as in the MeshLab of such scripts")
    return measures


def _identifier_at(mesh_set: Any, parameter: str, position: int) -> int:
    """Return the identifier of the layer at a position: scripts count, MeshLab numbers."""
    identifiers = [int(mesh.id()) for mesh in mesh_set]
    if position >= len(identifiers):
        message = (
            f"parameter '{parameter}' must be the position of a layer, counted from 0; "
            f"got {position}; the document has {len(identifiers)} layers at this step"
        )
        raise ParameterError(message)
    return identifiers[position]
