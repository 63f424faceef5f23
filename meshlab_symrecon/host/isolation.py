"""Work in a child process, so that a crash of native code ends as an error, not as the end of ours.

The child is a fresh interpreter, since a fork of a process in which OpenMP has run may hang. Its
job goes through its standard input, its progress and answer come through its standard output:
nothing is left on the disk, however it ends. It ends with its parent. Nothing here imports
pymeshlab, so a process that only looks after children stays small.
"""

from __future__ import annotations

import contextlib
import os
import pickle
import signal
import subprocess
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

from meshlab_symrecon.errors import HostError
from meshlab_symrecon.host.atomic import remove_staging, staging_prefix
from meshlab_symrecon.host.child_watch import Bounds, Watch
from meshlab_symrecon.host.interruption import guarded_child
from meshlab_symrecon.host.isolated_child import LENGTH, Answer, Job
from meshlab_symrecon.host.notices import warn_user
from meshlab_symrecon.host.own_program import own_program

if TYPE_CHECKING:
    from meshlab_symrecon.plugin import Progress

__all__ = [
    "Ending",
    "crash_in_words",
    "isolated",
    "run_child",
]

CHILD = "meshlab_symrecon.host.isolated_child"
WINDOWS_FAULT = 0xC0000000  # exit codes from here on are crashes there
LAST_BREATH = 10.0  # seconds for a child to end after its answer
WORDS = 4000  # characters that are kept of what a child prints


@dataclass(frozen=True, slots=True)
class Ending:
    """How a child process ended.

    Attributes
    ----------
    answer : Answer or None
        None when it crashed or was stopped.
    code : int
        Its exit code; below zero the signal that ended it.
    stopped : str
        Why it was ended from here: a word of ``child_watch``; empty when it ended itself.
    doing : str
        What it told last.
    seconds : float
    peak_memory : int
        Bytes of resident memory; of a child without an answer the most that was seen.
    words : str
        The end of what it printed, when that was kept.
    """

    answer: Answer | None
    code: int
    stopped: str
    doing: str
    seconds: float
    peak_memory: int
    words: str = ""


def isolated(
    function: Callable[..., Any],
    *arguments: Any,
    progress: Progress,
    folders: Sequence[Path] = (),
) -> Any:
    """Call ``function(*arguments, progress=...)`` in a child process; return what it returns.

    Parameters
    ----------
    function : callable
        At the top of a module; it, its arguments and its result are pickled.
    progress : callable
        Told what the child tells.
    folders : sequence of Path
        Where the child writes: what a crash leaves half-written there is removed.

    Raises
    ------
    SymReconError
        As the function.
    HostError
        The child crashed; the message names what it was doing.

    Warns
    -----
    SymReconWarning
        As the function.
    """
    ending = run_child(function, *arguments, progress=progress, folders=folders)
    if ending.answer is None:
        raise HostError(crash_in_words(ending))
    for sentence in ending.answer.warnings:
        warn_user(sentence)
    if ending.answer.error is not None:
        raise ending.answer.error
    return ending.answer.result


def run_child(
    function: Callable[..., Any],
    *arguments: Any,
    progress: Progress,
    folders: Sequence[Path] = (),
    bounds: Bounds | None = None,
    keep_words: bool = False,
) -> Ending:
    """Call a function in a child process as ``isolated`` does; return how that ended.

    The child and its own children are gone when this returns, or raises (when ``progress`` does,
    or an interruption comes).

    Parameters
    ----------
    bounds : Bounds, optional
    keep_words : bool
        Keep what the child prints out of our standard error stream.
    """
    bounds = bounds or Bounds()
    started = time.monotonic()
    with tempfile.TemporaryFile() if keep_words else contextlib.nullcontext() as words:
        child = _begun(bounds.environment, words)
        overslept = False
        try:
            _hand_over(child, Job(function, arguments, bounds.memory))
            watch = Watch(child, bounds, started)
            with guarded_child(child.pid, folders, staging_prefix(child.pid)):
                watch.listen(progress)
                if not watch.stopped:
                    overslept = _overslept(child)
        finally:
            _end(child)
            for written in folders:
                remove_staging(written, child.pid)
        whole = child.returncode == 0 or overslept
        return Ending(
            answer=watch.answer if whole and not watch.stopped else None,
            code=child.returncode,
            stopped=watch.stopped,
            doing=watch.doing,
            seconds=time.monotonic() - started,
            peak_memory=max(watch.peak, watch.answer.peak_memory if watch.answer else 0),
            words="" if words is None else _tail(words),
        )


def crash_in_words(ending: Ending) -> str:
    """Return one sentence for a child that ended without an answer."""
    code = ending.code
    if code < 0:
        how = f"by {_signal_name(-code)}"
    else:
        how = f"with exit code {code:#x}" if code >= WINDOWS_FAULT else f"with exit code {code}"
    where = f"{ending.doing}: " if ending.doing else ""
    return (
        f"{where}MeshLab's native code ended the process {how}; nothing was written; leave that "
        "step out, or run it in the MeshLab program"
    )


def _signal_name(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:  # a real-time one
        return f"signal {number}"


def _begun(environment: Mapping[str, str], words: IO[bytes] | None) -> subprocess.Popen[bytes]:
    """Begin a child; what it prints as errors goes to ``words``, or to our standard error."""
    return subprocess.Popen(  # noqa: S603  our own interpreter, our own program
        [*own_program(CHILD), str(os.getpid())],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=words,
        env=os.environ | dict(environment),
        start_new_session=True,  # it is ended from here, with all of its own children
    )


def _hand_over(child: subprocess.Popen[bytes], job: Job) -> None:
    """Send the job; the pipe stays open, since its end tells the child of ours."""
    data = pickle.dumps(job)
    with contextlib.suppress(BrokenPipeError):  # it has crashed already, which is seen later
        if child.stdin is not None:
            child.stdin.write(LENGTH.pack(len(data)) + data)
            child.stdin.flush()


def _overslept(child: subprocess.Popen[bytes]) -> bool:
    """Wait for a child that has closed its pipe; say whether it hangs all the same."""
    try:
        child.wait(LAST_BREATH)
    except subprocess.TimeoutExpired:
        return True
    return False


def _end(child: subprocess.Popen[bytes]) -> None:
    """Kill a child with its own children, if they still run, and close the pipes."""
    if hasattr(os, "killpg"):
        with contextlib.suppress(OSError):  # nobody of that group is left
            os.killpg(child.pid, signal.SIGKILL)
    child.kill()
    child.wait()
    for stream in (child.stdin, child.stdout):
        if stream is not None:
            with contextlib.suppress(OSError):
                stream.close()


def _tail(words: IO[bytes]) -> str:
    words.seek(0, os.SEEK_END)
    words.seek(max(0, words.tell() - WORDS))
    return words.read().decode("utf-8", "replace")
