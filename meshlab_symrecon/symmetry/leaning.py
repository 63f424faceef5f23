"""Mirror images that follow how the two sides of a statue differ."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from meshlab_symrecon.arrays import Floats, Points
from meshlab_symrecon.geometry.neighbours import blocks
from meshlab_symrecon.geometry.planes import reflect
from meshlab_symrecon.symmetry.asymmetry import asymmetry_field
from meshlab_symrecon.symmetry.preparation import PreparedCloud
from meshlab_symrecon.symmetry.progress import Progress, part, share_of

__all__ = ["leaning"]

NODES = 4  # places between which an offset is interpolated
LEANING = "following how the sides differ"


def leaning(
    cloud: PreparedCloud, images: Points, plane: Floats, blend: float, progress: Progress
) -> Points:
    """Move mirror images by what is known of the statue's asymmetry.

    Parameters
    ----------
    cloud : PreparedCloud
        What was measured.
    images : (n, 3) float
    plane : (4,) float
    blend : float
        As ``asymmetry_field``.
    progress : callable
        Called with a fraction and a message.

    Returns
    -------
    (n, 3) float
        The images themselves where nothing is known of the asymmetry.
    """
    progress(0.0, LEANING)
    field = asymmetry_field(cloud, plane, blend)
    if field is None:
        return images
    nodes = reflect(cloud.points @ cloud.axes * cloud.scale + cloud.centre, plane)
    offsets = field.offsets(nodes)
    tree = cKDTree(nodes)
    leaning = np.zeros(images.shape)
    for rows in blocks(len(images), share_of(part(progress, 0.5, 1.0), LEANING)):
        distances, nearest = tree.query(images[rows], k=NODES)
        weights = np.exp(-((distances / np.maximum(distances[:, -1:], 1e-300)) ** 2))
        weights /= weights.sum(axis=1, keepdims=True)
        leaning[rows] = images[rows] + np.einsum("nk,nki->ni", weights, offsets[nearest])
    return leaning
