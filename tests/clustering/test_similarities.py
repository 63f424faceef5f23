import numpy as np
import pytest

from meshlab_symrecon.clustering.similarities import all_similarities, similarity_quantile


def test_similarities_keep_their_digits_far_from_the_origin():
    rows = np.random.default_rng(0).random((40, 3))
    near = all_similarities(rows, np.full(40, -1.0))
    far = all_similarities((rows * 2.0**30).round() + 2.0**50, np.full(40, -1.0)) / 2.0**60
    assert np.array_equal(np.diagonal(near), np.full(40, -1.0))
    off = ~np.eye(40, dtype=bool)
    assert np.allclose(near[off], far[off], rtol=1e-6)


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 1.0])
def test_a_quantile_is_that_of_all_pairs(share):
    rows = np.random.default_rng(1).random((300, 3))
    differences = rows[:, np.newaxis] - rows
    squares = (differences**2).sum(axis=2)[~np.eye(300, dtype=bool)]
    found = similarity_quantile(rows, share, np.random.RandomState(0))
    assert found == pytest.approx(np.quantile(-squares, share), rel=1e-5)


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_a_quantile_of_many_rows_is_that_of_random_pairs(share):
    """Differences of two uniform numbers: P(d^2 <= t^2) = 2 t - t^2."""
    rows = np.random.default_rng(2).permutation(np.linspace(0.0, 1.0, 5000))[:, np.newaxis]
    found = similarity_quantile(rows, share, np.random.RandomState(0))
    distance = np.sqrt(-found)
    assert 2 * distance - distance**2 == pytest.approx(1 - share, abs=2e-3)
    assert found == similarity_quantile(rows, share, np.random.RandomState(0))


def test_a_row_is_never_paired_with_itself():
    rows = np.arange(2500.0)[:, np.newaxis]
    assert similarity_quantile(rows, 1.0, np.random.RandomState(0)) == -1.0
