"""MeshLab filters in Python: complete a statue scan from its mirror symmetry, close it."""

from __future__ import annotations

from typing import Any

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

_HOME = {
    "SymReconWarning": "registration",
    "apply_filter": "registration",
    "filter_list": "registration",
    "load_plugins": "registration",
    "unload_plugins": "registration",
}


def __getattr__(name: str) -> Any:
    """Import what talks to pymeshlab when it is first asked for."""
    if name not in _HOME:
        raise AttributeError(f"module 'meshlab_symrecon' has no attribute {name!r}")
    from importlib import import_module  # noqa: PLC0415

    return getattr(import_module(f"meshlab_symrecon.host.{_HOME[name]}"), name)
