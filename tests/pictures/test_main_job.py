"""The picture of the main job: viewpoint, panels, files."""

from __future__ import annotations

import sys

import matplotlib.image
import numpy as np
import pytest

from meshlab_symrecon.errors import FileError, GeometryError, ParameterError, SymReconError
from meshlab_symrecon.pictures import figure, main_job
from meshlab_symrecon.pictures.figure import Panel, save_panels
from meshlab_symrecon.pictures.main_job import main_job_picture, still
from meshlab_symrecon.pictures.projection import Camera, open_screen
from meshlab_symrecon.pictures.scene import INVENTED, MEASURED, PointCloud, colours_by_share
from meshlab_symrecon.pictures.viewpoint import disc_radius, upright, view_of_missing_side

NO_PLANES = np.zeros((0, 4))


@pytest.fixture(scope="module")
def egg():
    """An upright ellipsoid, mirrored in x = 0, its front right quarter invented."""
    rng = np.random.default_rng(0)
    points = rng.normal(size=(4000, 3))
    points *= [1.0, 2.0, 1.2] / np.linalg.norm(points, axis=1, keepdims=True)
    return points, (points[:, 0] > 0.2) & (points[:, 2] > 0.2)


@pytest.fixture
def job(egg):
    points, mirrored = egg
    corners = np.array([[1.0, 0, 0], [-1, 0, 0], [0, 2, 0], [0, -2, 0], [0, 0, 1], [0, 0, -1]])
    faces = np.array(
        [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]
    )
    planes = np.array([[1.0, 0.0, 0.0, 0.0]])
    share = np.array([1.0, 0, 0, 0, 1, 0])
    return [points[~mirrored], planes, points, mirrored, corners, faces, share]


@pytest.fixture
def small(monkeypatch):
    """Panels of a tenth of the size."""
    monkeypatch.setattr(main_job, "HEIGHT", 100)
    monkeypatch.setattr(main_job, "WIDTHS", (56, 110))


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("front", [1.0, -1.0])
def test_the_camera_stands_before_the_missing_side(egg, sign, front):
    points, mirrored = egg
    camera = view_of_missing_side(
        points * [1.0, 1.0, front], mirrored, np.array([[sign, 0.0, 0.0, 0.0]])
    )
    right, up, back = camera.axes()
    assert back[0] > 0.5  # from the invented side, whichever way the plane faces
    assert back[2] * front > 0.5  # and from the front, where most of them are seen
    assert up[1] > 0.98
    assert right[1] == pytest.approx(0.0, abs=1e-9)


def test_up_is_the_longest_axis_within_the_plane_and_does_not_lean_with_it(egg):
    lean = np.radians(40.0)
    turn = np.array([[1, 0, 0], [0, np.cos(lean), -np.sin(lean)], [0, np.sin(lean), np.cos(lean)]])
    planes = np.array([[1.0, 0.0, 0.0, 0.0]])
    np.testing.assert_allclose(upright(egg[0], planes), [0.0, 1.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(upright(egg[0] @ turn.T, planes), turn[:, 1], atol=0.05)
    np.testing.assert_allclose(upright(egg[0], NO_PLANES), [0.0, 1.0, 0.0], atol=1e-12)


def test_up_lies_within_the_mirror_plane(egg):
    normal = np.array([1.0, 0.2, 0.0]) / np.hypot(1.0, 0.2)
    assert upright(egg[0], np.array([[*normal, 0.0]])) @ normal == pytest.approx(0.0, abs=1e-12)


def test_without_plane_or_missing_points_there_is_still_a_view(egg):
    camera = view_of_missing_side(egg[0], np.zeros(4000, dtype=bool), NO_PLANES)
    assert camera.axes()[1, 1] > 0.98


def test_discs_grow_with_the_spacing_of_the_points(egg):
    screen = open_screen(Camera((0, 0, -1.0)), [egg[0]], 400, 400)
    radius = disc_radius(screen, egg[0])
    assert disc_radius(screen, egg[0][::4]) == pytest.approx(2.0 * radius, rel=0.2)


def test_the_picture_has_three_panels_with_the_second_colour_in_two_of_them(job, tmp_path, small):
    path = tmp_path / "job.png"
    main_job_picture(*job, path)
    page = matplotlib.image.imread(path)[..., :3]
    width = (page.shape[1] - figure.GAP) // 3
    thirds = [page[: figure.GAP + 100, figure.GAP + i * width :][:, :width] for i in range(3)]
    blue = [np.count_nonzero(third[..., 2] > third[..., 0] + 0.1) for third in thirds]
    assert blue[0] == 0
    assert min(blue[1:]) > 100
    assert [entry.name for entry in tmp_path.iterdir()] == ["job.png"]


def test_the_same_job_gives_the_same_bytes(job, tmp_path, small):
    for name in ("a.png", "b.png"):
        main_job_picture(*job, tmp_path / name, title="Egg")
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def captions_of(monkeypatch, job, **options):
    kept = []
    monkeypatch.setattr(main_job, "save_panels", lambda _path, panels, _title: kept.extend(panels))
    main_job_picture(*job, "unused.png", **options)
    return kept


def test_captions_count_points_triangles_and_shares(job, small, monkeypatch):
    panels = captions_of(monkeypatch, job)
    measured = int((~job[3]).sum())
    assert f"{measured:,}".replace(",", "\N{THIN SPACE}") in panels[0].lines[0]
    assert f"{job[3].sum()} points invented" in panels[1].lines[0]
    assert panels[2].lines == ("8 triangles, 33 % invented",)  # two vertices of six
    assert [bool(panel.swatches) for panel in panels] == [False, True, True]


def test_no_plane_is_said_and_none_is_drawn(job, small, monkeypatch):
    job[1], job[3] = NO_PLANES, np.zeros(len(job[2]), dtype=bool)
    panels = captions_of(monkeypatch, job)
    assert panels[1].heading == "No mirror plane was found"
    assert not any(panel.swatches for panel in panels)


def test_captions_and_camera_may_be_given(job, small, monkeypatch):
    given = ("one\nmore", "two", "")
    panels = captions_of(monkeypatch, job, captions=given, camera=Camera((1.0, 0, 0)))
    assert [panel.heading for panel in panels] == ["one", "two", ""]
    assert panels[0].lines == ("more",)


def test_a_still_has_its_view_and_its_caption(tmp_path):
    path = tmp_path / "still.png"
    still(path, [PointCloud(np.eye(3), radius=9.0)], Camera((-1, -1, -1.0)), (80, 60), "Head\nline")
    page = matplotlib.image.imread(path)
    assert page.shape[:2] == (60 + 2 * figure.GAP + 2 * figure.LINE, 80 + 2 * figure.GAP)
    assert (page[figure.GAP + 60 + figure.GAP :, :, 0] < 0.5).any()  # ink
    assert path.stat().st_mode & 0o777 == 0o644


def test_shares_run_from_stone_to_verdigris():
    colours = colours_by_share(np.array([0.0, 1.0, 0.5, -1.0, 2.0]))
    np.testing.assert_array_equal(colours[[0, 3]], [MEASURED] * 2)
    np.testing.assert_array_equal(colours[[1, 4]], [INVENTED] * 2)
    np.testing.assert_allclose(colours[2], (np.array(MEASURED) + INVENTED) / 2, atol=0.5)


@pytest.mark.parametrize(
    ("position", "value", "words"),
    [
        (0, np.zeros((0, 3)), "at least 1 points"),
        (1, np.zeros((1, 4)), "normal"),
        (3, np.zeros(3), "mirrored_mask"),
        (6, np.full(6, np.nan), "surface_share_invented"),
    ],
)
def test_arrays_that_do_not_belong_together_are_refused(job, tmp_path, position, value, words):
    job[position] = value
    with pytest.raises(GeometryError, match=words):
        main_job_picture(*job, tmp_path / "job.png")


def test_other_than_three_captions_are_refused(job, tmp_path):
    with pytest.raises(ParameterError, match="three"):
        main_job_picture(*job, tmp_path / "job.png", captions=("a", "b"))


def test_a_path_that_cannot_be_written_is_named_and_nothing_is_left(tmp_path):
    panel = Panel(np.zeros((4, 4, 3), dtype=np.uint8))
    with pytest.raises(FileError, match="nowhere"):
        save_panels(tmp_path / "nowhere" / "a.png", [panel])
    (tmp_path / "folder.png").mkdir()
    with pytest.raises(FileError, match=r"folder\.png"):
        save_panels(tmp_path / "folder.png", [panel])
    assert [entry.name for entry in tmp_path.iterdir()] == ["folder.png"]


def test_a_missing_matplotlib_is_one_clear_sentence(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(SymReconError, match=r"needs matplotlib.*meshlab-symrecon\[report\]"):
        save_panels(tmp_path / "a.png", [Panel(np.zeros((4, 4, 3), dtype=np.uint8))])
