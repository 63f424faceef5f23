"""Filters found through the entry-point group ``meshlab_symrecon.filters``.

Another distribution adds filters by naming ``Filter`` objects in the same group; they have the
same rights as ours.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points

from meshlab_symrecon.errors import PluginError, UnknownFilterError
from meshlab_symrecon.plugin.filter import Filter
from meshlab_symrecon.plugin.parameters import nearest_names

__all__ = ["ENTRY_POINT_GROUP", "PluginFailure", "Registry", "installed_filters", "plain_name"]

ENTRY_POINT_GROUP = "meshlab_symrecon.filters"


def plain_name(name: str) -> str:
    """Return ``name`` trimmed, with single spaces, in lower case: how names are compared."""
    return " ".join(name.split()).lower()


@dataclass(frozen=True, slots=True)
class PluginFailure:
    """A plugin that could not be loaded: its entry point, and one sentence that says why."""

    name: str
    reason: str


class Registry:
    """Filters by every one of their names, in the order in which they were given.

    Raises
    ------
    PluginError
        Two filters claim one name.
    """

    def __init__(self, filters: Iterable[Filter], failures: Iterable[PluginFailure] = ()) -> None:
        self._filters = tuple(filters)
        self._failures = tuple(failures)
        self._by_name: dict[str, Filter] = {}
        for item in self._filters:
            for name in dict.fromkeys(plain_name(name) for name in item.names):
                other = self._by_name.get(name)
                if other is not None:
                    message = (
                        f"two filters claim the name '{name}': {origin(other)} and {origin(item)}; "
                        "rename one or uninstall its package"
                    )
                    raise PluginError(message)
                self._by_name[name] = item

    def __iter__(self) -> Iterator[Filter]:
        return iter(self._filters)

    def __len__(self) -> int:
        return len(self._filters)

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and plain_name(name) in self._by_name

    @property
    def failures(self) -> tuple[PluginFailure, ...]:
        """Plugins that could not be loaded."""
        return self._failures

    @property
    def names(self) -> tuple[str, ...]:
        """Python names and aliases, in order."""
        return tuple(name for item in self for name in (item.python_name, *item.aliases))

    def find(self, name: str) -> Filter:
        """Return the filter with that Python name, alias or menu name.

        Raises
        ------
        UnknownFilterError
            No filter has it; the message carries the nearest known name.
        """
        found = self._by_name.get(plain_name(name))
        if found is None:
            every = [known for item in self for known in item.names]
            message = f"no filter is called '{name}'{nearest_names(name, every)}"
            raise UnknownFilterError(message)
        return found


def origin(item: Filter) -> str:
    """Say where a filter comes from: its menu name and the module of its ``run``."""
    return f"'{item.menu_name}' of {getattr(item.run, '__module__', 'an unknown module')}"


def installed_filters() -> Registry:
    """Load every filter that an installed distribution declares.

    A plugin that cannot be imported, or whose object is no ``Filter``, does not take the others
    with it: it is listed in ``Registry.failures``.

    Raises
    ------
    PluginError
        Two filters claim one name.
    """
    filters: list[Filter] = []
    failures: list[PluginFailure] = []
    points = entry_points(group=ENTRY_POINT_GROUP)
    unique = dict.fromkeys((point.name, point.value) for point in points)
    for name, value in unique:
        loaded = _load(EntryPoint(name, value, ENTRY_POINT_GROUP))
        if isinstance(loaded, Filter):
            filters.append(loaded)
        else:
            failures.append(loaded)
    return Registry(sorted(filters, key=_ours_first), failures)


def _ours_first(item: Filter) -> bool:
    return not item.run.__module__.startswith("meshlab_symrecon.")


def _load(point: EntryPoint) -> Filter | PluginFailure:
    where = f"{point.name} = {point.value}"
    try:
        loaded = point.load()
    # A stranger's module may raise anything, and a script without a guard ends the program.
    except (Exception, SystemExit) as error:  # noqa: BLE001
        reason = f"plugin '{where}' cannot be imported: {type(error).__name__}: {error}"
        return PluginFailure(point.name, f"{reason}; repair or uninstall its package")
    if not isinstance(loaded, Filter):
        reason = f"plugin '{where}' must be a Filter; got {type(loaded).__name__}"
        return PluginFailure(point.name, reason)
    return loaded
