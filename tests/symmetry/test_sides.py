import numpy as np
import pytest
import shapes
from symmetry.bodies import even_sphere, vase

from meshlab_symrecon.geometry.local_planes import local_planes
from meshlab_symrecon.symmetry.sides import _from_base, agreement_with_shape, outward_normals

BALL = 0.5 / 3**0.5 * even_sphere(3_000)
OUTWARD = even_sphere(3_000)


def turned_at_random(normals, seed=0):
    signs = np.random.default_rng(seed).choice([-1.0, 1.0], len(normals))
    return normals * signs[:, np.newaxis]


@pytest.mark.parametrize(
    "given", [None, OUTWARD, -OUTWARD, turned_at_random(OUTWARD, 1)], ids=lambda _: ""
)
def test_a_ball_faces_outwards_whatever_normals_came_with_it(given):
    normals, known = outward_normals(BALL, turned_at_random(OUTWARD), given)
    assert known
    assert np.array_equal(normals, OUTWARD)


def test_sides_are_carried_to_where_the_shape_does_not_tell():
    """The hollow of a bowl faces its own centroid, not away from it."""
    steep = even_sphere(40_000)
    bowl = steep[steep[:, 2] < -0.2]
    rim = 0.5 * (bowl + 0.92 * bowl)[bowl[:, 2] > -0.22]
    points = np.concatenate([bowl, 0.92 * bowl, rim]) / 2.2
    true = np.concatenate([bowl, -bowl, np.tile([0.0, 0.0, 1.0], (len(rim), 1))])
    normals, known = outward_normals(points, turned_at_random(true), None)
    assert known
    walls = slice(0, 2 * len(bowl))
    right = np.einsum("ij,ij->i", normals[walls], true[walls]) > 0.0
    assert right.mean() > 0.97


def test_of_two_thin_sheets_the_one_that_the_point_lies_on_tells_its_side():
    """They are a fifth as far from each other as their base points: the nearest may be beyond."""
    flat = np.stack(np.meshgrid(*[np.arange(0.0, 1.0, 0.01)] * 2), -1).reshape(-1, 2)
    sparse = np.stack(np.meshgrid(*[np.arange(0.0, 1.0, 0.05)] * 2), -1).reshape(-1, 2)
    up = np.array([0.0, 0.0, 1.0])
    points = np.concatenate([np.insert(flat, 2, height, axis=1) for height in (0.0, 0.01)])
    places = np.vstack([np.insert(sparse, 2, 0.0, 1), np.insert(sparse + 0.025, 2, 0.01, 1)])
    true, known = (np.repeat([-up, up], len(rows), axis=0) for rows in (flat, sparse))
    turned = _from_base(points, turned_at_random(true), (places, known))
    assert np.array_equal(turned, true)


def test_given_normals_decide_on_a_flat_sheet_and_without_them_nothing_does():
    flat = np.stack(np.meshgrid(*[np.linspace(0, 0.7, 40)] * 2), -1).reshape(-1, 2)
    points = np.column_stack([flat, 0.02 * np.sin(9.0 * flat[:, 0])])
    axes = local_planes(points).normals
    assert outward_normals(points, axes, None)[1] is False
    up = np.tile([0.0, 0.0, 1.0], (len(points), 1))
    normals, known = outward_normals(points, axes, up)
    assert known
    assert (normals[:, 2] > 0.0).all()
    guesses = turned_at_random(up)
    assert outward_normals(points, axes, guesses)[1] is False
    assert agreement_with_shape(points, axes) is None


def test_normals_are_only_turned():
    points = vase(4_000) / 2.5
    axes = local_planes(points).normals
    normals, _ = outward_normals(points, axes, None)
    assert np.array_equal(np.abs(normals), np.abs(axes))
    again, _ = outward_normals(points, turned_at_random(axes), None)
    assert np.array_equal(again, normals)
    aside = points[:, :2] / np.linalg.norm(points[:, :2], axis=1)[:, np.newaxis]
    wall = np.abs(normals[:, 2]) < 0.5
    assert (np.einsum("ij,ij->i", normals[wall, :2], aside[wall]) > 0.0).mean() > 0.99


def test_agreement_is_the_share_of_normals_that_face_outwards():
    assert agreement_with_shape(BALL, OUTWARD) == 1.0
    assert agreement_with_shape(BALL, -OUTWARD) == 0.0
    half = np.where(OUTWARD[:, :1] > 0.0, OUTWARD, -OUTWARD)
    assert agreement_with_shape(BALL, half) == pytest.approx(0.5, abs=0.01)


def test_a_moved_cloud_has_the_same_sides():
    points = shapes.statue(3000, seed=2) / 3.0
    axes = local_planes(points).normals
    normals, _ = outward_normals(points, axes, None)
    turn = shapes.rotation(4)
    moved, _ = outward_normals(points @ turn.T, axes @ turn.T, None)
    assert np.mean(np.einsum("ij,ij->i", moved, normals @ turn.T) > 0.0) > 0.995
