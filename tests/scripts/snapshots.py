"""A document as plain arrays, to compare two of them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

ARRAYS = {
    "vertices": "vertex_matrix",
    "faces": "face_matrix",
    "edges": "edge_matrix",
    "vertex normals": "vertex_normal_matrix",
    "face normals": "face_normal_matrix",
    "selected vertices": "vertex_selection_array",
    "selected faces": "face_selection_array",
    "matrix": "transform_matrix",
}
IF_THERE = {  # what Mesh has only when a filter or a file gave it
    "vertex colours": ("has_vertex_color", "vertex_color_matrix"),
    "face colours": ("has_face_color", "face_color_matrix"),
    "vertex quality": ("has_vertex_scalar", "vertex_scalar_array"),
    "face quality": ("has_face_scalar", "face_scalar_array"),
    "vertex texture": ("has_vertex_tex_coord", "vertex_tex_coord_matrix"),
    "wedge texture": ("has_wedge_tex_coord", "wedge_tex_coord_matrix"),
}


def snapshot(mesh_set: Any) -> list[dict[str, Any]]:
    """Return every layer, in order, with all that pymeshlab tells of it."""
    current = mesh_set.current_mesh_id() if mesh_set.mesh_number() else -1
    return [_layer(mesh) | {"current": mesh.id() == current} for mesh in mesh_set]


def _layer(mesh: Any) -> dict[str, Any]:
    if not mesh.is_compact():
        mesh.compact()
    facts: dict[str, Any] = {"label": mesh.label(), "visible": mesh.is_visible()}
    for name, method in ARRAYS.items():
        facts[name] = np.array(getattr(mesh, method)())
    for name, (has, method) in IF_THERE.items():
        facts[name] = np.array(getattr(mesh, method)()) if getattr(mesh, has)() else None
    facts["textures"] = sorted(mesh.textures())
    return facts


def assert_same_documents(got: list[dict[str, Any]], wanted: list[dict[str, Any]]) -> None:
    """Check that two documents are equal to the last bit."""
    assert [layer["label"] for layer in got] == [layer["label"] for layer in wanted]
    for one, other in zip(got, wanted, strict=True):
        assert one.keys() == other.keys()
        for name, value in one.items():
            assert_equal(value, other[name], f"{name} of layer '{one['label']}'")


def assert_equal(got: Any, wanted: Any, what: str) -> None:
    """Check that two values are equal to the last bit: numbers, arrays, or mappings of them."""
    if isinstance(wanted, Mapping):
        assert got.keys() == wanted.keys(), what
        for name in wanted:
            assert_equal(got[name], wanted[name], f"{name} of {what}")
    elif isinstance(wanted, np.ndarray):
        assert isinstance(got, np.ndarray), what
        np.testing.assert_array_equal(got, wanted, err_msg=what, strict=True)
    elif hasattr(wanted, "dim_x"):  # a box of pymeshlab
        np.testing.assert_array_equal(got.min(), wanted.min(), err_msg=what)
        np.testing.assert_array_equal(got.max(), wanted.max(), err_msg=what)
    else:
        assert got == wanted, f"{what}: {got} != {wanted}"
