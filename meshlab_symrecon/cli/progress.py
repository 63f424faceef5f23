"""A progress bar on the standard error stream, when that is a terminal."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

__all__ = ["progress_bar"]

SHOWN = 60  # characters of a message; its end tells more than its beginning
OFTEN = 0.05  # seconds between two looks of the same stage


@contextmanager
def progress_bar(
    title: str, *, shown: bool = True, stage: Callable[[str], None] | None = None
) -> Iterator[Callable[[float, str], None]]:
    """Yield a callback ``progress(fraction, message)``; in a pipe it shows nothing.

    Parameters
    ----------
    title : str
    shown : bool
        Show a bar where there is a terminal.
    stage : callable, optional
        Told each new message.
    """
    tell = stage or _nobody
    if not (shown and sys.stderr.isatty()):
        yield _changes(tell, lambda fraction, message: None)
        return
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        Progress,
        SpinnerColumn,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    columns = (
        SpinnerColumn(),
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f} %"),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(title, total=1.0)
        yield _changes(
            tell,
            lambda fraction, message: bar.update(
                task, completed=fraction, description=message[-SHOWN:].replace("[", r"\[") or title
            ),
        )


def _nobody(message: str) -> None:
    """Tell nobody."""


def _changes(
    tell: Callable[[str], None], show: Callable[[float, str], None]
) -> Callable[[float, str], None]:
    """Return a callback that tells new messages, and shows what it is told if not too often.

    What is shown never goes back.
    """
    most, last, when = 0.0, "", -OFTEN

    def progress(fraction: float, message: str) -> None:
        nonlocal most, last, when
        now = time.perf_counter()
        most = max(most, min(1.0, fraction))
        if message == last and now - when < OFTEN and most < 1.0:
            return
        if message != last:
            tell(message)
        last, when = message, now
        show(most, message)

    return progress
