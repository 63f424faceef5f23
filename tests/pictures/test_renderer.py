"""The renderer against closed forms: silhouettes, shades, what hides what, what shines through."""

from __future__ import annotations

import numpy as np
import pytest

from meshlab_symrecon.errors import GeometryError, ParameterError
from meshlab_symrecon.pictures.lighting import shade
from meshlab_symrecon.pictures.projection import Camera, fit, open_screen
from meshlab_symrecon.pictures.rasterisation import empty_buffer, scan_convert
from meshlab_symrecon.pictures.renderer import BACKGROUND, render
from meshlab_symrecon.pictures.scene import PlaneSheet, PointCloud, TriangleMesh, plane_sheet
from meshlab_symrecon.pictures.surface_buffer import GAMMA, draw, vertex_normals

FRONT = Camera((0.0, 0.0, -1.0), (0.0, 1.0, 0.0), target=(0.0, 0.0, 0.0), height=4.0)
SIZE = (200, 200)  # 50 pixels a unit
PAPER = np.array(BACKGROUND)
RED, BLUE = (200, 40, 30), (30, 60, 200)


def sphere(subdivisions: int = 5) -> tuple[np.ndarray, np.ndarray]:
    """An octahedron, subdivided and blown up to the unit sphere; faces look outward."""
    points = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1.0]])
    corners = points[
        [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]
    ]
    for _ in range(subdivisions):
        a, b, c = corners.transpose(1, 0, 2)
        ab, bc, ca = a + b, b + c, c + a
        parts = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        corners = np.concatenate([np.stack(part, axis=1) for part in parts])
        corners /= np.linalg.norm(corners, axis=2, keepdims=True)
    points, faces = np.unique(corners.reshape(-1, 3).round(12), axis=0, return_inverse=True)
    return points, faces.reshape(-1, 3)


def square(z: float, half: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    points = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1.0]]) * half
    return np.column_stack([points, np.full(4, z)]), np.array([[0, 1, 2], [0, 2, 3]])


def expected(colour: tuple[int, int, int], normal: tuple[float, float, float]) -> np.ndarray:
    """sRGB of a surface in full light."""
    light = shade(np.array([normal]), np.ones(1), np.ones(1), np.zeros(1, dtype=bool))[0]
    linear = ((np.array(colour) / 255.0) ** GAMMA * light).clip(0.0, 1.0)
    return 255.0 * linear ** (1.0 / GAMMA)


def covered(image: np.ndarray) -> np.ndarray:
    return (image != PAPER).any(axis=2)


def test_sphere_covers_the_area_of_its_disc():
    image = render([TriangleMesh(*sphere(), RED)], FRONT, SIZE)
    red = np.abs(image.astype(float) - PAPER).sum(axis=2)
    assert covered(image).sum() == pytest.approx(np.pi * 50.0**2, rel=0.03)  # antialiased rim
    columns, rows = np.nonzero(red)
    assert columns.mean() == pytest.approx(99.5, abs=0.5)
    assert rows.mean() == pytest.approx(99.5, abs=0.5)


def test_samples_of_a_sphere_cover_the_area_of_its_disc():
    screen = open_screen(FRONT, [], 1000, 1000)
    points, faces = sphere(6)
    buffer = empty_buffer(1000, 1000)
    scan_convert(buffer, 0, screen.project(points), faces)
    assert (buffer.item == 0).sum() == pytest.approx(np.pi * 250.0**2, rel=2e-3)


def test_depths_and_normals_of_a_sphere():
    screen = open_screen(FRONT, [], 400, 400)
    seen = draw([TriangleMesh(*sphere(6))], screen, 1.0)
    rows, columns = np.nonzero(np.isfinite(seen.depth))
    at = screen.unproject(np.column_stack([columns + 0.5, rows + 0.5, seen.depth[rows, columns]]))
    assert np.abs(np.linalg.norm(at, axis=1) - 1.0).max() < 1e-3
    assert np.abs(seen.normal[rows, columns] - at).max() < 5e-3
    assert not seen.inside.any()


def test_the_middle_of_a_sphere_has_the_shade_of_a_surface_that_faces_the_viewer():
    image = render([TriangleMesh(*sphere(), RED)], FRONT, SIZE)
    assert image[99:101, 99:101].mean(axis=(0, 1)) == pytest.approx(
        expected(RED, (0.0, 0.0, 1.0)), abs=1.0
    )


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_the_nearer_object_hides_the_farther_one_in_either_order(order):
    both = [TriangleMesh(*square(0.5, 0.5), RED), TriangleMesh(*square(-0.5), BLUE)]
    image = render([both[index] for index in order], FRONT, SIZE).astype(int)
    assert image[100, 100, 0] > image[100, 100, 2]
    assert image[100, 60, 2] > image[100, 60, 0]
    behind = Camera((0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (0.0, 0.0, 0.0), 4.0)
    image = render([both[index] for index in order], behind, SIZE).astype(int)
    assert image[100, 100, 2] > image[100, 100, 0]


@pytest.mark.parametrize("with_normals", [True, False])
def test_discs_are_round_and_keep_their_colours(with_normals):
    points = np.array([[-1.0, 0, 0], [1.0, 0, 0]])
    normals = np.array([[0.0, 0, 1]] * 2) if with_normals else None
    image = render([PointCloud(points, np.array([RED, BLUE]), normals, radius=20.0)], FRONT, SIZE)
    assert covered(image).sum() == pytest.approx(2 * np.pi * 20.0**2, rel=0.06)
    assert image[100, 50] == pytest.approx(expected(RED, (0, 0, 1)), abs=1.0)
    assert image[100, 150] == pytest.approx(expected(BLUE, (0, 0, 1)), abs=1.0)


def test_relief_of_a_slope_gives_its_normal():
    grid = np.stack(np.meshgrid(np.linspace(-1, 1, 120), np.linspace(-1, 1, 120)), axis=-1)
    points = np.column_stack([grid.reshape(-1, 2), 0.5 * grid[..., 0].ravel()])
    seen = draw([PointCloud(points, radius=2.0)], open_screen(FRONT, [], *SIZE), 1.0)
    normal = seen.normal[60:140, 60:140].reshape(-1, 3).mean(axis=0)
    np.testing.assert_allclose(normal / np.linalg.norm(normal), [-0.4472, 0.0, 0.8944], atol=0.03)


def test_a_vertex_colour_is_blended_over_its_triangle():
    points, faces = square(0.0)
    colours = np.array([RED, BLUE, BLUE, RED])  # from red on the left to blue on the right
    image = render([TriangleMesh(points, faces, colours)], FRONT, SIZE).astype(int)
    assert (np.diff(image[100, 52:148, 0]) <= 0).all()
    assert (np.diff(image[100, 52:148, 2]) >= 0).all()


def test_a_sheet_in_front_blends_and_one_behind_is_hidden():
    mesh = TriangleMesh(*square(0.0), RED)
    bare = render([mesh], FRONT, SIZE)
    sheet = square(0.6, 1.5)[0]
    before = render([mesh, PlaneSheet(sheet, BLUE, opacity=0.25, border=0.0)], FRONT, SIZE)

    def linear(image: np.ndarray) -> np.ndarray:
        return (np.asarray(image) / 255.0) ** GAMMA

    for row, column in ((100, 100), (100, 30)):  # over the mesh, over the paper
        blend = 0.75 * linear(bare[row, column]) + 0.25 * linear(np.array(BLUE))
        np.testing.assert_allclose(linear(before[row, column]), blend, atol=0.01)
    hidden = render([mesh, PlaneSheet(sheet - [0, 0, 1.2], BLUE, border=0.0)], FRONT, SIZE)
    np.testing.assert_array_equal(hidden[60:140, 60:140], bare[60:140, 60:140])
    assert (hidden[100, 30] != PAPER).any()


def test_a_sheet_through_a_sphere_shows_only_in_front_of_it():
    oblique = Camera((-1.0, 0.0, -1.0), (0.0, 1.0, 0.0), (0.0, 0.0, 0.0), 4.0)
    ball = TriangleMesh(*sphere())
    bare = render([ball], oblique, SIZE).astype(int)
    sheet = plane_sheet([1.0, 0.0, 0.0, 0.0], ball.points, [0.0, 1.0, 0.0], margin=0.5)
    cut = render([ball, sheet], oblique, SIZE).astype(int)
    changed = (cut != bare).any(axis=2) & covered(bare)
    # the sheet leaves the sphere at z = 1 and z = -1, columns 100 -+ 50 / sqrt(2)
    assert changed[100, 52:64].all()
    assert not changed[100, 68:148].any()


def test_crossing_sheets_are_blended_the_farther_one_first():
    slope = np.array([[-1, -1, -1], [1, -1, 1], [1, 1, 1], [-1, 1, -1.0]])
    sheets = [
        PlaneSheet(slope, RED, 0.6, 0.0),
        PlaneSheet(slope * [1, 1, -1], BLUE, 0.6, 0.0),
    ]
    image = render(sheets, FRONT, SIZE).astype(int)
    assert image[100, 60, 2] > image[100, 60, 0]  # blue is nearer on the left
    assert image[100, 140, 0] > image[100, 140, 2]
    np.testing.assert_array_equal(image, render(sheets[::-1], FRONT, SIZE))


def test_a_sheet_seen_from_its_side_is_not_drawn():
    sheet = plane_sheet([1.0, 0.0, 0.0, 0.0], sphere(1)[0], [0.0, 1.0, 0.0])
    assert not covered(render([sheet], FRONT, SIZE)).any()


def test_a_shadow_falls_behind_what_stands_in_the_key_light():
    floor, stop = square(0.0, 1.8), square(0.8, 0.5)
    bare = render([TriangleMesh(*floor)], FRONT, SIZE).astype(int)
    both = render([TriangleMesh(*floor), TriangleMesh(*stop)], FRONT, SIZE).astype(int)
    # light from the upper left: the shadow lies 0.8 * (0.5, -0.62) / 0.6 to the lower right
    assert both[141, 133, 0] < 0.8 * bare[141, 133, 0]
    assert both[30, 30, 0] == pytest.approx(bare[30, 30, 0], abs=3)


def test_up_is_up_and_right_is_right():
    image = render(
        [PointCloud([[0.0, 1.0, 0.0]], RED, radius=4.0), PointCloud([[1.0, 0, 0]], BLUE, radius=4)],
        FRONT,
        SIZE,
    )
    assert (image[50, 100] != PAPER).any()
    assert (image[100, 150] != PAPER).any()
    assert covered(image).sum() < 200
    turned = Camera((0.0, 0.0, -1.0), (1.0, 0.0, 0.0), (0.0, 0.0, 0.0), 4.0)
    image = render([PointCloud([[1.0, 0.0, 0.0]], RED, radius=4.0)], turned, SIZE)
    assert (image[50, 100] != PAPER).any()


def test_axes_are_a_rotation_and_projection_can_be_undone():
    screen = open_screen(Camera((1.0, -2.0, 0.5), (0.1, 0.2, 1.0), (1, 2, 3), 7.0), [], 300, 200)
    np.testing.assert_allclose(screen.axes @ screen.axes.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(screen.axes) == pytest.approx(1.0)
    points = np.random.default_rng(0).normal(size=(50, 3))
    np.testing.assert_allclose(screen.unproject(screen.project(points)), points, atol=1e-12)


@pytest.mark.parametrize("size", [(300, 100), (100, 300)])
def test_a_fitted_camera_shows_everything_and_wastes_no_room(size):
    points = np.random.default_rng(1).normal(size=(400, 3)) * [3.0, 1.0, 2.0] + 100.0
    camera = fit(Camera((1.0, -0.3, -2.0)), points, size, margin=0.1)
    seen = open_screen(camera, [], *size).project(points)[:, :2] / size
    assert seen.min() >= 0.1 - 1e-9
    assert seen.max() <= 0.9 + 1e-9
    assert np.ptp(seen, axis=0).max() == pytest.approx(0.8)


def test_a_single_point_is_seen():
    assert covered(render([PointCloud([[5.0, 5.0, 5.0]])], Camera((0, 0, -1.0)), (20, 20))).any()


def test_the_picture_does_not_depend_on_scale_or_place():
    points, faces = sphere(4)
    camera = Camera((-1.0, -0.5, -1.0))
    plain = render([TriangleMesh(points, faces, RED)], camera, (120, 120)).astype(int)
    moved = render([TriangleMesh(points * 1024.0 + 512.0, faces, RED)], camera, (120, 120))
    assert np.abs(plain - moved).mean() < 0.05


def test_equal_scenes_give_equal_bytes_and_leave_the_input_alone():
    points, faces = sphere(3)
    kept = points.copy()
    items = [TriangleMesh(points, faces), PointCloud(points * 1.1)]
    first = render(items, FRONT, SIZE)
    assert first.tobytes() == render(items, FRONT, SIZE).tobytes()
    assert first.dtype == np.uint8
    assert first.shape == (200, 200, 3)
    np.testing.assert_array_equal(points, kept)


def test_the_inside_of_a_surface_is_darker_than_its_outside():
    points, faces = square(0.0)
    outside = render([TriangleMesh(points, faces)], FRONT, SIZE)
    inside = render([TriangleMesh(points, faces[:, ::-1])], FRONT, SIZE)
    assert (inside[100, 100] < 0.8 * outside[100, 100]).all()


def test_vertex_normals_of_a_sphere_point_outward():
    points, faces = sphere(4)
    assert ((vertex_normals(points, faces) * points).sum(axis=1) > 0.999).all()


def test_triangles_without_area_and_off_the_screen_draw_nothing():
    points = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [90, 90, 0], [91, 90, 0], [90, 91, 0.0]])
    mesh = TriangleMesh(points, [[0, 1, 2], [0, 0, 1], [3, 4, 5]])
    assert not covered(render([mesh], FRONT, SIZE)).any()


@pytest.mark.parametrize("items", [[], [PointCloud(np.zeros((0, 3)))]])
def test_nothing_gives_clean_paper(items):
    assert not covered(render(items, FRONT, (30, 20))).any()


@pytest.mark.parametrize(
    ("make", "error", "words"),
    [
        (lambda: Camera((0, 0, 0)), ParameterError, "not zero"),
        (lambda: Camera((0, 1, 0), (0, -2, 0)), ParameterError, "not parallel"),
        (lambda: Camera((0, 0, np.nan)), ParameterError, "finite"),
        (lambda: Camera((0, 0, 1), height=0.0), ParameterError, "height"),
        (lambda: PointCloud([[0, 0, np.inf]]), GeometryError, "finite"),
        (lambda: PointCloud([[0, 0, 0]], radius=0.0), ParameterError, "radius"),
        (lambda: PointCloud([[0, 0, 0]], [0, 0, 256]), ParameterError, "0 .. 255"),
        (lambda: PointCloud([[0, 0, 0]], [0.5, 0, 0]), ParameterError, "whole"),
        (lambda: PointCloud([[0, 0, 0]], [[0, 0, 0]] * 2), ParameterError, "shape"),
        (lambda: PointCloud([[0, 0, 0]], normals=[[0, 0, 1]] * 2), GeometryError, "normals"),
        (lambda: TriangleMesh([[0, 0, 0]], [[0, 0, 1]]), GeometryError, "indices"),
        (lambda: PlaneSheet(np.zeros((3, 3))), GeometryError, "four"),
        (lambda: PlaneSheet([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 2, 0]]), GeometryError, "paral"),
        (lambda: PlaneSheet(square(0)[0], opacity=1.5), ParameterError, "opacity"),
        (lambda: PlaneSheet(square(0)[0], border=np.nan), ParameterError, "border"),
        (lambda: plane_sheet([0, 2, 0, 0], [[0, 0, 0]], [0, 1, 0]), GeometryError, "up"),
        (lambda: render([], FRONT, (0, 5)), ParameterError, "pixels"),
        (lambda: render([], FRONT, (5, 10_000)), ParameterError, "pixels"),
    ],
)
def test_what_cannot_be_drawn_is_refused(make, error, words):
    with pytest.raises(error, match=words):
        make()
