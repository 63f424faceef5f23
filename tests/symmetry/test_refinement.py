import numpy as np
import pytest
from scipy.spatial import cKDTree

from meshlab_symrecon.geometry.planes import reflect, reflect_directions
from meshlab_symrecon.symmetry.refinement import Schedule, refine_planes


def symmetric_cloud(seed=0):
    """Samples of a bumpy ellipsoid with normals, each with its exact mirror partner."""
    rng = np.random.default_rng(seed)
    normal = rng.normal(size=3)
    plane = np.append(normal / np.linalg.norm(normal), 0.03)
    directions = rng.normal(size=(1_500, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    shape = np.array([0.5, 0.35, 0.25])
    points = directions * shape
    normals = directions / shape
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    points = np.vstack([points, reflect(points, plane)])
    return points, np.vstack([normals, reflect_directions(normals, plane)]), plane


@pytest.mark.parametrize("seed", range(4))
def test_a_perturbed_plane_of_an_exactly_symmetric_cloud_is_recovered(seed):
    points, normals, plane = symmetric_cloud(seed)
    rng = np.random.default_rng(seed)
    starts = np.repeat(plane[np.newaxis], 5, axis=0)
    starts[:, :3] += rng.normal(0, 0.02, size=(5, 3))
    starts[:, 3] += rng.normal(0, 0.005, size=5)
    starts /= np.linalg.norm(starts[:, :3], axis=1, keepdims=True)
    tree = cKDTree(points)
    found = refine_planes(
        starts,
        (points, normals),
        (points, normals),
        lambda places: tree.query(places)[1],
        Schedule(40, 0.04, 0.003),
    )
    assert np.abs(starts - plane).max() > 1e-3
    assert np.abs(found - plane).max() < 1e-6


def test_a_plane_without_partners_stays():
    points, normals, _ = symmetric_cloud()
    far = np.array([[1.0, 0.0, 0.0, -50.0]])
    tree = cKDTree(points)
    found = refine_planes(
        far, (points, normals), (points, normals), lambda x: tree.query(x)[1], Schedule(5, 0.04, 0.01)
    )
    assert np.array_equal(found, far)


def test_tolerances_shrink_geometrically_and_then_stay():
    schedule = Schedule(10, 0.04, 0.01)
    values = [float(schedule.tolerances(step)) for step in range(10)]
    assert values[0] == 0.04
    assert values[3] == pytest.approx(0.02)
    assert values[6:] == pytest.approx([0.01] * 4)
