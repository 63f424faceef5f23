"""Negative squared distances between points: all of them, and their quantiles."""

from __future__ import annotations

import numpy as np
from scipy.spatial.distance import cdist, pdist

from meshlab_symrecon.arrays import Floats

__all__ = ["MOST_PAIRS", "all_similarities", "similarity_quantile"]

MOST_PAIRS = 2_000_000  # of which a quantile is taken; the share below it is right to .0004


def all_similarities(rows: Floats, preferences: Floats) -> Floats:
    """Return the (n, n) similarities between all rows, the preferences on the diagonal."""
    similarities: Floats = cdist(rows, rows, "sqeuclidean")
    np.negative(similarities, out=similarities)
    np.fill_diagonal(similarities, preferences)
    return similarities


def similarity_quantile(rows: Floats, quantile: float, random: np.random.RandomState) -> float:
    """Return a quantile of the similarities between different rows.

    Parameters
    ----------
    rows : (n, d) float
        Positions; n at least 2.
    quantile : float
        0 to 1; 0.5 is the median.
    random : numpy.random.RandomState
        Draws two million pairs when there are more, beyond 2000 rows.

    Returns
    -------
    float
        The similarity.
    """
    count = len(rows)
    if count * (count - 1) // 2 <= MOST_PAIRS:
        return float(np.quantile(-pdist(rows, "sqeuclidean"), quantile))
    first = random.randint(count, size=MOST_PAIRS)
    second = (first + random.randint(1, count, size=MOST_PAIRS)) % count
    squares = np.zeros(MOST_PAIRS)
    for column in rows.T:  # one at a time: d times less memory
        squares += (column[first] - column[second]) ** 2
    return float(np.quantile(-squares, quantile))
