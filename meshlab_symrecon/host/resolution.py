"""The steps of a script, matched with filters and checked, before anything runs."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from meshlab_symrecon.errors import ParameterError, UnknownFilterError
from meshlab_symrecon.host.findings import IGNORE, NOTE, Finding, Findings, check_findings
from meshlab_symrecon.host.guards import check_display
from meshlab_symrecon.host.mlx import Param, Script, Step
from meshlab_symrecon.host.native_filters import (
    NativeFilter,
    find_native,
    is_native,
    native_filters,
)
from meshlab_symrecon.host.native_values import SPREAD, NativeParameter, parse_native
from meshlab_symrecon.host.old_names import (
    CHANGE_LAYER,
    NOTHING,
    OldName,
    current_parameter,
    find_old_name,
)
from meshlab_symrecon.host.steps import find_filter, registry
from meshlab_symrecon.plugin import Filter
from meshlab_symrecon.plugin.parameters import Kind, nearest_names

__all__ = ["Matching", "ResolvedStep", "find_any", "matched", "resolve_script"]

CAMERA, LAYER, INPUT_FILE = "RichShotf", "RichMesh", "RichOpenFile"
WHOLE = ("RichInt", "RichMesh", "RichEnum")
WHOLE_AS_FRACTION = re.compile(r"[+-]?\d+\.0*")  # old scripts write whole numbers like this


@dataclass(frozen=True, slots=True)
class ResolvedStep:
    """A step that can run.

    Attributes
    ----------
    step : Step
        As it was written.
    filter : Filter, NativeFilter or str
        What runs; a str is one of ``NOTHING`` and ``CHANGE_LAYER``.
    values : mapping of str to value
        By Python names.
    layers : tuple of str
        Which of the values are positions of layers, to be mapped when the step runs.
    notes : tuple of Finding
        What was mapped or ignored, and why.
    """

    step: Step
    filter: Filter | NativeFilter | str
    values: Mapping[str, Any] = field(default_factory=dict)
    layers: tuple[str, ...] = ()
    notes: tuple[Finding, ...] = ()

    @property
    def python_name(self) -> str:
        """The filter's name today."""
        return self.filter if isinstance(self.filter, str) else self.filter.python_name


@dataclass(frozen=True, slots=True)
class Matching:
    """A script beside the filters that are there today.

    Attributes
    ----------
    steps : tuple of ResolvedStep or None
        In the order of the script; None where a step cannot run. Parameters with a mistake are
        left out of ``values``.
    findings : tuple of Finding
        Mistakes and notes, in the order of the lines.
    """

    steps: tuple[ResolvedStep | None, ...]
    findings: tuple[Finding, ...]


def matched(script: Script) -> Matching:
    """Match every step and parameter of a script with what is there today.

    Mistakes are unknown filters or parameters, values of the wrong type, files that are not there,
    filters that need a window.
    """
    findings = Findings(script.path)
    steps: list[ResolvedStep | None] = []
    for number, step in enumerate(script.steps):
        findings.step = number
        steps.append(None)
        with findings.at(step.line):
            steps[-1] = _with_notes(_resolved(step, findings), findings)
    return Matching(tuple(steps), tuple(findings.found))


def _with_notes(resolved: ResolvedStep, findings: Findings) -> ResolvedStep:
    of_step = (finding for finding in findings.found if finding.step == findings.step)
    notes = tuple(finding for finding in of_step if finding.severity == NOTE)
    return replace(resolved, notes=notes)


def resolve_script(script: Script) -> tuple[ResolvedStep, ...]:
    """Match a script that has no mistakes.

    Raises
    ------
    ScriptError
        All mistakes, one a line, each with ``file:line:``.
    """
    matching = matched(script)
    check_findings(matching.findings)
    return tuple(step for step in matching.steps if step is not None)


def find_any(name: str) -> Filter | NativeFilter:
    """Return the filter with that name: a plugin's first, then MeshLab's own.

    Raises
    ------
    UnknownFilterError
        There is none; the message carries the nearest name of all.
    PluginError
        It is that of a plugin that could not be loaded.
    """
    if name in registry():
        return registry().find(name)
    if is_native(name):
        return find_native(name)
    try:
        return find_filter(name)
    except UnknownFilterError as error:
        known = [known for item in registry() for known in item.names]
        for item in native_filters().values():
            known += [item.python_name, item.menu_name]
        hint = nearest_names(name, known) or "; 'symrecon filters --all' lists them"
        raise UnknownFilterError(f"no filter is called '{name}'{hint}") from error


def _resolved(step: Step, findings: Findings) -> ResolvedStep:
    known = step.name in registry() or is_native(step.name)
    old = None if known else find_old_name(step.name)
    if old is not None and old.filter == NOTHING:
        findings.note(step.line, "MeshLab does this by itself today")
        return ResolvedStep(step, NOTHING)
    if old is not None and old.filter == CHANGE_LAYER:
        return _resolved_change(step, findings)
    item = find_any(step.name if old is None else old.filter)
    if isinstance(item, Filter):
        return _resolved_plugin(step, item, findings)
    return _resolved_native(step, item, old, findings)


def _resolved_plugin(step: Step, item: Filter, findings: Findings) -> ResolvedStep:
    values: dict[str, Any] = {}
    layers = []
    before = findings.errors
    for written in step.parameters:
        with findings.at(written.line, IGNORE):
            known = item.find(written.name)
            if written.text is None:
                raise ParameterError(f"parameter '{written.name}' has no value")
            values[known.name] = known.parse(written.text)
            if known.kind is Kind.LAYER and values[known.name] >= 0:
                layers.append(known.name)
    if findings.errors == before:
        item.bind(values)
    return ResolvedStep(step, item, values, tuple(layers))


def _resolved_native(
    step: Step, item: NativeFilter, old: OldName | None, findings: Findings
) -> ResolvedStep:
    check_display(item)
    values: dict[str, Any] = {}
    layers = []
    if old is not None:
        findings.note(step.line, f"'{step.name.strip()}' is '{item.menu_name}' today")
    for name, text in ({} if old is None else old.values).items():
        values[name] = parse_native(item.find(name), text)
        meaning = f"'{name}' set to {values[name]!r}, which the old name stood for"
        findings.note(step.line, meaning)
    for written in step.parameters:
        with findings.at(written.line, IGNORE):
            parameter = _native_parameter(item, written, old, findings)
            if parameter is None:
                continue
            values[parameter.name] = _native_value(parameter, written)
            if parameter.rich_type == LAYER:
                layers.append(parameter.name)
    return ResolvedStep(step, item, values, tuple(layers))


def _native_parameter(
    item: NativeFilter, written: Param, old: OldName | None, findings: Findings
) -> NativeParameter | None:
    """Return what a written parameter is today; None, and a note, when it is to be ignored."""
    try:
        parameter = item.find(written.name)
    except ParameterError:
        name = current_parameter(old, written.name)
        if name is None:
            raise
        if not name:
            gone = f"parameter '{written.name}' ignored: it is gone from '{item.menu_name}'"
            findings.note(written.line, gone)
            return None
        parameter = item.find(name)
        findings.note(written.line, f"parameter '{written.name}' is '{name}' today")
    if parameter.rich_type == CAMERA:
        camera = f"parameter '{written.name}' ignored: pymeshlab takes no camera from outside"
        findings.note(written.line, camera)
        return None
    return parameter


def _native_value(parameter: NativeParameter, written: Param) -> Any:
    text = written.text
    if text is None:
        names = SPREAD.get(parameter.rich_type, ("value",))
        absent = [name for name in names if name not in written.attributes]
        if parameter.rich_type == "RichColor" and absent == ["a"]:
            names, absent = names[:3], []
        if absent:
            message = f"parameter '{written.name}' has no attribute '{absent[0]}'; write all of "
            raise ParameterError(message + ", ".join(names))
        text = " ".join(written.attributes[name] for name in names)
    if parameter.rich_type in WHOLE and WHOLE_AS_FRACTION.fullmatch(text.strip()):
        text = text.partition(".")[0]
    value = parse_native(parameter, text)
    if parameter.rich_type == LAYER and value < 0:
        raise ParameterError(f"parameter '{written.name}' must be a layer's position; got {value}")
    if parameter.rich_type == INPUT_FILE and not Path(value).is_file():
        raise ParameterError(f"parameter '{written.name}' names no file; got {value!r}")
    return value


def _resolved_change(step: Step, findings: Findings) -> ResolvedStep:
    findings.note(step.line, "the current layer changes, by position")
    target = NativeParameter("mesh", "mesh", LAYER)
    values = {}
    for written in step.parameters:
        with findings.at(written.line):
            if written.name.strip().lower() != target.name:
                message = f"unknown parameter '{written.name}' of '{step.name.strip()}'"
                raise ParameterError(f"{message}; known is 'mesh'")
            values[target.name] = _native_value(target, written)
    if not step.parameters:
        raise ParameterError(f"'{step.name.strip()}' needs the parameter 'mesh'; got none")
    return ResolvedStep(step, CHANGE_LAYER, values, (target.name,))
