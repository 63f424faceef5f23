"""The inside of an isolated process: it takes a job from its parent, and dies with it.

Nothing here imports pymeshlab before the job does.
"""

from __future__ import annotations

import copyreg
import ctypes
import os
import pickle
import signal
import struct
import sys
import threading
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

from meshlab_symrecon.errors import SymReconError, SymReconWarning

__all__ = ["LENGTH", "Answer", "Box", "Job", "Told", "main"]

LENGTH = struct.Struct("<Q")  # bytes of the pickle that follows
DEATH_SIGNAL = 1  # PR_SET_PDEATHSIG of prctl(2)
# Bytes that are mapped and never touched: stacks of threads and buffers of BLAS, which numpy and
# scipy each have a copy of.
SLACK, SLACK_OF_A_CORE = 512 << 20, 96 << 20
STATUS = Path("/proc/self/status")


@dataclass(frozen=True, slots=True)
class Box:
    """A bounding box of pymeshlab, which cannot travel itself."""

    low: Any
    high: Any

    def min(self) -> Any:
        """Return the lowest corner, (3,)."""
        return self.low

    def max(self) -> Any:
        """Return the highest corner, (3,)."""
        return self.high

    def diagonal(self) -> float:
        """Return the length of the diagonal."""
        return float(sum((self.high - self.low) ** 2) ** 0.5)


@dataclass(frozen=True, slots=True)
class Job:
    """What a child is to do, and with how much memory."""

    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    memory: int | None  # bytes


@dataclass(frozen=True, slots=True)
class Told:
    """One word of progress."""

    fraction: float
    message: str


@dataclass(frozen=True, slots=True)
class Answer:
    """What came of the job."""

    result: Any
    error: SymReconError | None
    warnings: tuple[str, ...]
    peak_memory: int  # bytes


def main() -> None:
    """Do the job that comes through the standard input; tell and answer on the standard output."""
    _die_with(int(sys.argv[1]))
    channel = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what native code prints does not disturb the channel
    job: Job = pickle.loads(_framed(sys.stdin.buffer))  # noqa: S301  our own parent's
    _bound(job.memory)

    def progress(fraction: float, message: str) -> None:
        _send(channel, Told(float(fraction), message))

    result, error = None, None
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", SymReconWarning)
        try:
            result = job.function(*job.arguments, progress=progress)
        except SymReconError as refused:
            error = refused
    sentences = [str(one.message) for one in caught if issubclass(one.category, SymReconWarning)]
    pymeshlab = sys.modules.get("pymeshlab")
    if pymeshlab is not None:
        copyreg.pickle(pymeshlab.BoundingBox, _reduced_box)
    _send(channel, Answer(result, error, tuple(sentences), _peak_memory()))


def _send(channel: IO[bytes], what: Told | Answer) -> None:
    data = pickle.dumps(what)
    channel.write(LENGTH.pack(len(data)) + data)
    channel.flush()


def _framed(stream: IO[bytes]) -> bytes:
    return stream.read(LENGTH.unpack(stream.read(LENGTH.size))[0])


def _die_with(parent: int) -> None:
    """End this process when its parent ends, even while native code keeps Python from running."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(DEATH_SIGNAL, signal.SIGKILL)
        if os.getppid() != parent:  # it ended before the kernel was asked
            os._exit(1)
    else:
        threading.Thread(target=_end_at_end_of_file, daemon=True).start()


def _end_at_end_of_file() -> None:
    """Wait for the parent's end of the pipe to close; the job has been read from it by then."""
    while os.read(0, 1):
        pass
    os._exit(1)


def _bound(memory: int | None) -> None:
    """Let what asks for far more than the bound fail at once; the parent watches the rest."""
    if memory is None or sys.platform != "linux":
        return
    import resource

    limit = memory + SLACK + SLACK_OF_A_CORE * (os.cpu_count() or 1)
    hard = resource.getrlimit(resource.RLIMIT_DATA)[1]
    if hard == resource.RLIM_INFINITY or limit < hard:
        resource.setrlimit(resource.RLIMIT_DATA, (limit, hard))


def _peak_memory() -> int:
    """Return the most memory that this process has held, in bytes; 0 where nobody knows."""
    try:
        lines = STATUS.read_text(encoding="ascii", errors="replace").splitlines()
    except OSError:
        return 0
    held = [line.split()[1] for line in lines if line.startswith("VmHWM:")]
    return int(held[0]) * 1024 if held else 0


def _reduced_box(box: Any) -> tuple[type[Box], tuple[Any, Any]]:
    return Box, (box.min(), box.max())
