"""The stages of a reconstruction: how far it is, and how long each took."""

from __future__ import annotations

import time
from collections.abc import Callable

__all__ = ["Stages"]


class Stages:
    """Tells how far a computation is and takes the time of its stages.

    Parameters
    ----------
    progress : callable, optional
        Told the fraction done and the stage.
    """

    def __init__(self, progress: Callable[[float, str], None] | None = None) -> None:
        self._progress = progress or (lambda fraction, message: None)
        self._done = 0.0
        self._current = ""
        self._started = 0.0
        self.seconds: dict[str, float] = {}  # of each finished stage; a repeated one adds up

    def begin(self, stage: str, until: float) -> Callable[[float], None]:
        """End the present stage and begin one that ends at the fraction ``until`` of the whole.

        Returns
        -------
        callable
            To be told the share of the stage that is done, 0 to 1.
        """
        self._finish()
        until = max(until, self._done)  # a stage may come again
        low, self._done = self._done, until
        self._current, self._started = stage, time.perf_counter()
        self._progress(low, stage)
        return lambda share: self._progress(low + (until - low) * share, stage)

    def end(self) -> None:
        """End the last stage."""
        self._finish()
        self._progress(1.0, "done")

    def _finish(self) -> None:
        if self._current:
            passed = time.perf_counter() - self._started
            self.seconds[self._current] = self.seconds.get(self._current, 0.0) + passed
        self._current = ""
