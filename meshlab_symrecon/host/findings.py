"""What a check of a script finds: mistakes, and what will run otherwise than it is written."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from meshlab_symrecon.errors import ScriptError, SymReconError

__all__ = [
    "ERROR",
    "IGNORE",
    "NOTE",
    "REMARK",
    "SKIP",
    "Finding",
    "Findings",
    "check_findings",
    "place",
]

ERROR, NOTE, REMARK = "error", "note", "remark"
SKIP, IGNORE = "skip", "ignore"
LONGEST = 600  # letters of a message; the longest that quotes nothing has about 400


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing to say about a script.

    Attributes
    ----------
    file, line : str, int
        Where it is written.
    message : str
        One sentence, without the place.
    severity : str
        ``ERROR``; ``NOTE`` for something that was mapped or ignored; ``REMARK`` for something else
        that is worth knowing.
    remedy : str
        What a lenient run does about an error: ``SKIP`` the step, ``IGNORE`` the parameter, or
        nothing, when empty.
    step : int
        Position of the step in the script, -1 for the script as a whole.
    """

    file: str
    line: int
    message: str
    severity: str = ERROR
    remedy: str = ""
    step: int = -1

    def __str__(self) -> str:
        return f"{place(self.file, self.line, self.step)}: {self.message}"


def place(file: str, line: int, step: int) -> str:
    """Return where a step is written; those made in memory have a number, and no line."""
    return f"{file}:{line}" if line or step < 0 else f"{file}: step {step + 1}"


class Findings:
    """Collects what is found in one script."""

    def __init__(self, path: str | Path) -> None:
        self.path = str(path)
        self.step = -1  # the step that is being looked at
        self.found: list[Finding] = []

    def note(self, line: int, message: str) -> None:
        """Collect something that was mapped or ignored."""
        self.found.append(Finding(self.path, line, _shortened(message), NOTE, "", self.step))

    def remark(self, line: int, message: str) -> None:
        """Collect something that is worth knowing, though it runs as it is written."""
        self.found.append(Finding(self.path, line, _shortened(message), REMARK, "", self.step))

    def error(self, line: int, message: str, remedy: str = SKIP) -> None:
        """Collect a mistake."""
        message = _shortened(message)
        self.found.append(Finding(self.path, line, message, ERROR, remedy, self.step))

    @contextmanager
    def at(self, line: int, remedy: str = SKIP) -> Iterator[None]:
        """Collect an error of the block as a mistake."""
        try:
            yield
        except SymReconError as error:
            self.error(line, str(error), remedy)

    @property
    def errors(self) -> int:
        """How many mistakes there are so far."""
        return sum(finding.severity == ERROR for finding in self.found)


def _shortened(message: str) -> str:
    """Return a message that fits a screen: what it quotes from a script may be of any length."""
    if len(message) <= LONGEST:
        return message
    return f"{message[: LONGEST // 2]} ... {message[-LONGEST // 2 :]}"


def check_findings(
    findings: Iterable[Finding], *, strict: bool = False, lenient: bool = False
) -> None:
    """Refuse a script for what was found in it.

    Parameters
    ----------
    findings : iterable of Finding
    strict : bool
        Notes count as errors.
    lenient : bool
        Errors that have a remedy do not count.

    Raises
    ------
    ScriptError
        All that counts, one a line, each with ``file:line:``.
    """
    counted = [
        str(finding)
        for finding in findings
        if (finding.severity == ERROR and not (lenient and finding.remedy))
        or (finding.severity == NOTE and strict)
    ]
    if counted:
        raise ScriptError("\n".join(counted))
