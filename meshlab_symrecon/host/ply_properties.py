"""The properties of a PLY file that MeshLab leaves unread, put into custom attributes.

MeshLab's reader takes the properties that it knows, in the types that it knows, and drops the
others without a word.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from meshlab_symrecon.arrays import Faces, Floats, Indices, Points
from meshlab_symrecon.host.meshset import SCALAR_PREFIX
from meshlab_symrecon.host.notices import warn_user
from meshlab_symrecon.host.ply_header import Element, Header, Property, read_header
from meshlab_symrecon.host.ply_plain import is_kept
from meshlab_symrecon.host.ply_table import Column, read_columns
from meshlab_symrecon.host.translation import script_name_in_python, translated

__all__ = ["VERTEX_STANDARD", "add_unread_properties"]

REAL = ("f4", "f8")
VERTEX_READ: dict[str, tuple[str, ...]] = {
    **dict.fromkeys(("x", "y", "z", "nx", "ny", "nz", "quality", "texture_u", "texture_v"), REAL),
    **dict.fromkeys(("red", "green", "blue", "alpha"), ("u1",)),
    **dict.fromkeys(("diffuse_red", "diffuse_green", "diffuse_blue", "diffuse_alpha"), ("u1",)),
    **dict.fromkeys(("s", "t"), ("f4",)),
    "flags": ("i4",),
}  # what MeshLab reads of a vertex: name, and the types in which it does
FACE_READ: dict[str, tuple[str, ...]] = {
    **dict.fromkeys(("red", "green", "blue", "alpha"), ("u1",)),
    "quality": REAL,
    "flags": ("i4",),
    "texnumber": ("i4",),
    **dict.fromkeys(("nx", "ny", "nz"), ("i1", "u1", "i2", "u2", "i4", "u4", *REAL)),  # computed
}
CORNERS = ("vertex_indices", "vertex_index")
EDGE_READ = ("vertex1", "vertex2")
KNOWN_ELEMENTS = ("vertex", "face", "edge", "tristrips")
VERTEX_STANDARD = frozenset(VERTEX_READ)


@dataclass(frozen=True, slots=True, eq=False)
class _Kept:
    """Which items of the file MeshLab kept: for each of its own, the place in the file."""

    vertices: Indices | None
    faces: Indices | None


def add_unread_properties(mesh_set: Any, identifier: int, path: Path) -> Mapping[str, str]:
    """Give a layer that was loaded from a PLY file the properties that MeshLab dropped.

    Single numbers become custom scalars, lists of three numbers custom points. ``confidence``
    becomes the vertex quality, too, where there is no other.

    Returns
    -------
    mapping of str to str
        The names of the custom scalars of the vertices, by the names that pymeshlab lists.

    Raises
    ------
    HostError
        MeshLab refused an attribute.

    Warns
    -----
    SymReconWarning
        Something cannot be kept: other lists, elements that are neither vertices, faces nor edges,
        or all of it when the file and what MeshLab read of it do not match.
    """
    header = read_header(path)
    vertex, face = header.element("vertex"), header.element("face")
    wanted_vertex = () if vertex is None else _unread(vertex, VERTEX_READ)
    wanted_face = () if face is None else _unread(face, FACE_READ)
    _warn_of_elements(path, header)
    if not wanted_vertex and not wanted_face:
        return {}
    mesh = mesh_set.mesh(identifier)
    try:
        vertices = read_columns(path, header, "vertex", {"x", "y", "z", *wanted_vertex})
        lists = {name for name in CORNERS if wanted_face}
        faces = read_columns(path, header, "face", {*lists, *wanted_face})
        kept = _kept(mesh, vertices, faces)
    except ValueError as error:
        _warn_of_all(path, [*wanted_vertex, *wanted_face], str(error))
        return {}
    scalars = _add(
        mesh, path, "vertex", {name: vertices[name] for name in wanted_vertex}, kept.vertices
    )
    _add(mesh, path, "face", {name: faces[name] for name in wanted_face}, kept.faces)
    _set_quality(mesh_set, identifier, vertex, frozenset(scalars.values()))
    return scalars


def _unread(element: Element, read: Mapping[str, tuple[str, ...]]) -> tuple[str, ...]:
    def dropped(item: Property) -> bool:
        if item.length_kind:
            return not is_kept(element.name, item)
        return item.kind not in read.get(item.name, ())

    return tuple(item.name for item in element.properties if dropped(item))


def _warn_of_elements(path: Path, header: Header) -> None:
    others = [item.name for item in header.elements if item.name not in KNOWN_ELEMENTS]
    edge = header.element("edge")
    if edge is not None:
        others += [f"edge {name}" for name in _unread(edge, dict.fromkeys(EDGE_READ, ("i4",)))]
    if others:
        warn_user(f"{path}: MeshLab does not read {', '.join(others)}; they were left out")


def _warn_of_all(path: Path, names: list[str], reason: str) -> None:
    warn_user(f"{path}: {', '.join(names)} were left out: {reason}; write the file again")


def _kept(mesh: Any, vertices: Mapping[str, Column], faces: Mapping[str, Column]) -> _Kept:
    """Find MeshLab's vertices and triangles in the file.

    Raises
    ------
    ValueError
        They are not there.
    """
    points = np.column_stack([vertices[axis].values[:, 0] for axis in "xyz"])
    kept = np.flatnonzero(np.isfinite(points).all(axis=1))
    held: Points = mesh.vertex_matrix()
    if len(kept) != len(held) or not np.array_equal(points[kept], held):
        raise ValueError("MeshLab read other points than the file holds")
    corners = next((faces[name] for name in CORNERS if name in faces), None)
    if corners is None:
        return _Kept(kept, None)
    return _Kept(kept, _kept_faces(mesh.face_matrix(), corners, kept, len(points)))


def _kept_faces(triangles: Faces, corners: Column, kept: Indices, count: int) -> Indices:
    """Return the face of the file that each triangle comes from.

    MeshLab cuts a polygon of n corners into n - 2 triangles and drops a face that names a vertex
    twice or one that was dropped.
    """
    renamed = np.full(count, -1, dtype=np.int64)
    renamed[kept] = np.arange(len(kept))
    flat = renamed[corners.values.reshape(-1).astype(np.int64)]
    owners = np.repeat(np.arange(len(corners.lengths)), corners.lengths)
    whole = np.ones(len(corners.lengths), dtype=np.bool_)
    whole[owners[flat < 0]] = False
    if (corners.lengths == 3).all():
        rows = flat.reshape(-1, 3)
        source = np.flatnonzero(whole & (rows != np.roll(rows, 1, axis=1)).all(axis=1))
        matching = np.array_equal(rows[source], triangles)
    else:
        source = np.repeat(
            np.arange(len(whole)), np.where(whole, np.maximum(corners.lengths - 2, 0), 0)
        )
        matching = len(source) == len(triangles) and _within(
            triangles, flat, owners, source, len(kept)
        )
    if not matching:
        raise ValueError("MeshLab read other faces than the file holds")
    return source


def _within(triangles: Faces, flat: Indices, owners: Indices, source: Indices, count: int) -> bool:
    """Say whether each triangle's corners are corners of the face that it shall come from."""
    named = np.unique(owners[flat >= 0] * count + flat[flat >= 0])
    asked = source[:, None] * count + triangles
    places = np.minimum(np.searchsorted(named, asked), max(len(named) - 1, 0))
    return bool(len(asked) == 0 or (named[places] == asked).all())


def _add(
    mesh: Any, path: Path, kind: str, columns: Mapping[str, Column], kept: Indices | None
) -> Mapping[str, str]:
    """Add columns as custom attributes; return the names of scalars by how pymeshlab lists them."""
    taken: set[str] = set()
    scalars = {}
    lost = []
    for name, column in columns.items():
        plain = script_name_in_python(SCALAR_PREFIX + name).removeprefix(SCALAR_PREFIX)
        width = column.values.shape[1] if column.even else 0
        if width not in (1, 3) or plain in taken or kept is None:
            lost.append(name)
            continue
        taken.add(plain)
        values: Floats = column.values[kept]
        form = "scalar" if width == 1 else "point"
        with translated(f"{path}: keeping '{name}'"):
            add = getattr(mesh, f"add_{kind}_custom_{form}_attribute")
            add(values[:, 0].copy() if width == 1 else values, name)
        if width == 1:
            scalars[plain] = name
    if lost:
        warn_user(
            f"{path}: {', '.join(lost)} of each {kind} cannot be kept by MeshLab, which takes "
            "single numbers and lists of three, under names that differ in more than their case"
        )
    return scalars


def _set_quality(
    mesh_set: Any, identifier: int, vertex: Element | None, added: frozenset[str]
) -> None:
    """Set the vertex quality to what the file gives for it in a type that MeshLab misreads."""
    if vertex is None:
        return
    if "quality" in vertex.names and "quality" not in added:
        return
    name = next((name for name in ("quality", "confidence") if name in added), None)
    if name is None:
        return
    with translated(f"taking '{name}' for the quality"):
        mesh_set.set_current_mesh(identifier)
        mesh_set.compute_scalar_by_function_per_vertex(q=name)
