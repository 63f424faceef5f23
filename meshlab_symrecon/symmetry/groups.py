"""Groups: mirror planes of one body bind each other."""

from __future__ import annotations

import numpy as np

from meshlab_symrecon.arrays import Floats, Indices, Planes
from meshlab_symrecon.geometry.planes import near_plane, plane_angles
from meshlab_symrecon.symmetry.cascade import TOLERANCE, refine_nearby
from meshlab_symrecon.symmetry.hypotheses import VARIANT, Hypotheses
from meshlab_symrecon.symmetry.preparation import PreparedCloud
from meshlab_symrecon.symmetry.verification import examine

__all__ = ["LIKELY", "consistent", "group_images", "not_parallel", "reflected"]

MOST_LIKELY = 6  # planes whose images across each other are tried
LIKELY = 0.3  # chance of a plane that others must not contradict
AGREEMENT_LOST = 0.2  # by the mirror image of a plane across another one
CONTRADICTED = 0.02
INCONSISTENT = 0.1  # what is left of the chance of a plane that contradicts a likelier one


def reflected(plane: Floats, mirror: Floats) -> Floats:
    """Return the mirror image of a plane (4,) across another one (4,)."""
    cosine = plane[:3] @ mirror[:3]
    return np.append(plane[:3] - 2.0 * cosine * mirror[:3], plane[3] - 2.0 * cosine * mirror[3])


def group_images(cloud: PreparedCloud, found: Hypotheses) -> Planes:
    """Return mirror images of likely planes across each other that were not found yet.

    Parameters
    ----------
    cloud : PreparedCloud
        The cloud.
    found : Hypotheses
        Planes found.

    Returns
    -------
    (k, 4) float
        Further planes, refined.
    """
    likely = found.planes[found.chances >= LIKELY][:MOST_LIKELY]
    images = [reflected(plane, mirror) for plane in likely for mirror in likely]
    new: list[Floats] = []
    for image in images:
        known = np.concatenate([found.planes, np.array(new).reshape(-1, 4)])
        if not near_plane(known, image, VARIANT).any():
            new.append(image)
    return refine_nearby(cloud, np.array(new).reshape(-1, 4)) if new else np.zeros((0, 4))


def not_parallel(planes: Planes) -> Indices:
    """Choose the first of parallel planes: no bounded body has two that are true.

    Parameters
    ----------
    planes : (k, 4) float
        Planes, best first.

    Returns
    -------
    (m,) int
        Rows that stay.
    """
    kept: list[int] = []
    for row, plane in enumerate(planes):
        if not kept or plane_angles(planes[kept], plane).min() > VARIANT[0]:
            kept.append(row)
    return np.array(kept, dtype=np.int64)


def consistent(cloud: PreparedCloud, found: Hypotheses) -> Hypotheses:
    """Lower the chances of planes that contradict likelier ones.

    The mirror image of a mirror plane across another one is a mirror plane, too.

    Parameters
    ----------
    cloud : PreparedCloud
        The cloud.
    found : Hypotheses
        Planes, likeliest first.

    Returns
    -------
    Hypotheses
        The same planes in the same order.
    """
    chances = found.chances.copy()
    likely: list[int] = []
    for row in np.flatnonzero(chances >= LIKELY):
        images = np.array([reflected(found.planes[k], found.planes[row]) for k in likely])
        images = images.reshape(len(likely), 4)
        evidence = examine(images, cloud, len(cloud.samples), TOLERANCE, exact=True)
        least = found.evidence.agreement[row] - AGREEMENT_LOST
        confirmed = (evidence.agreement >= least) & (evidence.contradiction <= CONTRADICTED)
        if confirmed.all():
            likely.append(int(row))
        else:
            chances[row] *= INCONSISTENT
    return Hypotheses(found.planes, found.evidence, chances)
