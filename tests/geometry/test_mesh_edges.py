"""Edges and corners of a cube, which are known."""

from __future__ import annotations

import numpy as np

from meshlab_symrecon.geometry.mesh_edges import Edges, vertex_normals, winding_conflicts

CUBE = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
CUBE_FACES = np.array(
    [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6],
     [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
)  # fmt: skip


def test_the_corners_of_a_cube_face_along_its_diagonals_whatever_the_triangles():
    np.testing.assert_allclose(vertex_normals(CUBE, CUBE_FACES), CUBE / np.sqrt(3), atol=1e-15)
    with_stray = np.vstack([CUBE, [[5.0, 5.0, 5.0]]])
    assert not vertex_normals(with_stray, CUBE_FACES)[8].any()


def test_conflicts_are_edges_whose_faces_contradict_each_other():
    assert winding_conflicts(CUBE_FACES) == 0.0
    assert winding_conflicts(CUBE_FACES[:, ::-1]) == 0.0
    turned = CUBE_FACES.copy()
    turned[3] = turned[3, ::-1]
    assert winding_conflicts(turned) == 3 / 18
    assert winding_conflicts(CUBE_FACES[:1]) == 0.0
    assert winding_conflicts(np.zeros((0, 3), dtype=np.int64)) == 0.0
    fan = np.array([[0, 1, 2], [0, 1, 3], [0, 1, 4]])  # an edge of three faces says nothing
    assert winding_conflicts(fan) == 0.0


def test_the_border_of_an_open_cube_is_the_edge_of_its_lid():
    without_lid = CUBE_FACES[2:]  # the face at x = -1 is missing
    rim = Edges(without_lid, len(CUBE)).rim_vertices()
    assert np.array_equal(rim, CUBE[:, 0] < 0.0)
    assert not Edges(CUBE_FACES, len(CUBE)).rim_vertices().any()
