"""What filters and parameters of older MeshLab and pymeshlab versions are called today.

The table beside this module has three parts: names of filters, changes of parameters by the filter
of today that they belong to (``*``: of any), and filters that are gone.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib.resources import files
from types import MappingProxyType
from typing import Any

__all__ = [
    "CHANGE_LAYER",
    "NOTHING",
    "POISSON",
    "Change",
    "OldName",
    "advice_on_gone",
    "bare_name",
    "change_of_parameter",
    "find_old_name",
    "old_names",
]

NOTHING = "no operation"  # what the filter did happens by itself today
CHANGE_LAYER = "set_current_mesh"  # a method of MeshSet, no filter, today
POISSON = "generate_surface_reconstruction_screened_poisson"
ANY_FILTER = "*"
NONE: Mapping[str, Any] = MappingProxyType({})


@dataclass(frozen=True, slots=True)
class OldName:
    """What an old filter became.

    Attributes
    ----------
    filter : str
        Python name today, ``NOTHING`` or ``CHANGE_LAYER``; empty when a parameter decides.
    values : mapping of str to str
        Values that the old name stood for.
    by : str
        Python name of the old parameter that decides which filter it is today.
    words : mapping of str to str
        Words of that parameter, in the order of their numbers: the filter of today.
    """

    filter: str = ""
    values: Mapping[str, str] = field(default_factory=dict)
    by: str = ""
    words: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Change:
    """What an old parameter became.

    Attributes
    ----------
    to : str
        Its name today; empty when it is gone.
    values : mapping of str to str or None
        What its values are today, None for one that says nothing today; all others stay.
    factors : mapping of str to float
        The parameters of today among which it was split: its number is multiplied.
    also : mapping of str to str
        Values of other parameters of today that it implied.
    unless_file : str
        Python name of a parameter: nothing is implied where it names a file that is there.
    note : str
        What to do now that it is gone.
    then : sequence of two str
        The filter that does today what it stood for, after its own, and the parameter of that
        filter that takes its value; empty for most.
    """

    to: str = ""
    values: Mapping[str, str | None] = field(default_factory=dict)
    factors: Mapping[str, float] = field(default_factory=dict)
    also: Mapping[str, str] = field(default_factory=dict)
    unless_file: str = ""
    note: str = ""
    then: Sequence[str] = ()


def bare_name(name: str) -> str:
    """Return the letters and digits of a name, in lower case: how names are compared loosely."""
    return "".join(letter for letter in name.lower() if letter.isalnum())


@cache
def _table() -> Mapping[str, Any]:
    text = files("meshlab_symrecon.host").joinpath("old_names.json").read_bytes()
    table: Mapping[str, Any] = json.loads(text)
    return table


@cache
def old_names() -> Mapping[str, OldName]:
    """Return what every old name became, by that name."""
    return {
        name: OldName(became) if isinstance(became, str) else OldName(**became)
        for name, became in _table()["names"].items()
    }


@cache
def _by_bare_name() -> Mapping[str, OldName]:
    return {bare_name(name): old for name, old in old_names().items()}


@cache
def _gone_by_bare_name() -> Mapping[str, str]:
    return {bare_name(name): advice for name, advice in _table()["gone"].items()}


def find_old_name(name: str) -> OldName | None:
    """Return what an old filter became, if ``name`` is one's, however it is punctuated."""
    return _by_bare_name().get(bare_name(name))


def advice_on_gone(name: str) -> str:
    """Return what to do without a filter that MeshLab dropped; empty when it is none."""
    return _gone_by_bare_name().get(bare_name(name), "")


def change_of_parameter(filter_name: str, name: str) -> Change | None:
    """Return what an old parameter became.

    Parameters
    ----------
    filter_name : str
        Python name of the filter of today.
    name : str
        Python name of the old parameter.
    """
    changes = _table()["parameters"]
    for owner in (filter_name, ANY_FILTER):
        known = changes.get(owner, NONE)
        if name in known:
            became = known[name]
            return Change(**became) if isinstance(became, dict) else Change(became or "")
    return None
