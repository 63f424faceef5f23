"""Which versions make a result; to know them takes neither pymeshlab nor numpy."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, entry_points, version

__all__ = ["versions_of", "versions_of_filters", "versions_of_results"]

OURS = "meshlab_symrecon"
DISTRIBUTIONS = (OURS, "pymeshlab", "numpy", "scipy", "scikit-learn")


def versions_of_results() -> dict[str, str]:
    """Return the versions of what every result is made with."""
    return {name: version(name) for name in DISTRIBUTIONS}


def versions_of(names: Iterable[str]) -> dict[str, str]:
    """Return the versions of distributions; those that are not installed are left out."""
    found = {}
    for name in names:
        with suppress(PackageNotFoundError):
            found[name] = version(name)
    return found


def versions_of_filters(names: Iterable[str]) -> dict[str, str]:
    """Return the versions of the other distributions that filters come from.

    Parameters
    ----------
    names : iterable of str
        Filters by any of their names; MeshLab's come from no other distribution.
    """
    from meshlab_symrecon.host.filter_names import known_today
    from meshlab_symrecon.plugin.registry import ENTRY_POINT_GROUP

    used = [known_today(name) for name in names]
    found = {}
    for point in entry_points(group=ENTRY_POINT_GROUP):
        if point.dist is None or point.module not in sys.modules:
            continue
        with suppress(AttributeError):  # it is no filter, which was told
            loaded = point.load()
            if any(loaded is item for item in used):
                found[point.dist.name] = point.dist.version
    return {name: found[name] for name in sorted(found) if name.replace("-", "_") != OURS}
