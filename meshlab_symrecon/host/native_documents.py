"""The documents on which MeshLab's filters are tried for the table of their behaviour.

Between them, every fact of a current layer is met both ways, beside layers that are alike and
layers that are not, so that what a filter does under every circumstance can be told from what it
did once. They are made in a folder that may be written to.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab

__all__ = ["DOCUMENTS"]


def _mesh() -> Any:
    """Return two closed meshes with colours, quality and selections."""
    mesh_set = _empty()
    mesh_set.create_cube()
    mesh_set.create_sphere(subdiv=2)
    _enrich(mesh_set)
    return mesh_set


def _enrich(mesh_set: Any) -> None:
    """Give the current mesh colours, quality and selections."""
    mesh_set.compute_color_by_function_per_vertex()
    mesh_set.compute_color_by_function_per_face()
    mesh_set.compute_scalar_by_function_per_vertex(q="x")
    mesh_set.compute_scalar_by_function_per_face(q="x0")
    mesh_set.compute_selection_by_condition_per_vertex(condselect="x>-0.5")
    mesh_set.compute_selection_by_condition_per_face(condselect="x0>-0.5")


def _textured() -> Any:
    mesh_set = _mesh()
    _paint(mesh_set)
    return mesh_set


def _paint(mesh_set: Any) -> None:
    """Give the current mesh a texture."""
    mesh_set.compute_texcoord_parametrization_triangle_trivial_per_wedge(sidedim=0, textdim=256)
    mesh_set.compute_texmap_from_color(textname="colours.png")


def _sheet() -> Any:
    """Return a mesh with a boundary and texture coordinates a vertex, and clouds."""
    mesh_set = _cloud()
    mesh_set.create_grid(numvertx=12, numverty=12)
    mesh_set.compute_texcoord_parametrization_flat_plane_per_wedge()
    mesh_set.compute_texcoord_transfer_wedge_to_vertex()
    return mesh_set


def _cloud() -> Any:
    """Return two clouds with normals that lie almost on each other."""
    mesh_set = _empty()
    directions = np.random.default_rng(0).normal(size=(500, 3))
    normals = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    for shift in (0.0, 0.01):
        points = normals * [1.0, 2.0, 3.0] + shift
        mesh_set.add_mesh(pymeshlab.Mesh(vertex_matrix=points, v_normals_matrix=normals))
    return mesh_set


def _rough_cloud() -> Any:
    """Return a cloud with nothing but points that look scanned."""
    mesh_set = _empty()
    mesh_set.create_sphere_points(pointnum=300)
    for name, function in (("x", "x+0.01*sin(90*y)"), ("y", "y"), ("z", "z")):
        mesh_set.compute_coord_by_function(**{"x": "x", "y": "y", "z": "z", name: function})
    mesh_set.compute_normal_by_function_per_vertex(x="0", y="0", z="0")
    return mesh_set


def _rich_cloud() -> Any:
    """Return a cloud with normals, colours, quality and a selection, and a textured mesh."""
    mesh_set = _textured()
    mesh_set.create_sphere_points(pointnum=300)
    mesh_set.compute_color_by_function_per_vertex()
    mesh_set.compute_scalar_by_function_per_vertex(q="x")
    mesh_set.compute_selection_by_condition_per_vertex(condselect="x>-0.5")
    return mesh_set


def _plain_mesh() -> Any:
    """Return one closed mesh and nothing else."""
    mesh_set = _empty()
    mesh_set.create_sphere(subdiv=2)
    return mesh_set


def _mixed() -> Any:
    """Return a plain mesh between a cloud and a textured mesh, and current."""
    mesh_set = _rough_cloud()
    mesh_set.create_sphere(subdiv=2)
    mesh_set.create_sphere(subdiv=1, radius=0.7)
    _enrich(mesh_set)
    _paint(mesh_set)
    mesh_set.set_current_mesh(1)
    return mesh_set


def _quads() -> Any:
    """Return a mesh of quads with a boundary, some selected, as it comes out of a file.

    A layer made from ``Mesh(face_list_of_indices=...)`` would not do: filters with a function a
    face crash on it.
    """
    across = range(6)
    lines = [f"v {x} {y} {0.1 * x * y}" for x in across for y in across]
    corners = [6 * x + y + 1 for x in range(5) for y in range(5)]
    lines += [f"f {corner} {corner + 6} {corner + 7} {corner + 1}" for corner in corners]
    Path("quads.obj").write_text("\n".join(lines) + "\n", encoding="ascii")
    mesh_set = _empty()
    mesh_set.load_new_mesh("quads.obj")
    mesh_set.compute_selection_by_condition_per_face(condselect="x0>2.5")
    return mesh_set


def _polyline() -> Any:
    """Return the outline of a section, and the mesh that was cut."""
    mesh_set = _plain_mesh()
    mesh_set.generate_polyline_from_planar_section()
    mesh_set.set_current_mesh(max(mesh.id() for mesh in mesh_set))
    return mesh_set


def _complete() -> Any:
    """Return a mesh with everything a layer can have, and a plain one."""
    mesh_set = _plain_mesh()
    mesh_set.create_grid(numvertx=9, numverty=9, absscalex=2.0, absscaley=2.0)
    _enrich(mesh_set)
    _paint(mesh_set)
    mesh_set.compute_texcoord_transfer_wedge_to_vertex()
    _enrich(mesh_set)  # the transfer has split vertices, and forgot what was selected
    return mesh_set


def _void() -> Any:
    """Return one layer from which every vertex was deleted."""
    mesh_set = _cloud()
    mesh_set.set_selection_all()
    mesh_set.meshing_remove_selected_vertices()
    return mesh_set


def _empty() -> Any:
    return pymeshlab.MeshSet(verbose=False)


DOCUMENTS: dict[str, Callable[[], Any]] = {
    "mesh": _mesh,
    "textured": _textured,
    "sheet": _sheet,
    "cloud": _cloud,
    "rough cloud": _rough_cloud,
    "rich cloud": _rich_cloud,
    "plain mesh": _plain_mesh,
    "mixed": _mixed,
    "quads": _quads,
    "polyline": _polyline,
    "complete": _complete,
    "void": _void,
    "empty": _empty,
}
