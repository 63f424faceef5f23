"""One declared parameter of a filter: what it holds, what it accepts, and its text in scripts."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import TypeAlias

from meshlab_symrecon.errors import ParameterError

__all__ = [
    "WORDS_OF_BOOLEANS",
    "Kind",
    "Parameter",
    "Value",
    "chosen_word",
    "nearest_names",
    "shortened",
    "unknown_parameter",
]

Value: TypeAlias = bool | int | float | str


class Kind(Enum):
    """What a parameter holds, and the type that MeshLab's scripts give to it."""

    BOOLEAN = ("true or false", "RichBool")
    INTEGER = ("a whole number", "RichInt")
    NUMBER = ("a number", "RichFloat")
    DIAGONAL_FRACTION = ("a fraction of the box diagonal", "RichFloat")
    SPACING_MULTIPLE = ("a multiple of the mean spacing", "RichFloat")
    CHOICE = ("one of the listed words", "RichEnum")
    LAYER = ("a layer's number", "RichMesh")
    TEXT = ("text", "RichString")

    def __init__(self, words: str, rich_type: str) -> None:
        self.words = words
        self.rich_type = rich_type


_LARGEST = 2**63 - 1  # numpy and the kernel count in 64 bits
_FLOATS = (Kind.NUMBER, Kind.DIAGONAL_FRACTION, Kind.SPACING_MULTIPLE)
WORDS_OF_BOOLEANS = {"true": True, "false": False, "1": True, "0": False}


@dataclass(frozen=True, slots=True)
class Parameter:
    """One declared parameter.

    Attributes
    ----------
    low, high : float or None
        Closed range of a number; None leaves a side open.
    choices : tuple of str
        The words of a choice, in the order in which scripts number them.
    unit : str
        Unit for people; empty for plain numbers.
    """

    name: str
    kind: Kind
    default: Value
    label: str
    tooltip: str
    low: float | None = None
    high: float | None = None
    choices: tuple[str, ...] = ()
    unit: str = ""

    def check(self, value: object) -> Value:
        """Return ``value`` as this parameter's own type.

        Raises
        ------
        ParameterError
            Wrong type, not finite, out of range, or not one of the choices.
        """
        plain = value.item() if hasattr(value, "item") and getattr(value, "ndim", 1) == 0 else value
        if self.kind is Kind.BOOLEAN and isinstance(plain, bool):
            return plain
        if self.kind is Kind.TEXT and isinstance(plain, str):
            return plain
        if self.kind is Kind.CHOICE:
            return self._checked_choice(plain)
        if self.kind in (Kind.INTEGER, Kind.LAYER):
            return int(self._in_range(self._whole(plain)))
        if self.kind in _FLOATS and isinstance(plain, (int, float)) and not isinstance(plain, bool):
            return self._in_range(self._float(plain))
        raise self._refusal(value)

    def parse(self, written: str) -> Value:
        """Return the value written as text in a script or on a command line.

        Raises
        ------
        ParameterError
            The text does not stand for a value of this parameter.
        """
        trimmed = written.strip()
        if self.kind is Kind.TEXT:
            return written
        if self.kind is Kind.BOOLEAN:
            if trimmed.lower() not in WORDS_OF_BOOLEANS:
                raise self._refusal(written)
            return WORDS_OF_BOOLEANS[trimmed.lower()]
        try:
            if self.kind is Kind.CHOICE:
                return self._checked_choice(int(trimmed) if trimmed.isdecimal() else trimmed)
            return self.check(int(trimmed) if self.kind not in _FLOATS else float(trimmed))
        except ParameterError:
            raise
        except ValueError as error:
            raise self._refusal(written) from error

    def format(self, value: Value) -> str:
        """Return text that ``parse`` reads back to the same value, to the last bit."""
        if self.kind is Kind.BOOLEAN:
            return "true" if value else "false"
        if self.kind is Kind.CHOICE:
            return str(self.choices.index(str(value)))
        return value if isinstance(value, str) else repr(value)

    @property
    def range_words(self) -> str:
        """Say in words which values are allowed."""
        if self.kind is Kind.CHOICE:
            return "one of " + ", ".join(repr(word) for word in self.choices)
        if self.low is not None and self.high is not None:
            return f"{self.kind.words} from {self.low:.12g} to {self.high:.12g}"
        if self.low is not None:
            return f"{self.kind.words} of at least {self.low:.12g}"
        if self.high is not None:
            return f"{self.kind.words} of at most {self.high:.12g}"
        return self.kind.words

    def _whole(self, value: object) -> int:
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise self._refusal(value)
        if isinstance(value, float) and not value.is_integer():  # neither are nan and infinity
            raise self._refusal(value)
        if abs(value) > _LARGEST:
            raise self._refusal(value)
        return int(value)

    def _float(self, value: float) -> float:
        try:
            return float(value)
        except OverflowError as error:  # whole numbers of Python have no largest one
            raise self._refusal(value) from error

    def _in_range(self, value: float) -> float:
        above = self.low is None or value >= self.low
        below = self.high is None or value <= self.high
        finite = isinstance(value, int) or math.isfinite(value)
        if not (finite and above and below):
            raise self._refusal(value)
        return value

    def _checked_choice(self, value: object) -> str:
        word = chosen_word(value, self.choices)
        if word is None:
            raise self._refusal(value)
        return word

    def _refusal(self, value: object) -> ParameterError:
        got = shortened(value)
        return ParameterError(f"parameter '{self.name}' must be {self.range_words}; got {got}")


def shortened(value: object) -> str:
    """Return a value as a message shows it; Python itself writes no number of 5000 digits."""
    try:
        return f"{value!r:.80}"
    except ValueError:
        return "a number with thousands of digits"


def chosen_word(value: object, words: Sequence[str]) -> str | None:
    """Return the word that ``value`` is, in any case, or numbers; None when it is no choice."""
    if isinstance(value, str):
        return next((word for word in words if word.lower() == value.lower()), None)
    if type(value) is int and value in range(len(words)):
        return words[value]
    return None


def nearest_names(name: str, known: Iterable[str]) -> str:
    """Return ``"; did you mean 'x'?"`` for the nearest known name, or an empty string."""
    by_lower = {candidate.lower(): candidate for candidate in known}
    found = difflib.get_close_matches(name.lower(), list(by_lower), n=1, cutoff=0.6)
    return f"; did you mean '{by_lower[found[0]]}'?" if found else ""


def unknown_parameter(name: str, known: Sequence[str], owner: str = "") -> ParameterError:
    """Return the error for a name that is none of a filter's ``known`` parameters."""
    of_whom = f" of '{owner}'" if owner else ""
    listing = f"; known are {', '.join(known)}" if known else "; this filter has no parameters"
    return ParameterError(
        f"unknown parameter '{name}'{of_whom}{nearest_names(name, known) or listing}"
    )
