"""Affinity propagation as a scikit-learn estimator."""

from __future__ import annotations

import warnings
from numbers import Integral, Real
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.base import BaseEstimator, ClusterMixin
from sklearn.exceptions import ConvergenceWarning
from sklearn.utils import check_random_state
from sklearn.utils.validation import check_is_fitted, validate_data

from meshlab_symrecon.arrays import Floats, Indices
from meshlab_symrecon.clustering.messages import Propagation, propagate_dense, propagate_sparse
from meshlab_symrecon.clustering.neighbour_graph import (
    best_members,
    dense_similarities,
    nearest_exemplars,
    neighbour_graph,
)
from meshlab_symrecon.errors import ParameterError

__all__ = ["AffinityPropagation"]

DENSE_LIMIT = 6_000  # rows; five n x n matrices of float64 are 1.4 GB there
TIE_BREAK = 1e-12  # of the largest similarity: breaks ties, far below any measurement


class AffinityPropagation(ClusterMixin, BaseEstimator):  # type: ignore[misc]
    """Choose exemplars among the data by passing messages (Frey and Dueck 2007).

    Similarities are negative squared Euclidean distances.

    Parameters
    ----------
    preference : float, (n,) array or None
        Similarity of each point to itself: the larger, the more exemplars. None takes ``quantile``.
    quantile : float
        Quantile of the similarities used as preference when ``preference`` is None; 0.5 is the
        median.
    damping : float
        Share of the old message kept in each iteration, at least 0.5, below 1.
    max_iter : int
        Most iterations.
    convergence_iter : int
        Iterations without a change of the exemplars that count as converged.
    n_neighbors : int or None
        Edges from each point in the sparse form, O(n n_neighbors) memory; None sends messages
        between all points, O(n^2), up to 6000 points.
    random_state : int, RandomState or None
        Source of the tiny noise that breaks ties.

    Attributes
    ----------
    cluster_centers_indices_ : (m,) int
        Exemplars, ascending.
    cluster_centers_ : (m, d) float
        Their positions.
    labels_ : (n,) int
        Index of the nearest exemplar for each point; never -1.
    converged_ : bool
        False when stopped at ``max_iter``: the exemplars are valid, but not settled.
    n_iter_ : int
        Iterations done.

    Notes
    -----
    After message passing every point belongs to its nearest exemplar, which in the sparse form need
    not be one of its neighbours; then, as in scikit-learn but not in the paper, each cluster elects
    the member with the largest sum of similarities, its preference included.
    """

    def __init__(  # the interface of scikit-learn
        self,
        *,
        preference: float | ArrayLike | None = None,
        quantile: float = 0.5,
        damping: float = 0.7,
        max_iter: int = 300,
        convergence_iter: int = 15,
        n_neighbors: int | None = None,
        random_state: int | np.random.RandomState | None = 0,
    ) -> None:
        self.preference = preference
        self.quantile = quantile
        self.damping = damping
        self.max_iter = max_iter
        self.convergence_iter = convergence_iter
        self.n_neighbors = n_neighbors
        self.random_state = random_state

    def fit(self, X: ArrayLike, y: object = None) -> AffinityPropagation:
        """Find exemplars among the rows of X.

        Parameters
        ----------
        X : (n, d) array
            Data.
        y : ignored
            For the interface of scikit-learn.

        Returns
        -------
        AffinityPropagation
            Itself.

        Raises
        ------
        ParameterError
            A parameter out of range, or too many rows for the dense form.
        """
        rows: Floats = validate_data(self, X, dtype=np.float64)
        self._check_parameters(len(rows))
        found, preferences = self._propagate(rows)
        if not found.converged:
            message = (
                f"affinity propagation has not converged after {found.iterations} iterations; "
                "raise damping or max_iter"
            )
            warnings.warn(message, ConvergenceWarning, stacklevel=2)
        found_exemplars = best_members(rows, preferences, found.exemplars)
        self.cluster_centers_indices_ = found_exemplars
        self.cluster_centers_ = rows[found_exemplars]
        self.labels_ = nearest_exemplars(rows, self.cluster_centers_)
        self.labels_[found_exemplars] = np.arange(len(found_exemplars))
        self.converged_ = found.converged
        self.n_iter_ = found.iterations
        return self

    def predict(self, X: ArrayLike) -> Indices:
        """Return the index of the nearest exemplar for each row of X."""
        check_is_fitted(self)
        rows = validate_data(self, X, dtype=np.float64, reset=False)
        return nearest_exemplars(rows, self.cluster_centers_)

    def _propagate(self, rows: Floats) -> tuple[Propagation, Floats]:
        if len(rows) == 1:
            return Propagation(np.zeros(1, dtype=np.int64), True, 0), np.zeros(1)
        if self.n_neighbors is None:
            similarities = dense_similarities(rows)
            edges = similarities[~np.eye(len(rows), dtype=bool)]
            preferences = self._preferences(edges, len(rows))
            np.fill_diagonal(similarities, preferences)
            self._break_ties(similarities)
            found = propagate_dense(
                similarities, self.damping, self.max_iter, self.convergence_iter
            )
            return found, preferences
        similarities, targets = neighbour_graph(rows, self.n_neighbors)
        preferences = self._preferences(similarities[:, 1:], len(rows))
        similarities[:, 0] = preferences
        self._break_ties(similarities)
        found = propagate_sparse(
            similarities, targets, self.damping, self.max_iter, self.convergence_iter
        )
        return found, preferences

    def _preferences(self, edges: Floats, count: int) -> NDArray[np.float64]:
        if self.preference is None:
            return np.full(count, np.quantile(edges, self.quantile))
        return np.broadcast_to(np.asarray(self.preference, dtype=np.float64), count)

    def _break_ties(self, similarities: Floats) -> None:
        scale = TIE_BREAK * max(float(np.abs(similarities).max()), float(np.finfo(np.float64).tiny))
        random = check_random_state(self.random_state)
        similarities += scale * random.standard_normal(similarities.shape)

    def _check_parameters(self, count: int) -> None:
        ranges: dict[str, tuple[Any, float, float]] = {
            "quantile": (Real, 0.0, 1.0),
            "damping": (Real, 0.5, 1.0 - 1e-9),
            "max_iter": (Integral, 1, np.inf),
            "convergence_iter": (Integral, 1, np.inf),
            "n_neighbors": (Integral, 1, np.inf),
        }
        for name, (kind, low, high) in ranges.items():
            value = getattr(self, name)
            if name == "n_neighbors" and value is None:
                continue
            if not isinstance(value, kind) or not low <= value <= high:
                message = f"{name} must lie between {low:g} and {high:g}; got {value!r}; change it"
                raise ParameterError(message)
        preference = np.asarray(0.0 if self.preference is None else self.preference)
        if preference.shape not in ((), (count,)) or not np.isfinite(preference).all():
            message = (
                f"preference must be one finite number or {count}, one a row; got shape "
                f"{preference.shape}; change it"
            )
            raise ParameterError(message)
        if self.n_neighbors is None and count > DENSE_LIMIT:
            message = (
                f"messages between all points are limited to {DENSE_LIMIT} rows; got {count}; "
                "set n_neighbors to use a sparse graph"
            )
            raise ParameterError(message)
