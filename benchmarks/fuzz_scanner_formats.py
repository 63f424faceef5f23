"""Good files of scanners and laboratories: TXT, PTX, BRE and PDB, written by hand."""

from __future__ import annotations

import struct
from collections.abc import Iterator

import numpy as np
from fuzz_good import Good

__all__ = ["scanner_files"]

TURN = np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1]], dtype=float)
PLACE = np.array([10.0, 20.0, 30.0])
OF_AN_ATOM = 42, 80  # points and faces of the ball that MeshLab makes of one


def scanner_files(points: np.ndarray, faces: list[list[int]]) -> Iterator[Good]:
    """Yield files of points; none for a mesh."""
    if faces:
        return
    yield from _txt(points)
    yield from _ptx(points)
    yield from _bre(points)
    yield _pdb(points)


def _txt(points: np.ndarray) -> Iterator[Good]:
    rows = points.tolist()
    for name, part in (("blanks", " "), ("tabs", "\t"), ("commas", ", "), ("semicolons", ";")):
        lines = [part.join(map(repr, row)) for row in rows]
        heading = [] if part == " " else [part.join("XYZ")]
        content = "".join(line + "\n" for line in [*heading, *lines]).encode()
        yield Good(f"{name}.txt", content, len(points), 0, points)


def _ptx(points: np.ndarray) -> Iterator[Good]:
    """Two scans; each has a place where its ray met nothing."""
    for colour in ("", " 255 0 10"):
        text = ""
        for matrix, place in ((np.eye(3), np.zeros(3)), (TURN, PLACE)):
            axes = "".join(" ".join(map(repr, row)) + "\n" for row in [place.tolist(),
                           *matrix.tolist()])  # fmt: skip
            rows = [*matrix.tolist(), place.tolist()]
            ends = (0, 0, 0, 1)
            text += f"{len(points) + 1}\n1\n{axes}"
            text += "".join(" ".join(map(repr, [*row, end])) + "\n"
                            for row, end in zip(rows, ends, strict=True))  # fmt: skip
            body = [f"{x!r} {y!r} {z!r} 0.5{colour}\n" for x, y, z in points.tolist()]
            body.insert(len(body) // 2, f"0 0 0 0{colour}\n")
            text += "".join(body)
        both = np.concatenate([points, points @ TURN + PLACE])
        yield Good(f"{'colours' if colour else 'plain'}.ptx", text.encode(), len(both), 0, both,
                   1e-12)  # fmt: skip


def _bre(points: np.ndarray) -> Iterator[Good]:
    """A grid with one place that holds nothing; the points are joined to triangles."""
    columns, rows = 6, 4
    generator = np.random.default_rng(len(points))
    height = generator.normal(size=(rows, columns)).astype("<f4")
    for version, size in ((0x101, 256), (0x201, 1024)):
        header = bytearray(size)
        struct.pack_into("<HH2s", header, 2, version, size, b"BR")
        struct.pack_into("<HH", header, 14, columns, rows)
        data = b"".join(
            struct.pack("<fffBBHHH", column, row, height[row, column], 9, 0, column, row, 0x7FFF)
            for row in range(rows)
            for column in range(columns)
            if (row, column) != (0, columns - 1)
        )
        held = 2 * (rows - 1) * (columns - 1) - 1
        yield Good(f"{version:x}.bre", bytes(header) + data, rows * columns - 1, held, None)


def _pdb(points: np.ndarray) -> Good:
    atoms = np.round(points / np.abs(points).max() * 500, 3)
    lines = ["HEADER    BY HAND"]
    for number, (x, y, z) in enumerate(atoms.tolist(), 1):
        lines += [f"ATOM  {number:5d}  CA  ALA A{number:4d}    {x:8.3f}{y:8.3f}{z:8.3f}"
                  "  1.00 20.00           C  "]  # fmt: skip
    content = "".join(line + "\n" for line in [*lines, "END"]).encode()
    return Good("atoms.pdb", content, OF_AN_ATOM[0] * len(atoms), OF_AN_ATOM[1] * len(atoms), None)
