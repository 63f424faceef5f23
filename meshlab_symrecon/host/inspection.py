"""What is checked in a file before MeshLab reads it: its readers crash, hang or leave out."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from meshlab_symrecon.errors import FileError
from meshlab_symrecon.host.held import Held
from meshlab_symrecon.host.inspection_3ds import check_3ds
from meshlab_symrecon.host.inspection_asc import notes_on_lines
from meshlab_symrecon.host.inspection_bre import check_bre
from meshlab_symrecon.host.inspection_ctm import check_ctm
from meshlab_symrecon.host.inspection_dae import check_dae
from meshlab_symrecon.host.inspection_e57 import notes_on_scans
from meshlab_symrecon.host.inspection_fbx import check_fbx
from meshlab_symrecon.host.inspection_gltf import check_gltf
from meshlab_symrecon.host.inspection_lengths import check_length
from meshlab_symrecon.host.inspection_obj import check_obj
from meshlab_symrecon.host.inspection_off import check_off
from meshlab_symrecon.host.inspection_pdb import notes_on_atoms
from meshlab_symrecon.host.inspection_ply import check_ply
from meshlab_symrecon.host.inspection_points import check_points_text
from meshlab_symrecon.host.inspection_ptx import check_ptx
from meshlab_symrecon.host.inspection_stl import check_stl, check_stl_content
from meshlab_symrecon.host.inspection_trial import try_in_child
from meshlab_symrecon.host.inspection_txt import check_txt
from meshlab_symrecon.host.inspection_xml import check_numbers

__all__ = ["check_kind", "check_stl", "inspect"]

# Formats that MeshLab lists and does not read as anyone would expect.
REFUSED: Mapping[str, str] = {
    "es": "a program that draws a shape (EisenScript), on which MeshLab ends the process",
    "tri": "a photogrammetric reconstruction (ARC 3D), which MeshLab does not read without images "
    "of its own kind",
    "vmi": "an image of MeshLab's memory, which only the build that wrote it can read",
}

CHECKS: Mapping[str, Callable[[Path], Held]] = {
    "ply": check_ply,
    "obj": check_obj,
    "qobj": check_obj,
    "off": check_off,
    "stl": check_stl_content,
    "xyz": check_points_text,
    "pts": check_points_text,
    "apts": check_points_text,
    "ptx": check_ptx,
    "txt": check_txt,
}

WORDS = ("dae", "wrl", "x3d", "x3dv")  # of marks and words, with numbers among them

# Checks of what a child process reads next; they return how many points are not numbers.
NUMBERED: Mapping[str, Callable[[Path], int]] = {
    "3ds": check_3ds,
    "ctm": check_ctm,
    "dae": check_dae,
    "fbx": check_fbx,
    "glb": check_gltf,
    "gltf": check_gltf,
}


def check_kind(path: Path) -> None:
    """Refuse formats that MeshLab cannot be trusted with.

    Raises
    ------
    FileError
        It is one of those.
    """
    what = REFUSED.get(path.suffix.removeprefix(".").lower())
    if what is not None:
        message = f"{path} cannot be read: it is {what}"
        raise FileError(f"{message}; write .ply with the program that made it")


def inspect(path: Path, extension: str) -> Held:
    """Check a file; return what it holds.

    Raises
    ------
    FileError
        As the check of its format: it is damaged, or MeshLab cannot read it.
    """
    if extension in CHECKS:
        return CHECKS[extension](path)
    check_length(path, extension)
    if extension in WORDS:
        check_numbers(path)
    if extension == "bre":
        held = check_bre(path)
        try_in_child(path)
        return held
    lost = NUMBERED[extension](path) if extension in NUMBERED else 0
    notes = (*notes_on_lines(path, extension), *notes_on_atoms(path, extension))
    read = try_in_child(path)
    notes += notes_on_scans(path, extension, read)
    return Held(read + lost, lost, notes=notes)
