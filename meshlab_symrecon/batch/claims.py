"""Which results a batch is at work on, for other batches that write into the same folder.

Batches may share a folder: parts of a collection on several machines, or two scripts whose results
have names of their own. They may not make the same result. So each holds a lock on one byte of one
file for each of its results; the byte's place is a checksum of the name. Such locks are the
operating system's, reach across machines where the file system does, and end with their process,
however that ends.
"""

from __future__ import annotations

import errno
import hashlib
import os
import struct
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from meshlab_symrecon.batch.names import folded
from meshlab_symrecon.errors import FileError
from meshlab_symrecon.host.atomic import reason

__all__ = ["TAKEN", "claimed"]

LOCKS = ".batch.lock"
PLACES = 1 << 62
FLOCK = "hhqqi"  # struct flock: type, whence, start, length, process
# By another process, as systems say it; other errors are of file systems without locks.
TAKEN = (errno.EAGAIN, errno.EACCES, errno.EDEADLK)


@contextmanager
def claimed(
    folder: Path, results: Mapping[str, str], said: Callable[[str], None]
) -> Iterator[None]:
    """Keep other batches from making these results until the block ends.

    Parameters
    ----------
    folder : Path
        Of the results.
    results : mapping of str to str
        How the user calls each, by its name in the folder.
    said : callable
        Told when the file system knows no locks; then nobody is kept from anything.

    Raises
    ------
    FileError
        Another batch is at work on one of them, or the folder cannot be written.
    """
    places = sorted((_place(name), shown) for name, shown in results.items())
    file = folder / LOCKS
    descriptor = _entered(file, places, said)
    try:
        yield
    finally:
        _leave(descriptor, file)


def _entered(file: Path, places: Sequence[tuple[int, str]], said: Callable[[str], None]) -> int:
    """Return the open file of locks, with ours."""
    while True:
        descriptor = _opened(file)
        try:
            _lock_all(descriptor, file.parent, places, said)
            if _is_at(descriptor, file):
                return descriptor
        except BaseException:
            _leave(descriptor, file)
            raise
        os.close(descriptor)  # the last one who was in it has just removed it


def _place(name: str) -> int:
    """Return where the lock of a name is; every batch takes its locks in this order."""
    digest = hashlib.sha256(folded(name).encode("utf-8", "surrogatepass")).digest()
    return int.from_bytes(digest[:8], "big") % PLACES


def _opened(file: Path) -> int:
    try:
        return os.open(file, os.O_RDWR | os.O_CREAT, 0o666)
    except OSError as error:
        message = f"the folder {file.parent} cannot be written: {reason(error)}"
        raise FileError(f"{message}; make room, or give another one with -d") from error


def _lock_all(
    descriptor: int, folder: Path, places: Sequence[tuple[int, str]], said: Callable[[str], None]
) -> None:
    for place, shown in places:  # in the same order everywhere: of two batches one gets them all
        try:
            _lock(descriptor, place, 1)
        except OSError as error:
            if error.errno in TAKEN:
                message = f"another batch is at work on {shown}"
                raise FileError(
                    f"{message}; wait for it, or give other folders or names of results"
                ) from error
            message = f"{folder}: its file system has no locks ({reason(error)})"
            said(f"{message}; see to it that no other batch makes the same results")
            return


def _lock(descriptor: int, start: int, length: int) -> None:
    """Lock bytes of a file, which need not be there; length 0 is all that follow."""
    if sys.platform == "win32":
        import msvcrt

        os.lseek(descriptor, start, os.SEEK_SET)
        msvcrt.locking(descriptor, msvcrt.LK_NBLCK, length)
    elif sys.platform == "linux":  # of the open file; others are of the process, for all its files
        import fcntl

        flock = struct.pack(FLOCK, fcntl.F_WRLCK, os.SEEK_SET, start, length, 0)
        fcntl.fcntl(descriptor, fcntl.F_OFD_SETLK, flock)
    else:
        import fcntl

        fcntl.lockf(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB, length, start)


def _is_at(descriptor: int, file: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(descriptor), file.stat())
    except FileNotFoundError:
        return False


def _leave(descriptor: int, file: Path) -> None:
    """Give the locks back; whoever is the last removes their file."""
    try:
        with suppress(OSError):  # others have locks
            if os.name == "posix":
                _lock(descriptor, 0, 0)
                if _is_at(descriptor, file):
                    file.unlink()
    finally:
        os.close(descriptor)
    if os.name != "posix":
        with suppress(OSError):  # others have it open
            file.unlink()
