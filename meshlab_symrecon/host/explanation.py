"""A script in words, for somebody who did not write it."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import Any

import numpy as np
import pymeshlab

from meshlab_symrecon.host.cloud_cleaning import EMPTY_CLOUDS
from meshlab_symrecon.host.constant_defaults import constant_defaults
from meshlab_symrecon.host.filter_words import sentence_of
from meshlab_symrecon.host.findings import ERROR, Finding
from meshlab_symrecon.host.mlx import Param, Script, Step
from meshlab_symrecon.host.native_filters import NativeFilter
from meshlab_symrecon.host.native_values import NativeParameter
from meshlab_symrecon.host.old_names import NOTHING
from meshlab_symrecon.host.resolution import Matching, ResolvedStep
from meshlab_symrecon.host.step_of_today import as_written, written_as
from meshlab_symrecon.plugin import Filter
from meshlab_symrecon.plugin.parameters import Kind, Parameter

__all__ = ["explained"]

WIDTH = 80
INDENT = "   "
ORDINALS = ("first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth", "ninth")
EVERY_LAYER = ("alllayers", "toall")


def explained(script: Script, matching: Matching) -> str:
    """Return numbered paragraphs, one a step: what it does, on what, with which values.

    Mistakes stand where they are made.
    """
    count = len(script.steps)
    heading = f"{script.path}: {count} step{'' if count == 1 else 's'}, in this order."
    paragraphs = ["\n".join(_wrapped(heading, ""))]
    for number, resolved in enumerate(matching.steps):
        found = [finding for finding in matching.findings if finding.step == number]
        lines = _paragraph(script.steps[number], resolved)
        lines += [f"Its comment: {' '.join(text.split())}" for text in _comments(script, number)]
        lines += [_said(finding, script.steps[number]) for finding in found]
        title, *rest = lines
        text = [f"{number + 1}. {title}", *(line for one in rest for line in _wrapped(one, INDENT))]
        paragraphs.append("\n".join(text))
    mistakes = sum(finding.severity == ERROR for finding in matching.findings)
    if mistakes:
        words = "mistake, so" if mistakes == 1 else "mistakes, so"
        paragraphs.append("\n".join(_wrapped(f"It has {mistakes} {words} it does not run.", "")))
    return "\n\n".join(paragraphs) + "\n"


def _comments(script: Script, number: int) -> list[str]:
    """Return what the author wrote above a step; below the last one belongs to it, too."""
    below = script.comments.get(number + 1, ()) if number + 1 == len(script.steps) else ()
    return [text for text in (*script.comments.get(number, ()), *below) if text.strip()]


def _wrapped(text: str, indent: str) -> list[str]:
    deeper = indent + ("  " if text.startswith("- ") else "")
    return textwrap.wrap(
        text,
        WIDTH,
        initial_indent=indent,
        subsequent_indent=deeper,
        break_long_words=False,
        break_on_hyphens=False,
    )


def _said(finding: Finding, step: Step) -> str:
    label = "MISTAKE" if finding.severity == ERROR else "Note"
    where = f" (line {finding.line})" if finding.line not in (0, step.line) else ""
    return f"{label}{where}: {' '.join(finding.message.split())}."


def _paragraph(step: Step, resolved: ResolvedStep | None) -> list[str]:
    where = f" (line {step.line})" if step.line else ""
    name = " ".join(step.name.split()) or "A step without a name"
    if resolved is None:
        return [f"{name}{where}", "Does not run."]
    if resolved.filter == NOTHING:
        return [f"{name}{where}", "Does nothing today."]
    if isinstance(resolved.filter, str):
        which = _layer(resolved.values["mesh"])
        return [f"{name}{where}", f"Makes {which} the current layer: the next steps work on it."]
    if isinstance(resolved.filter, Filter):
        return _plugin(resolved, resolved.filter, where)
    return _native(resolved, resolved.filter, where)


def _layer(position: int) -> str:
    """Name a layer by its position; scripts count from 0."""
    if position < len(ORDINALS):
        return f"layer {position} (the {ORDINALS[position]})"
    return f"layer {position} (number {position + 1})"


def _plugin(resolved: ResolvedStep, item: Filter, where: str) -> list[str]:
    declared = item.parameters.declared()
    given = [known for known in declared if known.name in resolved.values]
    lines = [f"{item.menu_name}{where}", f"In Python: {item.python_name}", item.summary]
    lines.append("Works on the current layer.")
    lines += [f"Makes a layer called '{label}'." for label in item.creates]
    if given:
        lines.append("With:")
    lines += [
        f"- {known.name} = {_declared(known, resolved.values[known.name])}: {known.label}"
        for known in given
    ]
    absent = [
        f"{known.name} = {_declared(known, known.default)}"
        for known in declared
        if known.name not in resolved.values
    ]
    if absent:
        lines.append(f"Not given, so left at the defaults: {', '.join(absent)}.")
    return lines


def _declared(known: Parameter, value: Any) -> str:
    if known.kind is Kind.LAYER:
        return _layer(value) if value >= 0 else f"{value}"
    shown = _plain(value)
    return f"{shown} {known.unit}".rstrip() if known.unit else shown


def _native(resolved: ResolvedStep, item: NativeFilter, where: str) -> list[str]:
    written = written_as(resolved)
    lines = [f"{item.menu_name}{where}", f"In Python: {item.python_name}"]
    lines.append(sentence_of(item.python_name))
    lines += _works_on(resolved, item)
    values = resolved.values
    given = [known for known in item.parameters if known.name in values]
    plain = [known for known in given if known.name not in resolved.layers]
    if plain:
        lines.append("With:")
    for known in plain:
        shown = _shown(known, values[known.name], written.get(known.name))
        lines.append(f"- {known.script_name} = {shown}")
    left = [known for known in item.parameters if known.name not in (*values, *written)]
    return lines + _left_to_meshlab(item, left) + _following(resolved.then)


def _following(then: ResolvedStep | None) -> list[str]:
    if then is None or not isinstance(then.filter, NativeFilter):
        return []
    title, *rest = _native(then, then.filter, "")
    return [f"Then, on a layer with faces, runs: {title}", *rest]


def _works_on(resolved: ResolvedStep, item: NativeFilter) -> list[str]:
    values = resolved.values
    lines = []
    if any(values.get(name) is True for name in EVERY_LAYER):
        lines.append("Works on every layer.")
    elif resolved.layers:
        named = [
            f"{_layer(values[known.name])} as {known.script_name}"
            for known in item.parameters
            if known.name in resolved.layers
        ]
        lines.append(f"Works on {' and '.join(named)}.")
    elif not item.python_name.startswith("create_") and "visible" not in item.python_name:
        lines.append("Works on the current layer.")
    if item.python_name in EMPTY_CLOUDS:
        lines.append("A cloud without faces would lose every point, so it is refused for one.")
    if resolved.keeps_current:
        lines.append("That layer stays the current one; what is made is a layer beside it.")
    return lines


def _left_to_meshlab(item: NativeFilter, absent: Sequence[NativeParameter]) -> list[str]:
    constant = constant_defaults(item.python_name)
    defaults = [
        f"{known.script_name} = {_shown(known, constant[known.name], None)}"
        for known in absent
        if known.name in constant
    ]
    layers = [known.script_name for known in absent if known.rich_type == "RichMesh"]
    others = [
        known.script_name
        for known in absent
        if known.name not in constant and known.rich_type not in ("RichMesh", "RichShotf")
    ]
    lines = []
    if defaults:
        lines.append(f"Not given, so left at MeshLab's defaults: {', '.join(defaults)}.")
    if others:
        lines.append(f"Not given, so chosen when it runs: {', '.join(others)}.")
    if layers:
        lines.append(f"Not given, so MeshLab picks the layer: {', '.join(layers)}.")
    return lines


def _shown(known: NativeParameter, value: Any, written: Param | None) -> str:
    if known.rich_type == "RichMesh":
        return _layer(value)
    if isinstance(value, pymeshlab.PercentageValue):
        return f"{value.value():.6g} % of the box's diagonal"
    if isinstance(value, pymeshlab.PureValue):
        length = as_written(value, written)
        return f"{length:.6g}{_share(length, written)}"
    if isinstance(value, pymeshlab.Color):
        channels = (value.red(), value.green(), value.blue())
        opacity = "" if value.alpha() == 255 else f", opacity {value.alpha() / 255:.0%}"
        return f"red {channels[0]}, green {channels[1]}, blue {channels[2]} of 255{opacity}"
    return _plain(value)


def _share(value: float, written: Param | None) -> str:
    """Say what share of its range a length is, where the script has a range that is no stand-in.

    MeshLab writes as the range of a length 0 and the diagonal of the box it was meant for.
    """
    attributes = {} if written is None else written.attributes
    try:
        low, high = float(attributes["min"]), float(attributes["max"])
    except (KeyError, ValueError):
        return ""
    if low != 0.0 or not high > 0.0 or high == max(1.0, 2.0 * value):
        return ""
    return f" ({100.0 * value / high:.3g} % of {high:.6g}, the size it was made for)"


def _plain(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, np.ndarray):
        return _numbers(value)
    return f"'{value}'" if isinstance(value, str) else str(value)


def _numbers(values: Any) -> str:
    if values.ndim == 1:
        return f"({_row(values)})"
    if np.array_equal(values, np.eye(4)):
        return "the matrix that moves nothing"
    return "the matrix with the rows " + ", ".join(f"({_row(row)})" for row in values)


def _row(values: Sequence[float]) -> str:
    return ", ".join(f"{number:.6g}" for number in values)
