"""Binary files that say how long they are: what is missing at their end."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from meshlab_symrecon.host.ply_header import damaged

__all__ = ["check_length"]

# How a file begins, and where four bytes tell the length of it all.
LENGTHS: Mapping[str, tuple[bytes, int]] = {"3ds": (b"MM", 2), "glb": (b"glTF", 8)}
WIDTH = 4  # bytes


def check_length(path: Path, extension: str) -> None:
    """Compare a file's size with the length in its header, where its format has one.

    Raises
    ------
    FileError
        It begins otherwise, or is shorter.
    """
    if extension not in LENGTHS:
        return
    mark, place = LENGTHS[extension]
    with path.open("rb") as file:
        beginning = file.read(place + WIDTH)
    if not beginning.startswith(mark) or len(beginning) < place + WIDTH:
        raise damaged(path, f"it does not begin as .{extension} files do")
    announced, size = int.from_bytes(beginning[place:], "little"), path.stat().st_size
    if size < announced:
        raise damaged(path, f"it announces {announced} bytes, and has {size}")
