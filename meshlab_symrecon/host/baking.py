"""A layer's transform matrix applied to its points and normals."""

from __future__ import annotations

from typing import Any

import numpy as np

from meshlab_symrecon.errors import HostError
from meshlab_symrecon.host.meshset import current_identifier
from meshlab_symrecon.host.native_filters import apply_native

__all__ = ["bake_layer"]

AXES = ("x", "y", "z")


def bake_layer(mesh_set: Any, identifier: int) -> None:
    """Apply a layer's transform matrix to its points and normals, and reset it.

    MeshLab's own way leaves normals that are not square to the surface, or not numbers.

    Raises
    ------
    HostError
        The matrix flattens the layer, or MeshLab refused a step.
    """
    mesh = mesh_set.mesh(identifier)
    matrix = np.array(mesh.transform_matrix())
    if np.array_equal(matrix, np.eye(4)):
        return
    if not np.isfinite(matrix).all() or np.linalg.det(matrix[:3, :3]) == 0.0:
        message = f"layer '{mesh.label()}' has a transform matrix that flattens it"
        raise HostError(f"{message}; reset the matrix first")
    mirrored = np.linalg.det(matrix[:3, :3]) < 0.0 and mesh.face_number() > 0
    before = current_identifier(mesh_set)
    mesh_set.set_current_mesh(identifier)
    try:
        apply_native(mesh_set, "compute_normal_by_function_per_vertex", _normal_functions(matrix))
        apply_native(mesh_set, "compute_coord_by_function", _point_functions(matrix))
        apply_native(mesh_set, "set_matrix", {"transformmatrix": np.eye(4), "freeze": False})
        if mirrored:
            apply_native(mesh_set, "meshing_invert_face_orientation", {"forceflip": True})
            apply_native(mesh_set, "compute_normal_per_vertex", {})
            apply_native(mesh_set, "apply_normal_normalization_per_vertex", {})
    finally:
        mesh_set.set_current_mesh(before)


def _combination(factors: Any, names: tuple[str, ...]) -> str:
    pairs = zip(factors, names, strict=True)
    return "(" + "+".join(f"({float(factor)!r})*{name}" for factor, name in pairs) + ")"


def _point_functions(matrix: Any) -> dict[str, str]:
    return {
        axis: f"{_combination(row[:3], AXES)}+({float(row[3])!r})"
        for axis, row in zip(AXES, matrix[:3], strict=True)
    }


def _normal_functions(matrix: Any) -> dict[str, str]:
    turned = np.linalg.inv(matrix[:3, :3]).T
    rows = [_combination(row, ("nx", "ny", "nz")) for row in turned]
    length = "sqrt(" + "+".join(f"{row}^2" for row in rows) + ")"
    return {
        axis: f"(({length})>0)?({row}/{length}):0" for axis, row in zip(AXES, rows, strict=True)
    }
