"""Exemplars: affinity propagation chooses among the planes that were voted for."""

from __future__ import annotations

import numpy as np

from meshlab_symrecon.arrays import Planes
from meshlab_symrecon.clustering.messages import propagate_sparse
from meshlab_symrecon.clustering.neighbour_graph import neighbour_graph
from meshlab_symrecon.symmetry.embedding import embed_planes
from meshlab_symrecon.symmetry.preparation import PreparedCloud
from meshlab_symrecon.symmetry.verification import examine

__all__ = ["choose_exemplars"]

QUICK_QUERIES = 96  # enough to put candidates in an order
QUICK_TOLERANCE = 0.025
BANDWIDTH = 0.02  # H: planes whose mirror images differ less vote for the same symmetry
THINNING = 0.5  # H: edge of the cells of which only the best candidate is clustered
MOST_CLUSTERED = 2_500
NEIGHBOURS = 32
LONGEST_EDGE = 6.0  # H
PREFERENCE = 10.0  # H^2: an exemplar stands for planes up to about 3 H away
DAMPING = 0.8
MOST_ITERATIONS = 200
CALM_ITERATIONS = 15
MOST_EXEMPLARS = 500


def choose_exemplars(cloud: PreparedCloud, planes: Planes) -> tuple[Planes, bool]:
    """Cluster candidates by affinity propagation; the most convincing exemplars come first.

    The preference of a candidate is its support in a quick look, so that exemplars sit where the
    cloud confirms them.

    Parameters
    ----------
    cloud : PreparedCloud
        The cloud.
    planes : (k, 4) float
        Candidates.

    Returns
    -------
    planes : (m, 4) float
        At most 500 exemplars.
    converged : bool
        False when clustering stopped at its iteration limit.
    """
    quick = examine(planes, cloud, QUICK_QUERIES, QUICK_TOLERANCE, exact=False)
    votes = quick.support - quick.contradiction
    order = np.argsort(-votes, kind="stable")
    places = embed_planes(planes[order], cloud.root_covariance)
    cells = np.floor(places / (THINNING * BANDWIDTH)).astype(np.int64)
    first = np.sort(np.unique(cells, axis=0, return_index=True)[1])[:MOST_CLUSTERED]
    places, planes, votes = places[first], planes[order][first], votes[order][first]
    if len(planes) < 3:  # messages need a choice
        return planes, True
    similarities, targets = neighbour_graph(places, NEIGHBOURS)
    similarities[similarities < -((LONGEST_EDGE * BANDWIDTH) ** 2)] = -np.inf
    likely = np.clip(votes / max(float(votes.max()), 1e-9), 0.0, 1.0)
    similarities[:, 0] = -PREFERENCE * BANDWIDTH**2 * (1.0 - 0.5 * likely)
    found = propagate_sparse(similarities, targets, DAMPING, MOST_ITERATIONS, CALM_ITERATIONS)
    best = found.exemplars[np.argsort(-votes[found.exemplars], kind="stable")]
    return planes[best[:MOST_EXEMPLARS]], found.converged
