"""How a child process is started that does our work: with our modules, wherever the user is."""

from __future__ import annotations

import sys

__all__ = ["own_program"]

# Python looks for modules in the folder where the user is first, and a numpy.py there is not ours.
# PYTHONSAFEPATH would do, but Python 3.10 does not know it. ``sys`` is built in.
PROGRAM = "import sys; sys.path[:] = [p for p in sys.path if p]; from {} import main; main()"


def own_program(module: str) -> list[str]:
    """Return the words of a command that calls ``main`` of a module of ours."""
    return [sys.executable, "-c", PROGRAM.format(module)]
