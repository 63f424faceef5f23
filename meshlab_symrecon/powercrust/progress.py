"""The share of a step that is done, told as a share of the whole."""

from __future__ import annotations

from meshlab_symrecon.geometry.triangulation import Progress

__all__ = ["Progress", "part"]


def part(progress: Progress | None, low: float, high: float) -> Progress | None:
    """Return a callback for a step that takes the whole from ``low`` to ``high``."""
    if progress is None:
        return None
    return lambda fraction: progress(low + (high - low) * fraction)
