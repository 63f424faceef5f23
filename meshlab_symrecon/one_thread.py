"""Linear algebra in one thread: the bytes of a result do not tell how many there were.

A BLAS that works in several threads adds up in another order, so the last bits change with their
number, and here and there a choice between two nearly equal planes or triangles follows. All
matrices here are narrow or small; one thread is as fast, and takes less of the processor.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache, wraps
from typing import Any, ParamSpec, TypeVar

__all__ = ["in_one_thread", "one_thread"]

P = ParamSpec("P")
R = TypeVar("R")


class _Limit:
    """Which libraries were limited, and how many threads of Python need it at the moment.

    Where a library counts its threads for each thread of Python apart (OpenMP), each one gives
    back what it had itself; else the last one gives it back for all.
    """

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self.needed = 0
        self.had: list[tuple[Any, int]] = []
        self.own = threading.local()

    def enter(self) -> None:
        depth = getattr(self.own, "depth", 0)
        if depth == 0:
            with self.lock:
                changed = [(known, known.get_num_threads()) for known in _libraries()]
                changed = [(known, count) for known, count in changed if count not in {None, 1}]
                for known, _ in changed:
                    _set(known, 1)
                self.own.had = [(known, count) for known, count in changed if _is_apart(known)]
                self.had += [(known, count) for known, count in changed if not _is_apart(known)]
                self.needed += 1
        self.own.depth = depth + 1

    def leave(self) -> None:
        self.own.depth -= 1
        if self.own.depth:
            return
        with self.lock:
            self.needed -= 1
            back = list(self.own.had)
            if self.needed == 0:
                back += self.had
                self.had = []
            for known, count in back:
                _set(known, count)


_limit = _Limit()


@cache
def _libraries() -> tuple[Any, ...]:
    """Return what sets the threads of the BLAS of numpy and of that of scipy."""
    import scipy.linalg  # noqa: F401  # loads the second one
    from threadpoolctl import ThreadpoolController

    found = ThreadpoolController().lib_controllers
    return tuple(known for known in found if known.user_api == "blas")


def _is_apart(known: Any) -> bool:
    return getattr(known, "threading_layer", None) == "openmp"


def _set(known: Any, count: int) -> None:
    """Set a library's threads, from whichever thread of Python."""
    # Newer versions of threadpoolctl listen only to the first thread that has ever set them.
    release = getattr(known, "clear_controlling_thread", None)
    if release is not None:
        release(force=True)
    known.set_num_threads(count)
    if release is not None:
        release(force=True)


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
