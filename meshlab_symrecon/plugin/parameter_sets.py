"""The parameters of a filter, each declared once.

The Python signature, the checks, ``.mlx`` reading and writing, the command-line options, ``--help``
and the docs page all derive from one declaration::

    class Parameters(ParameterSet):
        samples: int = integer(1500, "Samples", "Points that vote for planes.", low=100, high=8000)
        gap: float = spacing_multiple(1.5, "Gap", "Fill what is farther than this.", low=0.5)
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

from meshlab_symrecon.plugin.parameters import Kind, Parameter, Value, unknown_parameter

if TYPE_CHECKING:
    from typing_extensions import dataclass_transform
else:  # only type checkers read it, so it is no dependency at run time

    def dataclass_transform(**facts):
        return lambda declared: declared


__all__ = [
    "ParameterSet",
    "boolean",
    "choice",
    "diagonal_fraction",
    "integer",
    "layer",
    "number",
    "spacing_multiple",
    "text",
]

Set = TypeVar("Set", bound="ParameterSet")


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
                    "of meshlab_symrecon.plugin"
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
    def find(cls, name: str, owner: str = "") -> Parameter:
        """Return the declaration of ``name``, in any case; ``owner`` is the filter to be blamed.

        Raises
        ------
        ParameterError
            No parameter has that name.
        """
        for parameter in cls._declared:
            if parameter.name.lower() == name.strip().lower():
                return parameter
        raise unknown_parameter(name, [parameter.name for parameter in cls._declared], owner)

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
