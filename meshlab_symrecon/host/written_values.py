"""Values of native parameters, read from how old and new scripts write them."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from meshlab_symrecon.errors import ParameterError
from meshlab_symrecon.host.mlx import Param
from meshlab_symrecon.host.native_values import (
    SPREAD,
    NativeParameter,
    parse_native,
    parsed_number,
)
from meshlab_symrecon.host.old_names import bare_name

__all__ = ["LAYER", "value_of"]

LAYER, INPUT_FILE = "RichMesh", "RichOpenFile"
WHOLE = ("RichInt", LAYER)
FRACTIONS = ("RichFloat", "RichDynamicFloat", "RichAbsPerc")
WORD = re.compile(r"enum_val(\d+)")


def value_of(parameter: NativeParameter, written: Param) -> tuple[Any, str]:
    """Return the value of a written parameter, and what there is to say of it, often nothing.

    The type that a script gives does not count, since it changed between versions: the value is
    read as what the parameter is today.

    Raises
    ------
    ParameterError
        The text does not stand for a value of this parameter, attributes are missing, or a file
        is not there.
    """
    text, note = _written_text(parameter, written), ""
    if parameter.rich_type == "RichEnum":
        text, note = _choice(parameter, written, text)
    elif parameter.rich_type in WHOLE:
        text = _without_fraction(text)
    value = parse_native(parameter, text)
    if parameter.rich_type in FRACTIONS and "," in text:
        note = f"'{text.strip()}' of parameter '{written.name}' is read with a decimal comma"
    if parameter.rich_type == LAYER and value < 0:
        raise ParameterError(f"parameter '{written.name}' must be a layer's position; got {value}")
    if parameter.rich_type == INPUT_FILE and not Path(value).is_file():
        raise ParameterError(f"parameter '{written.name}' names no file; got {value!r}")
    return value, note


def _without_fraction(text: str) -> str:
    """Return a whole number without its zeros, which old scripts write; any other text as it is."""
    try:
        number = parsed_number(text.strip())
    except ValueError:
        return text
    return str(int(number)) if number.is_integer() and "." in text else text


def _written_text(parameter: NativeParameter, written: Param) -> str:
    """Return the text of a value, gathered from several attributes where its type has them."""
    names = SPREAD.get(parameter.rich_type, ())
    absent = tuple(name for name in names if name not in written.attributes)
    if parameter.rich_type == "RichColor" and absent == ("a",):
        names, absent = names[:3], ()
    if names and not absent:
        return " ".join(written.attributes[name] for name in names)
    if written.text is not None:
        return written.text
    message = f"parameter '{written.name}' has no attribute '{(absent or ['value'])[0]}'"
    raise ParameterError(
        f"{message}; write {'all of ' * bool(names)}{', '.join(names or ['value'])}"
    )


def _words_of(written: Param) -> tuple[str, ...]:
    """Return the words that a script lists for a choice, in the order of their numbers."""
    found = {int(match[1]): text for name, text in written.attributes.items()
             if (match := WORD.fullmatch(name))}  # fmt: skip
    return tuple(found[number] for number in range(len(found)) if number in found)


def _choice(parameter: NativeParameter, written: Param, text: str) -> tuple[str, str]:
    """Return the number or word of today for a number of the version that wrote the script."""
    number = _number(text)
    if number is None:
        return text, ""
    listed = _words_of(written)
    if number not in range(len(listed)):
        return str(number), ""
    then = listed[number]
    today = next((word for word in parameter.words if bare_name(word) == bare_name(then)), None)
    if today is None:
        return str(number), _renamed(parameter, written, number, then)
    if parameter.words.index(today) == number:
        return today, ""
    return today, (
        f"{number} of parameter '{written.name}' was '{then}', which is "
        f"{parameter.words.index(today)} today"
    )


def _renamed(parameter: NativeParameter, written: Param, number: int, then: str) -> str:
    if number not in range(len(parameter.words)):
        return ""  # the value is refused
    return f"{number} of parameter '{written.name}' was '{then}', '{parameter.words[number]}' today"


def _number(text: str) -> int | None:
    """Return a choice that is given by its number, as a fraction or a boolean, too."""
    plain = text.strip().lower()
    if plain in ("true", "false"):
        return int(plain == "true")
    return int(plain.partition(".")[0]) if re.fullmatch(r"\+?[0-9]{1,9}(\.0*)?", plain) else None
