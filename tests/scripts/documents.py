"""What the scripts are run on: small documents, the same at every call."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pymeshlab


def _directions(count: int, seed: int) -> np.ndarray:
    drawn = np.random.default_rng(seed).normal(size=(count, 3))
    return drawn / np.linalg.norm(drawn, axis=1, keepdims=True)


def _started() -> Any:
    return pymeshlab.MeshSet(verbose=False)


def nothing() -> Any:
    return _started()


def ball() -> Any:
    """Return a coloured sphere of 642 vertices and 1280 faces."""
    mesh_set = _started()
    mesh_set.create_sphere(radius=1.0, subdiv=3)
    mesh_set.compute_color_by_function_per_vertex(x="127+120*x", y="127+120*y", z="127+120*z")
    return mesh_set


def cloud() -> Any:
    """Return 800 coloured points of an ellipsoid, without normals."""
    mesh_set = _started()
    points = _directions(800, 3) * [1.0, 2.0, 3.0]
    colours = np.column_stack([(points / [1.0, 2.0, 3.0] + 1.0) / 2.0, np.ones(len(points))])
    mesh_set.add_mesh(pymeshlab.Mesh(vertex_matrix=points, v_color_matrix=colours), "cloud")
    return mesh_set


def statue() -> Any:
    """Return a cloud that is its own mirror image across x = 0, with a part missing."""
    x, y, z = _directions(1500, 0).T
    radius = 1.0 + 0.35 * z + 0.3 * y * z - 0.25 * y**3 + 0.3 * z * x**2
    radius += 0.4 * np.exp(-8.0 * ((abs(x) - 0.6) ** 2 + (y - 0.3) ** 2))
    points = radius[:, np.newaxis] * np.column_stack([x, y, z])
    mesh_set = _started()
    kept = points[~((points[:, 0] > 0.6) & (points[:, 1] > 0.0))]
    mesh_set.add_mesh(pymeshlab.Mesh(vertex_matrix=kept), "statue")
    return mesh_set


def two_solids() -> Any:
    """Return a coloured sphere with quality, and a cube that overlaps it."""
    mesh_set = ball()
    mesh_set.compute_scalar_by_function_per_vertex(q="z")
    mesh_set.create_cube(size=1.2)
    mesh_set.compute_matrix_from_translation(axisx=0.6, freeze=True)
    return mesh_set


def ball_and_points() -> Any:
    """Return a sphere, and eight coloured points near it."""
    mesh_set = ball()
    points = np.array([[x, y, z] for x in (-0.6, 0.6) for y in (-0.5, 0.5) for z in (-0.7, 0.7)])
    colours = np.column_stack([points + 0.5, np.ones(8)]).clip(0.0, 1.0)
    mesh_set.add_mesh(pymeshlab.Mesh(vertex_matrix=points, v_color_matrix=colours), "marks")
    return mesh_set


def two_scans() -> Any:
    """Return a lopsided mesh, and the same turned and shifted a little."""
    mesh_set = _started()
    mesh_set.create_sphere(radius=1.0, subdiv=4)
    mesh_set.compute_coord_by_function(x="x*1.5", y="y*(1+0.3*x)", z="z*0.8+0.2*x*y")
    mesh_set.generate_copy_of_current_mesh()
    mesh_set.compute_matrix_from_rotation(angle=3.0, freeze=True)
    mesh_set.compute_matrix_from_translation(axisx=0.02, axisy=-0.03, freeze=True)
    return mesh_set


def textured() -> Any:
    """Return a sphere with texture coordinates and a picture, read from the current folder."""
    mesh_set = ball()
    mesh_set.compute_texcoord_parametrization_triangle_trivial_per_wedge(textdim=256)
    mesh_set.compute_texmap_from_color(textname="colours.png", textw=256, texth=256)
    mesh_set.save_current_mesh("textured.obj", save_vertex_color=False)
    mesh_set = _started()
    mesh_set.load_new_mesh("textured.obj")
    return mesh_set


def textured_and_plain() -> Any:
    mesh_set = textured()
    mesh_set.create_sphere(radius=1.05, subdiv=3)
    return mesh_set


def sheet() -> Any:
    """Return a bent sheet of 144 vertices with a hole of four faces in it."""
    mesh_set = _started()
    mesh_set.create_grid(numvertx=12, numverty=12, absscalex=1.0, absscaley=1.0, center=True)
    mesh_set.compute_coord_by_function(x="x", y="y", z="0.3*x*x-0.2*x*y")
    faces = "(max(abs(x0),max(abs(x1),abs(x2)))<0.14)&&(max(abs(y0),max(abs(y1),abs(y2)))<0.14)"
    mesh_set.compute_selection_by_condition_per_face(condselect=faces)
    mesh_set.meshing_remove_selected_faces()
    mesh_set.meshing_remove_unreferenced_vertices()
    return mesh_set


def dirty() -> Any:
    """Return a sphere with a hole, a speck beside it, a double face, a fin and loose points."""
    mesh_set = ball()
    mesh = mesh_set.current_mesh()
    points, faces = mesh.vertex_matrix(), mesh.face_matrix()
    count = len(points)
    speck = np.array([[3.0, 0, 0], [3.1, 0, 0], [3, 0.1, 0], [3, 0, 0.1]])
    loose = np.array([[5.0, 5, 5], [6.0, 5, 5]])
    fin = points[faces[100, 0]] * 1.4
    twin = points[faces[200, 0]]
    four = count + np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    extra = [[*faces[100, :2], count + 6], faces[300], [*faces[200, :2], faces[200, 0]]]
    kept = np.delete(faces, [10, 11], axis=0)
    kept[kept == faces[200, 0]] = np.where(
        np.arange((kept == faces[200, 0]).sum()) % 2, faces[200, 0], count + 7
    )
    mesh_set.clear()
    everything = np.vstack([points, speck, loose, fin, twin])
    all_faces = np.vstack([kept, four, np.array(extra)])
    mesh_set.add_mesh(pymeshlab.Mesh(vertex_matrix=everything, face_matrix=all_faces), "scan")
    return mesh_set


DOCUMENTS: dict[str, Callable[[], Any]] = {
    made.__name__: made
    for made in (
        nothing, ball, cloud, statue, two_solids, ball_and_points, two_scans, textured,
        textured_and_plain, sheet, dirty,
    )
}  # fmt: skip
