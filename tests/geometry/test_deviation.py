"""Distances to clouds and meshes, against closed forms and against every triangle tried in turn."""

from __future__ import annotations

import numpy as np
import pytest
import shapes
from scipy.spatial import ConvexHull, cKDTree

from meshlab_symrecon import _native
from meshlab_symrecon.geometry.deviation import (
    Facing,
    TriangleSurface,
    heights_over_cloud,
    heights_over_mesh,
)
from meshlab_symrecon.geometry.mesh_edges import unit_rows, welded
from meshlab_symrecon.geometry.places import distinct_places, first_alike, nearby_order
from meshlab_symrecon.geometry.surfaces import face_normals

NO_DIRECTION = Facing(least_cosine=0.0, sided=False)  # everything counts
CUBE = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
CUBE_FACES = np.array(
    [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6],
     [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
)  # fmt: skip

CUBOID = TriangleSurface(CUBE, CUBE_FACES)


def soup(count, seed):
    """Triangles of all shapes, needles among them, that share vertices at random."""
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(count, 3)) * [1.0, 1.0, 0.2]
    faces = rng.integers(0, count, (2 * count, 3))
    return points, faces[(np.diff(np.sort(faces, axis=1), axis=1) > 0).all(axis=1)]


def distances_to_triangles(place, corners):
    """Of one place to each of (m, 3, 3) triangles: to their sides, and to planes it lies over."""
    distances = np.full(len(corners), np.inf)
    normals = unit_rows(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    over = normals.any(axis=1)
    for start, end in ((0, 1), (1, 2), (2, 0)):
        side, offset = corners[:, end] - corners[:, start], place - corners[:, start]
        share = (side * offset).sum(axis=1) / (side * side).sum(axis=1)
        to_side = np.linalg.norm(offset - share.clip(0.0, 1.0)[:, None] * side, axis=1)
        distances = np.minimum(distances, to_side)
        over &= (np.cross(side, offset) * normals).sum(axis=1) >= 0.0
    heights = np.abs(((place - corners[:, 0]) * normals).sum(axis=1))
    return np.where(over, heights, distances)


@pytest.mark.parametrize("seed", range(3))
def test_distances_to_triangles_are_those_of_every_triangle_tried(seed):
    points, faces = soup(60, seed)
    places = np.random.default_rng(seed + 10).normal(size=(150, 3))
    found = heights_over_mesh(
        places, np.ones_like(places), TriangleSurface(points, faces), NO_DIRECTION
    )
    every = np.array([distances_to_triangles(place, points[faces]) for place in places])
    of_found = every[np.arange(len(places)), found.nearest]
    np.testing.assert_allclose(of_found, every.min(axis=1), rtol=1e-9)
    inside = ~found.on_rim
    np.testing.assert_allclose(np.abs(found.heights[inside]), of_found[inside], rtol=1e-9)
    aside = np.hypot(found.heights, found.aside)[found.on_rim]
    np.testing.assert_allclose(aside, of_found[found.on_rim], rtol=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_only_faces_that_face_the_same_way_count(seed):
    points, faces = soup(60, seed)
    rng = np.random.default_rng(seed + 20)
    places, directions = rng.normal(size=(150, 3)), unit_rows(rng.normal(size=(150, 3)))
    cosines = directions @ unit_rows(face_normals(points, faces)).T
    every = np.array([distances_to_triangles(place, points[faces]) for place in places])
    for facing, counts in (
        (Facing(0.9), cosines >= 0.9),
        (Facing(0.9, sided=False), np.abs(cosines) >= 0.9),
        (Facing(0.9, within=0.4), (cosines >= 0.9) & (every <= 0.4)),
    ):
        nearest, weights = _native.closest_faces(
            points, faces.astype(np.int32), unit_rows(face_normals(points, faces)), places,
            directions, facing.least_cosine, facing.sided, facing.within,
        )  # fmt: skip
        least = np.where(counts, every, np.inf).min(axis=1)
        assert np.array_equal(nearest < 0, np.isinf(least))
        rows = np.flatnonzero(nearest >= 0)
        assert counts[rows, nearest[rows]].all()
        np.testing.assert_allclose(every[rows, nearest[rows]], least[rows], rtol=1e-9)
        first, second = weights.T[:, rows]
        corners = points[faces[nearest[rows]]].transpose(1, 2, 0)
        feet = (1.0 - first - second) * corners[0] + first * corners[1] + second * corners[2]
        apart = np.linalg.norm(feet.T - places[rows], axis=1)
        np.testing.assert_allclose(apart, least[rows], rtol=1e-9)


def signed_distance_to_cube(places):
    """Negative inside; the cube is [-1, 1] in every axis."""
    beyond = np.abs(places) - 1.0
    outside = np.linalg.norm(np.maximum(beyond, 0.0), axis=1)
    return outside + np.minimum(beyond.max(axis=1), 0.0)


def test_signed_distances_to_a_cube_are_exact_over_faces_edges_and_corners():
    places = np.random.default_rng(0).uniform(-2.5, 2.5, (4000, 3))
    found = heights_over_mesh(places, np.ones_like(places), CUBOID, NO_DIRECTION)
    np.testing.assert_allclose(found.heights, signed_distance_to_cube(places), atol=1e-14)
    assert not found.on_rim.any()


def test_near_an_edge_the_side_that_faces_the_same_way_is_measured():
    """Under the top of a cube, nearer to it than to the side, a place is measured sideways."""
    places = np.array([[0.7, 0.1, 0.9], [0.7, 0.1, 0.9], [1.2, 0.1, 0.9], [1.1, 0.1, 1.1]])
    directions = np.eye(3)[[0, 2, 0, 0]]
    found = heights_over_mesh(places, directions, CUBOID, Facing(0.5))
    np.testing.assert_allclose(found.heights, [-0.3, -0.1, 0.2, np.sqrt(0.02)], atol=1e-15)
    away = heights_over_mesh(places[:1], -np.eye(3)[:1], CUBOID, Facing(0.5, within=1.0))
    assert away.nearest.tolist() == [-1]
    assert away.heights.tolist() == away.aside.tolist() == [0.0]
    assert away.on_rim.tolist() == [False]


def test_the_tip_of_a_needle_faces_along_the_needle():
    """None of the faces round it is within 60 degrees of that."""
    ring = np.arange(7) * 2.0 * np.pi / 7.0
    tip = np.vstack([np.column_stack([np.cos(ring), np.sin(ring), 0.0 * ring]), [[0.0, 0.0, 9.0]]])
    faces = np.column_stack([np.arange(7), (np.arange(7) + 1) % 7, np.full(7, 7)])
    places = np.array([[0.0, 0.0, 9.5], [0.0, 0.0, 9.0]])
    up = np.tile([0.0, 0.0, 1.0], (2, 1))
    assert (unit_rows(face_normals(tip, faces))[:, 2] < 0.2).all()
    found = heights_over_mesh(places, up, TriangleSurface(tip, faces), Facing(0.5))
    np.testing.assert_allclose(found.heights, [0.5, 0.0], atol=1e-15)


def test_beyond_the_border_of_an_open_mesh_the_height_over_its_plane_counts():
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    places = np.array([[0.5, 0.5, 0.2], [0.3, 0.6, -0.2], [1.5, 0.4, 0.2], [2.0, 2.0, -0.1]])
    up = np.tile([0.0, 0.0, 1.0], (4, 1))
    found = heights_over_mesh(places, up, TriangleSurface(square, faces), Facing())
    np.testing.assert_allclose(found.heights, [0.2, -0.2, 0.2, -0.1], atol=1e-15)
    np.testing.assert_allclose(found.aside, [0.0, 0.0, 0.5, np.sqrt(2.0)], atol=1e-15)
    assert found.on_rim.tolist() == [False, False, True, True]


def test_of_two_sheets_the_one_that_faces_the_same_way_is_measured():
    flat = np.stack(np.meshgrid(*[np.linspace(0, 1, 21)] * 2), -1).reshape(-1, 2)
    below, above = (np.column_stack([flat, np.full(len(flat), z)]) for z in (0.0, 0.01))
    points = np.concatenate([below, above])
    normals = np.repeat([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]], len(flat), axis=0)
    places = np.column_stack([flat, np.full(len(flat), -0.05)])
    up = np.tile([0.0, 0.0, 1.0], (len(flat), 1))
    upper = heights_over_cloud(places, up, points, normals, Facing())
    np.testing.assert_allclose(upper.heights, -0.06, atol=1e-15)
    lower = heights_over_cloud(places, -up, points, normals, Facing())
    np.testing.assert_allclose(lower.heights, 0.05, atol=1e-15)
    either = heights_over_cloud(places, up, points, normals, Facing(0.5, sided=False))
    assert np.array_equal(either.nearest, lower.nearest)
    nothing = heights_over_cloud(places, up, points, normals, Facing(within=0.05))
    assert (nothing.nearest == -1).all()
    unknown = heights_over_cloud(places, 0.0 * up, points, normals, Facing(1e-9))
    assert (unknown.nearest == -1).all()
    anyhow = heights_over_cloud(places, 0.0 * up, points, normals, Facing(0.0))
    assert np.array_equal(anyhow.nearest, lower.nearest)


@pytest.mark.parametrize(("least_cosine", "counts"), [(0.0, True), (1e-9, False)])
def test_over_a_mesh_too_an_unknown_direction_counts_only_where_every_one_does(
    least_cosine, counts
):
    places = np.random.default_rng(3).uniform(-2.0, 2.0, (50, 3))
    found = heights_over_mesh(places, np.zeros_like(places), CUBOID, Facing(least_cosine))
    assert ((found.nearest >= 0) == counts).all()
    expected = signed_distance_to_cube(places) if counts else np.zeros(len(places))
    np.testing.assert_allclose(found.heights, expected, atol=1e-14)


def test_a_cloud_is_measured_to_second_order_in_its_spacing():
    """The floor of a nearest-sample distance would be first order: half as far, not a quarter."""
    places = shapes.fibonacci_sphere(3000)[::7] @ shapes.rotation(3).T
    floors = []
    for count in (2000, 8000, 32000):
        samples = shapes.fibonacci_sphere(count)
        found = heights_over_cloud(places, places, samples, samples, Facing())
        nearest = cKDTree(samples).query(places)[0]
        np.testing.assert_allclose(found.heights, -(nearest**2) / 2, atol=1e-12)
        np.testing.assert_allclose(np.hypot(found.heights, found.aside), nearest, atol=1e-7)
        floors.append(np.abs(found.heights).mean())
    assert floors[0] / floors[1] == pytest.approx(4.0, rel=0.2)
    assert floors[1] / floors[2] == pytest.approx(4.0, rel=0.2)


def test_the_order_of_places_and_faces_does_not_matter():
    points, faces = soup(80, 4)
    rng = np.random.default_rng(5)
    places = np.concatenate([rng.normal(size=(200, 3)), points[:50], points[:50]])
    directions = unit_rows(rng.normal(size=(300, 3)))
    found = heights_over_mesh(places, directions, TriangleSurface(points, faces), Facing())
    rows, order = rng.permutation(300), rng.permutation(len(faces))
    again = heights_over_mesh(
        places[rows], directions[rows], TriangleSurface(points, faces[order]), Facing()
    )
    square = np.hypot(found.heights, found.aside)[rows], np.hypot(again.heights, again.aside)
    np.testing.assert_allclose(square[1], square[0], atol=1e-12)


def test_vertices_that_coincide_are_joined_and_flat_faces_go():
    torn = CUBE[CUBE_FACES.ravel()]  # every triangle has corners of its own
    faces, vertex = welded(torn, np.arange(len(torn)).reshape(-1, 3))
    assert len(np.unique(faces)) == 8
    assert np.array_equal(torn[vertex], torn)
    places = np.random.default_rng(1).uniform(-2.0, 2.0, (500, 3))
    found = heights_over_mesh(
        places, np.ones_like(places), TriangleSurface(torn, faces), NO_DIRECTION
    )
    np.testing.assert_allclose(found.heights, signed_distance_to_cube(places), atol=1e-14)
    doubled = np.vstack([np.eye(3), np.eye(3)[:1]])
    assert welded(doubled, np.array([[0, 1, 3], [0, 1, 2]]))[0].tolist() == [[0, 1, 2]]
    assert first_alike(doubled).tolist() == [0, 1, 2, 0]
    chosen, place = distinct_places(doubled)
    assert sorted(chosen.tolist()) == [0, 1, 2]
    assert np.array_equal(doubled[chosen][place], doubled)
    assert sorted(nearby_order(doubled).tolist()) == [0, 1, 2, 3]


def test_a_large_mesh_is_searched_as_exactly_as_its_sphere():
    points = shapes.fibonacci_sphere(20_000)
    faces = ConvexHull(points).simplices
    outward = np.einsum("ij,ij->i", face_normals(points, faces), points[faces[:, 0]]) > 0.0
    faces = np.where(outward[:, None], faces, faces[:, ::-1])
    places = np.random.default_rng(2).normal(size=(5000, 3))
    found = heights_over_mesh(places, unit_rows(places), TriangleSurface(points, faces), Facing())
    beyond = np.linalg.norm(places, axis=1) - 1.0
    assert np.abs(found.heights - beyond).max() < 3e-4  # the sagitta of its edges


def test_the_kernel_refuses_arrays_that_do_not_fit():
    faces = CUBE_FACES.astype(np.int32)
    normals, rest = np.zeros((12, 3)), (CUBE, CUBE, 0.0, True, 1.0)
    with pytest.raises(ValueError, match="one normal a face"):
        _native.closest_faces(CUBE, faces, normals[:3], *rest)
    with pytest.raises(ValueError, match="one direction a place"):
        _native.closest_faces(CUBE, faces, normals, CUBE, CUBE[:3], 0.0, True, 1.0)
    with pytest.raises(ValueError, match="unknown points"):
        _native.closest_faces(CUBE, faces + 1, normals, *rest)
