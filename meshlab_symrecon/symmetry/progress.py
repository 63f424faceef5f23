"""Whom to tell how far a step has come."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

__all__ = ["Progress", "part", "share_of", "silent"]

Progress: TypeAlias = Callable[[float, str], None]  # the share that is done, and what is being done


def part(progress: Progress, low: float, high: float) -> Progress:
    """Return a callback for a step that takes the whole from ``low`` to ``high``."""
    return lambda fraction, message: progress(low + (high - low) * fraction, message)


def share_of(progress: Progress, message: str) -> Callable[[float], None]:
    """Return a callback for the share alone of what ``message`` names."""
    return lambda fraction: progress(fraction, message)


def silent(fraction: float, message: str) -> None:
    """Report progress to nobody."""
