"""Linear algebra in one thread: the bytes of a result do not tell how many there were.

A BLAS that works in several threads adds up in another order, so the last bits change with their
number, and here and there a choice between two nearly equal planes or triangles follows. All
matrices here are narrow or small; one thread is as fast, and takes less of the processor.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import cache, wraps
from typing import Any, ParamSpec, TypeVar

__all__ = ["in_one_thread", "one_thread"]

P = ParamSpec("P")
R = TypeVar("R")


class _Limit:
    """The limit of the whole process, and how many calls under way need it."""

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self.calls = 0
        self.undo = ExitStack()

    def enter(self) -> None:
        with self.lock:
            if self.calls == 0:
                self.undo.enter_context(_libraries().limit(limits=1, user_api="blas"))
            self.calls += 1

    def leave(self) -> None:
        with self.lock:
            self.calls -= 1
            if self.calls == 0:
                self.undo.close()


_limit = _Limit()


@cache
def _libraries() -> Any:
    """Return what sets the threads of the BLAS of numpy and of that of scipy."""
    import scipy.linalg  # noqa: F401  # loads the second one
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


@contextmanager
def one_thread() -> Iterator[None]:
    """Let linear algebra work in one thread, in the whole process, while the block runs.

    Blocks may be nested, and run at once in several threads of Python.
    """
    _limit.enter()
    try:
        yield
    finally:
        _limit.leave()


def in_one_thread(function: Callable[P, R]) -> Callable[P, R]:
    """Return a function that does the same inside ``one_thread``."""

    @wraps(function)
    def limited(*args: P.args, **kwargs: P.kwargs) -> R:
        with one_thread():
            return function(*args, **kwargs)

    return limited
