"""MeshLab filters in Python: complete a statue scan from its mirror symmetry, close it.

Importing this package is quick and does not import pymeshlab; what needs it, imports it when first
used.
"""

from __future__ import annotations

from importlib import import_module
from os import PathLike
from typing import TYPE_CHECKING, Any

from meshlab_symrecon.errors import SymReconWarning

if TYPE_CHECKING:
    from meshlab_symrecon.host.registration import (
        apply_filter,
        filter_list,
        load_plugins,
        unload_plugins,
    )
    from meshlab_symrecon.plugin import Progress

__version__ = "0.1.0"

__all__ = [
    "SymReconWarning",
    "__version__",
    "apply_filter",
    "apply_filter_script",
    "filter_list",
    "load_plugins",
    "unload_plugins",
]

_OF_THE_HOST = ("apply_filter", "filter_list", "load_plugins", "unload_plugins")


def __getattr__(name: str) -> Any:
    """Import what talks to pymeshlab when it is first asked for."""
    if name not in _OF_THE_HOST:
        raise AttributeError(f"module 'meshlab_symrecon' has no attribute {name!r}")
    return getattr(import_module("meshlab_symrecon.host.registration"), name)


def apply_filter_script(
    mesh_set: Any, path: str | PathLike[str], *, progress: Progress | None = None
) -> Any:
    """Check a filter script, then run it on a MeshSet; return the report of its steps.

    Raises
    ------
    ScriptError
        The script cannot be read, or a step cannot run; nothing has run then.
    """
    return import_module("meshlab_symrecon.host.script").run_script(
        mesh_set, path, progress=progress
    )
