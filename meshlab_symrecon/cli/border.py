"""Where errors become exit codes and one sentence on the standard error stream."""

from __future__ import annotations

import os
import re
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NoReturn

import click

from meshlab_symrecon.errors import SymReconError, SymReconWarning

__all__ = ["DONE", "FAILED", "INTERRUPTED", "BorderGroup", "exit_with", "sentence_of"]

DONE, FAILED, INTERRUPTED = 0, 1, 130  # 2 is click's, for wrong usage
NO_MEMORY = "there is not enough memory for this; close programs or thin the scan out first"
OF_SIGNALS = 128  # and the number of the signal: 130 for Ctrl-C, 143 for SIGTERM, 129 for SIGHUP


class BorderGroup(click.Group):
    """A group that ends with an exit code, and without a traceback for what users can mend."""

    def main(  # type: ignore[override]  # click overloads it; this one never returns
        self,
        args: Sequence[str] | None = None,
        prog_name: str | None = "symrecon",
        complete_var: str | None = None,
        standalone_mode: bool = True,
        **extra: Any,
    ) -> None:
        """Run a command line and exit; click's own border (``standalone_mode``) is never used."""

        def call() -> Any:
            return super(BorderGroup, self).main(
                args, prog_name, complete_var, standalone_mode=False, **extra
            )

        exit_with(call)

    def make_context(self, *arguments: Any, **named: Any) -> click.Context:
        """Parse the words; click itself would answer an interruption with an empty line."""
        try:
            return super().make_context(*arguments, **named)
        except KeyboardInterrupt as error:
            raise click.Abort from error

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command, with the same care."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt as error:
            raise click.Abort from error


def exit_with(call: Callable[[], Any]) -> NoReturn:
    """Run a program and exit: with the number that it returns, or what its error stands for.

    SIGINT, SIGTERM and SIGHUP end it within a second, and leave nothing half-written.
    """
    from meshlab_symrecon.host.interruption import interruptible

    with interruptible(), _warnings_as_sentences():
        code = _guarded(call)
    sys.exit(code)


def _guarded(call: Callable[[], Any]) -> int:
    from meshlab_symrecon.host.interruption import signal_of_interruption

    try:
        return _code_of(call)
    except (click.Abort, KeyboardInterrupt):
        return _interrupted()
    except Exception:
        # Libraries turn the exception of a signal into others, by way of what they were doing.
        if not signal_of_interruption():
            raise
        return _interrupted()


def _interrupted() -> int:
    """Tidy up, say the sentence; return the exit code."""
    from meshlab_symrecon.host.interruption import (
        SENTENCE,
        interruption_settled,
        signal_of_interruption,
    )

    number = signal_of_interruption()
    interruption_settled()
    _say(SENTENCE)
    return OF_SIGNALS + number if number else INTERRUPTED


def _code_of(call: Callable[[], Any]) -> int:
    from meshlab_symrecon.host.interruption import signal_of_interruption

    try:
        result = call()
    except click.Abort:
        raise
    except click.ClickException as error:
        error.show()
        return error.exit_code
    except BrokenPipeError:  # the reader of our output has gone, as in "symrecon filters | head"
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FAILED
    except Exception as error:  # what is not translated is raised again
        sentence = sentence_of(error)
        if sentence is None or signal_of_interruption():
            raise
        _say(f"error: {sentence}")
        return FAILED
    return result if isinstance(result, int) else DONE


def sentence_of(error: Exception) -> str | None:
    """Return one sentence for an error of the outside world; None for a mistake of ours."""
    if isinstance(error, SymReconError):
        return _with_memory_in_words(str(error))
    if isinstance(error, ImportError) and error.name in ("pymeshlab", "pmeshlab"):
        return (
            f"pymeshlab cannot be loaded: {error}; install what it lacks, on a server without a "
            "screen often the packages libgl1 and libopengl0, or see docs/install.md"
        )
    if isinstance(error, MemoryError):
        return NO_MEMORY
    if isinstance(error, OSError):
        words = error.strerror or str(error)
        return f"{error.filename}: {words}" if error.filename else words
    if type(error).__module__.partition(".")[0] == "pymeshlab":
        return _with_memory_in_words("MeshLab: " + " ".join(str(error).split()))
    return None


def _with_memory_in_words(sentence: str) -> str:
    """Return a sentence with our words where native code has told that memory ran out."""
    return re.sub(r"std::bad_(array_new_length|alloc)\b.*", NO_MEMORY, sentence)


@contextmanager
def _warnings_as_sentences() -> Iterator[None]:
    with warnings.catch_warnings():
        warnings.showwarning = _show_warning
        warnings.simplefilter("always", SymReconWarning)
        yield


def _show_warning(message: Warning | str, *details: Any, **more: Any) -> None:
    _say(f"warning: {message}")


def _say(sentence: str) -> None:
    click.echo(sentence, err=True)
