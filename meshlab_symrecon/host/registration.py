"""Our filters on plain MeshSets: with and without changes to pymeshlab's classes."""

from __future__ import annotations

import threading
import warnings
from collections.abc import Callable, Mapping
from typing import Any

from meshlab_symrecon.errors import HostError, PluginError, UnknownFilterError
from meshlab_symrecon.host import history
from meshlab_symrecon.host.meshset import add_layer, layers_of
from meshlab_symrecon.plugin import Filter, Outcome
from meshlab_symrecon.plugin.filter import silent
from meshlab_symrecon.plugin.registry import Registry, installed_filters

__all__ = ["SymReconWarning", "apply_filter", "find_filter", "registry", "run_filter"]


class SymReconWarning(UserWarning):
    """Something the user should know; the step went on."""


_lock = threading.RLock()
_registries: list[Registry] = []


def registry(refresh: bool = False) -> Registry:
    """Return the installed filters, found once; ``refresh`` looks for them again."""
    with _lock:
        if refresh or not _registries:
            _registries[:] = [installed_filters()]
        return _registries[0]


def find_filter(name: str) -> Filter:
    """Return our filter with that Python name, alias or menu name.

    Raises
    ------
    PluginError
        The name belongs to a plugin that could not be loaded.
    UnknownFilterError
        No filter has that name.
    """
    known = registry()
    try:
        return known.find(name)
    except UnknownFilterError:
        plain = "_".join(name.lower().replace("-", " ").split())
        for failure in known.failures:
            if failure.name.lower().replace("-", "_") in plain:
                raise PluginError(f"filter '{name}': {failure.reason}") from None
        raise


def apply_filter(
    mesh_set: Any,
    name: str,
    /,
    *,
    progress: Callable[[float, str], None] | None = None,
    **parameters: object,
) -> dict[str, Any]:
    """Run a filter, ours or MeshLab's, on a MeshSet; change no class of pymeshlab.

    Parameters
    ----------
    mesh_set : pymeshlab.MeshSet
    name : str
        Python name, alias or menu name.
    progress : callable, optional
        Called with a fraction 0..1 and a message.
    **parameters
        By their Python names.

    Returns
    -------
    dict
        The measures, by name; empty when there are none.

    Raises
    ------
    UnknownFilterError, PluginError
        No filter has that name, or its plugin could not be loaded.
    ParameterError
        Unknown name, wrong type, or out of range.
    GeometryError
        The layers are not what the filter needs.
    HostError
        MeshLab refused the step.
    """
    return run_filter(mesh_set, find_filter(name), parameters, progress or silent)


def run_filter(
    mesh_set: Any,
    item: Filter,
    values: Mapping[str, object],
    progress: Callable[[float, str], None] = silent,
) -> dict[str, Any]:
    """Run one of our filters, add its layers, record the step; return its measures."""
    parameters = item.bind(values)
    outcome = item.apply(layers_of(mesh_set), values, progress)
    _add_layers(mesh_set, item, outcome)
    recorded = history.record(mesh_set, item, parameters)
    notes = list(outcome.warnings)
    if not recorded:
        notes.append(
            f"'{item.menu_name}' ran but is not in the filter history, since a step before it has "
            "a camera that MeshLab cannot read back; keep your own note of it"
        )
    for note in notes:
        warnings.warn(note, SymReconWarning, stacklevel=_frames_below_caller())
    return dict(outcome.measures)


def _frames_below_caller() -> int:
    return 3


def _add_layers(mesh_set: Any, item: Filter, outcome: Outcome) -> None:
    chosen = outcome.current
    if chosen is not None and outcome.layers and chosen not in range(len(outcome.layers)):
        message = (
            f"filter '{item.menu_name}' made {len(outcome.layers)} layers and chose number "
            f"{chosen} as the current one; report this to its author"
        )
        raise HostError(message)
    identifiers = [add_layer(mesh_set, layer, current=False) for layer in outcome.layers]
    if chosen is not None and identifiers:
        mesh_set.set_current_mesh(identifiers[chosen])
