import numpy as np
import pytest
from scipy.spatial import cKDTree
from symmetry.bodies import ellipsoid, even_sphere

from meshlab_symrecon.symmetry.cleaning import DENSE_COUNT, without_clutter, without_plinth


def test_clutter_in_the_air_goes_and_the_statue_stays():
    rng = np.random.default_rng(0)
    statue = ellipsoid(5_000, [0.5, 0.35, 0.3])
    air = rng.uniform(-0.9, 0.9, (150, 3))
    air = air[cKDTree(statue).query(air)[0] > 0.1]
    kept, _ = without_clutter(np.vstack([statue, air]), None)
    rows = {row.tobytes() for row in kept}
    assert not rows & {row.tobytes() for row in air}
    assert len(rows & {row.tobytes() for row in statue}) > 0.98 * len(statue)
    assert len(kept) == len(rows)


def test_normals_go_with_their_points():
    directions = even_sphere(3_000)
    scattered = np.vstack([0.3 * directions, [[0.9, 0.9, 0.9]]])
    sides = np.vstack([directions, [[0.0, 0.0, 1.0]]])
    points, normals = without_clutter(scattered, sides)
    assert len(points) == 3_000
    assert np.array_equal(points, 0.3 * normals)


@pytest.mark.parametrize("sides", [None, "outwards"])
def test_large_clouds_are_thinned_to_means(sides):
    directions = even_sphere(150_000)
    points, normals = without_clutter(directions, None if sides is None else directions)
    assert 0.7 * DENSE_COUNT < len(points) <= 1.1 * DENSE_COUNT
    lengths = np.linalg.norm(points, axis=1)
    assert (np.abs(lengths - 1.0) < 1e-3).all()
    assert normals is None or np.allclose(normals, points)


def test_a_plinth_goes_with_its_normals():
    rng = np.random.default_rng(1)
    statue = ellipsoid(6_000, [0.3, 0.25, 0.5])
    statue[:, 2] += 0.5
    plinth = rng.uniform(-1, 1, (4_000, 3))
    faces = rng.choice(3, 4_000, p=[0.15, 0.15, 0.7])
    plinth[np.arange(4_000), faces] = np.sign(plinth[np.arange(4_000), faces])
    plinth = plinth * [0.45, 0.45, 0.06] - [0.0, 0.0, 0.065]
    cloud = np.vstack([statue, plinth])
    points, normals = without_plinth(cloud, cloud.copy())
    assert (points[:, 2] > 0.0).mean() > 0.999
    assert len(points) > 0.9 * len(statue)
    assert np.array_equal(points, normals)
