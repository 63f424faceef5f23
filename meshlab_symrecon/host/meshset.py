"""Layers of a MeshSet as plain arrays, and back.

A :class:`pymeshlab.Mesh` is a reference into its MeshSet that dangles once the layer is gone, so
nothing here keeps one.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache, partial
from typing import Any

import numpy as np
import pymeshlab
from numpy.typing import ArrayLike

from meshlab_symrecon.arrays import Booleans, Faces, Floats, Points
from meshlab_symrecon.errors import HostError
from meshlab_symrecon.host.notices import warn_user
from meshlab_symrecon.host.sources import source_of
from meshlab_symrecon.host.translation import translated
from meshlab_symrecon.one_thread import in_one_thread
from meshlab_symrecon.plugin import Layer, Layers

__all__ = [
    "FACE_POINT_PREFIX",
    "FACE_SCALAR_PREFIX",
    "POINT_PREFIX",
    "SCALAR_PREFIX",
    "add_layer",
    "attribute_names",
    "check_addable",
    "current_identifier",
    "layers_of",
    "read_layer",
]

HALF_A_STEP = 0.5 / 255.0  # pymeshlab cuts colours down to bytes; this makes it round
ROUNDED = 1e-12  # what products and inverses of matrices leave in the last row
SCALAR_PREFIX = "__ca_vs__"  # how the options of a PLY file list custom scalars of vertices
POINT_PREFIX = "__ca_vp__"  # custom points of vertices
FACE_SCALAR_PREFIX = "__ca_fs__"  # custom scalars of faces
FACE_POINT_PREFIX = "__ca_fp__"  # custom points of faces


def layers_of(mesh_set: Any) -> Layers:
    """Return the layers of a document; each is read once, when it is first asked for."""
    labels = {mesh.id(): mesh.label() for mesh in mesh_set}
    return Layers(labels, current_identifier(mesh_set), cache(partial(read_layer, mesh_set)))


def current_identifier(mesh_set: Any) -> int:
    """Return the current layer's identifier, -1 when there is none."""
    try:
        number = mesh_set.current_mesh_id()
    except pymeshlab.PyMeshLabException:
        return -1
    return int(number) if mesh_set.mesh_id_exists(number) else -1


def read_layer(mesh_set: Any, identifier: int) -> Layer:
    """Return a copy of one layer, in world coordinates.

    The layer's transform matrix is applied to points and normals; faces are turned over when the
    matrix mirrors, so that they face outward still. Attributes that MeshLab gives to every layer
    count as absent while they hold nothing: normals that are all zero, colours that are all white,
    quality that is all zero. Custom attributes whose names are not plain lower case are left out
    with a warning, since pymeshlab does not tell such names, unless they came with a PLY file.

    Raises
    ------
    HostError
        No layer has that identifier, or its transform matrix cannot be inverted or is one of
        perspective.
    """
    if not mesh_set.mesh_id_exists(identifier):
        raise HostError(f"no layer has the number {identifier}; list the layers and pick another")
    mesh = mesh_set.mesh(identifier)
    with translated(f"reading layer {identifier}"):
        if not mesh.is_compact():
            mesh.compact()
        matrix = np.asarray(mesh.transform_matrix(), dtype=np.float64)
        points = _floats(mesh.vertex_matrix())
        normals = _floats(mesh.vertex_normal_matrix())
        faces: Faces = np.ascontiguousarray(mesh.face_matrix(), dtype=np.int64).reshape(-1, 3)
        if not np.array_equal(matrix, np.eye(4)):
            points, normals, faces = _in_world(matrix, points, normals, faces, identifier)
        attributes = _attributes(mesh_set, identifier)
        return Layer(
            points=_sealed(points),
            faces=_sealed(faces),
            label=mesh.label(),
            normals=_sealed(normals) if normals.any() else None,
            colours=_vertex_colours(mesh),
            quality=_vertex_quality(mesh),
            face_quality=_floats(mesh.face_scalar_array()) if mesh.has_face_scalar() else None,
            face_colours=_floats(mesh.face_color_matrix()) if mesh.has_face_color() else None,
            selected=_selection(mesh.vertex_selection_array()),
            face_selected=_selection(mesh.face_selection_array()),
            attributes=attributes,
            identifier=identifier,
        )


def add_layer(mesh_set: Any, layer: Layer, current: bool) -> int:
    """Add a copy of ``layer`` to the document; return its identifier.

    Positions, quality and custom attributes arrive to the last bit, colours rounded to bytes.
    MeshLab computes the normals of a layer with faces itself, and appends ``(1)`` to a label that
    is taken. The selection is not carried. In an empty document the layer always becomes current.

    Raises
    ------
    HostError
        The layer has no points, which MeshLab cannot hold, or its arrays do not fit together.
    """
    check_addable(layer)
    becomes_current = current or current_identifier(mesh_set) < 0
    with translated(f"adding layer '{layer.label}'"):
        mesh_set.add_mesh(_mesh_of(layer), layer.label, becomes_current)
        identifier = max(mesh.id() for mesh in mesh_set)
        mesh = mesh_set.mesh(identifier)
        # Attributes given to the Mesh before it is added make the PLY exporter crash.
        for name, values in layer.attributes.items():
            mesh.add_vertex_custom_scalar_attribute(np.array(values, dtype=np.float64), name)
    return int(identifier)


def check_addable(layer: Layer) -> None:
    """Refuse a layer that MeshLab cannot hold.

    Raises
    ------
    HostError
        It has no points.
    """
    if len(layer.points) == 0:
        message = f"layer '{layer.label}' cannot be added; got no points; MeshLab needs at least 1"
        raise HostError(message)


def attribute_names(mesh_set: Any, identifier: int, prefix: str = SCALAR_PREFIX) -> tuple[str, ...]:
    """List a layer's custom attributes of one kind, in lower case.

    pymeshlab only tells them among the current layer's options for PLY files.
    """
    current = current_identifier(mesh_set)
    mesh_set.set_current_mesh(identifier)
    try:
        options = mesh_set.filter_parameter_values("ply")
    finally:
        if current >= 0:
            mesh_set.set_current_mesh(current)
    listed = (option for option in options if option.startswith(prefix))
    return tuple(option.removeprefix(prefix) for option in listed)


def _mesh_of(layer: Layer) -> Any:
    optional: dict[str, ArrayLike | None] = {
        "face_matrix": layer.faces if len(layer.faces) else None,
        "v_normals_matrix": layer.normals,
        "v_scalar_array": layer.quality,
        "v_color_matrix": None if layer.colours is None else _rounded(layer.colours),
        "f_scalar_array": layer.face_quality,
        "f_color_matrix": None if layer.face_colours is None else _rounded(layer.face_colours),
    }
    given = {name: np.array(array) for name, array in optional.items() if array is not None}
    return pymeshlab.Mesh(vertex_matrix=np.array(layer.points, dtype=np.float64), **given)


def _rounded(colours: Floats) -> Floats:
    shifted: Floats = np.minimum(np.clip(colours, 0.0, 1.0) + HALF_A_STEP, 1.0)
    return shifted


@in_one_thread
def _in_world(
    matrix: Floats, points: Points, normals: Points, faces: Faces, identifier: int
) -> tuple[Points, Points, Faces]:
    if not np.allclose(matrix[3], [0.0, 0.0, 0.0, 1.0], rtol=0.0, atol=ROUNDED):
        message = (
            f"layer {identifier} has a transform matrix with a last row of "
            f"{matrix[3].tolist()} instead of [0.0, 0.0, 0.0, 1.0]; reset the matrix first"
        )
        raise HostError(message)
    linear = matrix[:3, :3]
    determinant = np.linalg.det(linear)
    if not np.isfinite(matrix).all() or determinant == 0.0:
        message = (
            f"layer {identifier} has a transform matrix that flattens it; got determinant "
            f"{determinant:g}; reset the matrix first"
        )
        raise HostError(message)
    moved = points @ linear.T + matrix[:3, 3]
    turned = normals @ np.linalg.inv(linear)  # rows times the inverse = inverse transpose times n
    lengths = np.linalg.norm(turned, axis=1, keepdims=True)
    unit = np.divide(turned, lengths, out=np.zeros_like(turned), where=lengths > 0.0)
    return moved, unit, faces[:, ::-1] if determinant < 0.0 else faces


def _vertex_colours(mesh: Any) -> Floats | None:
    """Return colours, or None when there are none; every ``Mesh(...)`` of pymeshlab is white."""
    if not mesh.has_vertex_color():
        return None
    colours = _floats(mesh.vertex_color_matrix())
    return None if (colours == 1.0).all() else _sealed(colours)


def _vertex_quality(mesh: Any) -> Floats | None:
    """Return quality, or None when there is none; every ``Mesh(...)`` of pymeshlab has zeros."""
    if not mesh.has_vertex_scalar():
        return None
    quality = _floats(mesh.vertex_scalar_array())
    return _sealed(quality) if quality.any() else None


def _selection(flags: ArrayLike) -> Booleans | None:
    selected = np.array(flags, dtype=np.bool_)
    return _sealed(selected) if selected.any() else None


def _attributes(mesh_set: Any, identifier: int) -> Mapping[str, Floats]:
    found = {}
    known = source_of(mesh_set, identifier).attributes
    for listed in attribute_names(mesh_set, identifier):
        name = known.get(listed, listed)
        try:
            values = mesh_set.mesh(identifier).vertex_custom_scalar_attribute_array(name)
        except pymeshlab.PyMeshLabException:
            # The way to the true name is to save the layer, which crashes for some attributes.
            warn_user(
                f"the custom attribute '{name}' of layer {identifier} was left out: pymeshlab "
                "does not tell names with capitals, spaces or signs; use lower case"
            )
        else:
            found[name] = _sealed(_floats(values))
    return found


def _floats(values: ArrayLike) -> Floats:
    return np.array(values, dtype=np.float64, order="C")


def _sealed(array: Any) -> Any:
    array.setflags(write=False)
    return array
