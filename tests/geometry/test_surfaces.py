import numpy as np
import pytest
from scipy.spatial import ConvexHull
from shapes import MOTIONS, fibonacci_sphere, torus_mesh

from meshlab_symrecon.geometry.surfaces import (
    enclosed_volume,
    face_components,
    face_normals,
    surface_area,
    topology,
)

TETRAHEDRON = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])


def test_tetrahedron():
    found = topology(TETRAHEDRON)
    assert found.closed
    assert found.edge_manifold
    assert found.vertex_manifold
    assert found.oriented
    assert (found.components, found.genus, found.euler) == (1, 0, 2)
    assert enclosed_volume(CORNERS, TETRAHEDRON) == pytest.approx(1 / 6)
    assert surface_area(CORNERS, TETRAHEDRON) == pytest.approx(1.5 + np.sqrt(3) / 2)


def test_torus_has_genus_one_and_pieces_add_up():
    _, ring = torus_mesh(5, 7)
    assert topology(ring).genus == 1
    both = topology(np.concatenate([ring, TETRAHEDRON + ring.max() + 1, ring + 100]))
    assert (both.components, both.genus, both.euler) == (3, 2, 2)
    assert face_components(np.concatenate([ring, TETRAHEDRON + 99]))[0] == 2


def test_a_missing_face_opens_three_edges():
    found = topology(TETRAHEDRON[1:])
    assert not found.closed
    assert found.boundary_edges == 3
    assert found.genus == -1


def test_an_edge_with_three_faces_is_no_manifold():
    found = topology(np.concatenate([TETRAHEDRON, [[0, 1, 9]]]))
    assert not found.edge_manifold
    assert found.non_manifold_edges == 1
    assert not found.vertex_manifold


def test_two_tetrahedra_that_touch_in_a_vertex_are_pinched():
    other = np.array([4, 5, 6, 0])[TETRAHEDRON]
    found = topology(np.concatenate([TETRAHEDRON, other]))
    assert found.closed
    assert found.edge_manifold
    assert not found.vertex_manifold


def test_one_turned_face_spoils_the_orientation():
    turned = TETRAHEDRON.copy()
    turned[0] = turned[0, ::-1]
    assert not topology(turned).oriented


def test_no_faces_are_not_closed():
    found = topology(np.zeros((0, 3), dtype=np.int64))
    assert not found.closed
    assert found.components == 0
    assert enclosed_volume(CORNERS, np.zeros((0, 3), dtype=np.int64)) == 0.0


@pytest.mark.parametrize("motion", MOTIONS, ids=lambda motion: motion.name)
def test_volume_and_area_follow_motions(motion):
    points = fibonacci_sphere(200)
    hull = ConvexHull(points)
    faces = hull.simplices.copy()
    inward = np.einsum("ij,ij->i", face_normals(points, faces), points[faces].mean(axis=1)) < 0
    faces[inward] = faces[inward, ::-1]
    assert enclosed_volume(motion(points), faces) == pytest.approx(
        hull.volume * motion.scale**3, rel=1e-9
    )
    assert surface_area(motion(points), faces) == pytest.approx(
        hull.area * motion.scale**2, rel=1e-9
    )
