"""Work in a child process, so that a crash of native code ends as an error, not as the end of ours.

The child is a fresh interpreter, since a fork of a process in which OpenMP has run may hang. It
reads its job from a file, tells its progress on its standard output, line by line, and leaves its
answer in another file.
"""

from __future__ import annotations

import copyreg
import json
import os
import pickle
import signal
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import pymeshlab

from meshlab_symrecon import _native
from meshlab_symrecon.errors import HostError, SymReconError, SymReconWarning
from meshlab_symrecon.host.atomic import remove_staging, staging_prefix
from meshlab_symrecon.host.interruption import guarded_child
from meshlab_symrecon.host.notices import warn_user
from meshlab_symrecon.plugin import Progress

__all__ = ["Box", "isolated"]

JOB, ANSWER = "job.pickle", "answer.pickle"
CHILD = "from meshlab_symrecon.host.isolation import main; main()"
WINDOWS_FAULT = 0xC0000000  # exit codes from here on are crashes there


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
    with tempfile.TemporaryDirectory(prefix="symrecon-") as folder:
        Path(folder, JOB).write_bytes(pickle.dumps((function, arguments)))
        child = subprocess.Popen(  # noqa: S603  our own interpreter, our own program
            [sys.executable, "-c", CHILD, folder, str(os.getpid())],
            stdout=subprocess.PIPE,
            text=True,
            encoding="utf-8",
            env=os.environ | {"PYTHONSAFEPATH": "1"},  # a numpy.py in the folder here is not ours
            start_new_session=True,  # a terminal's Ctrl-C is for us; we end the child
        )
        try:
            with guarded_child(child.pid, folders, staging_prefix(child.pid)):
                doing = _listened(child.stdout, progress)
                code = child.wait()
        finally:
            child.kill()
            child.wait()
            if child.stdout is not None:
                child.stdout.close()
            for written in folders:
                remove_staging(written, child.pid)
        answer = Path(folder, ANSWER)
        if code != 0 or not answer.exists():
            raise HostError(_crash(doing, code))
        result, error, sentences = pickle.loads(answer.read_bytes())  # noqa: S301  our own child's
    for sentence in sentences:
        warn_user(sentence)
    if error is not None:
        raise error
    return result


def _listened(stream: IO[str] | None, progress: Progress) -> str:
    """Pass the child's progress on until it ends; return what it was doing last."""
    doing = ""
    for line in stream or ():
        fraction, doing = json.loads(line)
        progress(fraction, doing)
    return doing


def _crash(doing: str, code: int) -> str:
    if code < 0:
        how = f"by {signal.Signals(-code).name}"
    else:
        how = f"with exit code {code:#x}" if code >= WINDOWS_FAULT else f"with exit code {code}"
    where = f"{doing}: " if doing else ""
    return (
        f"{where}MeshLab's native code ended the process {how}; nothing was written; leave that "
        "step out, or run it in the MeshLab program"
    )


def _reduced_box(box: Any) -> tuple[type[Box], tuple[Any, Any]]:
    return Box, (box.min(), box.max())


def main() -> None:
    """Do the job in the folder that is named on the command line, while the parent lives."""
    folder, parent = Path(sys.argv[1]), int(sys.argv[2])
    if not _native.end_with_parent(parent):
        return
    channel = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # what native code prints does not disturb the channel
    copyreg.pickle(pymeshlab.BoundingBox, _reduced_box)

    def progress(fraction: float, message: str) -> None:
        channel.write(json.dumps([float(fraction), message]) + "\n")
        channel.flush()

    function, arguments = pickle.loads((folder / JOB).read_bytes())  # noqa: S301  our own parent's
    result, error = None, None
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", SymReconWarning)
        try:
            result = function(*arguments, progress=progress)
        except SymReconError as refused:
            error = refused
    sentences = [str(one.message) for one in caught if issubclass(one.category, SymReconWarning)]
    (folder / ANSWER).write_bytes(pickle.dumps((result, error, sentences)))
