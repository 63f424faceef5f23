"""The log of a command: lines with their time, appended and flushed, for people to read."""

from __future__ import annotations

import platform
import re
import shlex
import sys
import time
import warnings
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version
from io import FileIO
from pathlib import Path

from meshlab_symrecon import __version__
from meshlab_symrecon.errors import FileError

__all__ = ["WorkLog", "peak_memory"]

DATED = re.compile(rb"\d{4}-\d\d-\d\d \d\d:\d\d:\d\d ")
FORMAT = "%Y-%m-%d %H:%M:%S"
SHOWN_VERSIONS = ("pymeshlab", "numpy", "scipy")
MEGABYTE = 1 << 20
SHORTEST = 0.005  # seconds of a stage that is worth a line


class WorkLog:
    """A file to which lines are appended.

    Parameters
    ----------
    path : Path
    protected : sequence of Path
        Files of the command, none of which may be the log.

    Raises
    ------
    FileError
        The file cannot be appended to, is one of ``protected``, or holds something else.
    """

    def __init__(self, path: Path, protected: Sequence[Path] = ()) -> None:
        from meshlab_symrecon.host.atomic import check_target, same_file

        target = check_target(path)
        if any(same_file(path, other) for other in protected):
            raise FileError(f"{path} is another file of this command; give the log its own path")
        if not _may_be_log(path, target):
            raise FileError(f"{path} holds something else than a log; give another path")
        self._file = _appended_to(path, target)
        self.path = path
        self._stage, self._stage_began = "", 0.0
        self._began = time.perf_counter()

    @property
    def descriptor(self) -> int:
        """The number of the open file."""
        return self._file.fileno()

    def begin(self, words: Sequence[str]) -> None:
        """Note the command line and what it runs with."""
        self.say(shlex.join(words))
        known = ", ".join(f"{name} {_version(name)}" for name in SHOWN_VERSIONS)
        self.say(
            f"meshlab_symrecon {__version__}, {known}, Python {platform.python_version()}, "
            f"{platform.system()} {platform.machine()}"
        )

    def say(self, sentence: str) -> None:
        """Append a line, and see that it is in the file."""
        line = " ".join(sentence.splitlines())
        try:
            text = f"{time.strftime(FORMAT)} {line}\n"
            self._file.write(text.encode("utf-8", "backslashreplace"))
        except (OSError, ValueError) as error:  # the work is worth more than its log
            self.say = _nothing  # type: ignore[method-assign]
            warnings.warn(f"{self.path}: the log ends here: {error}", UserWarning, stacklevel=2)

    def stage(self, name: str) -> None:
        """Note the end of the stage before, with its seconds and the peak of memory so far."""
        if name == self._stage:
            return
        now = time.perf_counter()
        seconds = now - self._stage_began
        if self._stage and seconds >= SHORTEST:
            self.say(f"{self._stage}: {seconds:.2f} s{peak_memory()}")
        self._stage, self._stage_began = name, now

    def end(self, how: str) -> None:
        """Note the end of the work, and close."""
        self.stage("")
        self.say(f"{how} after {time.perf_counter() - self._began:.2f} s{peak_memory()}")
        self._file.close()


def _may_be_log(path: Path, target: Path) -> bool:
    """Say whether a file is a log, or new, or empty."""
    from meshlab_symrecon.host.atomic import reason

    try:
        if not target.exists():
            return True
        with target.open("rb") as file:
            beginning = file.read(32)
    except OSError as error:
        raise FileError(f"{path} cannot be read: {reason(error)}; give another path") from error
    return not beginning or DATED.match(beginning) is not None


def _appended_to(path: Path, target: Path) -> FileIO:
    from meshlab_symrecon.host.atomic import reason

    try:
        return target.open("ab", buffering=0)
    except OSError as error:
        raise FileError(f"{path} cannot be written: {reason(error)}; give another path") from error


def _nothing(sentence: str) -> None:
    """Say nothing any more."""


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "unknown"


def peak_memory() -> str:
    """Return the most memory of this process so far, in words; nothing where it is not told."""
    if sys.platform == "win32":
        return ""
    import resource

    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    unit = 1 if sys.platform == "darwin" else 1024  # bytes there, kilobytes elsewhere
    return f", peak {most * unit / MEGABYTE:.0f} MB"
