"""Affinity propagation as a scikit-learn estimator."""

from __future__ import annotations

import warnings
from numbers import Integral, Real
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from sklearn.base import BaseEstimator, ClusterMixin
from sklearn.exceptions import ConvergenceWarning
from sklearn.utils import check_random_state
from sklearn.utils.validation import check_is_fitted, validate_data

from meshlab_symrecon.arrays import Floats, Indices
from meshlab_symrecon.clustering.assignment import best_members, nearest_exemplars
from meshlab_symrecon.clustering.messages import (
    Propagation,
    Schedule,
    choose_among_equals,
    propagate_dense,
    propagate_neighbours,
)
from meshlab_symrecon.clustering.neighbour_graph import Neighbours
from meshlab_symrecon.clustering.similarities import all_similarities, similarity_quantile
from meshlab_symrecon.errors import ParameterError
from meshlab_symrecon.geometry.bounds import require_extent
from meshlab_symrecon.one_thread import in_one_thread

__all__ = ["AffinityPropagation"]

DENSE_LIMIT = 6_000  # rows; three n x n matrices of float64 are 0.9 GB there
TIE_BREAK = 1e-12  # of the largest preference: breaks ties, far below any measurement


class AffinityPropagation(ClusterMixin, BaseEstimator):  # type: ignore[misc]
    """Choose exemplars among the data by passing messages (Frey and Dueck 2007).

    Similarities are negative squared Euclidean distances.

    Parameters
    ----------
    preference : float, (n,) array or None
        Similarity of each point to itself: the larger, the more exemplars. None takes ``quantile``.
    quantile : float
        Quantile of the similarities between different points used as preference when
        ``preference`` is None; 0.5 is the median. Beyond 2000 rows of two million random pairs.
    damping : float
        Share of the old message kept in each iteration, at least 0.5, below 1. Where exemplars
        oscillate it is raised; see ``damping_``.
    max_iter : int
        Most iterations.
    convergence_iter : int
        Iterations without a change of the exemplars that count as converged.
    n_neighbors : int or None
        Edges from each point in the beginning; the graph grows where missing edges could have
        changed a message, up to 32 times as many in all. None sends messages between all points,
        O(n^2) memory, up to 6000 rows.
    random_state : int, RandomState or None
        Source of the tiny noise that breaks ties, and of the pairs for ``quantile``.

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
    exact_ : bool
        The sparse form proved that messages between all points give the same exemplars; always
        True in the dense form. False: preferences too low for so many neighbours.
    n_iter_ : int
        Iterations done.
    damping_ : float
        Damping of the last iteration, more than ``damping`` if exemplars oscillated.
    n_edges_ : int
        Edges that carried messages in the end.

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
        max_iter: int = 1000,
        convergence_iter: int = 15,
        n_neighbors: int | None = 32,
        random_state: int | np.random.RandomState | None = 0,
    ) -> None:
        self.preference = preference
        self.quantile = quantile
        self.damping = damping
        self.max_iter = max_iter
        self.convergence_iter = convergence_iter
        self.n_neighbors = n_neighbors
        self.random_state = random_state

    @in_one_thread
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
        GeometryError
            Rows whose distances floats cannot square.
        """
        with np.errstate(invalid="ignore"):  # of a sum by which scikit-learn looks for NaN
            rows: Floats = validate_data(self, X, dtype=np.float64)
        self._check_parameters(len(rows))
        require_extent(rows, "affinity propagation")
        preferences = self._preferences(rows)
        found = self._propagate(rows, preferences)
        if not found.converged:
            message = (
                f"affinity propagation has not converged after {found.iterations} iterations; "
                "raise damping or max_iter"
            )
            warnings.warn(message, ConvergenceWarning, stacklevel=2)
        exemplars = best_members(rows, preferences, found.exemplars)
        self.cluster_centers_indices_ = exemplars
        self.cluster_centers_ = rows[exemplars]
        self.labels_ = nearest_exemplars(rows, self.cluster_centers_)
        self.labels_[exemplars] = np.arange(len(exemplars))  # whatever duplicates there are
        self.converged_ = found.converged
        self.exact_ = found.exact
        self.n_iter_ = found.iterations
        self.damping_ = found.damping
        self.n_edges_ = found.edges
        return self

    def predict(self, X: ArrayLike) -> Indices:
        """Return the index of the nearest exemplar for each row of X."""
        check_is_fitted(self)
        rows = validate_data(self, X, dtype=np.float64, reset=False)
        return nearest_exemplars(rows, self.cluster_centers_)

    def _propagate(self, rows: Floats, preferences: Floats) -> Propagation:
        schedule = Schedule(self.damping, self.max_iter, self.convergence_iter)
        if len(rows) < 3 or (rows == rows[0]).all():
            similarity = -float(((rows[0] - rows[-1]) ** 2).sum())
            chosen = choose_among_equals(preferences, similarity)
            return Propagation(chosen, True, True, 0, self.damping, len(rows) ** 2, chosen)
        if self.n_neighbors is None:
            return propagate_dense(all_similarities(rows, preferences), schedule)
        return propagate_neighbours(Neighbours(rows), preferences, self.n_neighbors, schedule)

    def _preferences(self, rows: Floats) -> Floats:
        """Return one preference a row, with the noise that breaks ties."""
        random = check_random_state(self.random_state)
        if self.preference is not None:
            given = np.asarray(self.preference, dtype=np.float64)
        elif len(rows) == 1:
            given = np.zeros(1)
        else:
            given = np.asarray(similarity_quantile(rows, self.quantile, random))
        noise = TIE_BREAK * np.abs(given).max() * random.standard_normal(len(rows))
        preferences: Floats = given - np.abs(noise)  # never above a similarity of the same value
        return preferences

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
        numbers = preference.dtype.kind in "iuf" and np.isfinite(preference).all()
        if preference.shape not in ((), (count,)) or not numbers:
            message = (
                f"preference must be one finite number or {count}, one a row; got "
                f"{self.preference!r:.60}; change it, or give a quantile as quantile"
            )
            raise ParameterError(message)
        if self.n_neighbors is None and count > DENSE_LIMIT:
            message = (
                f"messages between all points are limited to {DENSE_LIMIT} rows; got {count}; "
                "set n_neighbors to use a sparse graph"
            )
            raise ParameterError(message)
