"""What ``symrecon-server`` says: on the standard output, and in the log file."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from datetime import datetime
from pathlib import Path
from typing import Any

import click

from meshlab_symrecon import __version__
from meshlab_symrecon.errors import FileError

__all__ = ["Journal", "journal_of"]


class Journal:
    """Says lines on the standard output, and keeps them and every warning for the log file."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def say(self, line: str) -> None:
        """Say one line."""
        click.echo(line)
        self.lines.append(line)

    def keep(self, line: str) -> None:
        """Keep a line that was said elsewhere."""
        self.lines.append(line)

    def complain(self, sentence: str) -> None:
        """Say an error that does not end the run."""
        click.echo(f"error: {sentence}", err=True)
        self.lines.append(f"error: {sentence}")


@contextmanager
def journal_of(words: Sequence[str], log: Path | None) -> Iterator[Journal]:
    """Yield a journal; append it to the log file at the end, however the block ends.

    When native code ends the process, the log file gets that one line.

    Raises
    ------
    FileError
        The log file cannot be written.
    """
    journal = Journal()
    file = None if log is None else log.absolute()  # a reader that fails changes the directory
    try:
        with _open_for_a_crash(file), _warnings_kept(journal):
            yield journal
    except BaseException as error:
        journal.keep(f"error: {error}" if str(error) else f"ended by {type(error).__name__}")
        raise
    finally:
        if file is not None:
            _append(file, words, journal.lines)


@contextmanager
def _open_for_a_crash(log: Path | None) -> Iterator[None]:
    if log is None:
        yield
        return
    from meshlab_symrecon.host.interruption import guarded_log

    try:
        file = log.open("ab", buffering=0)
    except OSError as error:
        raise _unwritable(log, error) from error
    with file, guarded_log(file.fileno()):
        yield


@contextmanager
def _warnings_kept(journal: Journal) -> Iterator[None]:
    with warnings.catch_warnings():
        shown = warnings.showwarning

        def show(message: Warning | str, *details: Any, **more: Any) -> None:
            journal.keep(f"warning: {message}")
            shown(message, *details, **more)

        warnings.showwarning = show
        yield


def _append(log: Path, words: Sequence[str], lines: Sequence[str]) -> None:
    moment = datetime.now().astimezone().isoformat(sep=" ", timespec="seconds")
    head = f"{moment} symrecon-server {__version__} {' '.join(words)}"
    text = "".join(f"{line}\n" for line in (head, *lines, ""))
    try:
        with log.open("a", encoding="utf-8", errors="backslashreplace") as file:
            file.write(text)
    except OSError as error:
        raise _unwritable(log, error) from error


def _unwritable(log: Path, error: OSError) -> FileError:
    return FileError(f"log {log} cannot be written: {error.strerror}; check its path")
