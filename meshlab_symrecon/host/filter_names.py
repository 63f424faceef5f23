"""Filters by any of their names: a plugin's or MeshLab's, of today or of older versions."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

from meshlab_symrecon.errors import UnknownFilterError
from meshlab_symrecon.host.native_filters import (
    NativeFilter,
    find_native,
    is_native,
    native_filters,
)
from meshlab_symrecon.host.old_names import (
    NOTHING,
    OldName,
    advice_on_gone,
    bare_name,
    find_old_name,
)
from meshlab_symrecon.host.steps import find_filter, registry
from meshlab_symrecon.plugin import Filter
from meshlab_symrecon.plugin.parameters import nearest_names

__all__ = ["find_any", "find_listed", "known_today"]


def find_any(name: str) -> Filter | NativeFilter:
    """Return the filter with that name: a plugin's first, then MeshLab's own.

    Names of older versions are known, and punctuation does not count.

    Raises
    ------
    UnknownFilterError
        There is none; the message carries the nearest name of all. Or it is an old name that
        needs more than a new one.
    PluginError
        It is that of a plugin that could not be loaded.
    """
    found = known_today(name)
    if found is not None:
        return found
    old = find_old_name(name)
    if old is not None:
        if old.filter in native_filters() and not old.values:
            return find_native(old.filter)
        raise UnknownFilterError(f"no filter is called '{name}' today; {_replacement(old)}")
    return find_listed(name)


def known_today(name: str) -> Filter | NativeFilter | None:
    """Return the filter that has the name today, however it is punctuated.

    Raises
    ------
    PluginError
        Two plugins claim one name.
    """
    if name in registry():
        return registry().find(name)
    if is_native(name):
        return find_native(name)
    bare = bare_name(name)
    ours = (item for item in registry() if bare in map(bare_name, item.names))
    return next(ours, None) or _natives_by_bare_name().get(bare)


@cache
def _natives_by_bare_name() -> Mapping[str, NativeFilter]:
    by_name = {bare_name(item.menu_name): item for item in native_filters().values()}
    return by_name | {bare_name(name): item for name, item in native_filters().items()}


def _replacement(old: OldName) -> str:
    if old.values:
        values = ", ".join(f"{name} {text}" for name, text in old.values.items())
        return f"it is '{old.filter}' with {values}"
    if old.words:
        return f"it is one of {', '.join(old.words.values())}"
    return "leave it out" if old.filter == NOTHING else "use it in scripts only"


def find_listed(name: str) -> Filter | NativeFilter:
    """Return the filter of a plugin that has the name, or say what to do without it.

    Raises
    ------
    UnknownFilterError, PluginError
        As ``find_any``.
    """
    advice = advice_on_gone(name)
    if advice:
        raise UnknownFilterError(f"'{name.strip()}' is gone from MeshLab; {advice}")
    try:
        return find_filter(name)
    except UnknownFilterError as error:
        known = [known for item in registry() for known in item.names]
        for item in native_filters().values():
            known += [item.python_name, item.menu_name]
        hint = nearest_names(name, known) or "; 'symrecon filters --all' lists them"
        raise UnknownFilterError(f"no filter is called '{name}'{hint}") from error
