"""Plugin filters as pymeshlab's own: methods of ``MeshSet``, names, lists and scripts.

``load_plugins`` changes pymeshlab's classes, ``unload_plugins`` puts the very objects back that
were there; ``apply_filter`` does the same work and changes nothing.
"""

from __future__ import annotations

import functools
import inspect
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pymeshlab

from meshlab_symrecon.errors import PluginError
from meshlab_symrecon.host import exact_steps, listings, script_history
from meshlab_symrecon.host.aftermath import aftermath_undone
from meshlab_symrecon.host.native_filters import native_filters
from meshlab_symrecon.host.notices import warn_user
from meshlab_symrecon.host.noting import noted
from meshlab_symrecon.host.script import ScriptReport
from meshlab_symrecon.host.steps import apply_filter, find_filter, registry, run_filter
from meshlab_symrecon.plugin import Filter, Progress
from meshlab_symrecon.plugin.documentation import method_documentation
from meshlab_symrecon.plugin.registry import Registry

__all__ = [
    "apply_filter",
    "filter_list",
    "find_filter",
    "load_plugins",
    "registry",
    "run_filter",
    "unload_plugins",
]

_lock = threading.RLock()
_replaced: list[tuple[Any, str, Any]] = []  # owner, attribute, what was there (_NOTHING: nothing)
_NOTHING = object()
_native_filter_list = pymeshlab.filter_list


def load_plugins() -> None:
    """Make every installed plugin filter a filter of pymeshlab, until ``unload_plugins``.

    Each becomes a method of ``MeshSet`` under its Python name and aliases, a name for
    ``apply_filter`` and ``filter_parameter_values``, and an entry of ``filter_list``,
    ``print_filter_list``, ``print_filter_parameter_list`` and ``search``. The filter scripts of a
    MeshSet are ours from then on: ``load_filter_script`` reads scripts of every version of MeshLab
    and raises for what cannot run, ``apply_filter_script`` runs them with exact numbers and returns
    a report, ``save_filter_script`` writes what ran to the last bit. Calling it again looks for
    plugins anew. A plugin that cannot be loaded is named in a warning, and does not hold up the
    others.

    Raises
    ------
    PluginError
        Two filters claim one name, or one claims a name that ``MeshSet`` has already.
    """
    with _lock:
        found = registry(refresh=True)
        unload_plugins()
        _check_names_are_free(found)
        for item in found:
            method = _method(item)
            for name in (item.python_name, *item.aliases):
                _replace(pymeshlab.MeshSet, name, method)
        for name, make in _METHODS.items():
            _replace(pymeshlab.MeshSet, name, make(getattr(pymeshlab.MeshSet, name)))
        for name, make in _FUNCTIONS.items():
            _replace(pymeshlab, name, make(getattr(pymeshlab, name)))
    for failure in found.failures:
        warn_user(failure.reason)


def unload_plugins() -> None:
    """Put back everything that ``load_plugins`` replaced; do nothing when nothing was."""
    with _lock:
        while _replaced:
            owner, name, before = _replaced.pop()
            if before is _NOTHING:
                delattr(owner, name)
            else:
                setattr(owner, name, before)


def filter_list() -> list[str]:
    """Return the Python names of all filters, MeshLab's and plugins', in alphabetical order."""
    return sorted([*_native_filter_list(), *(item.python_name for item in registry())])


def _check_names_are_free(found: Registry) -> None:
    for name in found.names:
        if hasattr(pymeshlab.MeshSet, name):
            message = (
                f"'{found.find(name).menu_name}' claims the name '{name}', which pymeshlab's "
                "MeshSet has already; rename the filter or uninstall its package"
            )
            raise PluginError(message)


def _replace(owner: Any, name: str, new: Any) -> None:
    _replaced.append((owner, name, vars(owner).get(name, _NOTHING)))
    setattr(owner, name, new)


def _method(item: Filter) -> Callable[..., dict[str, Any] | None]:
    """Return a method as pymeshlab makes them: the measures, or None when there are none."""

    def method(self: Any, **parameters: object) -> dict[str, Any] | None:
        return run_filter(self, item, parameters) or None

    method.__name__ = item.python_name
    method.__qualname__ = f"MeshSet.{item.python_name}"
    method.__doc__ = method_documentation(item)
    declared = [
        inspect.Parameter(
            known.name, inspect.Parameter.KEYWORD_ONLY, default=known.default,
            annotation=type(known.default),
        )
        for known in item.parameters.declared()
    ]  # fmt: skip
    itself = inspect.Parameter("self", inspect.Parameter.POSITIONAL_ONLY)
    method.__signature__ = inspect.Signature([itself, *declared])  # type: ignore[attr-defined]
    return method


def _apply_filter(native: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(native)
    def method(self: Any, filter_name: str, **parameters: object) -> Any:
        if filter_name in registry():
            return run_filter(self, find_filter(filter_name), parameters)
        item = native_filters().get(filter_name)
        with noted(self, item, parameters), aftermath_undone():
            return native(self, filter_name, **parameters)

    return method


def _filter_parameter_values(native: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(native)
    def method(self: Any, name: str, /, **parameters: object) -> Any:
        if name in registry():
            return find_filter(name).bind(parameters).values()
        with aftermath_undone():
            return native(self, name, **parameters)

    return method


def _load_filter_script(native: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(native)
    def method(self: Any, filter_script_name: str | Path) -> None:
        script_history.load_script(self, filter_script_name)

    return method


def _save_filter_script(native: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(native)
    def method(self: Any, filter_script_name: str | Path) -> None:
        script_history.save_script(self, filter_script_name)

    return method


def _apply_filter_script(native: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(native)
    def method(self: Any, *, progress: Progress | None = None) -> ScriptReport:
        return script_history.replay(self, progress)

    return method


def _clear_filter_script(native: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(native)
    def method(self: Any) -> None:
        native(self)
        exact_steps.replace(self, exact_steps.Notes())

    return method


def _print_filter_script(native: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(native)
    def method(self: Any) -> None:
        listings.print_script(script_history.recorded_script(self))

    return method


def _filter_list(native: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(native)
    def function() -> list[str]:
        return filter_list()

    return function


def _print_filter_list(native: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(native)
    def function() -> None:
        native()
        listings.print_names(registry())

    return function


def _print_filter_parameter_list(native: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(native)
    def function(name: str, /) -> None:
        if name in registry():
            listings.print_parameters(find_filter(name))
        else:
            native(name)

    return function


def _search(native: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(native)
    def function(keyword: str, /) -> None:
        native(keyword)
        listings.print_found(registry(), keyword)

    return function


_METHODS = {
    "apply_filter": _apply_filter,
    "apply_filter_script": _apply_filter_script,
    "clear_filter_script": _clear_filter_script,
    "filter_parameter_values": _filter_parameter_values,
    "load_filter_script": _load_filter_script,
    "print_filter_script": _print_filter_script,
    "save_filter_script": _save_filter_script,
}
_FUNCTIONS = {
    "filter_list": _filter_list,
    "print_filter_list": _print_filter_list,
    "print_filter_parameter_list": _print_filter_parameter_list,
    "search": _search,
}
