"""What long commands share: ``--quiet``, ``--log`` and ``--threads``, and who is told what.

A command gets the options by the decorator :func:`long_work`, which hands it a :class:`LongWork`
as ``work``; commands that are made otherwise add :func:`long_options` and use :func:`working`.
The same options are taken before the command too.
"""

from __future__ import annotations

import functools
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from meshlab_symrecon.cli.border import sentence_of
from meshlab_symrecon.cli.file_path import FilePath
from meshlab_symrecon.cli.progress import progress_bar
from meshlab_symrecon.cli.threads import limited_threads
from meshlab_symrecon.cli.work_log import WorkLog
from meshlab_symrecon.host.fewest_points import FEWEST_POINTS

__all__ = [
    "LONG_NAMES",
    "LongWork",
    "long_options",
    "long_work",
    "max_points",
    "max_points_option",
    "working",
]

LONG_NAMES = ("quiet", "log", "threads")
Progress = Callable[[float, str], None]


@dataclass(frozen=True, slots=True)
class LongWork:
    """Whom a command tells what."""

    quiet: bool = False
    log: WorkLog | None = None

    def say(self, line: str) -> None:
        """Tell a finding on the standard output, and in the log."""
        if self.log is not None:
            self.log.say(line)
        if not self.quiet:
            click.echo(line)

    def warn(self, sentence: str) -> None:
        """Tell a warning on the standard error stream, and in the log."""
        if self.log is not None:
            self.log.say(f"warning: {sentence}")
        if not self.quiet:
            click.echo(f"warning: {sentence}", err=True)

    @contextmanager
    def progress(self, title: str) -> Iterator[Progress]:
        """Show how far the work in a block is, on a terminal; each stage goes into the log.

        A crash of native code is told with the last message.
        """
        from meshlab_symrecon.host.interruption import now_doing, telling

        with progress_bar(title, shown=not self.quiet, stage=self._stage) as progress:
            yield telling(progress)
        now_doing("")
        self._stage("")

    def _stage(self, name: str) -> None:
        if self.log is not None:
            self.log.stage(name)


def long_options() -> list[click.Option]:
    """Return the options that every long command has."""
    return [
        click.Option(["-q", "--quiet"], is_flag=True, help="Say nothing but errors."),
        click.Option(
            ["--log"],
            type=FilePath(),
            metavar="FILE",
            help="Append what happens to a file: stages with seconds and memory, warnings, errors.",
        ),
        click.Option(
            ["--threads"],
            type=click.IntRange(min=1),
            metavar="N",
            help="Threads of numerical libraries; all cores when left out.",
        ),
    ]


def long_work(function: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the options, and call it with a ``LongWork`` as ``work``."""

    @functools.wraps(function)
    def command(*arguments: Any, **values: Any) -> Any:
        given = {name: values.pop(name) for name in LONG_NAMES}
        with working(given) as work:
            return function(*arguments, work=work, **values)

    waiting = list(getattr(command, "__click_params__", []))
    command.__click_params__ = [*reversed(long_options()), *waiting]  # type: ignore[attr-defined]
    return command


def max_points() -> click.Option:
    """Return the option that bounds the size of the work."""
    return click.Option(
        ["--max-points"],
        type=click.IntRange(min=FEWEST_POINTS),
        metavar="N",
        help="Thin a scan with more points out evenly to these first.",
    )


def max_points_option(function: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the option ``--max-points``."""
    waiting = [*getattr(function, "__click_params__", []), max_points()]
    function.__click_params__ = waiting  # type: ignore[attr-defined]
    return function


@contextmanager
def working(given: Mapping[str, Any]) -> Iterator[LongWork]:
    """Yield a ``LongWork`` by the options' values; what is missing is as before the command.

    Raises
    ------
    FileError
        The log cannot be written; nothing has been done.
    """
    asked = _asked(given)
    log = None if asked["log"] is None else WorkLog(asked["log"], _paths_of_the_command())
    work = LongWork(bool(asked["quiet"]), log)
    with limited_threads(asked["threads"]), _warnings_through(work):
        if log is None:
            yield work
        else:
            with _logged(log):
                yield work


def _asked(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the options' values: after the command, or else before it."""
    context = click.get_current_context(silent=True)
    before = {} if context is None else context.find_root().params
    return {name: given.get(name) or before.get(name) for name in LONG_NAMES}


def _paths_of_the_command() -> list[Path]:
    context = click.get_current_context(silent=True)
    values = {} if context is None else context.params
    found = []
    for name, value in values.items():
        several = value if isinstance(value, tuple) else (value,)
        found += [path for path in several if isinstance(path, Path) and name != "log"]
    return found


@contextmanager
def _logged(log: WorkLog) -> Iterator[None]:
    from meshlab_symrecon.host.interruption import guarded_log

    log.begin(["symrecon", *sys.argv[1:]])
    with guarded_log(log.descriptor):
        try:
            yield
        except BaseException as error:
            log.stage("")
            log.say(_last_words(error))
            log.end("ended")
            raise
        log.end("done")


def _last_words(error: BaseException) -> str:
    from meshlab_symrecon.host.interruption import SENTENCE, signal_of_interruption

    # Libraries turn the exception of a signal into others, by way of what they were doing.
    if isinstance(error, (KeyboardInterrupt, click.Abort)) or signal_of_interruption():
        return SENTENCE
    if isinstance(error, click.ClickException):
        return f"error: {error.format_message()}"
    known = sentence_of(error) if isinstance(error, Exception) else None
    return f"error: {known or repr(error)}"


@contextmanager
def _warnings_through(work: LongWork) -> Iterator[None]:
    """Tell warnings as the work wants them told."""

    def show(message: Warning | str, *details: Any, **more: Any) -> None:
        work.warn(str(message))

    before = warnings.showwarning
    warnings.showwarning = show
    try:
        yield
    finally:
        warnings.showwarning = before
