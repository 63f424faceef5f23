import numpy as np
import pytest
from scipy.spatial.distance import cdist

from meshlab_symrecon.clustering.assignment import best_members, nearest_exemplars


@pytest.mark.parametrize("seed", range(5))
def test_elected_members_have_the_largest_sum_of_similarities(seed):
    rng = np.random.default_rng(seed)
    rows, preferences = rng.normal(size=(90, 3)), -rng.random(90)
    exemplars = np.sort(rng.choice(90, 6, replace=False))
    distances = cdist(rows, rows, "sqeuclidean")
    labels = np.argmin(distances[:, exemplars], axis=1)
    similarities = -distances
    np.fill_diagonal(similarities, preferences)
    expected = []
    for cluster in range(6):
        members = np.flatnonzero(labels == cluster)
        sums = similarities[np.ix_(members, members)].sum(axis=0)
        expected.append(members[np.argmax(sums)])
    assert np.array_equal(best_members(rows, preferences, exemplars), np.sort(expected))


def test_exemplars_in_one_place_keep_a_cluster_each():
    rows = np.zeros((5, 2))
    exemplars = np.array([1, 3])
    found = best_members(rows, np.zeros(5), exemplars)
    assert len(found) == len(set(found)) == 2


def test_the_nearest_exemplar_is_the_nearest_of_all():
    rng = np.random.default_rng(6)
    rows, centres = rng.random((100, 9)), rng.random((12, 9))
    expected = np.argmin(cdist(rows, centres), axis=1)
    assert np.array_equal(nearest_exemplars(rows, centres), expected)
