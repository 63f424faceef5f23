"""Parameters of native steps, as scripts of any version write them, matched with those of today."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from meshlab_symrecon.errors import ParameterError
from meshlab_symrecon.host.expressions import modern_expression
from meshlab_symrecon.host.findings import Findings
from meshlab_symrecon.host.mlx import Param, Step
from meshlab_symrecon.host.native_filters import NativeFilter, find_native
from meshlab_symrecon.host.native_values import NativeParameter, parse_native
from meshlab_symrecon.host.old_names import Change, change_of_parameter
from meshlab_symrecon.host.translation import script_name_in_python
from meshlab_symrecon.host.written_values import value_of

__all__ = ["filter_after", "is_idle", "values_of"]

# Parameters that name a layer, and the switch without which that layer is not looked at.
SWITCHED = {"generate_sampling_poisson_disk": {"refinemesh": "refineflag"}}
CAMERA = "RichShotf"
TEXTURE = "textname"
MAKE_TEXTURES = ("compute_texmap_from_color", "transfer_attributes_to_texture_per_vertex")


def values_of(item: NativeFilter, step: Step, written: Param, findings: Findings) -> dict[str, Any]:
    """Return what a written parameter is today: no value, one, or several, by Python names.

    What was mapped or ignored is noted in ``findings``.

    Raises
    ------
    ParameterError
        It is none of the filter's, of today or of older versions, or its value is none.
    """
    try:
        parameter = item.find(written.name)
    except ParameterError:
        name = script_name_in_python(written.name.strip())
        change = change_of_parameter(item.python_name, name)
        if change is None:
            raise
        implied = _implied(item, step, written, change, findings)
        return implied | _changed(item, written, change, findings)
    return _read(item, parameter, written, findings)


def _implied(
    item: NativeFilter, step: Step, written: Param, change: Change, findings: Findings
) -> dict[str, Any]:
    named = (known.text or "" for known in step.parameters
             if script_name_in_python(known.name.strip()) == change.unless_file)  # fmt: skip
    if Path(next(named, "")).is_file():
        return {}
    values = {name: parse_native(item.find(name), text) for name, text in change.also.items()}
    for name, value in values.items():
        meaning = f"'{name}' set to {value!r}, which parameter '{written.name}' stood for"
        findings.note(written.line, meaning)
    return values


def is_idle(item: NativeFilter, step: Step, written: Param) -> bool:
    """Say whether a parameter has no effect: what it names need not be there."""
    switch = SWITCHED.get(item.python_name, {}).get(script_name_in_python(written.name.strip()))
    on = (known.text or "" for known in step.parameters
          if script_name_in_python(known.name.strip()) == switch)  # fmt: skip
    return switch is not None and next(on, "false").strip().lower() in ("false", "0")


def filter_after(item: NativeFilter, step: Step) -> tuple[str, Mapping[str, Any]] | None:
    """Return the filter, and its values, that does today what an old parameter stood for.

    Raises
    ------
    ParameterError
        The value of that parameter is none.
    """
    for written in step.parameters:
        change = change_of_parameter(item.python_name, script_name_in_python(written.name.strip()))
        if change is not None and change.then:
            name, taking = change.then
            parameter = find_native(name).find(taking)
            return name, {parameter.name: value_of(parameter, written)[0]}
    return None


def _read(
    item: NativeFilter, parameter: NativeParameter, written: Param, findings: Findings
) -> dict[str, Any]:
    if parameter.rich_type == CAMERA:
        camera = f"parameter '{written.name}' ignored: pymeshlab takes no camera from outside"
        findings.note(written.line, camera)
        return {}
    value, note = value_of(parameter, written)
    if note:
        findings.note(written.line, note)
    if parameter.name == TEXTURE and item.python_name in MAKE_TEXTURES:
        value = _beside_the_mesh(written, value, findings)
    if _is_expression(item, parameter):
        value = _of_today(written, value, findings)
    return {parameter.name: value}


def _beside_the_mesh(written: Param, path: str, findings: Findings) -> str:
    """Return a picture's name without folders: scripts of strangers must not write just anywhere.

    Raises
    ------
    ParameterError
        It is a folder.
    """
    name = re.split(r"[/\\]", path.strip())[-1]
    if name in (".", "..") or (path.strip() and not name):
        raise ParameterError(f"parameter '{written.name}' must be a picture's name; got {path!r}")
    if name != path.strip():
        words = f"the folder of '{path}' left out: textures are written beside the mesh"
        findings.note(written.line, words)
    return name


def _is_expression(item: NativeFilter, parameter: NativeParameter) -> bool:
    evaluates = any(words in item.python_name for words in ("_by_function", "_by_condition"))
    return parameter.rich_type == "RichString" and (evaluates or parameter.name.endswith("expr"))


def _of_today(written: Param, expression: str, findings: Findings) -> str:
    today = modern_expression(expression)
    if today != expression:
        findings.note(written.line, f"'{expression}' of '{written.name}' is '{today}' today")
    return today


def _changed(
    item: NativeFilter, written: Param, change: Change, findings: Findings
) -> dict[str, Any]:
    """Return the values of today for a parameter of old; say what became of it."""
    if change.factors:
        return _split(item, written, change, findings)
    if change.then:
        words = f"'{find_native(change.then[0]).menu_name}', which runs after this filter"
        findings.note(written.line, f"parameter '{written.name}' is {words}")
        return {}
    if not change.to:
        reason = change.note or f"it is gone from '{item.menu_name}'"
        findings.note(written.line, f"parameter '{written.name}' ignored: {reason}")
        return {}
    parameter = item.find(change.to)
    if not change.values:
        findings.note(written.line, f"parameter '{written.name}' is '{parameter.name}' today")
        return _read(item, parameter, written, findings)
    old = NativeParameter(written.name, written.name, "RichBool")
    word = str(value_of(old, written)[0]).lower()
    text = change.values[word]
    if text is None:
        gone = f"parameter '{written.name}' ignored: '{word}' says nothing today"
        findings.note(written.line, gone)
        return {}
    meaning = f"'{word}' of parameter '{written.name}' is '{text}' of '{parameter.name}' today"
    findings.note(written.line, meaning)
    return {parameter.name: parse_native(parameter, text)}


def _split(
    item: NativeFilter, written: Param, change: Change, findings: Findings
) -> dict[str, Any]:
    parameters = [item.find(name) for name in change.factors]
    number, _ = value_of(parameters[0], written)
    values = {known.name: number * change.factors[known.name] for known in parameters}
    listed = " and ".join(f"'{name}' {value:g}" for name, value in values.items())
    findings.note(written.line, f"parameter '{written.name}' is {listed} today")
    return values
