"""What MeshLab's filters log while they run, which pymeshlab only writes to the streams.

Old shell scripts read measures from it. ``meshlab_symrecon.host`` tells Qt to be quiet, so that a
program that wants the log sets ``QT_LOGGING_RULES`` otherwise before it imports that package.
"""

from __future__ import annotations

import io
import os
import re
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stdout
from typing import Any, BinaryIO

__all__ = ["NativeLog", "native_log"]

LOGGED = re.compile(r"LOG: \d+ ?(.*)")
PROGRESS = re.compile(r".*\[ *\d+ ?% *\]")
OUTPUT, ERRORS = 1, 2  # file descriptors of the standard streams


class NativeLog:
    """The log of the filters, in the file to which the standard error stream was diverted."""

    def __init__(self, mesh_set: Any, file: BinaryIO) -> None:
        self.mesh_set = mesh_set
        self.file = file
        self.taken = 0

    def take(self) -> list[str]:
        """Return the lines that were logged since they were last taken, without their mark."""
        size = os.fstat(self.file.fileno()).st_size
        self.file.seek(0)
        content = self.file.read(size)[self.taken :]
        self.file.seek(0, os.SEEK_END)  # the native side writes where this stands
        self.taken = size
        matches = map(LOGGED.fullmatch, content.decode("utf-8", "replace").splitlines())
        lines = [match[1].rstrip() for match in matches if match]
        return [line for line in lines if not PROGRESS.fullmatch(line)]

    @contextmanager
    def listening(self, say: Callable[[str], None]) -> Iterator[Callable[[float, str], None]]:
        """Let filters log inside the block.

        Parameters
        ----------
        say : callable
            Called with each line.

        Yields
        ------
        callable
            A progress callback that says what was logged so far; at the end of the block that
            happens by itself.
        """
        self.take()  # what was written before is nobody's business
        output = sys.stdout

        def relay(fraction: float = 1.0, message: str = "") -> None:
            with redirect_stdout(output):
                for line in self.take():
                    say(line)

        self.mesh_set.set_verbosity(True)
        try:
            with redirect_stdout(io.StringIO()):  # pymeshlab prints parameters there
                yield relay
        finally:
            self.mesh_set.set_verbosity(False)
            relay()


@contextmanager
def native_log(mesh_set: Any) -> Iterator[NativeLog]:
    """Drop what MeshLab's side writes to the standard streams inside the block, but for the log.

    What Python code writes to these streams goes where it always goes.
    """
    with (
        tempfile.TemporaryFile() as output,
        tempfile.TemporaryFile(buffering=0) as errors,
        _diverted(OUTPUT, "stdout", output),
        _diverted(ERRORS, "stderr", errors),
    ):
        yield NativeLog(mesh_set, errors)


@contextmanager
def _diverted(descriptor: int, name: str, file: BinaryIO) -> Iterator[None]:
    """Divert a descriptor to a file; Python's stream of that name stays as it was."""
    stream = getattr(sys, name)
    stream.flush()
    kept = os.dup(descriptor)
    os.dup2(file.fileno(), descriptor)
    python = None
    if _writes_to(stream, descriptor):
        python = open(  # noqa: SIM115  closed below, when nothing may write to it any more
            kept, "w", encoding=stream.encoding, errors=stream.errors, buffering=1, closefd=False
        )
        setattr(sys, name, python)
    try:
        yield
    finally:
        setattr(sys, name, stream)
        try:
            if python is not None:
                python.close()
        finally:  # a full disk, or a reader that has gone
            os.dup2(kept, descriptor)
            os.close(kept)


def _writes_to(stream: Any, descriptor: int) -> bool:
    try:
        return bool(stream.fileno() == descriptor)
    except (AttributeError, OSError, ValueError):  # a stand-in of a test
        return False
