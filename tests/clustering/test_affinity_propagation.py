import numpy as np
import pytest
from sklearn.base import clone
from sklearn.cluster import AffinityPropagation as Reference
from sklearn.exceptions import ConvergenceWarning
from sklearn.utils.estimator_checks import parametrize_with_checks

from meshlab_symrecon.clustering.affinity_propagation import DENSE_LIMIT, AffinityPropagation
from meshlab_symrecon.errors import ParameterError

BOTH_FORMS = pytest.mark.parametrize("n_neighbors", [None, 12])


@pytest.mark.filterwarnings("ignore")  # the checks of scikit-learn give warnings of their own
@parametrize_with_checks(
    [
        AffinityPropagation(),
        AffinityPropagation(n_neighbors=5),
        AffinityPropagation(n_neighbors=None),
    ]
)
def test_estimator_follows_the_conventions_of_scikit_learn(estimator, check):
    check(estimator)


def clusters(count, dimensions, seed):
    rng = np.random.default_rng(seed)
    centres = 3 * rng.normal(size=(9, dimensions))
    return centres[rng.integers(9, size=count)] + 0.6 * rng.normal(size=(count, dimensions))


@BOTH_FORMS
@pytest.mark.parametrize("damping", [0.5, 0.7, 0.9])
@pytest.mark.parametrize("preference", [-20.0, None])
def test_three_tight_clusters(damping, n_neighbors, preference):
    rng = np.random.default_rng(0)
    centres = np.eye(4)[:3] * 10
    rows = (centres[:, np.newaxis] + rng.normal(0, 0.05, size=(3, 40, 4))).reshape(-1, 4)
    found = AffinityPropagation(
        damping=damping, n_neighbors=n_neighbors, preference=preference
    ).fit(rows)
    assert found.converged_
    assert found.exact_
    assert np.array_equal(found.labels_, np.repeat([0, 1, 2], 40))


@pytest.mark.parametrize("dimensions", [2, 3, 9])
@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
@pytest.mark.parametrize("kind", ["uniform", "clusters"])
def test_exemplars_are_those_of_scikit_learn(kind, share, dimensions):
    uniform = kind == "uniform"
    rng = np.random.default_rng(dimensions)
    rows = rng.random((250, dimensions)) if uniform else clusters(250, dimensions, dimensions)
    squares = ((rows[:, np.newaxis] - rows) ** 2).sum(axis=2)
    ties = 1 + 1e-6 * rng.random(250)  # of clusters of two, whose members are equally good
    preference = np.quantile(-squares, share) * ties
    settings = {"damping": 0.8, "max_iter": 1000, "preference": preference}
    reference = Reference(**settings, random_state=0).fit(rows)
    assert reference.n_iter_ < 1000
    dense = AffinityPropagation(**settings, n_neighbors=None).fit(rows)
    sparse = AffinityPropagation(**settings).fit(rows)
    assert sparse.exact_
    for found in (dense, sparse):
        assert found.converged_
        assert np.array_equal(found.cluster_centers_indices_, reference.cluster_centers_indices_)
        assert np.array_equal(found.labels_, reference.labels_)


def test_preferences_of_single_points_are_those_of_scikit_learn():
    rows = clusters(200, 2, 0)
    settings = {"damping": 0.8, "preference": -np.random.default_rng(1).uniform(0.5, 20, 200)}
    reference = Reference(**settings, random_state=0).fit(rows)
    found = AffinityPropagation(**settings).fit(rows)
    assert np.array_equal(found.cluster_centers_indices_, reference.cluster_centers_indices_)


@BOTH_FORMS
@pytest.mark.parametrize("iterations", [1, 2, 10])
def test_stopping_early_warns_and_labels_stay_valid(n_neighbors, iterations):
    rows = np.random.default_rng(3).normal(size=(100, 3))
    estimator = AffinityPropagation(max_iter=iterations, n_neighbors=n_neighbors)
    with pytest.warns(ConvergenceWarning, match=f"not converged after {iterations} iterations"):
        estimator.fit(rows)
    assert not estimator.converged_
    assert estimator.n_iter_ == iterations
    chosen = estimator.cluster_centers_indices_
    assert np.array_equal(estimator.labels_[chosen], np.arange(len(chosen)))
    assert set(estimator.labels_) == set(range(len(chosen)))


def test_labels_are_complete_where_the_graph_has_no_room_to_grow():
    rows = np.random.default_rng(4).random((600, 2))
    found = AffinityPropagation(preference=-30.0, n_neighbors=2).fit(rows)
    assert not found.exact_
    distances = np.linalg.norm(rows[:, np.newaxis] - found.cluster_centers_, axis=2)
    assert np.array_equal(found.labels_, np.argmin(distances, axis=1))


def test_the_graph_stays_sparse_where_clusters_are_small():
    rows = np.random.default_rng(5).random((3000, 2))
    found = AffinityPropagation(preference=-2e-3).fit(rows)
    assert found.converged_
    assert found.exact_
    assert found.n_edges_ < 36 * 3000


@BOTH_FORMS
def test_one_point_is_its_own_exemplar(n_neighbors):
    found = AffinityPropagation(n_neighbors=n_neighbors).fit([[1.0, 2.0]])
    assert np.array_equal(found.cluster_centers_indices_, [0])
    assert np.array_equal(found.labels_, [0])
    assert found.converged_


@BOTH_FORMS
@pytest.mark.parametrize(("preference", "exemplars"), [(-5.0, [0]), (-3.0, [0, 1]), (None, [0])])
def test_two_points_join_when_that_is_better(n_neighbors, preference, exemplars):
    found = AffinityPropagation(preference=preference, n_neighbors=n_neighbors, random_state=2).fit(
        [[0.0], [2.0]]
    )
    assert len(found.cluster_centers_indices_) == len(exemplars)
    assert found.converged_


@BOTH_FORMS
@pytest.mark.parametrize("preference", [None, 0.0, -1.0, -100.0])
def test_equal_points_are_one_cluster(n_neighbors, preference):
    found = AffinityPropagation(preference=preference, n_neighbors=n_neighbors).fit(
        np.full((50, 3), 0.1)
    )
    assert np.array_equal(found.labels_, np.zeros(50))
    assert found.converged_
    assert found.exact_


@BOTH_FORMS
@pytest.mark.parametrize("times", [2, 25])
def test_duplicates_share_a_cluster(n_neighbors, times):
    places = np.random.default_rng(6).random((20, 2))
    found = AffinityPropagation(preference=-0.2, n_neighbors=n_neighbors).fit(
        np.repeat(places, times, axis=0)
    )
    assert found.converged_
    labels = found.labels_.reshape(20, times)
    assert (labels == labels[:, :1]).all()
    assert 1 < len(found.cluster_centers_) <= 20


@pytest.mark.parametrize("n_neighbors", [59, 60, 10_000])
def test_more_neighbours_than_points_are_all_of_them(n_neighbors):
    rows = clusters(60, 3, 7)
    dense = AffinityPropagation(n_neighbors=None).fit(rows)
    found = AffinityPropagation(n_neighbors=n_neighbors).fit(rows)
    assert found.n_edges_ == dense.n_edges_ == 3600
    assert np.array_equal(found.labels_, dense.labels_)


def test_single_precision_gives_the_same_clusters():
    rows = clusters(200, 3, 8).astype(np.float32)
    one = AffinityPropagation().fit(rows)
    other = AffinityPropagation().fit(rows.astype(np.float64))
    assert np.array_equal(one.labels_, other.labels_)


def test_labels_do_not_depend_on_where_the_points_are():
    rows = (clusters(200, 3, 9) * 2**20).round()  # exact in both places
    here = AffinityPropagation(preference=-(2.0**42)).fit(rows)
    there = AffinityPropagation(preference=-(2.0**42)).fit(rows + 2.0**48)
    assert np.array_equal(here.labels_, there.labels_)


def test_equal_seeds_give_equal_results():
    rows = np.stack(np.meshgrid(*2 * [np.arange(12.0)]), axis=-1).reshape(-1, 2)  # full of ties
    estimator = AffinityPropagation(preference=-6.0, random_state=3)
    one, other = estimator.fit(rows), clone(estimator).fit(rows)
    assert np.array_equal(one.cluster_centers_indices_, other.cluster_centers_indices_)
    assert one.converged_


def test_a_higher_preference_gives_more_exemplars_where_it_is_higher():
    rows = np.random.default_rng(4).random((400, 2))
    left = rows[:, 0] < 0.5
    found = AffinityPropagation(preference=np.where(left, -0.002, -0.2)).fit(rows)
    chosen = left[found.cluster_centers_indices_]
    assert np.count_nonzero(chosen) > 3 * np.count_nonzero(~chosen)


@BOTH_FORMS
def test_a_quantile_is_that_preference(n_neighbors):
    rows = clusters(200, 2, 10)
    squares = ((rows[:, np.newaxis] - rows) ** 2).sum(axis=2)[~np.eye(200, dtype=bool)]
    counts = []
    for share in (0.05, 0.5, 0.95):
        settings = {"n_neighbors": n_neighbors, "damping": 0.8}
        one = AffinityPropagation(quantile=share, **settings).fit(rows)
        other = AffinityPropagation(preference=np.quantile(-squares, share), **settings).fit(rows)
        assert np.array_equal(one.labels_, other.labels_)
        counts.append(len(one.cluster_centers_))
    assert counts[0] < counts[1] < counts[2]


def test_predict_returns_the_nearest_exemplar():
    rows = np.random.default_rng(6).normal(size=(120, 3))
    found = AffinityPropagation().fit(rows)
    assert np.array_equal(found.predict(rows), found.labels_)


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
        {"preference": "median"},
    ],
    ids=str,
)
def test_parameters_out_of_range_are_refused(wrong):
    rows = np.random.default_rng(7).normal(size=(10, 2))
    with pytest.raises(ParameterError, match=f"{next(iter(wrong))} must"):
        AffinityPropagation(**wrong).fit(rows)


def test_the_dense_form_refuses_more_rows_than_memory_allows():
    with pytest.raises(ParameterError, match=f"limited to {DENSE_LIMIT} rows"):
        AffinityPropagation(n_neighbors=None).fit(np.zeros((DENSE_LIMIT + 1, 2)))
