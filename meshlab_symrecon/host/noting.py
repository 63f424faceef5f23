"""MeshLab's own steps, noted to the last bit when they run; see ``exact_steps``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import pymeshlab

from meshlab_symrecon.host import exact_steps
from meshlab_symrecon.host.aftermath import aftermath_undone

if TYPE_CHECKING:
    from meshlab_symrecon.host.native_filters import NativeFilter

__all__ = ["noted"]

# As it was before ``load_plugins`` could replace it.
_native_parameter_values = pymeshlab.MeshSet.filter_parameter_values


@contextmanager
def noted(mesh_set: Any, item: NativeFilter | None, values: Mapping[str, object]) -> Iterator[None]:
    """Note one of MeshLab's filters, which the block runs, unless the block has noted it itself.

    Nothing is noted when it fails, or where its values cannot be known.
    """
    about_to_run = None if item is None else _note_of(mesh_set, item, values)
    before = len(exact_steps.notes_of(mesh_set).steps)
    yield
    if about_to_run is not None and len(exact_steps.notes_of(mesh_set).steps) == before:
        exact_steps.note(mesh_set, about_to_run)


def _note_of(
    mesh_set: Any, item: NativeFilter, values: Mapping[str, object]
) -> exact_steps.Note | None:
    """Return the values that a step is about to run with; None where they cannot be known.

    Mistakes in them are left to pymeshlab, which is about to raise its own errors.
    """
    if item.probed or ("empty" in item.fatal and mesh_set.mesh_number() == 0):
        return None
    try:
        with aftermath_undone():
            used = _native_parameter_values(mesh_set, item.python_name, **values)
        return exact_steps.note_of(mesh_set, item, exact_steps.in_full(used, values))
    except Exception:  # noqa: BLE001  pymeshlab raises five unrelated kinds
        return None
