"""What is lost of a layer when it is written to a format without faces, or without loose points."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from meshlab_symrecon.errors import FileError
from meshlab_symrecon.host.formats import FACES_ONLY, NEEDS_POINTS, POINTS_ONLY
from meshlab_symrecon.host.notices import warn_user
from meshlab_symrecon.host.whole import points_in_faces

__all__ = ["check_losses", "check_points"]


def check_points(mesh: Any, path: Path, extension: str) -> None:
    """Refuse a layer without points where the format cannot hold that.

    Raises
    ------
    FileError
    """
    if mesh.vertex_number() == 0 and extension in NEEDS_POINTS:
        message = f"{path}: layer '{mesh.label()}' has no points, which .{extension} cannot hold"
        raise FileError(f"{message}; look at what the steps before it deleted")


def check_losses(mesh: Any, path: Path, extension: str) -> None:
    """Say which faces or points the format leaves out; refuse a layer of which nothing is left.

    Raises
    ------
    FileError

    Warns
    -----
    SymReconWarning
    """
    faces = mesh.face_number()
    if extension in POINTS_ONLY and faces:
        words = f"{path}: .{extension} holds points only, so {faces} faces were left out"
        warn_user(f"{words}; write .ply to keep them")
    loose = mesh.vertex_number() - points_in_faces(mesh) if extension in FACES_ONLY else 0
    if loose:
        words = f"{path}: .{extension} holds faces only, and {loose} points belong to no face"
        if faces == 0:
            raise FileError(f"{words}; write .ply instead")
        warn_user(f"{words}, so they were left out; write .ply to keep them")
