"""The transformation space, in units of length."""

from __future__ import annotations

import numpy as np

from meshlab_symrecon.arrays import Floats, Planes

__all__ = ["embed_planes"]


def embed_planes(planes: Planes, root_covariance: Floats) -> Floats:
    """Embed planes so that distances are distances between mirror images.

    For a cloud around the origin with covariance S the mirror images across (n, d) and (m, e)
    differ by ``-2 (n n^T - m m^T) x + 2 (d n - e m)``; the mean of x vanishes, so the mean square
    over the cloud is ``4 |(n n^T - m m^T) S^(1/2)|_F^2 + 4 |d n - e m|^2``. That is the squared
    Euclidean distance of the 12 numbers ``2 (n n^T S^(1/2), d n)``. Both ways to write a plane give
    the same numbers, and there is no seam.

    Parameters
    ----------
    planes : (k, 4) float
        Unit normal and offset; the origin is the mean of the cloud.
    root_covariance : (3, 3) float
        Symmetric square root of the covariance of the cloud.

    Returns
    -------
    (k, 12) float
        Positions whose distance is the RMS distance of the mirrored clouds, in units of length.
    """
    normals, offsets = planes[:, :3], -planes[:, 3]
    turned = normals @ root_covariance
    products = normals[:, :, np.newaxis] * turned[:, np.newaxis, :]
    shifts = offsets[:, np.newaxis] * normals
    return 2.0 * np.column_stack([products.reshape(len(planes), 9), shifts])
