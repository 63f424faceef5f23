"""The programs' first lines: ready for Ctrl-C before anything that takes time is loaded."""

from __future__ import annotations

import os
import signal
import sys

TYPE_CHECKING = False  # importing typing would take as long as all that comes before

if TYPE_CHECKING:
    from types import FrameType

__all__ = ["server", "symrecon"]

SENTENCE = b"interrupted; nothing was left half-written\n"
OF_SIGNALS = 128


def symrecon() -> None:
    """Run ``symrecon``."""
    _run("meshlab_symrecon.cli.main")


def server() -> None:
    """Run ``symrecon-server``."""
    _run("meshlab_symrecon.cli.server")


def _run(program: str) -> None:
    """Load a program and run its ``main``; Ctrl-C is seen to before, and when it is done."""
    _end_at_interrupt()
    _open_closed_streams()
    _write_names_in_utf_8()
    from importlib import import_module

    main = import_module(program).main
    try:
        main()
    finally:
        _let_end()


def _open_closed_streams() -> None:
    """Let streams that are closed, as daemons leave them, lead nowhere.

    A file would be opened in their place else, and get what MeshLab tells the standard output.
    """
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(number)
        except OSError:
            opened = os.open(os.devnull, os.O_RDWR)
            if opened != number:
                os.dup2(opened, number)
                os.close(opened)
            os.set_inheritable(number, True)
        if getattr(sys, name) is None:
            mode = "w" if number else "r"
            setattr(sys, name, open(number, mode, encoding="utf-8", closefd=False))  # noqa: SIM115


def _write_names_in_utf_8() -> None:
    """Let MeshLab and child processes name files as Python does, also where LC_ALL is C."""
    if os.environ.get("LC_ALL") in ("C", "POSIX"):
        os.environ["LC_ALL"] = "C.UTF-8"


def _end_at_interrupt() -> None:
    """End at Ctrl-C at once, as long as nothing can be half-written; see ``interruptible``."""

    def end(number: int, frame: FrameType | None) -> None:
        os.write(2, SENTENCE)
        os._exit(OF_SIGNALS + number)

    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, end)


def _let_end() -> None:
    """Have no signal change the exit code of what is done, while Python tidies up."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
