"""The steps of a script, matched with filters and checked, before anything runs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from meshlab_symrecon.errors import ParameterError, ScriptError
from meshlab_symrecon.host.current_layer import KEPT, MADE, current_is_kept, current_was_kept
from meshlab_symrecon.host.filter_names import find_any, find_listed, known_today
from meshlab_symrecon.host.findings import IGNORE, NOTE, Finding, Findings, check_findings
from meshlab_symrecon.host.guards import check_display
from meshlab_symrecon.host.mlx import Param, Script, Step, same_name
from meshlab_symrecon.host.native_filters import NativeFilter, find_native
from meshlab_symrecon.host.native_values import NativeParameter, parse_native
from meshlab_symrecon.host.old_names import CHANGE_LAYER, NOTHING, OldName, find_old_name
from meshlab_symrecon.host.translation import script_name_in_python
from meshlab_symrecon.host.written_parameters import filter_after, is_idle, values_of
from meshlab_symrecon.host.written_steps import written_step
from meshlab_symrecon.host.written_values import LAYER, value_of
from meshlab_symrecon.plugin import Filter
from meshlab_symrecon.plugin.parameters import Kind
from meshlab_symrecon.plugin.registry import plain_name

__all__ = ["Matching", "ResolvedStep", "find_any", "matched", "resolve_script"]


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
    keeps_current : bool
        The layer that it works on stays the current one, whatever layer it makes.
    then : ResolvedStep or None
        A filter of MeshLab's that runs after it, for what an old parameter did; it looks at faces,
        so nothing is left for it to do on a layer without any.
    """

    step: Step
    filter: Filter | NativeFilter | str
    values: Mapping[str, Any] = field(default_factory=dict)
    layers: tuple[str, ...] = ()
    notes: tuple[Finding, ...] = ()
    keeps_current: bool = False
    then: ResolvedStep | None = None

    @property
    def python_name(self) -> str:
        """The filter's name today."""
        return self.filter if isinstance(self.filter, str) else self.filter.python_name

    @property
    def filters(self) -> tuple[ResolvedStep, ...]:
        """The step, and what runs after it, where something does."""
        return (self,) if self.then is None else (self, self.then)


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

    Mistakes are unknown filters or parameters, steps or parameters without a name, parameters given
    twice with different values, values of the wrong type, files that are not there, filters that
    need a window.
    """
    findings = Findings(script.path)
    steps: list[ResolvedStep | None] = []
    for number, step in enumerate(script.steps):
        findings.step = number
        steps.append(None)
        with findings.at(step.line):
            steps[-1] = _resolved(_sound(step, findings), findings)
    names = ["" if step is None else step.python_name for step in steps]
    found = [
        None if step is None else _with_current(step, names, number, findings)
        for number, step in enumerate(steps)
    ]
    ordered = sorted(findings.found, key=lambda finding: (finding.step, finding.line))
    return Matching(tuple(_with_notes(found, ordered)), tuple(ordered))


def _with_current(
    resolved: ResolvedStep, names: Sequence[str], number: int, findings: Findings
) -> ResolvedStep:
    """Decide which layer is current after a step; see ``current_layer``."""
    findings.step = number
    if current_is_kept(names, number):
        findings.note(resolved.step.line, KEPT)
        return replace(resolved, keeps_current=True)
    if current_was_kept(resolved.python_name, resolved.step):
        findings.note(resolved.step.line, MADE)
    return resolved


def _with_notes(
    steps: Sequence[ResolvedStep | None], findings: Sequence[Finding]
) -> Iterator[ResolvedStep | None]:
    for number, step in enumerate(steps):
        notes = (found for found in findings if (found.step, found.severity) == (number, NOTE))
        yield None if step is None else replace(step, notes=tuple(notes))


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


def _sound(step: Step, findings: Findings) -> Step:
    """Return a step without parameters that have no name, or were given another value before.

    Raises
    ------
    ScriptError
        The step itself has no name.
    """
    kept: list[Param] = []
    for param in step.parameters:
        with findings.at(param.line, IGNORE):
            if not param.name.strip():
                raise ScriptError('this parameter has no name; write name="..."')
            if any(same_name(param.name, known.name) for known in kept):
                message = f"parameter '{param.name}' is given twice, with different values"
                raise ScriptError(f"{message}; keep one")
            kept.append(param)
    if not step.name.strip():
        tag = "xmlfilter" if step.from_xml_plugin else "filter"
        raise ScriptError(f'this <{tag}> has no name; write name="..."')
    return step if len(kept) == len(step.parameters) else replace(step, parameters=tuple(kept))


def _resolved(step: Step, findings: Findings) -> ResolvedStep | None:
    known = known_today(step.name)
    old = None if known is not None else find_old_name(step.name)
    if old is not None and old.filter == NOTHING:
        findings.note(step.line, "MeshLab does this by itself today")
        return ResolvedStep(step, NOTHING)
    if old is not None and old.filter == CHANGE_LAYER:
        return _resolved_change(step, findings)
    item = known
    if item is None:
        item = find_listed(step.name) if old is None else find_native(_successor(step, old))
    if isinstance(item, Filter):
        return _resolved_plugin(step, item, findings)
    return _resolved_native(step, item, old, findings)


def _successor(step: Step, old: OldName) -> str:
    """Return the filter that an old one became; a parameter may decide."""
    if not old.by:
        return old.filter
    choice = NativeParameter(old.by, old.by, "RichEnum", tuple(old.words))
    for written in step.parameters:
        if script_name_in_python(written.name.strip()) == old.by:
            return old.words[value_of(choice, written)[0]]
    return next(iter(old.words.values()))


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
    if plain_name(step.name) not in (plain_name(item.menu_name), item.python_name):
        findings.note(step.line, f"'{step.name.strip()}' is '{item.menu_name}' today")
    for name, text in ({} if old is None else old.values).items():
        values[name] = parse_native(item.find(name), text)
        meaning = f"'{name}' set to {values[name]!r}, which the old name stood for"
        findings.note(step.line, meaning)
    for written in step.parameters:
        with findings.at(written.line, IGNORE):
            if not is_idle(item, step, written):
                values |= values_of(item, step, written, findings)
    then = None
    with findings.at(step.line, IGNORE):
        then = _resolved_after(item, step)
    layers = (known.name for known in item.parameters if known.rich_type == LAYER)
    named = tuple(name for name in layers if name in values)
    return ResolvedStep(step, item, values, named, then=then)


def _resolved_after(item: NativeFilter, step: Step) -> ResolvedStep | None:
    after = filter_after(item, step)
    if after is None:
        return None
    name, values = after
    follower = find_native(name)
    return ResolvedStep(replace(written_step(follower, values), line=step.line), follower, values)


def _resolved_change(step: Step, findings: Findings) -> ResolvedStep | None:
    findings.remark(step.line, "the current layer changes, by position")
    before = findings.errors
    target = NativeParameter("mesh", "mesh", LAYER)
    values = {}
    for written in step.parameters:
        with findings.at(written.line):
            if written.name.strip().lower() not in ("mesh", "layer"):
                message = f"unknown parameter '{written.name}' of '{step.name.strip()}'"
                raise ParameterError(f"{message}; known is 'mesh'")
            values[target.name] = value_of(target, written)[0]
    if not step.parameters:
        raise ParameterError(f"'{step.name.strip()}' needs the parameter 'mesh'; got none")
    if findings.errors > before:
        return None
    return ResolvedStep(step, CHANGE_LAYER, values, (target.name,))
