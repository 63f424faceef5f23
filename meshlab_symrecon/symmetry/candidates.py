"""Candidate planes: every pair of even samples votes for the plane that maps one onto the other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshlab_symrecon import _native
from meshlab_symrecon.arrays import Floats, Planes
from meshlab_symrecon.symmetry.preparation import PreparedCloud

__all__ = ["Candidates", "pair_planes", "vote"]

SHORTEST_PAIR = 0.08  # diagonals: the error of a sample tilts the plane of a shorter pair too much
NORMAL_TOLERANCE = float(
    np.cos(np.radians(12.0))
)  # between a normal and its partner's mirror image


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
        Number of samples, O(count^2) time.
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
    points = cloud.points[samples]
    pairs = _native.mirror_pairs(
        points,
        cloud.normals[samples],
        cloud.oriented[samples].view(np.uint8),
        SHORTEST_PAIR,
        NORMAL_TOLERANCE,
    )
    if len(pairs) > most:
        # Each pair draws its own lot, so that a pair more or less changes no other one's fate.
        lots = rng.random((2, len(samples)))
        drawn = (lots[0, pairs[:, 0]] + lots[1, pairs[:, 1]]) % 1.0
        pairs = pairs[np.sort(np.argpartition(drawn, most)[:most])]
    first, second = pairs.T
    return Candidates(pair_planes(points[first], points[second]))
