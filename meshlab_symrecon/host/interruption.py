"""Work that ends within a second of Ctrl-C, and leaves nothing half-written.

A signal raises :class:`Interruption` where Python code runs. Native code may keep Python waiting
for minutes, or swallow the exception; so a thread of the kernel listens too, and when the work has
not come to its end by itself after :data:`GRACE` it kills child processes, removes what was being
written, says so, and ends the process. When native code crashes, the thread does the same at once,
and names the step that :func:`now_doing` was told. Only programs ask for this, by
:func:`interruptible`; in a library's user's process nothing here has an effect. Elsewhere than on
Posix signals are Python's.
"""

from __future__ import annotations

import os
import secrets
import shutil
import signal
import tempfile
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from types import FrameType

from meshlab_symrecon import _native
from meshlab_symrecon.host.temporary_folders import kept_alive, remove_dead_folders

__all__ = [
    "GRACE",
    "SENTENCE",
    "Interruption",
    "guard_folder",
    "guarded_child",
    "guarded_log",
    "interruptible",
    "interruption_settled",
    "now_doing",
    "signal_of_interruption",
    "telling",
    "unbroken",
    "unhurried",
]

SENTENCE = "interrupted; nothing was left half-written"
GRACE = 0.4  # seconds until the kernel's thread ends what does not end by itself
SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP")
LONGEST_STEP = 1000  # bytes; the kernel has room for a few more


class Interruption(KeyboardInterrupt):
    """A signal asked for the end; ``number`` is the signal's."""

    def __init__(self, number: int) -> None:
        super().__init__(SENTENCE)
        self.number = number


@dataclass(slots=True)
class _State:
    """What the handler of signals knows: there is one in a process."""

    watching: bool = False
    number: int = 0  # of the signal that has come
    raised: bool = False
    replacing: int = 0  # blocks that must not be torn


_state = _State()


@contextmanager
def interruptible() -> Iterator[None]:
    """Let SIGINT, SIGTERM and SIGHUP end the work in this block, within a second.

    A crash of native code (SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT) ends the process at once with
    exit code 1 and a sentence, in whichever thread it happens.

    The first of them raises :class:`Interruption`; further ones are ignored, so that impatience
    does not tear the tidying up. Signals that are ignored when the block begins (``nohup``, the
    background of a shell's script) stay so. Temporary files of this process, and of its children,
    are made in one folder that is removed at the end.
    """
    if (
        os.name != "posix"
        or _state.watching
        or threading.current_thread() is not threading.main_thread()
    ):
        yield
        return
    with ExitStack() as stack:
        stack.callback(_forget)
        _state.watching, _state.number, _state.raised = True, 0, False
        _watch_signals(stack)
        stack.enter_context(_own_temporary_folder())
        yield


@contextmanager
def unhurried(seconds: float) -> Iterator[None]:
    """Let tidying up take longer in this block: many child processes take their time to end."""
    if not _state.watching:
        yield
        return
    _native.watch_signals(seconds, SENTENCE)
    try:
        yield
    finally:
        if not _state.number:
            _native.watch_signals(GRACE, SENTENCE)


def _watch_signals(stack: ExitStack) -> None:
    """Listen to signals, here and in the kernel's thread, until the stack ends."""
    descriptor = _native.watch_signals(GRACE, SENTENCE)
    stack.callback(_native.stop_watching)
    stack.callback(signal.set_wakeup_fd, signal.set_wakeup_fd(descriptor))
    _forget_in_forks()
    for name in SIGNALS:
        number = getattr(signal, name)
        before = signal.getsignal(number)
        if before not in (signal.SIG_IGN, None):
            stack.callback(signal.signal, number, before)
            signal.signal(number, _interrupt)


def _interrupt(number: int, frame: FrameType | None) -> None:
    if _state.number:
        return
    _state.number = number
    if not _state.replacing:
        _raise()


def _raise() -> None:
    _state.raised = True
    raise Interruption(_state.number)


def _forget() -> None:
    _state.watching = False


_in_forks: list[bool] = []


def _forget_in_forks() -> None:
    """Let copies of this process not write their signals into its pipe."""

    def forget() -> None:
        if _state.watching:
            with suppress(ValueError):
                signal.set_wakeup_fd(-1)

    if not _in_forks:
        _in_forks.append(True)
        os.register_at_fork(after_in_child=forget)


@contextmanager
def _own_temporary_folder() -> Iterator[None]:
    """Make temporary files in a folder of their own, whose removal removes them all."""
    name = f"symrecon-{os.getpid()}-{secrets.token_hex(4)}"
    before = tempfile.tempdir, os.environ.get("TMPDIR")
    try:
        folder = Path(tempfile.gettempdir(), name)
        remove_dead_folders(folder.parent)
        guard_folder(folder.parent, name)
        folder.mkdir(mode=0o700)
    except OSError:  # what needs temporary files will say so
        yield
        return
    tempfile.tempdir = os.environ["TMPDIR"] = str(folder)
    try:
        with kept_alive(folder):
            yield
    finally:
        tempfile.tempdir = before[0]
        os.environ.pop("TMPDIR")
        if before[1] is not None:
            os.environ["TMPDIR"] = before[1]
        shutil.rmtree(folder, ignore_errors=True)


def guard_folder(folder: Path, prefix: str) -> None:
    """Have files and folders in ``folder`` removed at an interruption if their names begin so."""
    if _state.watching:
        _native.guard_folder(os.fsencode(folder.absolute()), os.fsencode(prefix))


@contextmanager
def guarded_child(process: int, folders: Iterable[Path], prefix: str) -> Iterator[None]:
    """Have a child process killed at an interruption, and what it was writing removed."""
    for folder in folders:
        guard_folder(folder, prefix)
    _native.guard_process(process, True)
    try:
        yield
    finally:
        _native.guard_process(process, False)


@contextmanager
def guarded_log(descriptor: int) -> Iterator[None]:
    """Have an interruption noted in an open file too, with its time."""
    _native.guard_log(descriptor)
    try:
        yield
    finally:
        _native.guard_log(-1)


def telling(progress: Callable[[float, str], None], name: str = "") -> Callable[[float, str], None]:
    """Return a progress callback from which ``now_doing`` learns what is being done.

    Parameters
    ----------
    progress : callable
        Is called in turn.
    name : str
        What is being done in all; messages are its stages.
    """
    last = name

    def told(fraction: float, message: str) -> None:
        nonlocal last
        if message != last:
            last = message
            stages = [name, message] if message != name else [name]
            now_doing(": ".join(filter(None, stages)))
        progress(fraction, message)

    if name:
        now_doing(name)
    return told


def now_doing(step: str) -> None:
    """Say what is being done, for the sentence about a crash; nothing when it is not known."""
    if _state.watching:
        line = " ".join(step.split()).encode("utf-8", "backslashreplace")
        whole = line[:LONGEST_STEP].decode("utf-8", "ignore").encode()  # no half of a character
        _native.tell_step(whole.replace(b"\0", b" "))


@contextmanager
def unbroken() -> Iterator[None]:
    """Let an interruption wait for the end of this block, in which files take their places.

    Raises
    ------
    Interruption
        At the end, if a signal has come meanwhile.
    """
    _state.replacing += 1  # from here on the handler raises nothing
    try:
        _native.guard_replacing(True)
        yield
    finally:
        _native.guard_replacing(False)
        _state.replacing -= 1
    if _state.watching and _state.number and not (_state.raised or _state.replacing):
        _raise()


def signal_of_interruption() -> int:
    """Return the number of the signal that has come in ``interruptible``, 0 for none."""
    return _state.number if _state.watching else 0


def interruption_settled() -> None:
    """Say that the work has stopped: what it left is removed now, and the process may go on."""
    _native.acknowledge_signal()
    _native.sweep_guarded()
