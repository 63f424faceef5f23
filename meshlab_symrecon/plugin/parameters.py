"""Parameters of a filter, each declared once.

The Python signature, the checks, ``.mlx`` reading and writing, the command-line options, ``--help``
and the docs page all derive from one declaration::

    class Parameters(ParameterSet):
        samples: int = integer(1500, "Samples", "Points that vote for planes.", low=100, high=8000)
        gap: float = spacing_multiple(1.5, "Gap", "Fill what is farther than this.", low=0.5)
"""

from __future__ import annotations

import dataclasses
import difflib
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, Any, ClassVar, TypeAlias, TypeVar

from meshlab_symrecon.errors import ParameterError

if TYPE_CHECKING:
    from typing_extensions import dataclass_transform
else:  # only type checkers read it, so it is no dependency at run time

    def dataclass_transform(**facts):
        return lambda declared: declared


__all__ = [
    "Kind",
    "Parameter",
    "ParameterSet",
    "Value",
    "boolean",
    "choice",
    "diagonal_fraction",
    "integer",
    "layer",
    "nearest_names",
    "number",
    "spacing_multiple",
    "text",
]

Value: TypeAlias = bool | int | float | str
Set = TypeVar("Set", bound="ParameterSet")


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


_FLOATS = (Kind.NUMBER, Kind.DIAGONAL_FRACTION, Kind.SPACING_MULTIPLE)
_WORDS_OF_BOOLEANS = {"true": True, "false": False, "1": True, "0": False}


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
            return self._in_range(float(plain))
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
            if trimmed.lower() not in _WORDS_OF_BOOLEANS:
                raise self._refusal(written)
            return _WORDS_OF_BOOLEANS[trimmed.lower()]
        if self.kind is Kind.CHOICE:
            return self._checked_choice(int(trimmed) if trimmed.isdecimal() else trimmed)
        try:
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
        if not math.isfinite(value) or value != int(value):
            raise self._refusal(value)
        return int(value)

    def _in_range(self, value: float) -> float:
        above = self.low is None or value >= self.low
        below = self.high is None or value <= self.high
        if not (math.isfinite(value) and above and below):
            raise self._refusal(value)
        return value

    def _checked_choice(self, value: object) -> str:
        if isinstance(value, str):
            for word in self.choices:
                if word.lower() == value.lower():
                    return word
        elif type(value) is int and value in range(len(self.choices)):
            return self.choices[value]
        raise self._refusal(value)

    def _refusal(self, value: object) -> ParameterError:
        return ParameterError(f"parameter '{self.name}' must be {self.range_words}; got {value!r}")


def _declare(kind: Kind, default: Value, label: str, tooltip: str, **facts: Any) -> Any:
    parameter = Parameter("", kind, default, label, tooltip, **facts)
    return dataclasses.field(default=default, metadata={"parameter": parameter})


def boolean(default: bool, label: str, tooltip: str) -> Any:
    """Declare a switch."""
    return _declare(Kind.BOOLEAN, default, label, tooltip)


def integer(
    default: int,
    label: str,
    tooltip: str,
    *,
    low: int | None = None,
    high: int | None = None,
    unit: str = "",
) -> Any:
    """Declare a whole number in a closed range."""
    return _declare(Kind.INTEGER, default, label, tooltip, low=low, high=high, unit=unit)


def number(
    default: float,
    label: str,
    tooltip: str,
    *,
    low: float | None = None,
    high: float | None = None,
    unit: str = "",
) -> Any:
    """Declare a number in a closed range."""
    return _declare(Kind.NUMBER, default, label, tooltip, low=low, high=high, unit=unit)


def diagonal_fraction(
    default: float, label: str, tooltip: str, *, low: float = 0.0, high: float = 1.0
) -> Any:
    """Declare a length as a fraction of the diagonal of the cloud's box."""
    return _declare(
        Kind.DIAGONAL_FRACTION,
        default,
        label,
        tooltip,
        low=low,
        high=high,
        unit="box diagonals",
    )


def spacing_multiple(
    default: float, label: str, tooltip: str, *, low: float = 0.0, high: float | None = None
) -> Any:
    """Declare a length as a multiple of the mean distance between neighbouring points."""
    return _declare(
        Kind.SPACING_MULTIPLE, default, label, tooltip, low=low, high=high, unit="mean spacings"
    )


def choice(default: str, choices: tuple[str, ...], label: str, tooltip: str) -> Any:
    """Declare a choice between words."""
    return _declare(Kind.CHOICE, default, label, tooltip, choices=choices)


def layer(default: int, label: str, tooltip: str) -> Any:
    """Declare a layer of the document; -1 leaves the choice to the filter."""
    return _declare(Kind.LAYER, default, label, tooltip, low=-1)


def text(default: str, label: str, tooltip: str) -> Any:
    """Declare a text."""
    return _declare(Kind.TEXT, default, label, tooltip)


def nearest_names(name: str, known: Iterable[str]) -> str:
    """Return ``"; did you mean 'x'?"`` for the nearest known name, or an empty string."""
    by_lower = {candidate.lower(): candidate for candidate in known}
    found = difflib.get_close_matches(name.lower(), list(by_lower), n=1, cutoff=0.6)
    return f"; did you mean '{by_lower[found[0]]}'?" if found else ""


@dataclass_transform(
    kw_only_default=True,
    frozen_default=True,
    field_specifiers=(
        boolean, integer, number, diagonal_fraction, spacing_multiple, choice, layer, text,
    ),
)  # fmt: skip
class ParameterSet:
    """Base of the parameters of a filter: subclasses become frozen, keyword-only dataclasses.

    Raises
    ------
    ParameterError
        On construction, when a value has the wrong type or is out of its declared range.
    TypeError
        When a subclass declares a field without one of this module's functions.
    """

    _declared: ClassVar[tuple[Parameter, ...]] = ()

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        dataclass(frozen=True, kw_only=True)(cls)
        declared = []
        for field in dataclasses.fields(cls):  # type: ignore[arg-type]
            if "parameter" not in field.metadata:
                message = (
                    f"{cls.__qualname__}.{field.name} must be declared with one of the functions "
                    "of meshlab_symrecon.plugin.parameters"
                )
                raise TypeError(message)
            parameter = dataclasses.replace(field.metadata["parameter"], name=field.name)
            parameter.check(parameter.default)
            declared.append(parameter)
        cls._declared = tuple(declared)

    def __post_init__(self) -> None:
        for parameter in self._declared:
            checked = parameter.check(getattr(self, parameter.name))
            object.__setattr__(self, parameter.name, checked)

    @classmethod
    def declared(cls) -> tuple[Parameter, ...]:
        """Return the declarations in their order."""
        return cls._declared

    @classmethod
    def find(cls, name: str) -> Parameter:
        """Return the declaration of ``name``, in any case.

        Raises
        ------
        ParameterError
            No parameter has that name.
        """
        for parameter in cls._declared:
            if parameter.name.lower() == name.strip().lower():
                return parameter
        names = [parameter.name for parameter in cls._declared]
        message = f"unknown parameter '{name}'{nearest_names(name, names) or _listing(names)}"
        raise ParameterError(message)

    @classmethod
    def from_values(cls: type[Set], values: Mapping[str, object]) -> Set:
        """Return the set with ``values`` in place of the defaults.

        Raises
        ------
        ParameterError
            Unknown name, wrong type, or out of range.
        """
        return cls(**{cls.find(name).name: value for name, value in values.items()})

    def values(self) -> dict[str, Value]:
        """Return every value by name, in the order of declaration."""
        return {parameter.name: getattr(self, parameter.name) for parameter in self._declared}


def _listing(names: list[str]) -> str:
    return f"; known are {', '.join(names)}" if names else "; this filter has no parameters"
