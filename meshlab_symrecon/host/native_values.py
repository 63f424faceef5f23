"""Values of native parameters: checked, and read from text."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import PurePath
from typing import Any

import numpy as np
import pymeshlab

from meshlab_symrecon.errors import ParameterError
from meshlab_symrecon.host.old_names import bare_name
from meshlab_symrecon.plugin.parameters import WORDS_OF_BOOLEANS, chosen_word, shortened

__all__ = ["SPREAD", "NativeParameter", "checked_value", "parse_native", "parsed_number"]

SPREAD = {  # types that keep their value in several attributes
    "RichColor": ("r", "g", "b", "a"),
    "RichPosition": ("x", "y", "z"),
    "RichDirection": ("x", "y", "z"),
    "RichPoint3f": ("x", "y", "z"),
    "RichMatrix44f": tuple(f"val{number}" for number in range(16)),
}
_NUMBERS_IN = {"RichPosition": 3, "RichDirection": 3, "RichPoint3f": 3, "RichMatrix44f": 16}
_LARGEST = 2**31 - 1  # MeshLab's whole numbers have 32 bits
_DECIMAL_COMMA = re.compile(r"([+-]?\d+),(\d+(?:[eE][+-]?\d+)?)")
_WITH_SUFFIX = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)[fF]")


@dataclass(frozen=True, slots=True)
class NativeParameter:
    """A parameter of one of MeshLab's filters.

    Attributes
    ----------
    name, script_name : str
        As Python's keyword (``targetfacenum``), and as scripts write it (``TargetFaceNum``).
    rich_type : str
        Its type in scripts, such as ``RichAbsPerc``.
    words : tuple of str
        The words of a ``RichEnum``, in the order in which scripts number them.
    """

    name: str
    script_name: str
    rich_type: str
    words: tuple[str, ...] = ()


def checked_value(parameter: NativeParameter, value: object) -> Any:
    """Return ``value`` as pymeshlab wants it; a number for a percentage is an absolute length.

    Raises
    ------
    ParameterError
        The value has the wrong type.
    """
    checks: dict[str, Callable[[NativeParameter, Any], Any]] = {
        "RichBool": _boolean,
        "RichInt": _whole,
        "RichMesh": _whole,
        "RichFloat": _number,
        "RichDynamicFloat": _number,
        "RichAbsPerc": _length,
        "RichEnum": _word,
        "RichString": _text,
        "RichOpenFile": _text,
        "RichSaveFile": _text,
        "RichColor": _colour,
    }
    if parameter.rich_type in _NUMBERS_IN:
        return _row(parameter, value)
    if parameter.rich_type not in checks:  # a camera; pymeshlab has no Python type for it
        raise _refusal(parameter, value)
    return checks[parameter.rich_type](parameter, value)


def parse_native(parameter: NativeParameter, text: str) -> Any:
    """Return the value that ``text`` stands for, on a command line or in a script.

    Booleans are ``true``, ``false``, ``1``, ``0``; a choice is its word or its number; positions
    and matrices are 3 or 16 numbers, row by row, with spaces or commas between; a colour is
    ``#rrggbb`` or 3 or 4 numbers up to 255; a percentage is an absolute length, or ends in ``%``.
    Numbers may have a decimal comma, or the ``f`` of C++ at their end.

    Raises
    ------
    ParameterError
        The text does not stand for a value of this parameter.
    """
    trimmed = text.strip()
    kind = parameter.rich_type
    if kind in ("RichString", "RichOpenFile", "RichSaveFile"):
        return text
    if kind == "RichBool":
        if trimmed.lower() not in WORDS_OF_BOOLEANS:
            raise _refusal(parameter, text)
        return WORDS_OF_BOOLEANS[trimmed.lower()]
    try:
        if kind == "RichEnum":
            return _word(parameter, int(trimmed) if re.fullmatch("[0-9]+", trimmed) else trimmed)
        return checked_value(parameter, _parsed_numbers(kind, trimmed))
    except ParameterError:
        raise
    except ValueError as error:
        raise _refusal(parameter, text) from error


def _parsed_numbers(kind: str, text: str) -> object:
    if "_" in text or not text.isascii():  # Python reads 1_000 and digits of every language
        raise ValueError(text)
    if kind == "RichColor" and text.startswith("#"):
        return [int(text[start : start + 2], 16) for start in range(1, len(text), 2)]
    if kind in _NUMBERS_IN or kind == "RichColor":
        return _parsed_row(text.strip("[]() "), _NUMBERS_IN.get(kind, 3))
    if kind == "RichAbsPerc" and text.endswith("%"):
        share = parsed_number(text[:-1].strip())
        if not 0.0 <= share <= 100.0:
            raise ValueError(text)
        return pymeshlab.PercentageValue(share)
    return int(text) if kind in ("RichInt", "RichMesh") else parsed_number(text)


def parsed_number(text: str) -> float:
    """Return the number; it may have a decimal comma, or the ``f`` of C++ at its end.

    Raises
    ------
    ValueError
        It is none.
    """
    comma = _DECIMAL_COMMA.fullmatch(text)
    suffix = _WITH_SUFFIX.fullmatch(text)
    if comma:
        return float(f"{comma[1]}.{comma[2]}")
    return float(suffix[1] if suffix else text)


def _parsed_row(text: str, count: int) -> list[float]:
    """Return numbers with blanks or semicolons between, else with commas between."""
    words = re.split(r"[\s;]+", text)
    if len(words) == count and not any(word.endswith(",") for word in words):
        return [parsed_number(word) for word in words]
    return [float(word) for word in re.split(r"[\s,;]+", text)]


def _plain(value: object) -> object:
    """Return numpy scalars as Python's own."""
    return value.item() if isinstance(value, np.generic) else value


def _boolean(parameter: NativeParameter, value: object) -> bool:
    plain = _plain(value)
    if not isinstance(plain, bool):
        raise _refusal(parameter, value)
    return plain


def _number(parameter: NativeParameter, value: object) -> float:
    plain = _plain(value)
    if isinstance(plain, bool) or not isinstance(plain, (int, float)):
        raise _refusal(parameter, value)
    try:
        number = float(plain)
    except OverflowError as error:  # whole numbers of Python have no largest one
        raise _refusal(parameter, value) from error
    if not math.isfinite(number):
        raise _refusal(parameter, value)
    return number


def _whole(parameter: NativeParameter, value: object) -> int:
    plain = _plain(value)
    if type(plain) is not int:  # an int is not made a float, which would round it
        plain = _number(parameter, value)
    if plain != int(plain) or abs(plain) > _LARGEST:
        raise _refusal(parameter, value)
    return int(plain)


def _length(parameter: NativeParameter, value: object) -> Any:
    if isinstance(value, (pymeshlab.PercentageValue, pymeshlab.PureValue)):
        return value
    return pymeshlab.PureValue(_number(parameter, value))


def _word(parameter: NativeParameter, value: object) -> str:
    word = chosen_word(_plain(value), parameter.words)
    if word is None and isinstance(value, str):
        word = next(
            (known for known in parameter.words if bare_name(known) == bare_name(value)), None
        )
    if word is None:
        raise _refusal(parameter, value)
    return word


def _text(parameter: NativeParameter, value: object) -> str:
    if not isinstance(value, (str, PurePath)):  # pymeshlab itself takes no paths
        raise _refusal(parameter, value)
    return str(value)


def _colour(parameter: NativeParameter, value: object) -> Any:
    if isinstance(value, pymeshlab.Color):
        return value
    try:
        channels = [int(channel) for channel in value]  # type: ignore[attr-defined]
    except (TypeError, ValueError, OverflowError) as error:
        raise _refusal(parameter, value) from error
    if len(channels) not in (3, 4) or not all(0 <= channel <= 255 for channel in channels):
        raise _refusal(parameter, value)
    return pymeshlab.Color(*channels, *([255] if len(channels) == 3 else []))


def _row(parameter: NativeParameter, value: object) -> Any:
    count = _NUMBERS_IN[parameter.rich_type]
    try:
        numbers = np.array(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise _refusal(parameter, value) from error
    if numbers.size != count or not np.isfinite(numbers).all():
        raise _refusal(parameter, value)
    return numbers.reshape((4, 4) if count == 16 else (3,))


def _refusal(parameter: NativeParameter, value: object) -> ParameterError:
    wanted = {
        "RichBool": "true or false",
        "RichInt": "a whole number",
        "RichMesh": "a layer's number",
        "RichFloat": "a number",
        "RichDynamicFloat": "a number",
        "RichAbsPerc": "a length, or a percentage such as 5%",
        "RichEnum": "one of " + ", ".join(repr(word) for word in parameter.words),
        "RichString": "text",
        "RichOpenFile": "a file's path",
        "RichSaveFile": "a file's path",
        "RichColor": "3 or 4 numbers from 0 to 255",
        "RichMatrix44f": "16 numbers, row by row",
    }.get(parameter.rich_type, "3 numbers")
    if parameter.rich_type == "RichShotf":
        wanted = "left out, since pymeshlab takes no camera from Python"
    return ParameterError(f"parameter '{parameter.name}' must be {wanted}; got {shortened(value)}")
