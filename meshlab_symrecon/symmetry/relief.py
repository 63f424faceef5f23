"""Relief: bumps and hollows of the two sides must be the same, not only their tangent planes."""

from __future__ import annotations

import numpy as np

from meshlab_symrecon.arrays import Floats, Indices
from meshlab_symrecon.symmetry.preparation import PreparedCloud
from meshlab_symrecon.symmetry.verification import Landings

__all__ = ["relief_agreement"]

NEAR = 0.02  # diagonals: images farther from the surface are not compared,
NEAR_SPACINGS = 2.5  # but those up to so many spacings are
LEAST_COSINE = np.cos(np.radians(45.0))  # between the normals of what is compared
RIM = 0.02  # diagonals: nearer to a rim a ball is not whole
TINY = float(np.finfo(np.float64).tiny)


def relief_agreement(landings: Landings, cloud: PreparedCloud, queries: Indices) -> Floats:
    """Correlate the relief of the samples with that of the places their mirror images fall on.

    Large smooth parts of unlike shapes can lie close to each other's mirror image; only true planes
    bring bumps on bumps. The relief of a point is the height of the centroid of its ball above its
    tangent plane.

    Parameters
    ----------
    landings : Landings
        Of k planes.
    cloud : PreparedCloud
        The cloud they are on.
    queries : (q,) int
        The points whose images they are.

    Returns
    -------
    (k, r) float
        Correlation for each radius of the cloud's relief, -1 to 1; 0 where nothing is compared.
    """
    usable = cloud.oriented & (cloud.border_distance > RIM)
    near = landings.distances < max(NEAR, NEAR_SPACINGS * cloud.spacing)
    compared = near & (np.abs(landings.cosines) > LEAST_COSINE)
    compared &= usable[queries] & usable[landings.partners]
    weights = landings.weights * compared
    total = np.maximum(weights.sum(axis=1, keepdims=True), TINY)
    columns = []
    for relief in cloud.relief.T:
        own = relief[queries] - (weights @ relief[queries])[:, np.newaxis] / total
        other = relief[landings.partners]
        other = other - (weights * other).sum(axis=1, keepdims=True) / total
        both = (weights * own * other).sum(axis=1)
        spread = (weights * own**2).sum(axis=1) * (weights * other**2).sum(axis=1)
        columns.append(both / np.sqrt(np.maximum(spread, TINY)))
    return np.stack(columns, axis=1)
