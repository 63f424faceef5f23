import numpy as np
import pytest

from meshlab_symrecon.geometry.planes import (
    canonical_planes,
    distinct_planes,
    plane_angles,
    reflect,
    reflect_directions,
    signed_distances,
)


@pytest.fixture
def plane():
    normal = np.array([1.0, -2.0, 2.0]) / 3.0
    return np.append(normal, 0.7)


@pytest.fixture
def points():
    return np.random.default_rng(0).normal(size=(50, 3))


def test_reflection_is_an_involution(points, plane):
    assert np.allclose(reflect(reflect(points, plane), plane), points, atol=1e-14)
    assert np.allclose(
        reflect_directions(reflect_directions(points, plane), plane), points, atol=1e-14
    )


def test_reflection_turns_signed_distances_round(points, plane):
    mirrored = signed_distances(reflect(points, plane), plane)
    assert np.allclose(mirrored, -signed_distances(points, plane), atol=1e-14)


def test_reflection_is_an_isometry_of_determinant_minus_one(plane):
    matrix = reflect_directions(np.eye(3), plane)
    assert np.allclose(matrix @ matrix.T, np.eye(3), atol=1e-15)
    assert np.isclose(np.linalg.det(matrix), -1.0)


def test_outward_normals_of_a_sphere_stay_outward(plane):
    normals = np.random.default_rng(1).normal(size=(40, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    centre = np.array([0.3, 0.1, -2.0])
    moved = reflect(normals + centre, plane) - reflect(centre[np.newaxis], plane)
    assert np.allclose(moved, reflect_directions(normals, plane), atol=1e-14)


def test_both_ways_to_write_a_plane_become_one():
    planes = np.random.default_rng(2).normal(size=(30, 4))
    assert np.array_equal(canonical_planes(planes), canonical_planes(-planes))
    chosen = canonical_planes(planes)
    assert (chosen[np.arange(30), np.abs(chosen[:, :3]).argmax(axis=1)] > 0).all()


@pytest.mark.parametrize("angle", [0.0, 1e-9, 0.3, np.pi / 2])
def test_angles_are_exact_near_zero_and_ignore_signs(angle):
    turned = np.array([[np.cos(angle), np.sin(angle), 0.0, 1.0]])
    plane = np.array([1.0, 0.0, 0.0, 5.0])
    assert plane_angles(turned, plane) == pytest.approx([angle], rel=1e-9, abs=1e-15)
    assert plane_angles(-turned, plane) == pytest.approx([angle], rel=1e-9, abs=1e-15)


def test_of_planes_that_nearly_repeat_each_other_the_best_stays():
    turn = np.radians([0.0, 2.0, 90.0, 180.5, 0.0])  # the fourth is the first, written backwards
    planes = np.stack([np.cos(turn), np.sin(turn), 0 * turn, [0, 0, 0, 0.01, 0.5]], axis=1)
    scores = np.array([0.5, 0.9, 0.7, 0.6, 0.1])
    same = (np.radians(3.0), 0.02)
    assert list(distinct_planes(planes, scores, same)) == [1, 2, 4]
    assert list(distinct_planes(planes, scores, (0.0, 0.0))) == [1, 2, 3, 0, 4]
    assert len(distinct_planes(planes[:0], scores[:0], same)) == 0
