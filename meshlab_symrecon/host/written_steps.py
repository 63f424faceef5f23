"""Steps as scripts write them: a filter and its values, in the types that MeshLab reads."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import pymeshlab

from meshlab_symrecon.host.mlx import Param, Step, step_of
from meshlab_symrecon.host.native_values import SPREAD, NativeParameter, checked_value
from meshlab_symrecon.plugin import Filter

if TYPE_CHECKING:
    from meshlab_symrecon.host.native_filters import NativeFilter

__all__ = ["written_step"]

TEXTS = ("RichString", "RichOpenFile", "RichSaveFile")


def written_step(item: Filter | NativeFilter, values: Mapping[str, object]) -> Step:
    """Return a step under its menu name of today, with line 0.

    A filter of ours gets every parameter; one of MeshLab's only those that are given, since its
    other defaults depend on the layer it runs on.

    Parameters
    ----------
    item : Filter or NativeFilter
    values : mapping
        By the names of parameters, in Python or in scripts.

    Raises
    ------
    ParameterError
        Unknown parameter, or a value of the wrong type.
    """
    if isinstance(item, Filter):
        return step_of(item, values)
    given = {}
    for name, value in values.items():
        parameter = item.find(name)
        given[parameter.name] = _native_param(parameter, checked_value(parameter, value))
    return Step(
        item.menu_name,
        0,
        tuple(given[known.name] for known in item.parameters if known.name in given),
    )


def _native_param(parameter: NativeParameter, value: Any) -> Param:
    kind = parameter.rich_type
    text: str | None = None
    attributes: dict[str, str] = {}
    if kind == "RichBool":
        text = "true" if value else "false"
    elif kind == "RichEnum":
        text = str(parameter.words.index(value))
        attributes["enum_cardinality"] = str(len(parameter.words))
        attributes |= {f"enum_val{number}": word for number, word in enumerate(parameter.words)}
    elif kind == "RichAbsPerc":
        text, attributes = _length(value)
    elif kind == "RichColor":
        channels = (value.red(), value.green(), value.blue(), value.alpha())
        attributes = dict(zip(SPREAD[kind], map(str, channels), strict=True))
    elif kind in SPREAD:
        numbers = (repr(float(number)) for number in value.reshape(-1))
        attributes = dict(zip(SPREAD[kind], numbers, strict=True))
    else:
        text = value if kind in TEXTS else repr(value)
    return Param(parameter.script_name, 0, kind, text, attributes | _reader_wants(kind, text))


def _length(value: Any) -> tuple[str, dict[str, str]]:
    """Return a length as scripts keep it: absolute. A percentage is kept as ``5.0%``.

    MeshLab itself drops a length without ``min`` and ``max``, and reads no percentage.
    """
    if isinstance(value, pymeshlab.PercentageValue):
        return f"{value.value()!r}%", {}
    number = float(value.value())
    return repr(number), {"min": repr(min(0.0, number)), "max": repr(max(1.0, 2.0 * number))}


def _reader_wants(kind: str, text: str | None) -> dict[str, str]:
    """Return attributes without which MeshLab's reader drops a parameter."""
    if kind == "RichDynamicFloat":
        number = float(text or 0.0)
        return {"min": repr(min(0.0, number)), "max": repr(max(1.0, number))}
    if kind == "RichOpenFile":
        return {"exts_cardinality": "1", "exts_val0": "*.*"}
    return {"ext": "*.*"} if kind == "RichSaveFile" else {}
