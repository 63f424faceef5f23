"""Deviation from the mirror image, on bodies whose deviation is known in closed form."""

from __future__ import annotations

import numpy as np
import pytest
import shapes
from scipy.spatial import ConvexHull

from meshlab_symrecon.errors import GeometryError, ParameterError
from meshlab_symrecon.geometry.planes import reflect
from meshlab_symrecon.geometry.surfaces import face_normals
from meshlab_symrecon.symmetry.deviation import mirror_deviation

X = np.array([1.0, 0.0, 0.0, 0.0])
HEIGHT, WIDTH = 0.05, 0.5  # of the bump


def hull_mesh(points):
    """The convex hull of points round the origin, facing outward."""
    faces = ConvexHull(points).simplices.astype(np.int64)
    outward = np.einsum("ij,ij->i", face_normals(points, faces), points[faces[:, 0]]) > 0.0
    return np.where(outward[:, None], faces, faces[:, ::-1])


def mirrored_mesh(points, faces):
    """A mesh and its mirror image across x = 0, as one layer."""
    return (
        np.concatenate([points, points * [-1, 1, 1]]),
        np.concatenate([faces, faces[:, ::-1] + len(points)]),
    )


def swelling(directions, centre=(1.0, 0.0, 0.0)):
    """Height of a smooth bump of compact support over the unit sphere."""
    away = ((directions - np.array(centre)) ** 2).sum(axis=1) / WIDTH**2
    return HEIGHT * np.clip(1.0 - away, 0.0, None) ** 3


SPHERE = shapes.fibonacci_sphere(6000)
SPHERE = np.concatenate([SPHERE[SPHERE[:, 0] > 0.0], SPHERE[SPHERE[:, 0] > 0.0] * [-1, 1, 1]])
SPHERE = np.concatenate([SPHERE, [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]])  # the two summits last
FACES = hull_mesh(SPHERE)
SAGITTA = 6e-4  # how far the triangles lie under the sphere
BUMPED = SPHERE * (1.0 + swelling(SPHERE))[:, None]


@pytest.mark.parametrize(
    "motion", [None, *shapes.MOTIONS], ids=lambda motion: motion.name if motion else "at rest"
)
def test_a_symmetric_mesh_has_no_deviation(motion):
    ring, triangles = shapes.torus_mesh(40, 20)
    points, faces = mirrored_mesh(ring + np.array([2.0, 0.0, 0.0]), triangles)
    plane, size = X, 1.0
    if motion is not None:
        points, (plane,), size = motion(points), motion.planes(X[None]), motion.scale
    found = mirror_deviation(points, plane, faces)
    far_off = np.abs(points).max() / size  # rounding of the coordinates themselves
    assert np.abs(found.distances).max() < 1e-14 * far_off * size
    assert found.has_counterpart.all()
    assert found.signed
    assert found.share_within == 1.0


def test_a_symmetric_cloud_has_no_deviation_either():
    found = mirror_deviation(SPHERE, X)
    assert np.abs(found.distances).max() < 1e-14
    assert found.has_counterpart.all()


def test_a_bump_stands_out_and_its_mirror_image_lies_under_it():
    found = mirror_deviation(BUMPED, X, FACES)
    on_bump = BUMPED[:, 0] > 0.2  # there the mirror image is the bare sphere
    expected = np.linalg.norm(BUMPED[on_bump], axis=1) - 1.0
    np.testing.assert_allclose(found.distances[on_bump], expected, atol=SAGITTA)
    top, image = found.distances[-2:]
    assert top == pytest.approx(HEIGHT, abs=SAGITTA)
    assert image == pytest.approx(-HEIGHT, abs=SAGITTA)
    facing = BUMPED[:, 0] < -0.2
    under = -swelling(SPHERE[facing] * [-1, 1, 1])
    assert (found.distances[facing] >= under - SAGITTA).all()  # no nearer than along the radius
    assert (found.distances[facing] <= SAGITTA).all()
    sizes = np.abs(found.distances)
    assert found.median == np.median(sizes)
    assert found.percentile_95 == pytest.approx(np.quantile(sizes, 0.95))
    assert found.rms == pytest.approx(np.sqrt(np.mean(sizes**2)))
    assert found.share_within == np.mean(sizes <= found.tolerance)


@pytest.mark.parametrize("given", ["none", "outward", "inward", "at random"])
def test_the_bump_of_a_cloud_stands_out_whatever_its_normals(given):
    signs = np.random.default_rng(0).choice([-1.0, 1.0], len(SPHERE))[:, None]
    normals = {"none": None, "outward": SPHERE, "inward": -SPHERE, "at random": signs * SPHERE}
    found = mirror_deviation(BUMPED, X, normals=normals[given])
    assert found.signed
    on_bump = BUMPED[:, 0] > 0.2
    expected = np.linalg.norm(BUMPED[on_bump], axis=1) - 1.0
    np.testing.assert_allclose(found.distances[on_bump], expected, atol=2e-3)
    np.testing.assert_allclose(found.distances[-2:], [HEIGHT, -HEIGHT], atol=2e-3)


def test_faces_that_are_all_inside_out_are_turned_round():
    found = mirror_deviation(BUMPED, X, FACES)
    turned = mirror_deviation(BUMPED, X, FACES[:, ::-1])
    np.testing.assert_allclose(turned.distances, found.distances, atol=1e-14)


def test_faces_that_contradict_each_other_give_distances_without_sign():
    rng = np.random.default_rng(0)
    mixed = np.where(rng.random((len(FACES), 1)) < 0.5, FACES, FACES[:, ::-1])
    found = mirror_deviation(BUMPED, X, mixed)
    assert not found.signed
    assert (found.distances >= 0.0).all()
    assert found.distances[-2:] == pytest.approx([HEIGHT, HEIGHT], abs=SAGITTA)


def test_a_few_turned_faces_take_no_sign_away():
    turned = FACES.copy()
    turned[::500] = turned[::500, ::-1]
    open_mesh = turned[1:]
    found = mirror_deviation(BUMPED, X, open_mesh)
    assert found.signed
    assert found.distances[-2:] == pytest.approx([HEIGHT, -HEIGHT], abs=SAGITTA)


@pytest.mark.parametrize("inward", [False, True], ids=["outward", "inward"])
def test_an_open_mesh_that_faces_inwards_is_turned_round(inward):
    upper = FACES[(BUMPED[FACES][:, :, 1] > -0.3).all(axis=1)]  # the bump lies in its middle
    found = mirror_deviation(BUMPED, X, upper[:, ::-1] if inward else upper)
    assert found.signed
    assert found.distances[-2:] == pytest.approx([HEIGHT, -HEIGHT], abs=SAGITTA)


def test_the_seams_of_a_texture_are_no_borders():
    """Every triangle has corners of its own, as if a texture were cut along every edge."""
    torn, corners = BUMPED[FACES.ravel()], np.arange(FACES.size).reshape(-1, 3)
    whole, found = mirror_deviation(BUMPED, X, FACES), mirror_deviation(torn, X, corners)
    np.testing.assert_allclose(found.distances, whole.distances[FACES.ravel()], atol=1e-12)
    assert found.has_counterpart.all()


def test_over_an_edge_places_may_lie_far_to_its_side():
    """The wide end of a frustum: its corners lie over the edges of the narrow end, at 45 degrees.

    They are over the plane of one face and beside that of the other.
    """
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    frustum = signs * np.column_stack([np.ones(8), 1.05 + 0.05 * signs[:, 0], np.ones(8)])
    found = mirror_deviation(frustum, X, hull_mesh(frustum))
    assert found.has_counterpart.all()
    wide = signs[:, 0] > 0.0
    np.testing.assert_allclose(found.distances[wide], 0.1 / np.hypot(1.0, 0.05), atol=1e-14)
    np.testing.assert_allclose(found.distances[~wide], 0.0, atol=1e-14)


def test_a_flat_relief_without_normals_gives_distances_without_sign():
    flat = np.stack(np.meshgrid(*[np.linspace(-1, 1, 61)] * 2), -1).reshape(-1, 2)
    height = 0.05 * np.exp(-(((flat - [0.5, 0.0]) / 0.2) ** 2).sum(axis=1))
    relief = np.column_stack([flat, height])
    found = mirror_deviation(relief, X)
    assert not found.signed
    expected = np.abs(height - height.reshape(61, 61)[:, ::-1].ravel())
    np.testing.assert_allclose(found.distances.max(), expected.max(), rtol=0.02)
    up = np.tile([0.0, 0.0, 1.0], (len(relief), 1))
    signed = mirror_deviation(relief, X, normals=up)
    assert signed.signed
    assert signed.distances.min() < -0.9 * expected.max() < 0.9 * expected.max()
    assert signed.distances.max() == pytest.approx(expected.max(), rel=0.02)


def holed(points, faces):
    """Take a window of angular radius .5 out of the left of the sphere; the mesh keeps its rest."""
    kept = points @ np.array([-0.8, 0.6, 0.0]) < np.cos(0.5)
    number = np.cumsum(kept) - 1
    whole = kept[faces].all(axis=1)
    return points[kept], number[faces[whole]]


def over_the_window(points):
    """The angle from the middle of the window's mirror image."""
    return np.arccos((points @ np.array([0.8, 0.6, 0.0])).clip(-1.0, 1.0))


@pytest.mark.parametrize("kind", ["mesh", "cloud"])
def test_what_falls_into_a_hole_has_no_counterpart(kind):
    points, faces = holed(SPHERE, FACES)
    found = mirror_deviation(points, X, faces if kind == "mesh" else None)
    angle, spacing = over_the_window(points), 0.05
    assert not found.has_counterpart[angle < 0.5 - 3.5 * spacing].any()
    assert found.has_counterpart[angle > 0.5 + spacing].all()
    assert not found.distances[~found.has_counterpart].any()
    assert np.abs(found.distances).max() < (0.5 * (3.5 * spacing) ** 2)  # of beyond the rim
    assert found.median < 1e-4


def test_a_single_point_in_a_hole_closes_no_more_than_its_surroundings():
    """Its spacing is that of the hole, but is believed up to twice the median only."""
    points = shapes.fibonacci_sphere(20_000)
    left = points[points @ np.array([-0.8, 0.6, 0.0]) < np.cos(0.5)]
    found = mirror_deviation(np.vstack([left, [[-0.8, 0.6, 0.0]]]), X)
    angle, spacing = over_the_window(left), 0.025
    near, far = angle < 4.0 * spacing, (angle > 5.4 * spacing) & (angle < 0.25)
    assert found.has_counterpart[:-1][near].all()
    assert not found.has_counterpart[:-1][far].any()
    assert min(np.count_nonzero(near), np.count_nonzero(far)) > 20


def test_a_cluster_of_points_makes_no_hole():
    """The spacing in it is a thousandth of the others', but half the median is believed."""
    points = shapes.fibonacci_sphere(3000)
    around = np.random.default_rng(0).normal(size=(60, 3)) * 1e-4 + [-1.0, 0.0, 0.0]
    cluster = around / np.linalg.norm(around, axis=1)[:, None]
    turns = np.linspace(0.0, 2.0 * np.pi, 9)
    ring = np.column_stack([np.ones(9), 0.03 * np.cos(turns), 0.03 * np.sin(turns)])
    opposite = ring / np.linalg.norm(ring, axis=1)[:, None]
    found = mirror_deviation(np.concatenate([points, cluster, opposite]), X)
    assert found.has_counterpart[-9:].all()
    np.testing.assert_allclose(found.distances[-9:], 0.0, atol=1e-3)


def test_a_part_that_is_missing_on_the_other_side_is_not_wear():
    """A long arm on one side: its far end has nothing near that it could be compared with."""
    along = SPHERE * [1.0, 0.15, 0.15] + [1.6, 0.0, 0.0]
    points = np.concatenate([SPHERE, along])
    faces = np.concatenate([FACES, FACES + len(SPHERE)])
    found = mirror_deviation(points, X, faces)
    arm = np.arange(len(points)) >= len(SPHERE)
    assert not found.has_counterpart[arm & (points[:, 0] > 1.3)].any()
    assert found.has_counterpart[~arm].all()
    assert np.abs(found.distances[~arm]).max() < 1e-14
    everything = mirror_deviation(points, X, faces, farthest=1.0)
    assert everything.has_counterpart[arm & (points[:, 0] > 1.3)].any()


def test_a_thin_part_is_compared_with_its_own_side():
    """A plate of .4 % of the diagonal whose one half is lifted by twice its thickness."""
    grid = np.linspace(-1, 1, 81)
    flat = np.stack(np.meshgrid(grid, grid), -1).reshape(-1, 2)
    corner = np.arange(80)[:, None] * 81 + np.arange(80)
    quad = np.stack([corner, corner + 1, corner + 82, corner + 81], -1).reshape(-1, 4)
    top = np.concatenate([quad[:, [0, 1, 2]], quad[:, [0, 2, 3]]])
    lift = 0.02 * np.clip(flat[:, 0] * 4.0, 0.0, 1.0)
    points = np.concatenate([np.column_stack([flat, lift]), np.column_stack([flat, lift - 0.01])])
    faces = np.concatenate([top, top[:, ::-1] + len(flat)])
    found = mirror_deviation(points, X, faces)
    right, left = (points[:, 0] > 0.35), (points[:, 0] < -0.35)
    upper = np.arange(len(points)) < len(flat)
    for side, sign in ((right, 1.0), (left, -1.0)):
        inner = side & (np.abs(points[:, :2]) < 0.9).all(axis=1)
        np.testing.assert_allclose(found.distances[inner & upper], sign * 0.02, atol=1e-12)
        np.testing.assert_allclose(found.distances[inner & ~upper], -sign * 0.02, atol=1e-12)
    assert found.signed


@pytest.mark.parametrize("kind", ["mesh", "cloud"])
@pytest.mark.parametrize("motion", shapes.MOTIONS, ids=lambda motion: motion.name)
def test_it_follows_motion_and_scale(kind, motion):
    points, faces = holed(BUMPED, FACES)
    shape = faces if kind == "mesh" else None
    rest = mirror_deviation(points, X, shape)
    (plane,) = motion.planes(X[None])
    moved = mirror_deviation(motion(points), plane, shape)
    assert np.array_equal(moved.has_counterpart, rest.has_counterpart)
    np.testing.assert_allclose(moved.distances / motion.scale, rest.distances, atol=1e-9)
    assert moved.tolerance / motion.scale == pytest.approx(rest.tolerance)


def test_neither_the_order_nor_the_way_the_plane_is_written_matters():
    points, faces = holed(BUMPED, FACES)
    order = np.random.default_rng(0).permutation(len(points))
    for shape in (faces, None):
        found = mirror_deviation(points, X, shape)
        shuffled = None if shape is None else np.argsort(order)[shape]
        again = mirror_deviation(points[order], X, shuffled)
        np.testing.assert_allclose(again.distances, found.distances[order], atol=1e-12)
        assert np.array_equal(again.has_counterpart, found.has_counterpart[order])
        for other in (-X, 3.0 * X):
            same = mirror_deviation(points, other, shape)
            assert same.distances.tobytes() == found.distances.tobytes()


def test_the_mirrored_scan_deviates_as_the_scan_does():
    points, faces = holed(BUMPED, FACES)
    found = mirror_deviation(points, X, faces)
    image = mirror_deviation(reflect(points, X), X, faces[:, ::-1])
    np.testing.assert_allclose(image.distances, found.distances, atol=1e-12)


def test_points_that_coincide_get_one_answer():
    doubled = np.concatenate([BUMPED, BUMPED[::3]])
    found = mirror_deviation(doubled, X)
    assert np.array_equal(found.distances[len(BUMPED) :], found.distances[: len(BUMPED) : 3])
    np.testing.assert_allclose(
        found.distances[: len(BUMPED)], mirror_deviation(BUMPED, X).distances, atol=1e-12
    )


def test_chosen_points_are_measured_against_all():
    chosen = BUMPED[:, 0] > 0.5
    everything = mirror_deviation(BUMPED, X, FACES)
    some = mirror_deviation(BUMPED, X, FACES, chosen=chosen)
    assert np.array_equal(some.distances[chosen], everything.distances[chosen])
    assert not some.distances[~chosen].any()
    assert np.array_equal(some.has_counterpart, chosen)
    assert some.median == np.median(np.abs(everything.distances[chosen]))


def test_a_cloud_that_is_nearly_all_in_one_place_has_the_size_of_its_box():
    heap = np.zeros((2000, 3))
    found = mirror_deviation(np.concatenate([heap, np.eye(3), -np.eye(3)]), X, tolerance=0.01)
    assert found.tolerance == pytest.approx(0.01 * 2.0 * np.sqrt(3.0))
    assert found.has_counterpart.all()
    assert not found.distances.any()


def test_vertices_without_a_face_have_no_counterpart():
    points = np.vstack([BUMPED, [[0.0, 0.0, 0.0]]])
    found = mirror_deviation(points, X, FACES)
    assert not found.has_counterpart[-1]
    np.testing.assert_allclose(found.distances[-3:-1], [HEIGHT, -HEIGHT], atol=SAGITTA)


def test_a_plane_far_away_leaves_nothing_to_compare():
    found = mirror_deviation(BUMPED, [1.0, 0.0, 0.0, -5.0])
    assert not found.has_counterpart.any()
    assert np.isnan([found.median, found.percentile_95, found.rms, found.share_within]).all()


def test_progress_is_told():
    told = []
    mirror_deviation(BUMPED, X, progress=lambda share, words: told.append(share))
    assert told == sorted(told)
    assert told[-1] == 1.0


def test_nothing_of_the_input_is_changed():
    kept = BUMPED.tobytes(), FACES.tobytes(), SPHERE.tobytes()
    mirror_deviation(BUMPED, X, FACES)
    mirror_deviation(BUMPED, X, normals=SPHERE)
    assert (BUMPED.tobytes(), FACES.tobytes(), SPHERE.tobytes()) == kept


IN_LINE = np.vstack([np.outer([0.1, 0.2, 0.7], [1.0, 0.3, 0.9]), SPHERE])  # the first three


@pytest.mark.parametrize(
    ("values", "error", "words"),
    [
        ({"tolerance": 0.0}, ParameterError, "tolerance must be a positive share"),
        ({"tolerance": -1.0}, ParameterError, "use 0.005$"),
        ({"farthest": np.nan}, ParameterError, "farthest must be a positive share"),
        ({"farthest": 0.0}, ParameterError, "use 0.05$"),
        ({"plane": []}, GeometryError, "plane must be four numbers"),
        ({"plane": 1.0}, GeometryError, "planes must have shape"),
        ({"faces": [[0, 0, 1], [2, 2, 2]]}, GeometryError, "needs faces with an area"),
        ({"points": IN_LINE, "faces": [[0, 1, 2]]}, GeometryError, "needs faces with an area"),
        ({"plane": [0.0, 0.0, 0.0, 1.0]}, GeometryError, "need a normal"),
        ({"plane": [X, X]}, GeometryError, "planes must have shape"),
        ({"points": np.eye(3)}, GeometryError, "mirror deviation needs at least"),
        ({"points": np.outer(np.arange(9.0), X[:3])}, GeometryError, "on one line"),
        ({"faces": [[0, 1, 10**6]]}, GeometryError, "face indices must lie in"),
        ({"normals": np.eye(3)}, GeometryError, "normals are needed"),
        ({"chosen": [True]}, GeometryError, "chosen must be"),
        ({"chosen": np.ones(len(SPHERE))}, GeometryError, "chosen must be"),
    ],
)
def test_bad_input_gives_one_sentence(values, error, words):
    given = {"points": SPHERE, "plane": X} | values
    with pytest.raises(error, match=words):
        mirror_deviation(**given)
