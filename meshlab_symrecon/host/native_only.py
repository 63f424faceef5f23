"""What is left of a script without the filters of plugins."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TypeAlias

import pymeshlab

from meshlab_symrecon.errors import ScriptError
from meshlab_symrecon.host.constant_defaults import constant_defaults
from meshlab_symrecon.host.findings import IGNORE, Findings, check_findings
from meshlab_symrecon.host.mlx import Script
from meshlab_symrecon.host.native_filters import NativeFilter
from meshlab_symrecon.host.old_names import CHANGE_LAYER, NOTHING
from meshlab_symrecon.host.resolution import Matching, ResolvedStep
from meshlab_symrecon.host.upgrade import checked
from meshlab_symrecon.plugin import Filter

__all__ = ["checked_for_the_window", "for_the_window", "without_plugins"]

Before: TypeAlias = Sequence[ResolvedStep | None]  # what stands above a step
DELETE = "delete_current_mesh"
MADE = (
    "in MeshLab's window this deletes the layer that the step above made, which is current there; "
    "delete the other one by hand"
)


def without_plugins(script: Script, matching: Matching) -> Matching:
    """Leave out the steps of plugins, each with a note.

    Raises
    ------
    ScriptError
        It has steps, and none of MeshLab's own is left.
    """
    return _rewritten(script, matching, _native)


def for_the_window(script: Script, matching: Matching) -> Matching:
    """Leave out what a script cannot hold that is to run in MeshLab's window; write out defaults.

    Its window fills in no defaults, so all that depend neither on the layer nor on the
    machine are written.
    Steps of plugins go with a note, since MeshLab ends when it meets a filter it does not know.
    Changes of the current layer, deletions that would meet another layer there, and percentages
    are findings of severity ``ERROR``: without them the script would do something else.

    Raises
    ------
    ScriptError
        It has steps, and none of MeshLab's own is left.
    """
    return _rewritten(script, matching, _in_the_window)


def checked_for_the_window(script: Script, *, lenient: bool = False) -> Matching:
    """Match a script with MeshLab's own filters, and refuse it for its mistakes.

    Raises
    ------
    ScriptError
        As ``checked`` and ``for_the_window``, and for what a script in MeshLab's window cannot
        hold, unless ``lenient``.
    """
    matching = for_the_window(script, checked(script, lenient=lenient))
    check_findings(matching.findings, lenient=lenient)
    return matching


def _rewritten(
    script: Script,
    matching: Matching,
    rule: Callable[[ResolvedStep, Before, Findings], ResolvedStep | None],
) -> Matching:
    findings = Findings(script.path)
    findings.found += matching.findings
    steps: list[ResolvedStep | None] = []
    for number, resolved in enumerate(matching.steps):
        findings.step = number
        before = matching.steps[:number]
        steps.append(None if resolved is None else rule(resolved, before, findings))
    _check_rest(script, steps)
    return Matching(tuple(steps), tuple(sorted(findings.found, key=lambda found: found.step)))


def _check_rest(script: Script, steps: Sequence[ResolvedStep | None]) -> None:
    if steps and not any(step is not None and not isinstance(step.filter, str) for step in steps):
        message = "no step that can run is a filter of MeshLab's own, so nothing is left"
        raise ScriptError(f"{script.path}:1: {message}; run it with 'symrecon run'")


def _native(resolved: ResolvedStep, before: Before, findings: Findings) -> ResolvedStep | None:
    if not isinstance(resolved.filter, Filter):
        return resolved
    message = f"'{resolved.filter.menu_name}' left out: it is no filter of MeshLab's own"
    findings.note(resolved.step.line, message)
    return None


def _is_kept(before: Before) -> bool:
    """Say whether the layer before the last step is still current after it."""
    acted = [step for step in before if step is not None and step.filter != NOTHING]
    return bool(acted) and acted[-1].keeps_current


def _in_the_window(
    resolved: ResolvedStep, before: Before, findings: Findings
) -> ResolvedStep | None:
    native = _native(resolved, before, findings)
    if native is None:
        return None
    line = native.step.line
    if native.filter == CHANGE_LAYER:
        findings.error(line, "MeshLab's scripts cannot change the current layer; click on it")
        return None
    if native.python_name == DELETE and _is_kept(before):
        findings.error(line, MADE)
        return None
    values = dict(native.values)
    for name, value in native.values.items():
        if isinstance(value, pymeshlab.PercentageValue):
            message = f"parameter '{name}' is a percentage, {value.value():g}%; MeshLab's scripts "
            findings.error(line, f"{message}hold lengths only; write the length", IGNORE)
            del values[name]
    if isinstance(native.filter, NativeFilter) and not native.filter.probed:
        values = {**constant_defaults(native.filter.python_name), **values}
        _note_absent(native, native.filter, values, findings)
    return replace(native, values=values)


def _note_absent(
    native: ResolvedStep, item: NativeFilter, values: Mapping[str, object], findings: Findings
) -> None:
    """Say what is not given, for MeshLab's window fills in no defaults of its own."""
    absent = [known.script_name for known in item.parameters if known.name not in values]
    if absent:
        message = f"not given, since chosen when it runs: {', '.join(absent)}; MeshLab's window"
        findings.note(native.step.line, f"{message} may want it")
