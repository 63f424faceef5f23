"""MeshLab filters in Python: complete a statue scan from its mirror symmetry, close it.

Importing this package is quick and does not import pymeshlab; what needs it, imports it when first
used.
"""

from __future__ import annotations

from importlib import import_module

from meshlab_symrecon.errors import SymReconWarning

TYPE_CHECKING = False  # typing takes longer to import than all of this; checkers know the name

if TYPE_CHECKING:
    from os import PathLike
    from typing import Any

    from meshlab_symrecon.host.filter_script import FilterScript
    from meshlab_symrecon.host.registration import (
        apply_filter,
        filter_list,
        load_plugins,
        unload_plugins,
    )
    from meshlab_symrecon.plugin import Progress

__version__ = "0.1.0"

__all__ = [
    "FilterScript",
    "SymReconWarning",
    "__version__",
    "apply_filter",
    "apply_filter_script",
    "filter_list",
    "load_plugins",
    "unload_plugins",
]

_OF_THE_HOST = {
    "FilterScript": "filter_script",
    "apply_filter": "registration",
    "filter_list": "registration",
    "load_plugins": "registration",
    "unload_plugins": "registration",
}


def __getattr__(name: str) -> Any:
    """Import what talks to pymeshlab when it is first asked for."""
    if name not in _OF_THE_HOST:
        raise AttributeError(f"module 'meshlab_symrecon' has no attribute {name!r}")
    return getattr(import_module(f"meshlab_symrecon.host.{_OF_THE_HOST[name]}"), name)


def apply_filter_script(
    mesh_set: Any,
    path: str | PathLike[str],
    *,
    strict: bool = False,
    lenient: bool = False,
    isolate: bool = False,
    progress: Progress | None = None,
) -> Any:
    """Check a filter script, then run it on a MeshSet; return the report of its steps.

    Parameters
    ----------
    mesh_set : pymeshlab.MeshSet
    path : path-like
    strict : bool
        Refuse a script of which anything would be mapped or ignored.
    lenient : bool
        Pass over steps that cannot run, and report each.
    isolate : bool
        Try it on a copy in a child process first, so that a crash of MeshLab is an error.
    progress : callable, optional
        Called with a fraction 0..1 and a message.

    Raises
    ------
    FileError, ScriptError
        The script cannot be read, has mistakes, all of which are listed and nothing has run, or a
        step failed.
    HostError
        A step crashed in the child process; the document is as it was.
    """
    script = import_module("meshlab_symrecon.host.filter_script").FilterScript.read(path)
    return script.run(mesh_set, strict=strict, lenient=lenient, isolate=isolate, progress=progress)
