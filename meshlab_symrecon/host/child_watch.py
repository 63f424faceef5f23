"""An eye on a child process: what it tells, and whether it stays within its bounds."""

from __future__ import annotations

import contextlib
import pickle
import queue
import subprocess
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import psutil

from meshlab_symrecon.host.isolated_child import LENGTH, Answer, Told

if TYPE_CHECKING:
    from meshlab_symrecon.plugin import Progress

__all__ = ["ABANDONED", "OUT_OF_MEMORY", "TIMED_OUT", "Bounds", "Watch"]

TICK = 0.05  # seconds between two looks at what the child uses
TIMED_OUT, OUT_OF_MEMORY, ABANDONED = "timed out", "out of memory", "abandoned"


def _always() -> bool:
    return True


@dataclass(frozen=True, slots=True)
class Bounds:
    """What a child process may use, and whether it is still wanted.

    Attributes
    ----------
    seconds : float or None
    memory : int or None
        Bytes of resident memory.
    environment : mapping of str to str
        Added to ours.
    wanted : callable
        Asked all the time; the child is ended when it says no.
    """

    seconds: float | None = None
    memory: int | None = None
    environment: Mapping[str, str] = field(default_factory=dict)
    wanted: Callable[[], bool] = _always


class Watch:
    """What a child tells, and whether it stays within its bounds."""

    def __init__(self, child: subprocess.Popen[bytes], bounds: Bounds, started: float) -> None:
        self.child, self.bounds, self.started = child, bounds, started
        self.answer: Answer | None = None
        self.doing, self.stopped, self.peak = "", "", 0
        self._heard: queue.SimpleQueue[Told | Answer | None] = queue.SimpleQueue()
        with contextlib.suppress(psutil.Error):
            self._process = psutil.Process(child.pid)

    def listen(self, progress: Progress) -> None:
        """Pass the child's progress on until it ends, or oversteps its bounds."""
        threading.Thread(target=self._read, daemon=True).start()
        looked = 0.0
        while not self.stopped:
            with contextlib.suppress(queue.Empty):
                heard = self._heard.get(timeout=TICK)
                if heard is None:
                    return
                if isinstance(heard, Answer):
                    self.answer = heard
                else:
                    self.doing = heard.message
                    progress(heard.fraction, heard.message)
            if time.monotonic() - looked >= TICK:
                self.stopped = self._overstepped()
                looked = time.monotonic()

    def _read(self) -> None:
        """Take what comes through the pipe, until the child's end of it is closed."""
        stream = self.child.stdout
        with contextlib.suppress(OSError, ValueError):  # it is closed from the other thread
            while stream is not None and len(head := stream.read(LENGTH.size)) == LENGTH.size:
                size = LENGTH.unpack(head)[0]
                if len(data := stream.read(size)) < size:
                    break
                self._heard.put(pickle.loads(data))  # noqa: S301  our own child's
        self._heard.put(None)

    def _overstepped(self) -> str:
        bounds = self.bounds
        with contextlib.suppress(psutil.Error, AttributeError):  # it has just ended
            self.peak = max(self.peak, self._process.memory_info().rss)
        if bounds.memory is not None and self.peak > bounds.memory:
            return OUT_OF_MEMORY
        if bounds.seconds is not None and time.monotonic() - self.started > bounds.seconds:
            return TIMED_OUT
        return "" if bounds.wanted() else ABANDONED
