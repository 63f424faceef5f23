"""One step on a MeshSet, ours or MeshLab's."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from typing import Any

from meshlab_symrecon.errors import HostError, PluginError, UnknownFilterError
from meshlab_symrecon.host import exact_steps, history
from meshlab_symrecon.host.meshset import add_layer, check_addable, layers_of
from meshlab_symrecon.host.native_filters import apply_native, find_native, is_native
from meshlab_symrecon.host.notices import warn_user
from meshlab_symrecon.host.scalars import (
    NATIVE_STEPS,
    QUALITY_FUNCTION,
    check_writable,
    write_scalars,
)
from meshlab_symrecon.one_thread import in_one_thread
from meshlab_symrecon.plugin import Filter, Outcome, Progress
from meshlab_symrecon.plugin.filter import silent
from meshlab_symrecon.plugin.parameters import nearest_names
from meshlab_symrecon.plugin.registry import Registry, installed_filters, origin

__all__ = ["apply_filter", "find_filter", "registry", "run_filter"]

_lock = threading.RLock()
_found: list[Registry] = []


def registry(refresh: bool = False) -> Registry:
    """Return the installed filters, found once; ``refresh`` looks for them again.

    Raises
    ------
    PluginError
        Two filters claim one name, or a plugin claims the name of one of MeshLab's filters.
    """
    with _lock:
        if refresh or not _found:
            found = installed_filters()
            _check_names_are_free(found)
            _found[:] = [found]
        return _found[0]


def _check_names_are_free(found: Registry) -> None:
    for item in found:
        for name in item.names:
            if is_native(name):
                message = (
                    f"{origin(item)} claims the name '{name}' of one of MeshLab's own filters; "
                    "rename it or uninstall its package"
                )
                raise PluginError(message)


def find_filter(name: str) -> Filter:
    """Return the plugin filter with that Python name, alias or menu name.

    Raises
    ------
    PluginError
        The name is that of a plugin that could not be loaded.
    UnknownFilterError
        No plugin has that name.
    """
    known = registry()
    try:
        return known.find(name)
    except UnknownFilterError:
        wanted = _joined(name)
        for failure in known.failures:
            if _joined(failure.name) in wanted:
                raise PluginError(f"filter '{name}' is not there: {failure.reason}") from None
        raise


def _joined(name: str) -> str:
    return "_".join(name.lower().replace("-", " ").replace("_", " ").split())


def apply_filter(
    mesh_set: Any, name: str, /, *, progress: Progress | None = None, **parameters: object
) -> dict[str, Any]:
    """Run a filter, a plugin's or MeshLab's, on a MeshSet; change no class of pymeshlab.

    Parameters
    ----------
    mesh_set : pymeshlab.MeshSet
    name : str
        Python name, alias or menu name.
    progress : callable, optional
        Called with a fraction 0..1 and a message; for MeshLab's own filters, which report to
        nobody, at their start and end.
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
    report = progress or silent
    if is_native(name):
        menu_name = find_native(name).menu_name
        report(0.0, menu_name)
        measures = apply_native(mesh_set, name, parameters)
        report(1.0, menu_name)
        return measures
    try:
        item = find_filter(name)
    except UnknownFilterError as error:
        raise UnknownFilterError(_unknown(name)) from error
    return run_filter(mesh_set, item, parameters, report)


def _unknown(name: str) -> str:
    """Name the nearest filter of all, in a sentence."""
    ours = [known for item in registry() for known in item.names]
    try:
        find_native(name)
    except UnknownFilterError as error:
        hint = nearest_names(name, ours)
        return f"no filter is called '{name}'{hint}" if hint else str(error)
    raise AssertionError(f"{name} is known")  # the caller looked it up


@in_one_thread
def run_filter(
    mesh_set: Any, item: Filter, values: Mapping[str, object], progress: Progress = silent
) -> dict[str, Any]:
    """Run a plugin's filter: write what it made, record the step, warn; return its measures.

    Raises
    ------
    ParameterError, GeometryError
        As ``Filter.apply``.
    HostError
        The filter made something that MeshLab cannot hold.
    """
    parameters = item.bind(values)
    note = exact_steps.note_of(mesh_set, item, parameters.values())
    outcome = item.apply(layers_of(mesh_set), values, progress)
    progress(1.0, "adding layers" if outcome.layers else "done")
    _write(mesh_set, item, outcome)
    native_steps = NATIVE_STEPS * len(outcome.scalars)
    if not history.record(mesh_set, item, parameters, note, native_steps):
        warn_user(_unrecorded(item, native_steps))
    for sentence in outcome.warnings:
        warn_user(sentence)
    return dict(outcome.measures)


def _unrecorded(item: Filter, native_steps: int) -> str:
    sentence = (
        f"'{item.menu_name}' ran, but is not in the filter history: a step before it holds a "
        "camera, which MeshLab cannot read back"
    )
    if not native_steps:
        return sentence
    means = find_native(QUALITY_FUNCTION).menu_name
    return f"{sentence}; in its place is '{means}', by which it wrote the quality"


def _write(mesh_set: Any, item: Filter, outcome: Outcome) -> None:
    """Write scalars into layers, and add the new layers: all or nothing."""
    chosen = outcome.current
    if chosen is not None and outcome.layers and chosen not in range(len(outcome.layers)):
        message = (
            f"'{item.menu_name}' made {len(outcome.layers)} layers and wants number {chosen} to be "
            "the current one; report this to its author"
        )
        raise HostError(message)
    for layer in outcome.layers:
        check_addable(layer)
    for scalars in outcome.scalars:
        check_writable(mesh_set, scalars)
    for scalars in outcome.scalars:
        write_scalars(mesh_set, scalars)
    identifiers = [add_layer(mesh_set, layer, current=False) for layer in outcome.layers]
    if chosen is not None and identifiers:
        mesh_set.set_current_mesh(identifiers[chosen])
