import numpy as np
import pytest
import shapes
from scipy.spatial import cKDTree

from meshlab_symrecon.errors import GeometryError
from meshlab_symrecon.geometry.surfaces import enclosed_volume, topology
from meshlab_symrecon.powercrust import Recipe, reconstruct


def assert_solid(crust, components=1, genus=0):
    shape = crust.topology
    assert shape.closed
    assert shape.edge_manifold
    assert shape.vertex_manifold
    assert shape.oriented
    assert (shape.components, shape.genus) == (components, genus)
    assert enclosed_volume(crust.points, crust.faces) > 0
    assert len(np.unique(crust.faces)) == len(crust.points)


def noisy_sphere(count, noise, seed):
    rng = np.random.default_rng(seed)
    return shapes.fibonacci_sphere(count) * (1 + noise * rng.normal(size=(count, 1)))


def test_volume_of_a_sphere_converges_at_second_order():
    errors = []
    for count in (500, 2000, 8000):
        crust = reconstruct(shapes.fibonacci_sphere(count))
        assert_solid(crust)
        errors.append(abs(enclosed_volume(crust.points, crust.faces) * 0.75 / np.pi - 1))
    # the spacing halves from step to step, so the error falls fourfold
    assert errors[1] < errors[0] / 3
    assert errors[2] < errors[1] / 3


def test_a_torus_has_a_handle_and_its_volume():
    crust = reconstruct(shapes.torus(6000, seed=3))
    assert_solid(crust, genus=1)
    assert enclosed_volume(crust.points, crust.faces) == pytest.approx(
        2 * np.pi**2 * 0.4**2, rel=0.01
    )


@pytest.mark.parametrize("steps", [3, 8, 15])
def test_a_lattice_box_keeps_its_walls(steps):
    crust = reconstruct(shapes.box_lattice(steps))
    assert_solid(crust)
    assert crust.points.min() == pytest.approx(0.0, abs=1e-12 * steps)
    assert crust.points.max() == pytest.approx(steps, rel=1e-12)
    assert enclosed_volume(crust.points, crust.faces) > 0.93 * steps**3


def test_every_vertex_lies_near_the_samples():
    samples = shapes.torus(4000, seed=8)
    crust = reconstruct(samples)
    spacing = np.median(cKDTree(samples).query(samples, k=2)[0][:, 1])
    assert cKDTree(samples).query(crust.points)[0].max() < 8 * spacing


@pytest.mark.parametrize("seed", range(4))
def test_no_two_vertices_coincide(seed):
    """Readers that join equal vertices must not pinch the surface."""
    crust = reconstruct(shapes.statue(3000, seed=seed))
    assert len(np.unique(crust.points.astype(np.float32), axis=0)) == len(crust.points)
    a, b, c = (crust.points[crust.faces[:, k]] for k in range(3))
    assert np.linalg.norm(np.cross(b - a, c - a), axis=1).min() > 0.0


def test_two_bodies_stay_two():
    ball = noisy_sphere(600, 1e-3, 1)
    assert_solid(reconstruct(np.vstack([ball, ball + 3])), components=2)


def test_duplicates_change_nothing():
    ball = noisy_sphere(600, 1e-3, 2)
    assert_same_bytes(reconstruct(ball), reconstruct(np.vstack([ball, ball[::3], ball[::7]])))


def assert_same_bytes(one, other):
    assert one.points.tobytes() == other.points.tobytes()
    assert one.faces.tobytes() == other.faces.tobytes()


@pytest.mark.parametrize("motion", shapes.MOTIONS, ids=lambda motion: motion.name)
def test_it_follows_motions(motion):
    samples = noisy_sphere(800, 0.01, 4) * [1.0, 2.0, 0.7]
    at_rest, moved = reconstruct(samples), reconstruct(motion(samples))
    assert_solid(moved)
    back = cKDTree(motion.back(moved.points))
    # rounding decides which of the eight-fold power vertices at a sample are joined to it
    spacing = np.median(cKDTree(samples).query(samples, k=2)[0][:, 1])
    gap = back.query(at_rest.points)[0]
    assert np.mean(gap > 1e-6 * spacing) < 0.05
    assert gap.max() < 0.25 * spacing
    assert enclosed_volume(moved.points, moved.faces) / motion.scale**3 == pytest.approx(
        enclosed_volume(at_rest.points, at_rest.faces), rel=1e-4
    )


def test_the_order_of_the_samples_does_not_matter():
    samples = noisy_sphere(800, 0.01, 5)
    shuffled = samples[np.random.default_rng(0).permutation(len(samples))]
    assert_same_bytes(reconstruct(samples), reconstruct(shuffled))


def test_same_input_same_bytes_and_input_untouched():
    samples = noisy_sphere(500, 0.01, 6)
    kept = samples.copy()
    assert_same_bytes(reconstruct(samples), reconstruct(samples))
    assert np.array_equal(samples, kept)


def test_noise_and_outliers_neither_open_nor_split_it():
    rng = np.random.default_rng(7)
    samples = noisy_sphere(4000, 0.005, 7)
    outliers = rng.uniform(-1.5, 1.5, (40, 3))
    crust = reconstruct(np.vstack([samples, outliers]))
    assert_solid(crust)
    assert enclosed_volume(crust.points, crust.faces) == pytest.approx(4 * np.pi / 3, rel=0.01)


def test_a_hole_is_capped():
    ball = noisy_sphere(3000, 1e-3, 8)
    crust = reconstruct(ball[ball[:, 2] < 0.7])
    assert_solid(crust)
    above = np.pi * 0.3**2 * (3 - 0.3) / 3  # volume of the ball above z = 0.7
    assert enclosed_volume(crust.points, crust.faces) == pytest.approx(
        4 * np.pi / 3 - above, rel=0.01
    )
    assert crust.points[:, 2].max() < 0.75


def bar(rng):
    """Samples of the box [-3, 3] x [-1, 1] x [-1, 1]."""
    points = rng.uniform(-1, 1, (6000, 3))
    axis = rng.integers(0, 3, 6000)
    points[np.arange(6000), axis] = np.sign(points[np.arange(6000), axis])
    return points * [3.0, 1.0, 1.0]


@pytest.mark.parametrize(
    ("kept", "volume"),
    [
        (lambda p: p[:, 0] < 1.0, 16.0),
        (lambda p: ~((p[:, 1] == 1.0) & (np.abs(p[:, 0]) < 2.0)), 24.0),
        (lambda p: ~((p[:, 1] == 1.0) & (p[:, 0] > -2.5)), 24.0),
    ],
    ids=["end broken off", "window", "side gone"],
)
def test_a_wide_hole_does_not_swallow_the_body(kept, volume):
    """A cut straight across the hole must not be cheaper than the surface behind it."""
    samples = bar(np.random.default_rng(12))
    crust = reconstruct(samples[kept(samples)])
    assert_solid(crust)
    assert enclosed_volume(crust.points, crust.faces) == pytest.approx(volume, rel=0.1)


def test_a_third_of_a_body_may_be_missing():
    """Whether the wide cap has a handle near its rim is a toss-up for one body in four."""
    genera = []
    for seed in range(6):
        whole = shapes.statue(4000, seed=seed, missing=0.0)
        towards = np.array([1.0, 0.35, 0.2])
        limit = np.quantile(whole @ towards, 0.65)
        crust = reconstruct(whole[whole @ towards < limit])
        genera.append(crust.topology.genus)
        assert_solid(crust, genus=genera[-1])
        share = enclosed_volume(crust.points, crust.faces)
        share /= enclosed_volume(*(lambda c: (c.points, c.faces))(reconstruct(whole)))
        assert 0.4 < share < 0.8
    assert genera.count(0) >= 4
    assert max(genera) <= 1


def test_the_medial_axis_of_a_sphere_is_its_centre():
    crust = reconstruct(noisy_sphere(2000, 1e-9, 9))
    deep = crust.axis.radii > 0.5
    assert deep.any()
    assert np.abs(crust.axis.points[deep]).max() < 1e-3
    np.testing.assert_allclose(crust.axis.radii[deep], 1.0, atol=1e-3)


@pytest.mark.parametrize(
    "samples",
    [
        np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]]),
        shapes.box_lattice(1),
        np.random.default_rng(3).random((6, 3)),
        np.random.default_rng(4).random((300, 3)),
        np.vstack([shapes.fibonacci_sphere(200), 1e6 + shapes.fibonacci_sphere(200)]),
    ],
    ids=["five", "cube", "six", "filled", "far apart"],
)
def test_hard_input_still_gives_a_closed_manifold(samples):
    crust = reconstruct(samples)
    shape = crust.topology
    assert shape.closed
    assert shape.vertex_manifold
    assert shape.oriented
    assert enclosed_volume(crust.points, crust.faces) > 0


def test_few_points_give_their_hull_and_say_so():
    crust = reconstruct(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0.1, 0.1, 0.1]]))
    assert crust.hull
    assert enclosed_volume(crust.points, crust.faces) == pytest.approx(1 / 6)
    assert topology(crust.faces).euler == 2


@pytest.mark.parametrize(
    ("samples", "words"),
    [
        (np.zeros((0, 3)), "got 0 points"),
        (np.eye(3), "got 3 points"),
        (np.eye(3), "at least 4 points"),
        (np.ones((9, 3)), "9 points that all coincide"),
        (np.outer(np.arange(10.0), [1, 2, 3]), "10 points on one line"),
        (
            np.column_stack([np.random.default_rng(0).random((50, 2)), np.zeros(50)]),
            "50 points in one plane",
        ),
        (np.full((9, 3), np.nan), "finite"),
        (np.full((9, 3), np.inf), "finite"),
        (np.zeros((9, 2)), "shape"),
    ],
    ids=["none", "three", "fewest", "equal", "line", "plane", "nan", "infinite", "flat array"],
)
def test_what_has_no_inside_is_refused(samples, words):
    with pytest.raises(GeometryError, match=words):
        reconstruct(samples)


def test_progress_rises_to_one():
    told = []
    reconstruct(shapes.fibonacci_sphere(300), progress=lambda part, step: told.append(part))
    assert told == sorted(told)
    assert told[-1] == 1.0


@pytest.mark.parametrize("name", ["smallest_ball", "widest_cap", "axis_noise", "axis_redundancy"])
@pytest.mark.parametrize("length", [-1.0, np.nan, np.inf])
def test_a_recipe_refuses_lengths_that_are_none(name, length):
    with pytest.raises(GeometryError, match=f"{name} is a multiple of the spacing"):
        Recipe(**{name: length})


def test_a_recipe_refuses_unknown_words():
    with pytest.raises(GeometryError, match="a surface is 'power crust' or 'interpolating'"):
        Recipe(surface="poisson")
    with pytest.raises(GeometryError, match="poles are labelled by 'min cut' or 'propagation'"):
        reconstruct(shapes.fibonacci_sphere(100), Recipe(labelling="luck"))


@pytest.mark.parametrize("surface", ["power crust", "interpolating"])
@pytest.mark.parametrize("labelling", ["min cut", "propagation"])
def test_every_surface_and_labelling_gives_a_torus(surface, labelling):
    samples = shapes.torus(5000, seed=14)
    crust = reconstruct(samples, Recipe(surface=surface, labelling=labelling))
    assert_solid(crust, genus=1)
    assert enclosed_volume(crust.points, crust.faces) == pytest.approx(
        2 * np.pi**2 * 0.4**2, rel=0.01
    )
    distance = np.linalg.norm(crust.points - samples[crust.nearest], axis=1)
    assert np.mean(distance <= cKDTree(samples).query(crust.points)[0] + 1e-12) > 0.98
    if surface == "interpolating":
        assert np.array_equal(crust.points, samples[crust.nearest])
        assert len(crust.faces) == 2 * len(crust.points)  # chi = 0


def test_wide_caps_can_be_left_open():
    ball = noisy_sphere(6000, 1e-3, 15)
    ball = ball[(ball[:, 2] < 0.9) & (ball[:, 2] > -0.7)]  # holes 0.87 and 1.43 wide
    closed = reconstruct(ball)
    assert_solid(closed)
    spacing = np.sqrt(4 * np.pi / 6000)
    assert closed.largest_cap * spacing == pytest.approx(1.43, rel=0.3)
    one, both = (reconstruct(ball, Recipe(widest_cap=width / spacing)) for width in (1.1, 0.4))
    assert (closed.opened, one.opened, both.opened) == (0, 1, 2)
    for trimmed in (one, both):
        assert not trimmed.topology.closed
        assert trimmed.topology.edge_manifold
        assert trimmed.topology.vertex_manifold
    assert one.topology.euler == 1
    assert both.topology.euler == 0


def test_it_says_how_well_it_did():
    rng = np.random.default_rng(16)
    samples = shapes.torus(5000, seed=16)
    stray = rng.uniform(-1.5, 1.5, (50, 3))
    clean, dirty = reconstruct(samples), reconstruct(np.concatenate([samples, stray]))
    assert (clean.outliers, clean.dropped_poles, clean.opened) == (0, 0, 0)
    assert 30 < dirty.outliers <= 50
    kept = reconstruct(np.concatenate([samples, stray]), Recipe(keep_outliers=True))
    assert kept.outliers == 0
    noisy = reconstruct(samples + rng.normal(0.0, 0.05, samples.shape))
    assert noisy.dropped_poles > 0
    assert noisy.poles > noisy.dropped_poles
    assert set(clean.seconds) == {
        "triangulating the samples", "finding poles", "building the power diagram",
        "labelling poles", "extracting the surface", "extracting the medial axis", "measuring caps",
    }  # fmt: skip
    assert all(seconds >= 0.0 for seconds in clean.seconds.values())
