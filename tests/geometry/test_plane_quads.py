import numpy as np
import pytest
from shapes import MOTIONS, fibonacci_sphere

from meshlab_symrecon.errors import GeometryError
from meshlab_symrecon.geometry.plane_quads import planes_as_quads, planes_of_pieces

PLANES = np.array([[1.0, 0, 0, -0.25], [0, 0.6, 0.8, 0.1], [-1, 2, 2, 0.3]])
PLANES /= np.linalg.norm(PLANES[:, :3], axis=1, keepdims=True)


@pytest.mark.parametrize("motion", MOTIONS, ids=lambda motion: motion.name)
def test_planes_come_back_from_their_rectangles(motion):
    points, planes = motion(fibonacci_sphere(50)), motion.planes(PLANES)
    corners, faces = planes_as_quads(planes, points)
    assert corners.shape == (12, 3)
    assert faces.shape == (6, 3)
    back = planes_of_pieces(corners, faces)
    np.testing.assert_allclose(back[:, :3], planes[:, :3], atol=1e-9)
    np.testing.assert_allclose(back[:, 3], planes[:, 3], rtol=1e-9, atol=1e-9 * motion.scale)


def test_a_rectangle_spans_the_box():
    points = fibonacci_sphere(500) * [1.0, 2.0, 3.0]
    corners, _ = planes_as_quads(np.array([[1.0, 0, 0, 0]]), points)
    np.testing.assert_allclose(corners[:, 0], 0.0, atol=1e-12)
    np.testing.assert_allclose(corners.min(axis=0)[1:], points.min(axis=0)[1:])
    np.testing.assert_allclose(corners.max(axis=0)[1:], points.max(axis=0)[1:])


def test_no_plane_is_an_empty_mesh_which_is_no_layer_of_planes():
    corners, faces = planes_as_quads(np.zeros((0, 4)), fibonacci_sphere(10))
    assert corners.shape == (0, 3)
    assert faces.shape == (0, 3)
    with pytest.raises(GeometryError, match="got a layer of 0 points that has no faces; detect"):
        planes_of_pieces(corners, faces)


def test_a_triangle_drawn_by_hand_is_a_plane():
    triangle = np.array([[0.0, 0, 1], [1, 0, 1], [0, 1, 1]])
    np.testing.assert_allclose(planes_of_pieces(triangle, np.array([[0, 1, 2]])), [[0, 0, 1, -1]])


@pytest.mark.parametrize(
    "corners",
    [
        np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]]),
        np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0.5], [0, 1, 0]]),
    ],
    ids=["needle", "bent"],
)
def test_what_is_no_plane_is_refused(corners):
    faces = np.array([[0, 1, 2], [0, 2, 3]])[: len(corners) - 2]
    with pytest.raises(GeometryError, match="flat patch"):
        planes_of_pieces(corners, faces)


def test_a_corner_that_is_no_number_is_refused():
    triangle = np.array([[0.0, 0, 1], [1, 0, np.nan], [0, 1, 1]])
    with pytest.raises(GeometryError, match="points must be finite; got 1 rows"):
        planes_of_pieces(triangle, np.array([[0, 1, 2]]))


def test_pieces_keep_the_order_of_their_first_faces_however_faces_are_mixed():
    planes = np.column_stack([np.tile([0.0, 0.0, 1.0], (200, 1)), -np.arange(200.0)])
    corners, faces = planes_as_quads(planes, fibonacci_sphere(50))
    order = np.random.default_rng(0).permutation(len(faces))
    first_seen = list(dict.fromkeys((order // 2).tolist()))
    back = planes_of_pieces(corners, faces[order])
    np.testing.assert_allclose(back, planes[first_seen], atol=1e-9)
