"""PDB files, atoms of a molecule in fixed columns: whether each has a place, and an end follows."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from meshlab_symrecon.host.number_lines import check_plain_text, numbers_in, shown, whole_lines
from meshlab_symrecon.host.ply_header import damaged

__all__ = ["notes_on_atoms"]

ATOMS = (b"ATOM  ", b"HETATM")
COLUMNS = tuple(slice(first, first + 8) for first in (30, 38, 46))  # of x, y and z
END = b"END"


def notes_on_atoms(path: Path, extension: str) -> tuple[str, ...]:
    """Return a warning when a PDB file has no end.

    Raises
    ------
    FileError
        It is no text of lines, or an atom has no place.
    """
    if extension != "pdb":
        return ()
    check_plain_text(path)
    number, last = 0, b""
    with path.open("rb") as file:
        for text in whole_lines(path, file):
            for line in text.splitlines():
                number += 1
                last = line if line.strip() else last
                if line.startswith(ATOMS):
                    _check_place(path, number, line)
    if last.split()[:1] == [END]:
        return ()
    return (
        f"{path} does not end with the word END, so it may have been cut off; compare its size",
    )


def _check_place(path: Path, number: int, line: bytes) -> None:
    for column in COLUMNS:
        found = numbers_in(line[column])
        if len(found) != 1 or not np.isfinite(found).all():
            word = shown(line[column].strip())
            raise damaged(path, f"the atom in line {number} has '{word}' instead of a number")
