"""How many threads numerical libraries use: told to them before they are loaded, or after."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager

from meshlab_symrecon.host.thread_variables import VARIABLES

__all__ = ["asked_threads", "limited_threads"]

OPTION = "--threads"


@contextmanager
def limited_threads(count: int | None) -> Iterator[None]:
    """Let libraries use ``count`` threads in this block, and in child processes; None: as they are.

    Libraries that are loaded in the block read the environment, those that are there already are
    told.
    """
    if count is None:
        yield
        return
    before = {name: os.environ.get(name) for name in VARIABLES}
    os.environ.update(dict.fromkeys(VARIABLES, str(count)))
    with ExitStack() as stack:
        if "numpy" in sys.modules:
            from threadpoolctl import threadpool_limits

            stack.enter_context(threadpool_limits(count))
        try:
            yield
        finally:
            for name, value in before.items():
                os.environ.pop(name)
                if value is not None:
                    os.environ[name] = value


def asked_threads(words: Sequence[str]) -> int | None:
    """Return the number that a command line asks for, before it is parsed; None for nothing.

    What is wrong with it, the parser says later.
    """
    asked = None
    for number, word in enumerate(words):
        name, equals, value = word.partition("=")
        if name == OPTION:
            value = value if equals else "".join(words[number + 1 : number + 2])
            if value.isdecimal() and int(value) > 0:
                asked = int(value)
    return asked
