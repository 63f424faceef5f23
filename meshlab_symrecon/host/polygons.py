"""Whether triangles are parts of polygons, which MeshLab keeps as marks on the edges inside."""

from __future__ import annotations

import tempfile
from enum import Enum
from pathlib import Path
from typing import Any

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from meshlab_symrecon.arrays import Booleans, Faces
from meshlab_symrecon.host.meshset import current_identifier
from meshlab_symrecon.host.ply_header import read_header
from meshlab_symrecon.host.ply_table import read_columns
from meshlab_symrecon.host.process_state import process_kept
from meshlab_symrecon.host.translation import translated

__all__ = ["Polygons", "polygons_of"]

INSIDE = (0x40000, 0x80000, 0x100000)  # flags of a face: its first, second, third edge is inside
BARE = {
    f"save_{what}": False
    for what in (
        "vertex_quality", "vertex_flag", "vertex_color", "vertex_coord", "vertex_normal",
        "vertex_radius", "face_quality", "face_color", "wedge_color", "wedge_texcoord",
        "wedge_normal",
    )
}  # fmt: skip


class Polygons(Enum):
    """What the triangles of a layer are."""

    NONE = "triangles"
    PLAIN = "polygons that can be put together again"
    TANGLED = "polygons that overlap, on which MeshLab's exporters end the process"


def polygons_of(mesh_set: Any, identifier: int) -> Polygons:
    """Tell whether the triangles of a layer are parts of polygons.

    pymeshlab only tells it in the flags of a PLY file: its list of polygons takes a second a
    million triangles, and fails on polygons that overlap.

    Raises
    ------
    HostError
        MeshLab could not write the flags.
    """
    before = current_identifier(mesh_set)
    with (
        tempfile.TemporaryDirectory() as folder,
        translated("looking for polygons"),
        process_kept(),
    ):
        path = Path(folder) / "flags.ply"
        mesh_set.set_current_mesh(identifier)
        try:
            mesh_set.save_current_mesh(str(path), save_textures=False, save_face_flag=True, **BARE)
        finally:
            mesh_set.set_current_mesh(before)
        columns = read_columns(path, read_header(path), "face", ("vertex_indices", "flags"))
    flags = columns["flags"].values.astype(np.int64)
    inside = (flags & np.array(INSIDE)) != 0
    if not inside.any():
        return Polygons.NONE
    faces = columns["vertex_indices"].values.astype(np.int64)
    return Polygons.PLAIN if _plain(faces, inside) else Polygons.TANGLED


def _plain(faces: Faces, inside: Booleans) -> bool:
    """Say whether every polygon is a disc cut along diagonals, and shares none of these."""
    ends = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
    keys = np.sort(ends, axis=1) @ np.array([faces.max() + 1, 1])
    _, which, count = np.unique(keys, return_inverse=True, return_counts=True)
    marked = np.bincount(which, weights=inside.reshape(-1), minlength=len(count))
    if ((marked > 0) & ((marked != 2) | (count != 2))).any():
        return False
    corners = np.flatnonzero(inside)
    first, second = corners[np.argsort(which[corners], kind="stable")].reshape(-1, 2).T // 3
    links = coo_array((np.ones(len(first)), (first, second)), shape=(len(faces), len(faces)))
    pieces = connected_components(links, directed=False)[0]
    return bool(len(faces) - pieces == len(first))  # as many links as a tree has
