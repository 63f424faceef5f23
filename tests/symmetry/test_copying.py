import numpy as np
import pytest
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from meshlab_symrecon.geometry.neighbours import nearest_field
from meshlab_symrecon.geometry.planes import signed_distances
from meshlab_symrecon.symmetry.completion import mirror_complete
from meshlab_symrecon.symmetry.copying import off_lopsided_plinth, on_surface, standing_plane

PLANE = np.array([1.0, 0.0, 0.0, 0.0])


def sheet(count, rng, width=1.0):
    return np.column_stack([rng.uniform(0, width, (count, 2)), np.zeros(count)])


def together(points):
    distances, nearest = cKDTree(points).query(points, k=9)
    return on_surface(points, distances[:, 1:].mean(axis=1), nearest[:, 1:])


def box(count, half, centre, rng):
    half = np.asarray(half)
    areas = np.array([half[1] * half[2], half[0] * half[2], half[0] * half[1]])
    faces = rng.choice(3, count, p=areas / areas.sum())
    places = rng.uniform(-1, 1, size=(count, 3))
    places[np.arange(count), faces] = rng.choice([-1.0, 1.0], count)
    return places * half + centre


def on_plinth(shapes, seed, yaw):
    """A statue with the plane x = 0 on a box turned by ``yaw``; the statue comes first."""
    rng = np.random.default_rng(seed)
    statue = shapes.blob(4_000, seed, mirrored=True)
    low = statue[:, 2].min()
    plinth = box(2_000, [0.8, 0.9, 0.12], [0.0, 0.0, low - 0.121], rng)
    return statue, plinth @ Rotation.from_rotvec([0.0, 0.0, yaw]).as_matrix().T


# --- scatter --------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(3))
def test_a_surface_keeps_nearly_all_its_points_and_loses_what_flies(seed):
    rng = np.random.default_rng(seed)
    surface = sheet(4_000, rng)
    apart = rng.uniform([0, 0, 0.3], [1, 1, 1.3], (40, 3))
    kept = together(np.vstack([surface, apart]))
    assert kept[:4_000].mean() > 0.995
    assert kept[4_000:].mean() <= 0.05


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_the_choice_follows_scale_and_order(scale):
    rng = np.random.default_rng(3)
    cloud = np.vstack([sheet(2_000, rng), rng.uniform(-1, 2, (100, 3))])
    order = rng.permutation(len(cloud))
    assert np.array_equal(together(scale * cloud[order]), together(cloud)[order])


def test_scatter_close_to_a_surface_goes():
    rng = np.random.default_rng(1)
    surface, spacing = sheet(8_000, rng), 1.0 / np.sqrt(8_000)
    close = np.column_stack([rng.random((100, 2)), rng.uniform(6, 12, 100) * spacing])
    kept = together(np.vstack([surface, close]))
    assert kept[8_000:].mean() < 0.05
    assert kept[:8_000].mean() > 0.995


@pytest.mark.parametrize("ratio", [4, 8])
def test_a_sparse_surface_beside_a_dense_one_stays(ratio):
    rng = np.random.default_rng(2)
    dense = sheet(8_000, rng)
    steps = np.arange(0.5, 40.0) * ratio / np.sqrt(8_000)
    sparse = np.stack(np.meshgrid(steps + 1.0, steps, [0.0]), axis=-1).reshape(-1, 3)
    sparse = sparse + rng.uniform(-0.1, 0.1, sparse.shape) * [1, 1, 0] * (steps[1] - steps[0])
    kept = together(np.vstack([dense, sparse]))
    assert kept[8_000:].mean() > 0.97
    assert kept[:8_000].mean() > 0.995


def test_a_sparse_cloud_in_the_air_is_scatter_however_regular_its_spacing():
    rng = np.random.default_rng(4)
    dense = sheet(8_000, rng)
    steps = np.arange(6.0) * 0.2
    lattice = np.stack(np.meshgrid(steps, steps, steps + 0.5), axis=-1).reshape(-1, 3)
    kept = together(np.vstack([dense, lattice + rng.normal(0, 0.02, lattice.shape)]))
    assert kept[8_000:].mean() < 0.05


# --- plinths --------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(3))
def test_the_standing_plane_is_the_top_of_the_plinth(shapes, seed):
    statue, plinth = on_plinth(shapes, seed, 0.4)
    matrix = Rotation.random(random_state=seed).as_matrix()
    scan, shift = np.vstack([statue, plinth]) @ matrix.T, np.array([7.0, -5.0, 3.0])
    plane = standing_plane(1e3 * (scan + shift))
    size = np.linalg.norm(np.ptp(scan, axis=0))
    top = statue[:, 2].min() - 0.001
    up = matrix[:, 2]
    assert plane[:3] @ up > np.cos(np.radians(1.0))
    margin = signed_distances(1e3 * (scan.mean(axis=0) + shift)[np.newaxis], plane)[0] / 1e3
    height = np.vstack([statue, plinth])[:, 2].mean() - top
    assert 0.0 < height - margin < 0.02 * size  # a little above the top
    below = signed_distances(1e3 * (scan + shift), plane) <= 0.0
    assert below[len(statue) :].all()


def test_without_a_plinth_nothing_is_stood_on(shapes):
    assert standing_plane(shapes.blob(6_000, 1, mirrored=True)) is None
    assert standing_plane(np.ones((500, 3))) is None


@pytest.mark.parametrize(
    ("yaw", "copied"), [(0.0, True), (np.pi / 2, True), (0.25, False), (0.6, False)]
)
def test_only_a_plinth_that_is_its_own_mirror_image_is_copied(shapes, yaw, copied):
    statue, plinth = on_plinth(shapes, 0, yaw)
    scan = np.vstack([statue, plinth])
    spacing = float(np.median(cKDTree(scan).query(scan, k=5)[0][:, 1:].mean(axis=1)))
    standing = standing_plane(scan)
    field = nearest_field(scan, 0.02, 0.5, 10**6)
    may = off_lopsided_plinth(scan, field, spacing, standing, PLANE)
    if copied:
        assert may.all()
    else:
        assert np.array_equal(may, signed_distances(scan, standing) > 0.0)
        assert not may[len(statue) :].any()
        assert may[: len(statue)].mean() > 0.95


def test_a_cloud_above_its_standing_plane_is_copied_whole():
    scan = sheet(500, np.random.default_rng(0)) + np.array([0.0, 0.0, 1.0])
    field = nearest_field(scan, 0.02, 0.5, 10**6)
    standing = np.array([0.0, 0.0, 1.0, 0.0])
    assert off_lopsided_plinth(scan, field, 0.02, standing, PLANE).all()


def test_a_completed_statue_has_the_plinth_that_was_measured(shapes):
    statue, plinth = on_plinth(shapes, 2, 0.5)
    broken = statue[~((statue[:, 0] > 0.3) & (statue[:, 1] > 0.0))]
    found = mirror_complete(np.vstack([broken, plinth]), PLANE, blend=0.0)
    copied = found.source[found.mirrored]
    assert found.mirrored.sum() > 0.8 * (len(statue) - len(broken))
    assert (copied < len(broken)).all()
    assert len(plinth) <= found.plinth < len(plinth) + 0.05 * len(broken)


def test_a_plinth_with_a_hole_is_its_own_mirror_image_all_the_same(shapes):
    statue, plinth = on_plinth(shapes, 0, 0.0)
    hole = (plinth[:, 0] > 0.1) & (plinth[:, 1] > -0.3)
    found = mirror_complete(np.vstack([statue, plinth[~hole]]), PLANE, blend=0.0)
    assert found.plinth == 0
    assert found.mirrored.sum() > 0.8 * hole.sum()


def test_a_plinth_beside_the_plane_is_not_copied(shapes):
    statue, plinth = on_plinth(shapes, 0, 0.0)
    scan = np.vstack([statue, plinth])
    standing = standing_plane(scan)
    field = nearest_field(scan, 0.02, 0.5, 10**6)
    beside = np.array([1.0, 0.0, 0.0, -0.9])
    assert not off_lopsided_plinth(scan, field, 0.05, standing, beside)[len(statue) :].any()


@pytest.mark.parametrize("seed", range(3))
def test_clutter_that_is_half_of_the_scan_goes_for_the_most_part(seed):
    rng = np.random.default_rng(seed)
    surface = sheet(8_000, rng)
    loose = rng.uniform([0, 0, -0.5], [1, 1, 0.5], (8_000, 3))
    loose = loose[np.abs(loose[:, 2]) > 0.1]
    kept = together(np.vstack([surface, loose]))
    assert kept[:8_000].mean() > 0.99
    assert kept[8_000:].mean() < 0.25
