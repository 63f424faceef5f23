"""What tells inner poles from outer ones: balls that intersect, and the two poles of a sample.

Two balls that intersect deeply lie on the same side of the surface; the two poles of a sample lie
on different sides, the more certainly the flatter the angle between them (Amenta, Choi, Kolluri
2001, section 4).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshlab_symrecon.arrays import Floats, Indices
from meshlab_symrecon.geometry.triangulation import Triangulation
from meshlab_symrecon.powercrust.poles import Poles

__all__ = ["Intersections", "Opposites", "intersections", "opposites"]

DEEPEST = 1.0 - 1e-9  # cosine of two equal balls; keeps -log of it above zero
MOST_PARTNERS = 24  # balls that meet in a sample, of which about eight are usual
LONG = 3.0  # spacings: a sample with both poles farther than this lies on the surface for certain
TYPICAL = 1.5  # times the median length, where noise makes most cells round
STEEPNESS = 4.0  # power with which certainty falls with nearer poles


@dataclass(frozen=True, slots=True, eq=False)
class Intersections:
    """Pairs of poles whose balls intersect at less than a right angle.

    Attributes
    ----------
    start, end : (e,) int
    cosine : (e,) float
        Of the angle at which the balls intersect: 1 for equal balls, 0 for orthogonal ones.
    """

    start: Indices
    end: Indices
    cosine: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Opposites:
    """The two poles of a sample, for each sample that has two.

    Attributes
    ----------
    first, second : (k,) int
    certainty : (k,) float
        How sure it is that the surface parts them, 0 to 1.
    """

    first: Indices
    second: Indices
    certainty: Floats


def intersections(poles: Poles, diagram: Triangulation, representative: Indices) -> Intersections:
    """Return the pairs that share an edge of the triangulation, or a sample on their balls.

    About eight balls meet in every sample, and rounding decides which of them the triangulation
    joins there; with all their pairs the evidence does not depend on it.
    """
    cells = diagram.cells.astype(np.int64)
    sides = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]
    keys = [_pair_keys(cells[:, a], cells[:, b]) for a, b in sides]
    keys += _pairs_at_samples(poles, diagram, representative)
    unique = np.concatenate(keys)
    unique.sort()
    unique = unique[np.flatnonzero(np.diff(unique, prepend=-1))]
    start, end = unique >> 32, unique & 0xFFFFFFFF
    arms = poles.centres[start] - poles.centres[end]
    r, s = poles.radii[start], poles.radii[end]
    cosine = (r * r + s * s - np.einsum("ij,ij->i", arms, arms)) / (2.0 * r * s)
    deep = cosine > 0.0
    return Intersections(start[deep], end[deep], np.minimum(cosine[deep], DEEPEST))


def opposites(poles: Poles, representative: Indices) -> Opposites:
    """Return the two poles of each sample, with the certainty that they lie on different sides."""
    arms = poles.centres[poles.pairs] - poles.sites[poles.pair_samples][:, None, :]
    lengths = np.linalg.norm(arms, axis=2).prod(axis=1)
    flatness = -np.einsum("ij,ij->i", arms[:, 0], arms[:, 1]) / np.maximum(
        lengths, np.finfo(float).tiny
    )
    first, second = representative[poles.pairs].T
    useful = (flatness > 0.0) & (first != second)
    certainty = np.minimum(flatness, DEEPEST) * _trust(poles)
    return Opposites(first[useful], second[useful], certainty[useful])


def _pair_keys(a: Indices, b: Indices) -> Indices:
    return (np.minimum(a, b) << 32) | np.maximum(a, b)


def _pairs_at_samples(
    poles: Poles, diagram: Triangulation, representative: Indices
) -> list[Indices]:
    """Return keys of the pairs of shown poles whose balls touch one sample."""
    used = np.flatnonzero((representative == np.arange(len(representative))) & ~diagram.hidden)
    touched = poles.samples[used].ravel()
    order = np.argsort(touched, kind="stable")
    order = order[: np.searchsorted(touched[order], poles.sample_count)]
    sample: Indices = touched[order]
    pole: Indices = np.repeat(used, 4)[order]
    keys = []
    for step in range(1, MOST_PARTNERS):
        together = sample[step:] == sample[:-step]
        if not together.any():
            break
        keys.append(_pair_keys(pole[:-step][together], pole[step:][together]))
    return keys


def _trust(poles: Poles) -> Floats:
    """Return (k,) how much a sample's cell looks like one on a surface, 0 to 1.

    The Voronoi cell of a sample on a well sampled surface is long and thin: both poles are much
    farther away than the next samples.  An outlier's cell is round, and says nothing.  Where noise
    makes most cells round, only those rounder than usual are doubted.
    """
    length = poles.radii[poles.pairs].min(axis=1) / poles.room[poles.pair_samples]
    certain = min(LONG, TYPICAL * float(np.median(length)))
    trust: Floats = np.minimum(1.0, length / certain) ** STEEPNESS
    return trust
