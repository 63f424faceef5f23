import numpy as np
import pytest
from symmetry import numpy_loops

from meshlab_symrecon import _native
from meshlab_symrecon.geometry.planes import reflect
from meshlab_symrecon.symmetry.candidates import pair_planes, vote
from meshlab_symrecon.symmetry.preparation import prepare


def test_the_plane_of_a_pair_maps_one_point_onto_the_other():
    first, second = np.random.default_rng(0).normal(size=(2, 50, 3))
    planes = pair_planes(first, second)
    assert np.allclose(np.linalg.norm(planes[:, :3], axis=1), 1.0)
    for plane, p, q in zip(planes, first, second, strict=True):
        assert np.allclose(reflect(p[np.newaxis], plane)[0], q, atol=1e-13)


def test_votes_crowd_around_the_true_plane(statue):
    cloud = prepare(statue, None, 1_000)
    candidates = vote(cloud, 1_000, 16_000, np.random.default_rng(0))
    true = cloud.from_input(np.array([[1.0, 0.0, 0.0, 0.0]]))[0]
    cosines = candidates.planes[:, :3] @ true[:3]
    close = (np.abs(cosines) > np.cos(np.radians(5.0))) & (
        np.abs(np.sign(cosines) * candidates.planes[:, 3] - true[3]) < 0.02
    )
    # A ball of 5 degrees is 0.4 % of all directions, the offsets 4 % of their range.
    assert close.mean() > 20 * 0.004 * 0.04


def test_the_limit_of_candidates_is_kept_and_reproducible(statue):
    cloud = prepare(statue, None, 600)
    one = vote(cloud, 600, 500, np.random.default_rng(5))
    other = vote(cloud, 600, 500, np.random.default_rng(5))
    assert len(one.planes) == 500
    assert np.array_equal(one.planes, other.planes)


@pytest.mark.parametrize("count", [2, 50, 700])
def test_pairs_are_as_in_the_sums_of_numpy(count):
    rng = np.random.default_rng(count)
    points, normals = rng.normal(size=(2, count, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    oriented = rng.random(count) < 0.7
    found = _native.mirror_pairs(points, normals, oriented.view(np.uint8), 0.9, 0.8)
    expected = numpy_loops.voting_pairs(points, normals, oriented, 0.9, 0.8)
    assert np.array_equal(found, expected)
    assert count < 50 or 0.01 < len(found) / (count * (count - 1) / 2) < 0.3


def test_an_exact_mirror_pair_votes_and_one_with_a_turned_normal_does_not():
    points = np.array([[1.0, 0.3, 0.0], [-1.0, 0.3, 0.0]])
    normals = np.array([[0.6, 0.0, 0.8], [-0.6, 0.0, 0.8]])
    known, unknown = np.ones(2, dtype=np.uint8), np.array([1, 0], dtype=np.uint8)
    turned = normals * [[1.0], [-1.0]]
    assert _native.mirror_pairs(points, normals, known, 1.9, 0.999).tolist() == [[0, 1]]
    assert _native.mirror_pairs(points, normals, known, 2.0, 0.999).shape == (0, 2)
    assert _native.mirror_pairs(points, turned, known, 1.9, 0.999).shape == (0, 2)
    assert _native.mirror_pairs(points, turned, unknown, 1.9, 0.999).tolist() == [[0, 1]]


def test_points_without_normals_are_refused():
    points, known = np.zeros((4, 3)), np.ones(4, dtype=np.uint8)
    with pytest.raises(ValueError, match="one entry a point"):
        _native.mirror_pairs(points, points[:3], known, 0.1, 0.9)
    with pytest.raises(ValueError, match="one entry a point"):
        _native.mirror_pairs(points, points, known[:3], 0.1, 0.9)
