"""What a filter or a save that fails leaves behind in pymeshlab, undone.

For the time of a call, pymeshlab turns C++'s standard streams to Python's, and keeps a pointer to
the log of the MeshSet. When the call fails it undoes neither. From then on MeshLab's prints are
lost, and once that MeshSet is gone, the next load may log into freed memory and end the process.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any

import pymeshlab

from meshlab_symrecon import _native

__all__ = ["aftermath_undone", "undo_aftermath"]

_first = _native.stream_buffers()  # when this module was imported, before anything failed


def undo_aftermath() -> None:
    """Let MeshLab forget the log of the call that failed; put C++'s streams back."""
    _bystander().set_selection_none()  # a filter that succeeds lets go of any log
    _native.set_stream_buffers(*_first)


@contextmanager
def aftermath_undone() -> Iterator[None]:
    """Run calls of pymeshlab; undo what they leave behind when one fails."""
    try:
        yield
    except BaseException:
        undo_aftermath()
        raise


@cache
def _bystander() -> Any:
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.create_cube()
    return mesh_set
