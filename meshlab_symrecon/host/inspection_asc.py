"""ASC files, points among words: the lines that MeshLab passes over without a word."""

from __future__ import annotations

import re
from pathlib import Path

from meshlab_symrecon.host.inspection_points import cut_off
from meshlab_symrecon.host.number_lines import check_plain_text, shown, whole_lines

__all__ = ["notes_on_lines"]

NUMBER = rb"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
POINT = re.compile(rb"\s*" + rb"[\s,]+".join([NUMBER] * 3))
COMMENT = (b"#", b"/")


def notes_on_lines(path: Path, extension: str) -> tuple[str, ...]:
    """Return warnings of lines that hold no point, but for comments and a heading.

    Raises
    ------
    FileError
        It is no text of lines.
    """
    if extension != "asc":
        return ()
    check_plain_text(path)
    lines = others = first = 0
    words = b""
    with path.open("rb") as file:
        for text in whole_lines(path, file):
            for line in text.splitlines():
                lines += 1
                if POINT.match(line) or not line.strip() or line.lstrip().startswith(COMMENT):
                    continue
                others += 1
                if others == 1:
                    first, words = lines, line.strip()
    if others == first <= 1:  # none, or the names of the columns
        return cut_off(path)
    message = f"{path}: {others} of {lines} lines hold no point and were passed over, the first"
    return (f"{message} is line {first}, '{shown(words)}'; look at what was read", *cut_off(path))
