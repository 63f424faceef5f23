import numpy as np
import pytest
from symmetry.bodies import even_sphere, vase

from meshlab_symrecon.geometry.neighbours import principal_normals
from meshlab_symrecon.symmetry.orientation import orient


def turned_at_random(normals, seed=0):
    signs = np.random.default_rng(seed).choice([-1.0, 1.0], len(normals))
    return normals * signs[:, np.newaxis]


def test_normals_of_a_ball_all_face_outwards():
    directions = even_sphere(3_000)
    points = 0.5 / 3**0.5 * directions
    normals, oriented = orient(points, turned_at_random(directions), None)
    assert oriented.all()
    assert np.array_equal(normals, directions)


def test_what_is_said_to_be_oriented_is_on_a_vase():
    points = vase(6_000) / 2.5
    normals, _ = principal_normals(points, points, 20)
    found, oriented = orient(points, normals, None)
    assert oriented.mean() > 0.6
    outwards = points - points.mean(axis=0)
    assert (np.einsum("ij,ij->i", found, outwards)[oriented] > 0.0).mean() > 0.99


def test_normals_are_only_turned_and_their_signs_do_not_matter():
    points = vase(2_000) / 2.5
    normals, _ = principal_normals(points, points, 20)
    found, oriented = orient(points, normals, None)
    again, known = orient(points, turned_at_random(normals), None)
    assert np.array_equal(np.abs(found), np.abs(normals))
    assert np.array_equal(oriented, known)
    assert np.array_equal(found[oriented], again[oriented])


def test_the_side_of_a_flat_sheet_is_not_known():
    places = np.random.default_rng(0).uniform(-0.35, 0.35, (2_000, 2))
    sheet = np.column_stack([places, np.zeros(2_000)])
    upwards = np.broadcast_to([0.0, 0.0, 1.0], sheet.shape)
    assert not orient(sheet, upwards, None)[1].any()


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_hints_that_all_point_inwards_are_turned_round(sign):
    directions = even_sphere(500)
    hints = sign * 7.0 * directions
    normals, oriented = orient(0.3 * directions, turned_at_random(directions), hints)
    assert oriented.all()
    assert np.array_equal(normals, directions)


def test_hints_decide_where_the_shape_is_silent():
    places = np.random.default_rng(0).uniform(-0.35, 0.35, (2_000, 2))
    sheet = np.column_stack([places, np.zeros(2_000)])
    upwards = np.broadcast_to([0.0, 0.0, 1.0], sheet.shape)
    normals, oriented = orient(sheet, upwards, -upwards)
    assert oriented.all()
    assert np.array_equal(normals, -upwards)


def test_guessed_hints_are_not_used():
    directions = even_sphere(500)
    plain = orient(0.3 * directions, directions, None)
    guessed = orient(0.3 * directions, directions, turned_at_random(directions))
    assert np.array_equal(plain[0], guessed[0])
    assert np.array_equal(plain[1], guessed[1])


def test_hints_across_the_normal_or_of_no_length_tell_nothing():
    normals = np.tile([0.0, 0.0, 1.0], (4, 1))
    hints = np.array([[1.0, 0.0, 0.4], [0.0, 0.0, 0.0], [1.0, 0.0, 1.0], [0.3, 0.0, -0.4]])
    found, oriented = orient(np.eye(4)[:, :3], normals, hints)
    assert list(oriented) == [False, False, True, True]
    assert list(found[2:, 2]) == [1.0, -1.0]
