"""MeshLab's own filters: found by every one of their names, with the types of their parameters.

pymeshlab maps no names and tells no types, so both come from a table made once by
``meshlab_symrecon.host.native_table``.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

from meshlab_symrecon.errors import UnknownFilterError
from meshlab_symrecon.host.cloud_cleaning import reason_to_skip
from meshlab_symrecon.host.guards import check_step
from meshlab_symrecon.host.native_values import NativeParameter, checked_value
from meshlab_symrecon.host.notices import warn_user
from meshlab_symrecon.host.noting import noted
from meshlab_symrecon.host.remembered import first_defaults
from meshlab_symrecon.host.translation import script_name_in_python, translated
from meshlab_symrecon.plugin.parameters import nearest_names, unknown_parameter
from meshlab_symrecon.plugin.registry import plain_name

__all__ = [
    "NativeFilter",
    "apply_native",
    "completed",
    "find_native",
    "is_native",
    "native_filters",
]

THREADS = "threads"


@dataclass(frozen=True, slots=True)
class NativeFilter:
    """One of MeshLab's own filters.

    Attributes
    ----------
    python_name, menu_name : str
    parameters : tuple of NativeParameter
        In the order in which MeshLab shows them.
    fatal : frozenset of str
        Kinds of documents on which its defaults ended the process when the table was made:
        mesh, textured, sheet, cloud, void (a layer without vertices), empty (no layer).
    display : bool
        It draws with OpenGL, and aborts the process where there is no window.
    probed : bool
        It never ended well when the table was made: types of its parameters were told from its
        defaults, and ``script_name`` is the Python name, since the case in scripts stayed unknown.
    """

    python_name: str
    menu_name: str
    parameters: tuple[NativeParameter, ...]
    fatal: frozenset[str]
    display: bool
    probed: bool

    def find(self, name: str) -> NativeParameter:
        """Return the parameter with that name, in Python or in scripts, in any case.

        Raises
        ------
        ParameterError
            The filter has no such parameter.
        """
        wanted = script_name_in_python(name.strip())
        for parameter in self.parameters:
            if parameter.name == wanted:
                return parameter
        names = [parameter.name for parameter in self.parameters]
        raise unknown_parameter(name, names, self.menu_name)


@cache
def native_filters() -> Mapping[str, NativeFilter]:
    """Return MeshLab's filters by Python name, in alphabetical order."""
    table = json.loads(files("meshlab_symrecon.host").joinpath("native_filters.json").read_bytes())
    return {name: _declared(name, facts) for name, facts in table.items()}


def _declared(name: str, facts: Mapping[str, Any]) -> NativeFilter:
    parameters = tuple(
        NativeParameter(
            name=parameter["name"],
            script_name=parameter["script_name"],
            rich_type=parameter["type"],
            words=tuple(parameter.get("words", ())),
        )
        for parameter in facts["parameters"] or ()
    )
    return NativeFilter(
        python_name=name,
        menu_name=facts["menu"],
        parameters=parameters,
        fatal=frozenset(facts["fatal"]),
        display=facts["display"],
        probed=facts["probed"],
    )


@cache
def _by_plain_name() -> Mapping[str, NativeFilter]:
    by_menu = {plain_name(item.menu_name): item for item in native_filters().values()}
    return by_menu | dict(native_filters())  # a Python name wins over a menu name


def is_native(name: str) -> bool:
    """Say whether MeshLab has a filter with that Python or menu name."""
    return plain_name(name) in _by_plain_name()


def find_native(name: str) -> NativeFilter:
    """Return MeshLab's filter with that Python name or menu name.

    Names are compared trimmed, with single spaces, in any case.

    Raises
    ------
    UnknownFilterError
        MeshLab has no such filter; the message carries the nearest known name.
    """
    found = _by_plain_name().get(plain_name(name))
    if found is None:
        known = [name for item in native_filters().values() for name in _names(item)]
        message = f"MeshLab has no filter called '{name}'{nearest_names(name, known)}"
        raise UnknownFilterError(message)
    return found


def _names(item: NativeFilter) -> tuple[str, str]:
    return item.python_name, item.menu_name


def completed(item: NativeFilter, values: Mapping[str, object]) -> dict[str, Any]:
    """Return checked values by Python names, with those that must not be left to MeshLab.

    These are the number of threads, and what it remembers from the step before; see
    ``first_defaults``.

    Raises
    ------
    ParameterError
        Unknown parameter, or a value of the wrong type.
    """
    arguments = {}
    for given, value in {**first_defaults(item.python_name), **values}.items():
        parameter = item.find(given)
        arguments[parameter.name] = checked_value(parameter, value)
    if any(parameter.name == THREADS for parameter in item.parameters):
        arguments.setdefault(THREADS, 1)
    return arguments


def apply_native(
    mesh_set: Any, name: str, values: Mapping[str, object], *, may_empty: bool = False
) -> dict[str, Any]:
    """Run one of MeshLab's filters; return what it measured.

    Checks first what would end the process or do silent damage. A percentage given as a plain
    number is an absolute length. A filter with a parameter ``threads`` (Screened Poisson) runs in
    one thread unless told otherwise: with more, its result differs in the last bits from run to
    run, and on a busy machine it takes longer.

    Parameters
    ----------
    mesh_set : pymeshlab.MeshSet
    name : str
        Python or menu name.
    values : mapping
        By the names of parameters.
    may_empty : bool
        Let a cleaning filter delete every point of a layer without faces, as it does for MeshLab.

    Raises
    ------
    UnknownFilterError
        MeshLab has no such filter.
    ParameterError
        Unknown parameter, or a value of the wrong type.
    GeometryError
        The filter cannot work on the current layer.
    HostError
        MeshLab refused the step.
    """
    item = find_native(name)
    arguments = completed(item, values)
    check_step(mesh_set, item, arguments)
    skipped = "" if may_empty else reason_to_skip(mesh_set, item, arguments)
    if skipped:
        warn_user(f"'{item.menu_name}' was skipped: {skipped}")
        return {}
    with translated(f"'{item.menu_name}'"), noted(mesh_set, item, arguments):
        measures = mesh_set.apply_filter(item.python_name, **arguments)
    return dict(measures or {})
