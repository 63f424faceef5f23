"""Files that appear whole or not at all: written in a directory beside their place, then moved."""

from __future__ import annotations

import os
import platform
import re
import shutil
import tempfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass
from pathlib import Path

from meshlab_symrecon.errors import FileError
from meshlab_symrecon.host.interruption import guard_folder, unbroken

__all__ = [
    "STAGING_PREFIX",
    "check_target",
    "flush_folder",
    "reason",
    "remove_dead_staging",
    "remove_staging",
    "replacing",
    "same_file",
    "staging_prefix",
    "together",
]

STAGING_PREFIX = ".symrecon-"
PROCESSES = Path("/proc/self/ns/pid")  # a container has its own, and counts its processes anew


def reason(error: OSError | ValueError) -> str:
    """Return what went wrong, in the operating system's own words where it has some."""
    said = error.strerror if isinstance(error, OSError) else ""
    return said or str(error) or type(error).__name__


def same_file(first: Path, second: Path) -> bool:
    """Say whether two paths lead to one file, through links and other spellings too."""
    try:
        return first.samefile(second)
    except OSError:
        return Path(os.path.realpath(first)) == Path(os.path.realpath(second))


def check_target(path: Path) -> Path:
    """Return where a file named ``path`` would be written, links followed.

    Raises
    ------
    FileError
        The place is a directory or a device, its directory does not exist, or what is there is
        read-only: renaming would take no notice of that.
    """
    try:
        target = Path(os.path.realpath(path))
        exists, regular, directory = target.exists(), target.is_file(), target.parent.is_dir()
    except (OSError, ValueError) as error:
        message = f"{path} cannot be written: {reason(error)}; give another path"
        raise FileError(message) from error
    if not directory:
        message = f"{path} cannot be written: no directory is at {target.parent}; make it first"
        raise FileError(message)
    if exists and not regular:
        message = f"{path} cannot be written: it is not an ordinary file; give a file's path"
        raise FileError(message)
    if exists and not os.access(target, os.W_OK):
        message = f"{path} cannot be written: the file there is read-only; give another path"
        raise FileError(message)
    return target


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yield a path to write to; what was written there takes the place of ``path`` at the end.

    The path that is yielded has the same name, in a fresh directory beside the target, so that a
    writer that looks at the extension, or that puts further files beside (materials, textures,
    also in folders), works as ever. Once all are whole the further files are moved, the named one
    last. When the block fails or is interrupted, nothing is left and an older file at ``path``
    stays as it was. What a process that ended by a crash has left in the same place is removed.

    Raises
    ------
    FileError
        As ``check_target``; or the block wrote no file; or the system refused to write.
    """
    target = check_target(path)
    staging: Path | None = None
    try:
        remove_dead_staging(target.parent)
        prefix = staging_prefix(os.getpid())
        guard_folder(target.parent, prefix)
        staging = Path(tempfile.mkdtemp(prefix=prefix, dir=target.parent))
        yield staging / path.name
        group = _group.get()
        if group is None:
            _put_in_place(staging, path.name, target)
        else:
            group.append(_Written(staging, path.name, target))
            staging = None  # it is the group's now
    except FileError:
        raise
    except OSError as error:
        message = f"{path} cannot be written: {reason(error)}; nothing was changed"
        raise FileError(message) from error
    finally:
        if staging is not None:
            shutil.rmtree(staging, ignore_errors=True)


@contextmanager
def together() -> Iterator[None]:
    """Let the files that are replaced in this block take their places at its end, all at once.

    An interruption changes none of them, unless it comes in the last instant, when it waits until
    all are there. After an error those that were whole by then take their places.

    Raises
    ------
    FileError
        The system refused to write.
    """
    group: list[_Written] = []
    token = _group.set(group)
    try:
        try:
            yield
        except Exception:
            _put_all_in_place(group)
            raise
        _put_all_in_place(group)
    finally:
        _group.reset(token)
        for written in group:
            shutil.rmtree(written.staging, ignore_errors=True)


@dataclass(frozen=True, slots=True)
class _Written:
    """A file that waits for the others."""

    staging: Path
    name: str
    target: Path


_group: ContextVar[list[_Written] | None] = ContextVar("_group", default=None)


def _put_all_in_place(group: list[_Written]) -> None:
    for written in group:  # may take seconds, and an interruption need not wait for that
        with _refusals_told(written.target):
            for file in written.staging.rglob("*"):
                if file.is_file():
                    _flush(file)
    with unbroken():
        for written in group:
            with _refusals_told(written.target):
                _put_in_place(written.staging, written.name, written.target)


@contextmanager
def _refusals_told(target: Path) -> Iterator[None]:
    """Raise FileError for what the system refuses in this block."""
    try:
        yield
    except FileError:
        raise
    except OSError as error:
        message = f"{target} cannot be written: {reason(error)}; free space or give another path"
        raise FileError(message) from error


def staging_prefix(process: int) -> str:
    """Return how the names begin of what a process of this machine is writing."""
    return f"{STAGING_PREFIX}{process}-{_machine()}-"


def remove_staging(folder: Path, process: int) -> None:
    """Remove what another process of ours, ended by a crash, left half-written in a folder."""
    for staging in folder.glob(f"{STAGING_PREFIX}{process}-*"):
        shutil.rmtree(staging, ignore_errors=True)


def remove_dead_staging(folder: Path) -> None:
    """Remove what processes of ours on this machine left in a folder, if they are no more.

    Those of other machines and containers, which may write in the same folder, cannot be asked
    for; nor can processes be on Windows. What they left stays.
    """
    if os.name != "posix":
        return
    for staging in folder.glob(f"{STAGING_PREFIX}*-{_machine()}-*"):
        number = re.match(rf"{re.escape(STAGING_PREFIX)}(\d{{1,9}})-", staging.name)
        if number and not _is_running(int(number[1])):
            shutil.rmtree(staging, ignore_errors=True)


def _machine() -> str:
    """Return a word for the machine, or the container, whose numbers of processes are ours."""
    inside = PROCESSES.readlink() if PROCESSES.is_symlink() else ""
    return f"{zlib.crc32(f'{platform.node()} {inside}'.encode()):08x}"


def _is_running(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:  # it is another user's
        return True
    return not _is_zombie(process)


def _is_zombie(process: int) -> bool:
    """Say whether a process has ended, and nobody has asked yet how: in containers nobody may."""
    try:
        state = Path(f"/proc/{process}/stat").read_bytes().rpartition(b")")[2].split()
    except OSError:  # it has just been asked, or this is no Linux
        return False
    return state[:1] in ([b"Z"], [b"X"])


def _put_in_place(staging: Path, name: str, target: Path) -> None:
    named = staging / name
    written = [file for file in sorted(staging.rglob("*")) if file.is_file() and file != named]
    if not named.is_file():
        raise FileError(f"{target} cannot be written: the writer made no file; check free space")
    places = {file: target.parent / file.relative_to(staging) for file in written}
    for place in places.values():
        place.parent.mkdir(parents=True, exist_ok=True)
        check_target(place)
    for file in (*written, named):
        _flush(file)
    with unbroken():
        for file, place in (*places.items(), (named, target)):
            file.replace(place)
    for folder in {place.parent for place in (*places.values(), target)}:
        flush_folder(folder)


def flush_folder(folder: Path) -> None:
    """Have a directory's entries on the disk, so that a loss of power does not undo a renaming."""
    if os.name != "posix":  # there is no such call on Windows, whose file systems keep a journal
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        with suppress(OSError):  # some network file systems cannot; the files are whole even so
            os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _flush(file: Path) -> None:
    descriptor = os.open(file, os.O_RDWR)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
