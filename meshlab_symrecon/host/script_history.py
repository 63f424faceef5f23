"""The history of a MeshSet as a filter script: loaded, replayed and saved by our own runner.

pymeshlab's own methods pass over what they do not know, cut numbers down to six digits, and may
end the process; nothing of them is used here but the history itself.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from meshlab_symrecon.host import exact_steps, history
from meshlab_symrecon.host.exact_steps import Note, Notes
from meshlab_symrecon.host.findings import check_findings
from meshlab_symrecon.host.mlx import Param, Script, Step, step_of
from meshlab_symrecon.host.mlx_reading import read_script
from meshlab_symrecon.host.mlx_writing import write_script
from meshlab_symrecon.host.native_filters import NativeFilter
from meshlab_symrecon.host.notices import warn_user
from meshlab_symrecon.host.old_names import NOTHING
from meshlab_symrecon.host.resolution import ResolvedStep, matched, resolve_script
from meshlab_symrecon.host.script import ScriptReport, run_steps
from meshlab_symrecon.host.written_steps import written_step
from meshlab_symrecon.plugin import Filter, Progress

__all__ = ["load_script", "recorded_script", "replay", "save_script", "todays_steps"]

LENGTH = "RichAbsPerc"
UNTYPED = "RichString"  # what the native history keeps as it is


def recorded_script(mesh_set: Any) -> Script:
    """Return the steps that ran, or were loaded, on a MeshSet.

    Numbers are exact for steps that ran through this package, or after ``load_plugins``; pymeshlab
    keeps six digits of the others. Numbers of layers are positions, as in every script.
    """
    return exact_steps.exact_script(mesh_set, history.read_history(mesh_set))


def load_script(mesh_set: Any, path: str | Path) -> None:
    """Make the steps of a script the history of a MeshSet; nothing is run.

    What was mapped or ignored is told in warnings, with file and line.

    Raises
    ------
    FileError
        The script cannot be read; the history stays as it was, here and below.
    ScriptError
        It has mistakes, all of which are listed, each with ``file:line:``.
    """
    script = read_script(path)
    matching = matched(script)
    check_findings(matching.findings)
    steps = [one for step in matching.steps if step is not None for one in step.filters]
    history.restore(mesh_set, [_shown(step) for step in steps])
    notes = tuple(Note(_today(step), _noted(step)) for step in steps)
    exact_steps.replace(mesh_set, Notes(script.path, notes))
    for finding in matching.findings:
        warn_user(str(finding))


def replay(mesh_set: Any, progress: Progress | None = None) -> ScriptReport:
    """Run every step of the history again, in order; the history itself stays as it is.

    Raises
    ------
    HostError
        A step holds a camera, which MeshLab cannot read back.
    ScriptError
        A step cannot run, and none has; or a step failed, and the later ones have not run.
    """
    shown = history.read_history(mesh_set)
    history.check_restorable(shown)
    notes = exact_steps.notes_of(mesh_set)
    script = exact_steps.exact_script(mesh_set, shown)
    try:
        return run_steps(mesh_set, script, progress=progress)
    finally:
        history.restore(mesh_set, shown)
        exact_steps.replace(mesh_set, notes)


def save_script(mesh_set: Any, path: str | Path) -> None:
    """Write the history as a script, under the names of today, to the last bit.

    Raises
    ------
    HostError
        A step holds a camera, which MeshLab cannot read back.
    ScriptError
        A step is none that is known, or a text has a character that XML cannot hold.
    FileError
        The file cannot be written.
    """
    shown = history.read_history(mesh_set)
    history.check_restorable(shown)
    script = exact_steps.exact_script(mesh_set, shown)
    write_script(todays_steps(script), path)
    for sentence in exact_steps.lost_between(mesh_set, shown):
        warn_user(sentence)


def todays_steps(script: Script) -> tuple[Step, ...]:
    """Return a script's steps under the names of today; warn of what that changes.

    Raises
    ------
    ScriptError
        As ``resolve_script``.
    """
    steps = []
    for resolved in resolve_script(script):
        where = f"{script.path}:{resolved.step.line}: '{resolved.step.name.strip()}'"
        if resolved.filter == NOTHING:
            warn_user(f"{where} was left out: MeshLab does this by itself today")
            continue
        for step in map(_today, resolved.filters):
            for param in step.parameters:
                if param.rich_type == LENGTH and (param.text or "").endswith("%"):
                    warn_user(f"{where} keeps {param.name}={param.text}, which only we read")
            steps.append(step)
    return tuple(steps)


def _today(resolved: ResolvedStep) -> Step:
    if isinstance(resolved.filter, Filter):
        return step_of(resolved.filter, resolved.values)
    if isinstance(resolved.filter, NativeFilter):
        return written_step(resolved.filter, resolved.values)
    return resolved.step


def _noted(resolved: ResolvedStep) -> Step:
    """Return the step as it was written; of today where what follows is a step of its own."""
    if resolved.then is None:
        return resolved.step
    return replace(_today(resolved), line=resolved.step.line)


def _shown(resolved: ResolvedStep) -> history.Step:
    """Return the step as the native history is to hold it."""
    if isinstance(resolved.filter, Filter):
        return history.plugin_step(resolved.filter, resolved.filter.bind(resolved.values))
    step = _today(resolved)
    return history.Step(step.name, tuple(_attributes(param) for param in step.parameters))


def _attributes(param: Param) -> dict[str, str]:
    written = {"type": param.rich_type or UNTYPED, "name": param.name}
    if param.text is not None:
        written["value"] = param.text
    return written | dict(param.attributes)
