"""The log of a batch: one line of JSON a scan, each on the disk before the next."""

from __future__ import annotations

import contextlib
import json
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from meshlab_symrecon.batch.claims import TAKEN
from meshlab_symrecon.batch.reports import ScanReport
from meshlab_symrecon.errors import FileError
from meshlab_symrecon.host.atomic import flush_folder, reason

__all__ = ["Log", "opened_log"]

MOST = 1 << 64  # of what a system counts
BEGINNING = b'{"scan": "'
REQUIRED = {"scan": str, "output": str, "name": str, "status": str, "work_sha256": str}
OPTIONAL: dict[str, type | tuple[type, ...]] = {
    "error": str, "input_sha256": str, "output_sha256": str, "input_files": dict,
    "output_files": dict, "script": str, "script_sha256": str, "parameters": dict, "limits": dict,
    "versions": dict, "measures": dict, "points": int, "steps": list, "warnings": list,
    "again": str, "started": str, "seconds": (int, float), "peak_memory_bytes": int, "machine": str,
}  # fmt: skip


class Log:
    """An open log, locked for this process.

    Attributes
    ----------
    path : Path
    reports : tuple of ScanReport
        What it held when it was opened, oldest first.
    passed_over : int
        How many lines were not ours.
    """

    def __init__(self, path: Path, descriptor: int) -> None:
        self.path, self._descriptor = path, descriptor
        self.reports, self.passed_over = _read(_mended(descriptor, path))

    def append(self, report: ScanReport) -> None:
        """Write one line, and have it on the disk.

        Raises
        ------
        FileError
            The system refused; the log is as it was.
        """
        text = json.dumps(report.as_data(), ensure_ascii=False, allow_nan=False)
        data = text.encode("utf-8", "backslashreplace") + b"\n"
        before = os.lseek(self._descriptor, 0, os.SEEK_END)
        try:
            written = os.write(self._descriptor, data)
            while written < len(data):  # a full disk takes a part, and refuses the rest
                written += os.write(self._descriptor, data[written:])
            os.fsync(self._descriptor)
        except OSError as error:
            with contextlib.suppress(OSError):
                os.ftruncate(self._descriptor, before)
            message = f"the log {self.path} cannot be written: {reason(error)}"
            raise FileError(
                f"{message}; what it holds is done, make room and give the same command again"
            ) from error


@contextmanager
def opened_log(path: Path) -> Iterator[Log]:
    """Open a log, make it when it is missing, mend its end, and lock it until the block ends.

    The lock is the operating system's: it ends with the process, however that ends.

    Raises
    ------
    FileError
        It cannot be opened or locked, another process has it open, or it holds something else.
    """
    new = not path.exists()
    try:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND | _binary(), 0o666)
    except OSError as error:
        message = f"the log {path} cannot be opened: {reason(error)}"
        raise FileError(f"{message}; give another path with --log") from error
    try:
        _lock(descriptor, path)
        if new:
            flush_folder(path.parent)
        yield Log(path, descriptor)
    finally:
        os.close(descriptor)


def _binary() -> int:
    return getattr(os, "O_BINARY", 0)


def _lock(descriptor: int, path: Path) -> None:
    try:
        if sys.platform == "win32":
            import msvcrt

            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        else:
            import fcntl

            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        if error.errno in TAKEN:
            message = f"another batch is at work on the log {path}"
            raise FileError(f"{message}; wait for it, or give another one with --log") from error
        message = f"the log {path} cannot be locked: {reason(error)}"
        raise FileError(f"{message}; give a path on another disk with --log") from error


def _mended(descriptor: int, path: Path) -> bytes:
    """Return what a log holds, after what a pulled plug has left at its end was removed.

    Raises
    ------
    FileError
        It is no log; it is as it was.
    """
    with os.fdopen(os.dup(descriptor), "rb") as file:
        file.seek(0)
        data = file.read()
    whole = data.rstrip(b"\0")  # some file systems fill with zeros what was not yet written
    end = whole.rfind(b"\n") + 1
    if not _is_log(whole[:end].split(b"\n"), whole[end:]):
        message = f"{path} holds something else than the log of a batch"
        raise FileError(f"{message}; give another path with --log")
    last = whole[end:]
    if last and (_record(last) is not None or not _is_half_ours(last)):
        end = len(whole)
    if end < len(data):
        os.ftruncate(descriptor, end)
    if end and not whole[:end].endswith(b"\n"):
        os.write(descriptor, b"\n")
    return whole[:end]


def _is_log(lines: list[bytes], rest: bytes) -> bool:
    """Say whether a line is ours, maybe damaged; before the first: half of it, or nothing."""
    if any(_record(line) is not None for line in (*lines, rest)):
        return True
    if any(line.startswith(BEGINNING) for line in lines):  # damaged, as when a block was lost
        return True
    return not any(line.strip() for line in lines) and _is_half_ours(rest)


def _is_half_ours(line: bytes) -> bool:
    return line.startswith(BEGINNING[: len(line)])


def _read(data: bytes) -> tuple[tuple[ScanReport, ...], int]:
    """Return the reports, and how many lines hold none."""
    lines = [line for line in data.split(b"\n") if line.strip()]
    records = [record for line in lines if (record := _record(line)) is not None]
    return tuple(map(ScanReport.from_data, records)), len(lines) - len(records)


def _counted(digits: str) -> int:
    """Return a whole number; one with hundreds of digits cannot be worked with."""
    number = int(digits)
    if abs(number) > MOST:
        raise ValueError(digits)
    return number


def _record(line: bytes) -> dict[str, Any] | None:
    """Return what a line of ours says; None for any other line."""
    try:
        data = json.loads(line, parse_int=_counted)
    except (ValueError, RecursionError):
        return None
    ours = (
        isinstance(data, dict)
        and all(isinstance(data.get(name), kind) for name, kind in REQUIRED.items())
        and all(
            data.get(name) is None or isinstance(data[name], OPTIONAL[name]) for name in OPTIONAL
        )
        and all(isinstance(step, dict) for step in data.get("steps") or ())
    )
    return data if ours else None
