"""Whether a writer of MeshLab finished: few of them tell when the disk was full."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab

from meshlab_symrecon.errors import FileError, HostError
from meshlab_symrecon.host.formats import POINTS_ONLY
from meshlab_symrecon.host.inspection import check_stl
from meshlab_symrecon.host.ply_header import read_header
from meshlab_symrecon.host.ply_table import read_columns
from meshlab_symrecon.host.process_state import process_kept
from meshlab_symrecon.host.translation import translated

__all__ = ["check_whole", "points_in_faces"]

# Nothing else tells for these. CTM is left out: its reader may end the process on a whole file.
READ_BACK = ("3mf", "dae", "e57", "wrl", "x3d")
ENDINGS = {"dxf": b"\nEOF", "idtf": b"\n}", "json": b"\n}", "obj": b"# End of File"}
TAIL = 100  # bytes


def points_in_faces(mesh: Any) -> int:
    """Return how many vertices belong to a face."""
    return len(np.unique(mesh.face_matrix())) if mesh.face_number() else 0


def check_whole(mesh: Any, path: Path, staged: Path) -> None:
    """Check that a file which a writer of MeshLab made holds a layer to the end.

    Parameters
    ----------
    mesh : pymeshlab.Mesh
        What was written.
    path : Path
        Where the file will be, and what messages call it.
    staged : Path
        Where it was written.

    Raises
    ------
    FileError
        There is no file, or its end is missing.
    """
    if not staged.is_file() or staged.stat().st_size == 0:
        raise FileError(f"{path} cannot be written: the writer made no file; check free space")
    try:
        whole = _is_whole(mesh, path.suffix.removeprefix(".").lower(), staged)
    except (FileError, HostError, ValueError):
        whole = False
    if not whole:
        message = f"{path} cannot be written: the writer did not finish; check free space"
        raise FileError(message)


def _is_whole(mesh: Any, extension: str, file: Path) -> bool:
    if extension in ENDINGS:
        return _tail(file).endswith(ENDINGS[extension])
    if extension == "ply":
        return _ply_is_whole(file)
    if extension == "stl":
        check_stl(file)
        return not _is_text(file) or _tail(file).split()[-2:-1] == [b"endsolid"]
    if extension == "xyz":
        return file.read_bytes().count(b"\n") >= mesh.vertex_number()
    if extension == "off":
        return _off_is_whole(file)
    return extension not in READ_BACK or _is_read_back(mesh, extension, file)


def _is_text(file: Path) -> bool:
    """Say whether an STL file is text: MeshLab's binary ones begin otherwise."""
    with file.open("rb") as content:
        return content.read(6) == b"solid "


def _tail(file: Path) -> bytes:
    with file.open("rb") as content:
        content.seek(max(0, file.stat().st_size - TAIL))
        return content.read().rstrip()


def _ply_is_whole(file: Path) -> bool:
    """Say whether a PLY file holds what its header announces; ValueError when it ends early."""
    header = read_header(file)
    names = [element.name for element in header.elements if element.count]
    if names:
        read_columns(file, header, names[-1], ())
    return header.form != "ascii" or _ends_a_line(file)


def _off_is_whole(file: Path) -> bool:
    """Say whether an OFF file has a line for each point and face that it announces."""
    content = file.read_bytes()
    counts = content.split(b"\n", 2)[1].split()
    return content.count(b"\n") >= 2 + int(counts[0]) + int(counts[1])


def _ends_a_line(file: Path) -> bool:
    with file.open("rb") as content:
        content.seek(-1, 2)
        return content.read() == b"\n"


def _is_read_back(mesh: Any, extension: str, file: Path) -> bool:
    if mesh.vertex_number() == 0:  # not every reader takes an empty file
        return True
    written = pymeshlab.MeshSet(verbose=False)
    with translated("it cannot be read back"), process_kept():
        written.load_new_mesh(str(file.resolve()))
    faces = 0 if extension in POINTS_ONLY else mesh.face_number()
    fewest = points_in_faces(mesh) if faces else mesh.vertex_number()
    points_read = sum(layer.vertex_number() for layer in written)
    faces_read = sum(layer.face_number() for layer in written)
    return points_read >= fewest and faces_read == faces
