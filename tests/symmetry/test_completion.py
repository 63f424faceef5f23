import numpy as np
import pytest
from scipy.spatial import cKDTree

from meshlab_symrecon.errors import GeometryError, ParameterError
from meshlab_symrecon.geometry.planes import reflect
from meshlab_symrecon.symmetry.completion import GAP, mirror_complete

PLANE = np.array([1.0, 0.0, 0.0, 0.0])


def sphere(count=4_000):
    steps = np.arange(count) + 0.5
    polar, turn = np.arccos(1 - 2 * steps / count), np.pi * (1 + 5**0.5) * steps
    return np.stack(
        [np.cos(turn) * np.sin(polar), np.sin(turn) * np.sin(polar), np.cos(polar)], axis=1
    )


@pytest.fixture
def scan():
    """Three quarters of a sphere: everything but x > 0.5 with z > 0."""
    points = sphere()
    return points[~((points[:, 0] > 0.2) & (points[:, 2] > 0))]


def test_half_a_sphere_becomes_a_sphere():
    whole = sphere()
    half = whole[whole[:, 0] < 0]
    found = mirror_complete(half, PLANE)
    assert np.abs(np.linalg.norm(found.points, axis=1) - 1).max() < 1e-12
    spacing = np.sqrt(4 * np.pi / len(whole))
    seam = GAP * spacing / 2  # share of the sphere within the gap of the rim, on the far side
    assert (1 - 1.2 * seam) * len(whole) < len(found.points) < len(whole)
    assert cKDTree(found.points).query(whole)[0].max() < 1.5 * spacing


def test_a_quarter_of_a_box_is_completed_by_two_planes():
    rng = np.random.default_rng(0)
    faces = rng.integers(0, 3, 9_000)
    box = rng.uniform(-1, 1, size=(9_000, 3))
    box[np.arange(9_000), faces] = rng.choice([-1.0, 1.0], 9_000)
    quarter = box[(box[:, 0] < 0) & (box[:, 1] < 0)]
    found = mirror_complete(quarter, [[1.0, 0, 0, 0], [0, 1.0, 0, 0]])
    assert cKDTree(found.points).query(box)[0].max() < 0.25
    assert len(found.points) > 3.2 * len(quarter)
    folded = -np.abs(found.points[:, :2])
    assert np.allclose(folded, quarter[found.source, :2], atol=1e-12)


def test_measured_points_come_first_bit_for_bit(scan):
    scan = (scan * 1e3 + 0.1).astype(np.float32)
    before = scan.copy()
    plane = np.array([1.0, 0, 0, -0.1])
    for blend in (0.0, 0.1):
        found = mirror_complete(scan, plane, blend=blend)
        count = len(scan)
        assert np.array_equal(found.points[:count], scan.astype(np.float64))
        assert np.array_equal(found.mirrored, np.arange(len(found.points)) >= count)
        assert np.array_equal(found.source[:count], np.arange(count))
        assert found.mirrored.any()
    assert np.array_equal(scan, before)


def test_only_what_is_missing_is_filled(scan):
    found = mirror_complete(scan, PLANE)
    spacing = np.sqrt(4 * np.pi / 4_000)
    new = found.points[found.mirrored]
    assert cKDTree(scan).query(new)[0].min() > 0.5 * spacing
    assert (new[:, 0] > 0.2 - 2 * spacing).mean() > 0.97
    missing = sphere()
    missing = missing[(missing[:, 0] > 0.2) & (missing[:, 2] > 0)]
    assert cKDTree(new).query(missing)[0].max() < (1 + GAP) * spacing


def test_a_whole_cloud_gets_nothing():
    half = sphere()[sphere()[:, 0] < 0]
    whole = np.vstack([half, reflect(half, PLANE)])
    found = mirror_complete(whole, PLANE)
    assert not found.mirrored.any()
    assert np.array_equal(found.points, whole)


def test_no_planes_add_nothing(scan):
    found = mirror_complete(scan, np.zeros((0, 4)))
    assert np.array_equal(found.points, scan)
    assert not found.mirrored.any()


def test_attributes_follow_their_points(scan):
    plane = np.array([2.0, 0.0, 0.0, 0.0])  # need not be of unit length
    colours = np.random.default_rng(1).integers(0, 256, size=(len(scan), 4)).astype(np.uint8)
    quality = np.arange(float(len(scan)))
    found = mirror_complete(scan, plane, scan, colours, quality, blend=0.0)
    assert np.allclose(found.normals, found.points, atol=1e-12)  # a sphere: outward stays outward
    assert np.array_equal(found.colours, colours[found.source])
    assert found.colours.dtype == np.uint8
    assert np.array_equal(found.quality, quality[found.source])
    images = reflect(scan[found.source[found.mirrored]], PLANE)
    assert np.array_equal(found.points[found.mirrored], images)


def test_outliers_are_not_copied(scan):
    far = np.array([[-3.0, 0.0, 0.0], [-3.0, 2.0, 1.0]])
    found = mirror_complete(np.vstack([scan, far]), PLANE)
    assert not np.isin(found.source[found.mirrored], [len(scan), len(scan) + 1]).any()


def test_blend_closes_the_step_at_the_seam(scan):
    tilted = np.array([1.0, 0.0, 0.0, -0.01])  # mirror images stand off the sphere by up to 0.02
    plain = mirror_complete(scan, tilted, blend=0.0)
    leaning = mirror_complete(scan, tilted)

    def step(found):
        new = found.points[found.mirrored]
        seam = cKDTree(scan).query(new)[0] < 0.12
        return np.abs(np.linalg.norm(new[seam], axis=1) - 1).mean()

    assert step(leaning) < 0.5 * step(plain)


@pytest.mark.parametrize("scale", [1e-3, 1e6])
def test_completion_follows_scale(scan, scale):
    at_rest = mirror_complete(scan, PLANE)
    scaled = mirror_complete(scan * scale, PLANE)
    assert np.array_equal(scaled.source, at_rest.source)
    assert np.allclose(scaled.points / scale, at_rest.points, rtol=0.0, atol=1e-9)


def test_progress_is_reported_to_its_end(scan):
    calls = []
    mirror_complete(scan, np.eye(4)[:2], progress=lambda *call: calls.append(call))
    fractions = [fraction for fraction, _ in calls]
    assert fractions == sorted(fractions)
    assert fractions[-1] == 1.0


@pytest.mark.parametrize(
    ("wrong", "error"),
    [
        ({"gap": 0.0}, ParameterError),
        ({"gap": float("nan")}, ParameterError),
        ({"blend": -1.0}, ParameterError),
        ({"planes": [[0.0, 0.0, 0.0, 1.0]]}, GeometryError),
        ({"normals": np.zeros((3, 3))}, GeometryError),
        ({"colours": np.zeros((3, 4))}, GeometryError),
        ({"quality": 1.0}, GeometryError),
        ({"source": np.ones(3)}, GeometryError),
        ({"source": np.full(3_000, np.nan)}, GeometryError),
        ({"planes": [["a", "b", "c", "d"]]}, GeometryError),
        ({"planes": np.ones((1, 1, 4))}, GeometryError),
        ({"points": np.zeros((1, 3))}, GeometryError),
        ({"points": [[np.nan, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]]}, GeometryError),
        ({"points": np.outer(np.arange(9.0), [1, 2, 3])}, GeometryError),
        ({"planes": [1.0, 0.0, 0.0, 2.0]}, GeometryError),
        ({"planes": [[1.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 2.0]]}, GeometryError),
    ],
    ids=lambda value: str(value)[:20],
)
def test_wrong_input_is_refused(scan, wrong, error):
    with pytest.raises(error):
        mirror_complete(**{"points": scan, "planes": PLANE, **wrong})


def test_one_plane_after_the_other_must_reach_the_cloud_completed_so_far():
    """A wedge of 40 degrees and a plane beside it, which passes through the doubled wedge."""
    points = sphere()
    turn = np.degrees(np.arctan2(points[:, 1], points[:, 0]))
    wedge = points[(turn > 5.0) & (turn < 45.0) & (np.abs(points[:, 2]) < 0.8)]
    first, second = (np.array([-np.sin(a), np.cos(a), 0, 0]) for a in np.radians([45.0, 75.0]))
    both = mirror_complete(wedge, [first, second], blend=0.0)
    reach = np.degrees(np.arctan2(both.points[:, 1], both.points[:, 0])).max()
    assert reach == pytest.approx(145.0, abs=2.0)  # 5 .. 85 across 75 degrees
    assert np.abs(np.linalg.norm(both.points, axis=1) - 1).max() < 1e-12
    with pytest.raises(GeometryError, match=r"got plane 0 at 0\.1"):
        mirror_complete(wedge, [second, first])


def test_points_that_coincide_count_once(scan):
    found = mirror_complete(scan, PLANE, blend=0.0)
    rng = np.random.default_rng(0)
    copies = rng.permutation(np.repeat(np.arange(len(scan)), rng.integers(1, 20, len(scan))))
    again = mirror_complete(scan[copies], PLANE, blend=0.0)
    assert again.scattered == found.scattered == 0
    assert again.mirrored.sum() == pytest.approx(found.mirrored.sum(), rel=0.02)
    apart = cKDTree(found.points[found.mirrored]).query(again.points[again.mirrored])[0]
    assert (apart < 1e-9).mean() > 0.95


def test_nearly_all_points_may_coincide():
    points = np.vstack([np.zeros((2_000, 3)), np.eye(3), [[1.0, 2.0, 3.0]]])
    found = mirror_complete(points, PLANE)
    assert np.array_equal(found.points[: len(points)], points)
    with pytest.raises(GeometryError, match="must pass through the scan"):
        mirror_complete(points, [1.0, 0.0, 0.0, 0.5])


def test_scatter_is_counted(scan):
    far = np.array([[-3.0, 0.0, 0.0], [-3.0, 2.0, 1.0], [-3.0, 2.0, 1.0]])
    assert mirror_complete(np.vstack([scan, far]), PLANE, blend=0.0).scattered == 2


@pytest.mark.parametrize("blend", [0.0, 0.25])
def test_completion_follows_motion_and_order(statue, blend):
    found = mirror_complete(statue, PLANE, blend=blend)
    spacing = np.median(cKDTree(statue).query(statue, k=2)[0][:, 1])
    matrix = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    order, place = np.random.default_rng(2).permutation(len(statue)), np.array([50.0, -7.0, 9.0])
    normal = matrix @ PLANE[:3]
    moved = mirror_complete(
        statue[order] @ matrix.T + place, np.append(normal, -normal @ place), blend=blend
    )
    back = (moved.points - place) @ matrix
    one, other = found.points[found.mirrored], back[moved.mirrored]
    assert len(one) > 300
    for some, others in ((one, other), (other, one)):
        assert (cKDTree(some).query(others)[0] > 1e-3 * spacing).mean() < 0.005


def test_far_from_the_origin_the_same_is_filled(scan):
    place = np.array([1e6, -2e6, 3e6])
    found = mirror_complete(scan, PLANE, blend=0.0)
    far = mirror_complete(scan + place, [1.0, 0.0, 0.0, -place[0]], blend=0.0)
    assert np.array_equal(np.sort(far.source), np.sort(found.source))


def test_attributes_may_hold_what_is_no_number(scan):
    colours, quality = np.full((len(scan), 4), np.nan), np.full(len(scan), np.nan)
    found = mirror_complete(scan, PLANE, colours=colours, quality=quality, blend=0.0)
    assert np.isfinite(found.points).all()
    assert np.isnan(found.colours).all()
    assert np.isnan(found.quality).all()


def test_only_allowed_points_are_mirrored(scan):
    allowed = scan[:, 1] > 0.0
    found = mirror_complete(scan, PLANE, source=allowed, blend=0.0)
    assert found.mirrored.any()
    assert allowed[found.source[found.mirrored]].all()
    assert not mirror_complete(scan, PLANE, source=np.zeros(len(scan))).mirrored.any()


KINDS = ["normal", "half sphere", "lattice", "sheet", "copies", "lonely", "clutter", "scales"]


def small_cloud(kind, count, rng):
    cloud = rng.normal(size=(count, 3))
    directions = cloud / np.linalg.norm(cloud, axis=1, keepdims=True)
    half = directions * [-1, 1, 1] * np.sign(directions[:, :1])
    return {
        "normal": cloud,
        "half sphere": half,
        "lattice": rng.integers(0, 4, (count, 3)).astype(float),
        "sheet": cloud * [1, 1, 1e-5],
        "copies": np.vstack([np.repeat(cloud[:5], 20, axis=0), cloud[:4]]),
        "lonely": np.vstack([np.zeros((count, 3)), cloud[:4]]),
        "clutter": np.vstack([half, rng.uniform(-1.5, 1.5, (count, 3))]),
        "scales": cloud * 10.0 ** rng.uniform(-9, 2, (count, 1)),
    }[kind]


@pytest.mark.parametrize("kind", KINDS)
def test_any_small_cloud_is_completed_or_refused(kind):
    """Finite, measured points first, images of them across planes in any place; no warnings."""
    for seed in range(6):
        rng = np.random.default_rng(seed)
        points = small_cloud(kind, int(rng.integers(5, 300)), rng)
        points = points * 10.0 ** rng.choice([-20, -6, 0, 6, 20])
        planes = rng.normal(size=(rng.integers(1, 4), 4))
        planes[:, 3] = -planes[:, :3] @ points[rng.integers(len(points))]
        planes[-1, :3] = planes[0, :3] + 0.01 * planes[-1, :3]  # nearly the same
        planes[-1, 3] = -planes[-1, :3] @ points.mean(axis=0)
        normals = rng.normal(size=points.shape) if seed % 2 else None
        try:
            found = mirror_complete(points, planes, normals, blend=rng.choice([0.0, 0.25]))
        except GeometryError:
            assert kind in ("lattice", "sheet", "scales", "copies", "lonely")  # flat, or missed
            continue
        assert np.array_equal(found.points[: len(points)], points)
        assert np.isfinite(found.points).all()
        assert np.isfinite(found.open_rims).all()
        assert len(found.points) <= len(points) * 2 ** len(planes)
        assert (found.source < len(points)).all()


@pytest.mark.parametrize("size", [1e-200, 1e50])
def test_the_length_of_normals_does_not_matter(scan, size):
    found = mirror_complete(scan, PLANE, scan, blend=0.0)
    again = mirror_complete(scan, PLANE, size * scan, blend=0.0)
    assert np.array_equal(again.source, found.source)
    np.testing.assert_allclose(again.normals / size, found.normals, atol=1e-12)


def test_the_least_blend_moves_nothing_far(statue):
    least = mirror_complete(statue, PLANE, blend=1e-320)
    assert np.isfinite(least.points).all()
    assert least.mirrored.sum() > 300


@pytest.mark.parametrize("kind", ["zero", "random"])
def test_normals_that_contradict_each_other_count_as_none(scan, kind):
    signs = np.random.default_rng(4).choice([-1.0, 1.0], (len(scan), 1))
    normals = scan * (0.0 if kind == "zero" else signs)
    found = mirror_complete(scan, PLANE, normals)
    bare = mirror_complete(scan, PLANE)
    assert np.array_equal(found.points, bare.points)
    assert np.array_equal(found.source, bare.source)
    assert len(found.normals) == len(found.points)


def test_a_limb_beside_the_plane_does_not_pair_with_its_own_image():
    """Two legs under a body; most of one is missing, and the other one's image lies near it."""
    rng = np.random.default_rng(6)
    body = sphere(6_000) * [0.6, 0.35, 0.35]
    turn, height = rng.uniform(0.0, 2.0 * np.pi, 3_000), rng.uniform(-1.5, -0.3, 3_000)
    leg = np.stack([0.16 + 0.11 * np.cos(turn), 0.11 * np.sin(turn), height], axis=1)
    whole = np.vstack([body, leg, leg * [-1.0, 1.0, 1.0]])
    missing = (whole[:, 0] > 0.0) & (whole[:, 2] < -0.6)
    found = mirror_complete(whole[~missing], PLANE)
    plain = mirror_complete(whole[~missing], PLANE, blend=0.0)
    off = cKDTree(found.points).query(whole[missing])[0]
    assert np.quantile(off, 0.99) < 1.5 * np.quantile(
        cKDTree(plain.points).query(whole[missing])[0], 0.99
    )
    assert np.abs(found.mirrored.sum() / missing.sum() - 1.0) < 0.15
