"""Many scans through one script, or through the whole method, each in a process of its own."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from meshlab_symrecon.batch.listener import Listener
    from meshlab_symrecon.batch.reports import BatchReport, ScanReport
    from meshlab_symrecon.batch.request import Batch, Limits
    from meshlab_symrecon.batch.running import BatchInterruptedError, run_batch

__all__ = [
    "Batch",
    "BatchInterruptedError",
    "BatchReport",
    "Limits",
    "Listener",
    "ScanReport",
    "run_batch",
]

_PLACES = {
    "Batch": "request",
    "BatchInterruptedError": "running",
    "BatchReport": "reports",
    "Limits": "request",
    "Listener": "listener",
    "ScanReport": "reports",
    "run_batch": "running",
}


def __getattr__(name: str) -> Any:
    """Import a part when it is first asked for: a worker needs few of them."""
    if name not in _PLACES:
        raise AttributeError(f"module 'meshlab_symrecon.batch' has no attribute {name!r}")
    return getattr(import_module(f"meshlab_symrecon.batch.{_PLACES[name]}"), name)
