"""Numbers in files of marks and words that no coordinate can be: MeshLab drops their points."""

from __future__ import annotations

import re
from pathlib import Path

from meshlab_symrecon.errors import FileError
from meshlab_symrecon.host.number_lines import shown

__all__ = ["check_numbers"]

CHUNK = 1 << 22  # bytes
# Among other numbers; MeshLab reads these formats in single precision.
ABSURD = re.compile(
    rb"\d[\s,]+([-+]?(?:nan|inf|[\d.]+e\+?(?:39|[4-9]\d|\d{3,})))[\s,]+[-+]?[\d.]", re.IGNORECASE
)


def check_numbers(path: Path) -> None:
    """Look for numbers that are none, or too large, among the numbers of a text.

    Raises
    ------
    FileError
        There is one.
    """
    rest = b""
    with path.open("rb") as file:
        while chunk := file.read(CHUNK):
            match = ABSURD.search(rest + chunk)
            if match:
                message = f"{path} has the coordinate {shown(match[1])}, with which nothing can be"
                raise FileError(f"{message} measured; remove that point")
            rest = chunk[-100:]
