import numpy as np

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
    true = np.array([1.0, 0.0, 0.0, cloud.centre[0] / cloud.scale])
    signs = np.sign(candidates.planes[:, 0])
    close = (np.abs(candidates.planes[:, 0]) > np.cos(np.radians(5.0))) & (
        np.abs(signs * candidates.planes[:, 3] - true[3]) < 0.02
    )
    # A ball of 5 degrees is 0.4 % of all directions, the offsets 4 % of their range.
    assert close.mean() > 20 * 0.004 * 0.04


def test_the_limit_of_candidates_is_kept_and_reproducible(statue):
    cloud = prepare(statue, None, 600)
    one = vote(cloud, 600, 500, np.random.default_rng(5))
    other = vote(cloud, 600, 500, np.random.default_rng(5))
    assert len(one.planes) == 500
    assert np.array_equal(one.planes, other.planes)
