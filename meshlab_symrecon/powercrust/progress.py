"""The share of a step that is done, told as a share of the whole."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

__all__ = ["Progress", "part"]

Progress: TypeAlias = Callable[[float], object]


def part(progress: Progress | None, low: float, high: float) -> Progress | None:
    """Return a callback for a step that takes the whole from ``low`` to ``high``."""
    if progress is None:
        return None
    return lambda fraction: progress(low + (high - low) * fraction)
