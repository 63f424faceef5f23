"""Folders of temporary files that are removed after their process, however that ended.

Each holds a file that its process keeps locked. Such a lock is the kernel's and ends with the
process; unlike a process's number it is not given to another one, and it counts in all containers
of a machine. So a folder is removed only when it is this user's, its file was made under this very
kernel, and nobody holds the lock. What others left stays.
"""

from __future__ import annotations

import os
import platform
import re
import shutil
import stat
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

__all__ = ["kept_alive", "remove_dead_folders"]

NAME = re.compile(r"symrecon-[0-9]+-[0-9a-f]+")
SIGN, UNFINISHED = ".alive", ".being-born"
KERNEL = Path("/proc/sys/kernel/random/boot_id")  # Linux; another one after each start
LONGEST = 1000  # bytes of a sign


@contextmanager
def kept_alive(folder: Path) -> Iterator[None]:
    """Mark a new folder as one that is used, until the block ends or the process does."""
    descriptor = _signed(folder)
    try:
        yield
    finally:
        if descriptor is not None:
            os.close(descriptor)


def remove_dead_folders(parent: Path) -> None:
    """Remove the folders of this user's processes that are no more."""
    with suppress(OSError):  # it need not be ours to look into
        for folder in parent.iterdir():
            if NAME.fullmatch(folder.name) and _is_dead(folder):
                shutil.rmtree(folder, ignore_errors=True)


def _signed(folder: Path) -> int | None:
    """Return the locked file of a folder; None where there are no locks, and no sign either."""
    if sys.platform == "win32":
        return None
    import fcntl

    unfinished = folder / UNFINISHED
    descriptor = None
    try:
        descriptor = os.open(unfinished, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o600)
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        os.write(descriptor, _kernel())
        unfinished.rename(folder / SIGN)  # now that it is locked, others may see it
    except OSError:
        if descriptor is not None:
            os.close(descriptor)
        return None
    return descriptor


def _is_dead(folder: Path) -> bool:
    if sys.platform == "win32":
        return False
    import fcntl

    try:
        status = folder.lstat()
        if not stat.S_ISDIR(status.st_mode) or status.st_uid != os.geteuid():
            return False
        descriptor = os.open(folder / SIGN, os.O_RDWR | os.O_NOFOLLOW | os.O_NONBLOCK)
    except OSError:  # it has no sign
        return False
    try:
        if os.read(descriptor, LONGEST) != _kernel():
            return False
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:  # its process lives
        return False
    finally:
        os.close(descriptor)
    return True


def _kernel() -> bytes:
    """Return what tells this kernel from those of other machines that may share a folder."""
    try:
        return KERNEL.read_bytes()
    except OSError:
        return os.fsencode(platform.node())
