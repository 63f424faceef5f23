"""One step of an old script as MeshLab writes it today."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import pymeshlab

from meshlab_symrecon.errors import ParameterError
from meshlab_symrecon.host.mlx import Param, Step
from meshlab_symrecon.host.native_filters import NativeFilter
from meshlab_symrecon.host.old_names import NOTHING
from meshlab_symrecon.host.resolution import ResolvedStep
from meshlab_symrecon.host.written_steps import written_step

__all__ = ["as_written", "steps_today", "written_as"]

RANGES = ("RichAbsPerc", "RichDynamicFloat")  # MeshLab drops these without "min" and "max"
CHANGE_NAME = "Change the current layer"


def steps_today(resolved: ResolvedStep) -> tuple[Step | None, Step | None]:
    """Return the step under its name of today, and the one that must follow it today.

    Each is None where there is nothing to do.
    """
    return _step_today(resolved), None if resolved.then is None else _step_today(resolved.then)


def _step_today(resolved: ResolvedStep) -> Step | None:
    if resolved.filter == NOTHING:
        return None
    if isinstance(resolved.filter, str):
        return _change_today(resolved)
    step = written_step(resolved.filter, resolved.values)
    if isinstance(resolved.filter, NativeFilter):
        return _as_it_was(resolved, resolved.filter, step)
    return step


def _change_today(resolved: ResolvedStep) -> Step:
    value = str(resolved.values["mesh"])
    return Step(CHANGE_NAME, 0, (Param("mesh", 0, "RichMesh", value),))


def written_as(resolved: ResolvedStep) -> Mapping[str, Param]:
    """Return the parameters of a native step as they were written, by their Python names.

    Those that have another name today are left out.
    """
    item = resolved.filter
    if not isinstance(item, NativeFilter):
        return {}
    written = resolved.step.parameters
    return {item.find(param.name).name: param for param in written if _is_known(item, param.name)}


def _is_length(param: Param, value: Any) -> bool:
    number = _number(param.text)
    return math.isfinite(number) and pymeshlab.PureValue(number).value() == value.value()


def as_written(value: Any, written: Param | None) -> float:
    """Return a length as it was written: pymeshlab itself keeps lengths in single precision."""
    if written is not None and _is_length(written, value):
        return _number(written.text)
    return float(value.value())


def _as_it_was(resolved: ResolvedStep, item: NativeFilter, step: Step) -> Step:
    """Return the step with what the table does not know: ranges, and names in filters not tried."""
    written = written_as(resolved)
    parameters = []
    for new in step.parameters:
        known = item.find(new.name)
        old = written.get(known.name)
        if old is not None:
            spelt = old.name.strip() if item.probed else new.name
            new = replace(new, name=spelt, **_in_its_range(new, old, resolved.values[known.name]))
        parameters.append(new)
    return replace(step, parameters=tuple(parameters))


def _is_known(item: NativeFilter, name: str) -> bool:
    try:
        item.find(name)
    except ParameterError:
        return False
    return True


def _in_its_range(new: Param, old: Param, value: Any) -> dict[str, Any]:
    """Return text and attributes of a number with a range: the old ones where they are sound."""
    if new.rich_type not in RANGES or isinstance(value, pymeshlab.PercentageValue):
        return {}
    number = as_written(value, old) if isinstance(value, pymeshlab.PureValue) else float(value)
    low, high = _number(old.attributes.get("min")), _number(old.attributes.get("max"))
    if not (low <= number <= high and low < high):
        low, high = min(0.0, number), max(1.0, 2.0 * number)
    return {"text": repr(number), "attributes": {"min": repr(low), "max": repr(high)}}


def _number(text: Any) -> float:
    try:
        number = float(text)
    except (TypeError, ValueError):
        return math.nan  # which is in no range
    return number if math.isfinite(number) else math.nan
