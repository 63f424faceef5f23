"""What is checked in a file before MeshLab reads it: its readers crash, hang or leave out."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from meshlab_symrecon.host.held import Held
from meshlab_symrecon.host.inspection_3ds import check_3ds
from meshlab_symrecon.host.inspection_asc import notes_on_lines
from meshlab_symrecon.host.inspection_dae import check_dae
from meshlab_symrecon.host.inspection_gltf import check_gltf
from meshlab_symrecon.host.inspection_lengths import check_length
from meshlab_symrecon.host.inspection_obj import check_obj
from meshlab_symrecon.host.inspection_off import check_off
from meshlab_symrecon.host.inspection_ply import check_ply
from meshlab_symrecon.host.inspection_points import check_points_text
from meshlab_symrecon.host.inspection_ptx import check_grids
from meshlab_symrecon.host.inspection_stl import check_stl, check_stl_content
from meshlab_symrecon.host.inspection_trial import try_in_child
from meshlab_symrecon.host.inspection_xml import check_numbers

__all__ = ["check_stl", "inspect"]

CHECKS: Mapping[str, Callable[[Path], Held]] = {
    "ply": check_ply,
    "obj": check_obj,
    "off": check_off,
    "stl": check_stl_content,
    "xyz": check_points_text,
    "pts": check_points_text,
    "apts": check_points_text,
}

NUMBERED: Mapping[str, Callable[[Path], None]] = {
    "3ds": check_3ds,
    "dae": check_dae,
    "glb": check_gltf,
    "gltf": check_gltf,
}


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
    check_numbers(path, extension)
    check_grids(path, extension)
    if extension in NUMBERED:
        NUMBERED[extension](path)
    notes = notes_on_lines(path, extension)
    return Held(try_in_child(path), notes=notes)
