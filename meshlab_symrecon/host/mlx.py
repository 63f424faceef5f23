"""MeshLab's filter scripts (``.mlx``) as plain data with line numbers; no pymeshlab in it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from meshlab_symrecon.plugin.filter import Filter
from meshlab_symrecon.plugin.parameters import Kind, Parameter, Value

__all__ = ["ROOT", "Param", "Script", "Step", "choice_attributes", "same_name", "step_of"]

ROOT = "FilterScript"  # the outermost element


@dataclass(frozen=True, slots=True)
class Param:
    """A parameter as it was written.

    Attributes
    ----------
    name : str
    line : int
        Line of the script; no part of the comparison.
    rich_type : str
        MeshLab's type, such as ``RichFloat``; empty in an ``<xmlparam>``, and where a script leaves
        it out: types are those of today's filters.
    text : str or None
        The attribute ``value``; None where the type keeps its value in other attributes.
    attributes : mapping of str to str
        Every other attribute, such as ``min``, ``enum_val0`` or ``x``.
    """

    name: str
    line: int = field(compare=False)
    rich_type: str
    text: str | None
    attributes: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Step:
    """A filter as it was written: its name, its line, its parameters in their order."""

    name: str
    line: int = field(compare=False)
    parameters: tuple[Param, ...] = ()
    from_xml_plugin: bool = False  # an <xmlfilter> of 2014 to 2020


@dataclass(frozen=True, slots=True)
class Script:
    """The steps of a script, and the file they were read from.

    Attributes
    ----------
    path : Path
    steps : tuple of Step
    comments : mapping of int to texts
        What stands above or in the step at a position; after the last one at one more than its
        position.
    """

    path: Path
    steps: tuple[Step, ...]
    comments: Mapping[int, Sequence[str]] = field(default_factory=dict, compare=False)


def same_name(first: str, second: str) -> bool:
    """Say whether two names of parameters are one, as scripts are read."""
    return first.strip().lower() == second.strip().lower()


def step_of(item: Filter, values: Mapping[str, object]) -> Step:
    """Return a step of one of our filters with every parameter, in the order of declaration.

    Raises
    ------
    ParameterError
        As ``Filter.bind``.
    """
    bound = item.bind(values).values()
    return Step(
        item.menu_name,
        0,
        tuple(_param_of(declared, bound[declared.name]) for declared in item.parameters.declared()),
    )


def _param_of(declared: Parameter, value: Value) -> Param:
    text = declared.format(value)
    return Param(declared.name, 0, declared.kind.rich_type, text, choice_attributes(declared))


def choice_attributes(declared: Parameter) -> dict[str, str]:
    """Return the attributes in which scripts list the words of a choice; none for other kinds."""
    if declared.kind is not Kind.CHOICE:
        return {}
    words = {f"enum_val{number}": word for number, word in enumerate(declared.choices)}
    return {"enum_cardinality": str(len(declared.choices)), **words}
