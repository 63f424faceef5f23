"""The values that a step ran with, as plain data: what records and reports tell."""

from __future__ import annotations

import math
import re
from typing import Any

from meshlab_symrecon.host.mlx import Param, Step
from meshlab_symrecon.host.native_values import SPREAD
from meshlab_symrecon.host.translation import script_name_in_python

__all__ = ["recorded_values"]

FILES = ("RichOpenFile", "RichSaveFile")
WHOLE = ("RichInt", "RichMesh", "RichEnum")
REAL = ("RichFloat", "RichAbsPerc", "RichDynamicFloat", "RichPercentage")


def recorded_values(step: Step, *, folders: bool) -> dict[str, Any]:
    """Return a step's parameters by their Python names, as Python has them.

    Choices are their words, positions and colours lists of numbers, lengths absolute, layers
    positions; a number that is not finite is a text.

    Parameters
    ----------
    step : Step
        As it is written in full.
    folders : bool
        Tell the folders of files, too.
    """
    return {script_name_in_python(param.name): _value(param, folders) for param in step.parameters}


def _value(param: Param, folders: bool) -> Any:
    text = param.text
    if text is None:
        names = SPREAD.get(param.rich_type, tuple(param.attributes))
        return [_number(param.attributes.get(name, "")) for name in names]
    if param.rich_type in FILES:
        return text if folders else re.split(r"[\\/]", text)[-1]
    if param.rich_type == "RichBool":
        return text == "true"
    if param.rich_type == "RichEnum":
        return param.attributes.get(f"enum_val{text}", _number(text))
    return _number(text) if param.rich_type in (*WHOLE, *REAL) else text


def _number(text: str) -> int | float | str:
    for kind in (int, float):
        try:
            number = kind(text)
        except ValueError:
            continue
        return number if math.isfinite(number) else text
    return text
