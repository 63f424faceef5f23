"""What is left of a script without the filters of plugins."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TypeAlias

import pymeshlab

from meshlab_symrecon.errors import ScriptError
from meshlab_symrecon.host.findings import ERROR, IGNORE, NOTE, SKIP, Finding, check_findings
from meshlab_symrecon.host.mlx import Script
from meshlab_symrecon.host.old_names import CHANGE_LAYER
from meshlab_symrecon.host.resolution import Matching, ResolvedStep
from meshlab_symrecon.host.step_of_today import kept_current
from meshlab_symrecon.host.upgrade import checked
from meshlab_symrecon.plugin import Filter

__all__ = ["checked_for_the_window", "for_the_window", "without_plugins"]

Say: TypeAlias = Callable[[str, str, str], None]  # severity, message, remedy


def without_plugins(script: Script, matching: Matching) -> Matching:
    """Leave out the steps of plugins, each with a note.

    Raises
    ------
    ScriptError
        No step of MeshLab's own is left.
    """
    return _rewritten(script, matching, _native)


def for_the_window(script: Script, matching: Matching) -> Matching:
    """Leave out what a script cannot hold that is to run in MeshLab's window.

    Steps of plugins go with a note, since MeshLab ends when it meets a filter it does not know.
    Changes of the current layer and percentages are findings of severity ``ERROR``: without them
    the script would do something else.

    Raises
    ------
    ScriptError
        No step of MeshLab's own is left.
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
    rule: Callable[[ResolvedStep, Say], ResolvedStep | None],
) -> Matching:
    found = list(matching.findings)
    steps: list[ResolvedStep | None] = []
    for number, resolved in enumerate(matching.steps):
        if resolved is None:
            steps.append(None)
            continue
        line = resolved.step.line

        def say(
            severity: str, message: str, remedy: str, line: int = line, number: int = number
        ) -> None:
            found.append(Finding(str(script.path), line, message, severity, remedy, number))

        steps.append(rule(resolved, say))
    _check_rest(script, matching, steps)
    return Matching(tuple(steps), tuple(sorted(found, key=lambda finding: finding.step)))


def _check_rest(script: Script, matching: Matching, steps: list[ResolvedStep | None]) -> None:
    if not any(step is not None and not isinstance(step.filter, str) for step in steps):
        count = len(matching.steps)
        message = f"none of the {count} steps is a filter of MeshLab's own, so nothing is left"
        raise ScriptError(f"{script.path}:1: {message}; run it with 'symrecon run'")


def _native(resolved: ResolvedStep, say: Say) -> ResolvedStep | None:
    if not isinstance(resolved.filter, Filter):
        return resolved
    say(NOTE, f"'{resolved.filter.menu_name}' left out: it is no filter of MeshLab's own", "")
    return None


def _in_the_window(resolved: ResolvedStep, say: Say) -> ResolvedStep | None:
    native = _native(resolved, say)
    if native is None:
        return None
    if native.filter == CHANGE_LAYER:
        say(ERROR, "MeshLab's scripts cannot change the current layer; click on it", SKIP)
        return None
    values = dict(native.values)
    for name, value in native.values.items():
        if isinstance(value, pymeshlab.PercentageValue):
            message = f"parameter '{name}' is a percentage, {value.value():g}%; MeshLab's scripts "
            say(ERROR, f"{message}hold lengths only; write the length", IGNORE)
            del values[name]
    if not kept_current(native):
        return replace(native, values=values)
    say(NOTE, "the surface becomes the current layer, as MeshLab does it today", "")
    step = replace(native.step, from_xml_plugin=False, upgraded=False)
    return replace(native, step=step, values=values)
