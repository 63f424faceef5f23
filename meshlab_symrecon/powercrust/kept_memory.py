"""Memory that one stage has freed, kept for the next one."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from meshlab_symrecon import _native

__all__ = ["kept_memory"]

LEAST = 50_000  # samples; arrays of fewer are kept anyway


@contextmanager
def kept_memory(samples: int) -> Iterator[None]:
    """Let the C library keep freed arrays in this block, and give them back after it.

    The stages of the crust make and free gigabytes one after the other. It has an effect where the
    library is glibc; elsewhere memory is as ever.
    """
    if samples < LEAST:
        yield
        return
    _native.keep_freed_memory(True)
    try:
        yield
    finally:
        _native.keep_freed_memory(False)
