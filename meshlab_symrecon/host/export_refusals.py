"""What MeshLab's exporters say when they fail, in a sentence for whoever asked for the file."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from meshlab_symrecon.errors import FileError, HostError
from meshlab_symrecon.host.atomic import reason
from meshlab_symrecon.host.translation import translated

__all__ = ["exporting_to"]

TRIED = 1 << 20  # bytes; a writer's last buffer may leave a little room
# "exportering" is MeshLab's; the place is the hidden one in which the file is being written.
IN_FRONT = r"(?:Saving Error: )?Error encountered while export(?:er)?ing file {place}:?\s*"


@contextmanager
def exporting_to(path: Path, staged: Path) -> Iterator[None]:
    """Have MeshLab write ``staged`` in this block; what it refuses is told of ``path``.

    Raises
    ------
    FileError
        The system takes no more, as a full disk does.
    HostError
        MeshLab refused for any other reason.
    """
    try:
        with translated(f"{path} cannot be written"):
            yield
    except HostError as error:
        refusal = _refusal(staged)
        if refusal is not None:
            message = f"{path} cannot be written: {reason(refusal)}"
            raise FileError(f"{message}; make room, or give another path") from refusal
        pattern = IN_FRONT.format(place=re.escape(" ".join(str(staged.resolve()).split())))
        words = re.sub(pattern, "", str(error).removeprefix(f"{path} cannot be written: "))
        told = words.rstrip(" :") or "MeshLab names no reason"
        raise HostError(f"{path} cannot be written: {told}") from error


def _refusal(staged: Path) -> OSError | None:
    """Return what the system says to more in a file, since MeshLab does not tell it."""
    try:
        with staged.open("ab", buffering=0) as file:
            size = file.tell()
            try:
                left = TRIED
                while left:
                    left -= file.write(bytes(left))
            finally:
                with suppress(OSError):  # what was refused matters
                    file.truncate(size)
    except OSError as error:
        return error
    return None
