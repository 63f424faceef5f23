import warnings

import numpy as np
import pytest
from sklearn.cluster import AffinityPropagation as Reference
from sklearn.exceptions import ConvergenceWarning
from sklearn.utils.estimator_checks import check_estimator

from meshlab_symrecon.clustering.affinity_propagation import DENSE_LIMIT, AffinityPropagation
from meshlab_symrecon.errors import ParameterError

BOTH_FORMS = pytest.mark.parametrize("n_neighbors", [None, 12])


@BOTH_FORMS
def test_estimator_follows_the_conventions_of_scikit_learn(n_neighbors):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        check_estimator(AffinityPropagation(n_neighbors=n_neighbors))


@pytest.mark.parametrize("damping", [0.7, 0.9])
@pytest.mark.parametrize("n_neighbors", [None, 55])
def test_three_tight_clusters(damping, n_neighbors):
    rng = np.random.default_rng(0)
    centres = np.eye(4)[:3] * 10
    rows = (centres[:, np.newaxis] + rng.normal(0, 0.05, size=(3, 40, 4))).reshape(-1, 4)
    found = AffinityPropagation(
        damping=damping, n_neighbors=n_neighbors, preference=-20.0, max_iter=1000
    ).fit(rows)
    assert found.converged_
    assert len(found.cluster_centers_indices_) == 3
    for cluster in found.labels_.reshape(3, 40):
        assert len(set(cluster)) == 1


@pytest.mark.parametrize("seed", range(4))
def test_exemplars_are_those_of_scikit_learn(seed):
    rows = np.random.default_rng(seed).normal(size=(150, 2))
    settings = {"damping": 0.8, "max_iter": 1000, "preference": -3.0}
    reference = Reference(**settings, random_state=0).fit(rows)
    assert reference.n_iter_ < 1000
    dense = AffinityPropagation(**settings).fit(rows)
    sparse = AffinityPropagation(**settings, n_neighbors=149).fit(rows)
    for found in (dense, sparse):
        assert np.array_equal(found.cluster_centers_indices_, reference.cluster_centers_indices_)
        assert np.array_equal(found.labels_, reference.labels_)


def net_similarity(rows, found, preference):
    distances = ((rows - found.cluster_centers_[found.labels_]) ** 2).sum()
    return -distances + preference * len(found.cluster_centers_indices_)


def test_sparse_form_is_as_good_as_the_dense_one():
    rows = np.random.default_rng(2).random((600, 3))
    dense = AffinityPropagation(preference=-0.1).fit(rows)
    sparse = AffinityPropagation(preference=-0.1, n_neighbors=64).fit(rows)
    assert dense.converged_
    assert sparse.converged_
    best = net_similarity(rows, dense, -0.1)
    assert net_similarity(rows, sparse, -0.1) >= 1.02 * best


@BOTH_FORMS
def test_stopping_early_warns_and_labels_stay_valid(n_neighbors):
    rows = np.random.default_rng(3).normal(size=(100, 3))
    estimator = AffinityPropagation(max_iter=2, n_neighbors=n_neighbors)
    with pytest.warns(ConvergenceWarning, match="not converged after 2 iterations"):
        estimator.fit(rows)
    assert not estimator.converged_
    assert len(estimator.cluster_centers_indices_) >= 1
    assert set(estimator.labels_) <= set(range(len(estimator.cluster_centers_indices_)))


def test_a_higher_preference_gives_more_exemplars_where_it_is_higher():
    rows = np.random.default_rng(4).random((400, 2))
    left = rows[:, 0] < 0.5
    preference = np.where(left, -0.002, -0.2)
    found = AffinityPropagation(preference=preference, n_neighbors=40, max_iter=500).fit(rows)
    chosen = left[found.cluster_centers_indices_]
    assert np.count_nonzero(chosen) > 3 * np.count_nonzero(~chosen)


def test_quantiles_order_the_number_of_exemplars():
    rows = np.random.default_rng(5).normal(size=(200, 2))
    counts = [
        len(AffinityPropagation(quantile=q, max_iter=1000).fit(rows).cluster_centers_indices_)
        for q in (0.05, 0.5, 0.95)
    ]
    assert counts[0] < counts[1] < counts[2]


def test_predict_returns_the_nearest_exemplar():
    rows = np.random.default_rng(6).normal(size=(120, 3))
    found = AffinityPropagation(n_neighbors=20).fit(rows)
    assert np.array_equal(
        found.predict(found.cluster_centers_), np.arange(len(found.cluster_centers_))
    )


@pytest.mark.parametrize(
    "wrong",
    [
        {"damping": 0.4},
        {"damping": 1.0},
        {"damping": float("nan")},
        {"max_iter": 0},
        {"max_iter": 2.5},
        {"convergence_iter": 0},
        {"n_neighbors": 0},
        {"quantile": 1.5},
        {"preference": [1.0, 2.0]},
        {"preference": float("inf")},
    ],
    ids=str,
)
def test_parameters_out_of_range_are_refused(wrong):
    rows = np.random.default_rng(7).normal(size=(10, 2))
    with pytest.raises(ParameterError, match=f"{next(iter(wrong))} must"):
        AffinityPropagation(**wrong).fit(rows)


def test_the_dense_form_refuses_more_rows_than_memory_allows():
    with pytest.raises(ParameterError, match=f"limited to {DENSE_LIMIT} rows"):
        AffinityPropagation().fit(np.zeros((DENSE_LIMIT + 1, 2)))
