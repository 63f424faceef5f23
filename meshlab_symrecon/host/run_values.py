"""What filters ran with, for reports: the same values as in the records of results."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from meshlab_symrecon.host import exact_steps
from meshlab_symrecon.host.native_filters import NativeFilter, completed
from meshlab_symrecon.host.recorded_values import recorded_values
from meshlab_symrecon.host.written_steps import written_step
from meshlab_symrecon.plugin import Filter

__all__ = ["noted_steps", "values_of_run"]


def noted_steps(mesh_set: Any) -> int:
    """Return how many steps of a MeshSet are noted, to tell later which came after."""
    return len(exact_steps.notes_of(mesh_set).steps)


def values_of_run(
    mesh_set: Any, item: Filter | NativeFilter, values: Mapping[str, object], noted: int
) -> dict[str, Any]:
    """Return all parameters of a filter that has run, by Python names, as plain data.

    Where MeshLab does not tell a filter's defaults, they are those that it was given.

    Parameters
    ----------
    mesh_set : pymeshlab.MeshSet
    item : Filter or NativeFilter
    values : mapping
        What it was given; layers as positions.
    noted : int
        ``noted_steps`` before it ran.
    """
    steps = exact_steps.notes_of(mesh_set).steps[noted:]
    ran = (note.written for note in steps if note.written.name == item.menu_name)
    step = next(ran, None)
    if step is None:
        given = completed(item, values) if isinstance(item, NativeFilter) else values
        step = written_step(item, given)
    return recorded_values(step, folders=True)
