"""Texts of points that MeshLab reads only in part, read through a PLY copy of all of them.

Of a PTX file it reads the first scan, and not all of its points where some met nothing. Of a TXT
file it reads the lines that are parted by semicolons, in single precision, and passes over others.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from meshlab_symrecon.arrays import Floats
from meshlab_symrecon.errors import FileError
from meshlab_symrecon.host.atomic import reason

__all__ = ["PointRows", "with_points_copied"]

DIGITS = 20  # the room in the header for the number of points, which is known at the end
AXES, COLOURS = ("x", "y", "z"), ("red", "green", "blue")


@dataclass(frozen=True, slots=True, eq=False)
class PointRows:
    """Some points of a file, and what it holds of each.

    Attributes
    ----------
    points : (n, 3) float
    quality : (n,) float or None
    colours : (n, 3) float or None
        From 0 to 255. Either all rows of a file have these two, or none.
    """

    points: Floats
    quality: Floats | None = None
    colours: Floats | None = None


@contextmanager
def with_points_copied(
    path: Path, rows_of: Callable[[Path], Iterator[PointRows]]
) -> Iterator[Path]:
    """Yield the path of a PLY file with the points that ``rows_of`` finds in a file.

    Raises
    ------
    FileError
        The system refused to write a copy.
    """
    with tempfile.TemporaryDirectory(prefix="symrecon-") as folder:
        copy = Path(folder, path.name).with_suffix(".ply")
        try:
            _write(copy, rows_of(path))
        except FileError:
            raise
        except OSError as error:
            message = f"{path} is read through a copy, which cannot be written in {folder}"
            words = f"{message}: {reason(error)}; free space there or set TMPDIR"
            raise FileError(words) from error
        yield copy


def _write(copy: Path, pieces: Iterator[PointRows]) -> None:
    count = 0
    names: tuple[str, ...] = ()
    with copy.open("wb") as file:
        for rows in pieces:
            table = _table(rows)
            if not names:
                names = tuple(table.dtype.names or ())
                file.write(_header(names, 0))
            file.write(table.tobytes())
            count += len(table)
        file.seek(0)
        file.write(_header(names, count))


def _table(rows: PointRows) -> NDArray[np.void]:
    kinds: list[tuple[str, str]] = [(axis, "<f8") for axis in AXES]
    columns = list(rows.points.T)
    if rows.quality is not None:
        kinds.append(("quality", "<f8"))
        columns.append(rows.quality)
    if rows.colours is not None:
        kinds += [(colour, "u1") for colour in COLOURS]
        columns += list(np.clip(np.nan_to_num(np.round(rows.colours)), 0, 255).T)
    table = np.zeros(len(rows.points), kinds)
    for (name, _), column in zip(kinds, columns, strict=True):
        table[name] = column
    return table


def _header(names: tuple[str, ...], count: int) -> bytes:
    """Return a header whose length is the same for every number of points."""
    element = f"element vertex {count}"
    room = "." * (DIGITS - len(str(count)))
    properties = [f"property {'uchar' if n in COLOURS else 'double'} {n}" for n in names]
    lines = ["ply", "format binary_little_endian 1.0", f"comment {room}", element, *properties]
    return "".join(line + "\n" for line in [*lines, "end_header"]).encode()
