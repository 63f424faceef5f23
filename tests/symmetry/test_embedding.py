import numpy as np
import pytest

from meshlab_symrecon.geometry.planes import reflect
from meshlab_symrecon.symmetry.embedding import embed_planes


@pytest.fixture
def cloud():
    points = np.random.default_rng(0).normal(size=(400, 3)) @ [[3, 0, 0], [1, 1, 0], [0, 0.2, 0.5]]
    return points - points.mean(axis=0)


def root_of_covariance(cloud):
    variances, axes = np.linalg.eigh(np.cov(cloud.T, bias=True))
    return (axes * np.sqrt(variances)) @ axes.T


def random_planes(count):
    planes = np.random.default_rng(1).normal(size=(count, 4))
    return planes / np.linalg.norm(planes[:, :3], axis=1, keepdims=True)


def test_distance_is_the_rms_distance_of_the_mirror_images(cloud):
    planes = random_planes(20)
    places = embed_planes(planes, root_of_covariance(cloud))
    for i in range(20):
        for j in range(i):
            images = reflect(cloud, planes[i]) - reflect(cloud, planes[j])
            rms = np.sqrt((images**2).sum(axis=1).mean())
            assert np.linalg.norm(places[i] - places[j]) == pytest.approx(rms, rel=1e-12)


def test_both_ways_to_write_a_plane_have_one_place(cloud):
    planes, root = random_planes(20), root_of_covariance(cloud)
    assert np.array_equal(embed_planes(planes, root), embed_planes(-planes, root))
