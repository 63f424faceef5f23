"""Candidate planes: every pair of even samples votes for the plane that maps one onto the other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshlab_symrecon.arrays import Floats, Planes
from meshlab_symrecon.symmetry.preparation import PreparedCloud

__all__ = ["Candidates", "pair_planes", "vote"]

SHORTEST_PAIR = 0.08  # diagonals: the error of a sample tilts the plane of a shorter pair too much
NORMAL_TOLERANCE = np.cos(np.radians(12.0))  # between a normal and the mirror image of its partner


@dataclass(frozen=True, slots=True, eq=False)
class Candidates:
    """Planes voted for, in the coordinates of the prepared cloud."""

    planes: Planes  # (k, 4)  unit normal, offset


def pair_planes(first: Floats, second: Floats) -> Planes:
    """Return the planes that mirror points onto each other.

    Parameters
    ----------
    first, second : (k, 3) float
        Pairs of distinct points.

    Returns
    -------
    (k, 4) float
        Normal ``(p - q) / |p - q|`` and offset ``-n . (p + q) / 2``.
    """
    differences = first - second
    normals = differences / np.linalg.norm(differences, axis=1, keepdims=True)
    offsets = -0.5 * np.einsum("ki,ki->k", normals, first + second)
    return np.column_stack([normals, offsets])


def vote(cloud: PreparedCloud, count: int, most: int, rng: np.random.Generator) -> Candidates:
    """Let all pairs of even samples vote, except short ones and those whose normals disagree.

    Parameters
    ----------
    cloud : PreparedCloud
        The cloud.
    count : int
        Number of samples, O(count^2) time and memory.
    most : int
        Largest number of candidates; a random choice among more.
    rng : numpy.random.Generator
        For that choice.

    Returns
    -------
    Candidates
        Possibly none.
    """
    samples = cloud.samples[:count]
    points, normals, oriented = (
        cloud.points[samples],
        cloud.normals[samples],
        cloud.oriented[samples],
    )
    squares = (points**2).sum(axis=1)
    lengths = squares[:, np.newaxis] + squares - 2.0 * points @ points.T
    np.fill_diagonal(lengths, 0.0)
    heights = points @ normals.T  # p_i . N_j
    own = np.diagonal(heights)
    # (I - 2 n n^T) N_i . N_j  with  n = (p_i - p_j) / |p_i - p_j|
    products = (own[:, np.newaxis] - heights.T) * (heights - own)
    agreement = normals @ normals.T - 2.0 * products / np.maximum(lengths, SHORTEST_PAIR**2)
    signed = oriented[:, np.newaxis] & oriented
    agreement = np.where(signed, agreement, np.abs(agreement))
    accepted = (agreement > NORMAL_TOLERANCE) & (lengths > SHORTEST_PAIR**2)
    first, second = np.nonzero(np.triu(accepted, 1))
    if len(first) > most:
        chosen = np.sort(rng.choice(len(first), most, replace=False))
        first, second = first[chosen], second[chosen]
    return Candidates(pair_planes(points[first], points[second]))
