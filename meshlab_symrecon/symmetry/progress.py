"""Whom to tell how far a step has come."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

__all__ = ["Progress", "silent"]

Progress: TypeAlias = Callable[[float, str], None]  # the share that is done, and what is being done


def silent(fraction: float, message: str) -> None:
    """Report progress to nobody."""
