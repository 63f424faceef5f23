"""What tells inner poles from outer ones: balls that intersect, and the two poles of a sample.

Two balls that intersect deeply lie on the same side of the surface; the two poles of a sample lie
on different sides, the more certainly the flatter the angle between them (Amenta, Choi, Kolluri
2001, section 4).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from meshlab_symrecon import _native
from meshlab_symrecon.arrays import Booleans, Floats, Indices
from meshlab_symrecon.geometry.triangulation import SmallIndices, Triangulation
from meshlab_symrecon.powercrust.poles import Poles
from meshlab_symrecon.powercrust.progress import Progress

__all__ = [
    "Intersections",
    "Opposites",
    "covering_poles",
    "intersections",
    "opposites",
    "shown_poles",
]

FLATTEST = 1.0 - 1e-9  # cosine of poles straight across; keeps -log of it above zero
MOST_PARTNERS = 24  # at a sample with more balls (about eight are usual) the largest meet the rest
LONG = 2.0  # spacings: a sample with a pole farther than this lies on the surface for certain
TYPICAL = 1.5  # times the median length, where noise makes most cells round
NOISY = 3.0  # spacings: the median larger ball where noise is as wide as the spacing
STEEPNESS = 4.0  # power with which certainty falls with nearer poles


@dataclass(frozen=True, slots=True, eq=False)
class Intersections:
    """Neighbours of each pole: those whose balls intersect its own at less than a right angle.

    The neighbours of pole i are ``ends[offsets[i]:offsets[i + 1]]``, in rising order; every edge is
    there from both of its ends.

    Attributes
    ----------
    offsets : (p + 1,) int
    ends : (e,) int
    cost : (e,) float
        Minus the logarithm of the cosine of the angle at which the balls intersect: 0 for equal
        balls, infinite for orthogonal ones.
    """

    offsets: Indices
    ends: SmallIndices
    cost: NDArray[np.float32]


@dataclass(frozen=True, slots=True, eq=False)
class Opposites:
    """The two poles of a sample, for each sample that has two.

    Attributes
    ----------
    first, second : (k,) int
    flatness : (k,) float
        Minus the cosine of the angle between the directions to them: 1 where they lie straight
        across.
    certainty : (k,) float
        How sure it is that the surface parts them, 0 to 1: the flatness, less where the sample
        does not look like one on a surface.
    """

    first: SmallIndices
    second: SmallIndices
    flatness: Floats
    certainty: Floats


def shown_poles(diagram: Triangulation) -> Booleans:
    """Return (p,) True for the poles that have a cell in the power diagram."""
    shown: Booleans = ~diagram.hidden & (
        diagram.representative == np.arange(len(diagram.representative))
    )
    return shown


def covering_poles(poles: Poles, diagram: Triangulation) -> Indices:
    """Return (p,) the pole with a cell in the power diagram that stands for each pole.

    A pole without one takes the label of the ball that covers it most, and leaves it its samples:
    where many samples lie on one sphere, all but a few of their poles at its centre have no cell.
    """
    cover = diagram.representative.astype(np.int64)
    hidden = np.flatnonzero(diagram.hidden)
    corners = diagram.cells[diagram.hidden_cell[hidden]]
    arms = poles.centres[corners] - poles.centres[hidden][:, None]
    power = np.einsum("ijk,ijk->ij", arms, arms) - poles.radii[corners] ** 2
    cover[hidden] = corners[np.arange(len(hidden)), power.argmin(axis=1)]
    return cover[diagram.representative]


def intersections(
    poles: Poles, diagram: Triangulation, *, progress: Progress | None = None
) -> Intersections:
    """Return the pairs that share an edge of the triangulation, or a sample on their balls.

    About eight balls meet in every sample, and rounding decides which of them the triangulation
    joins there; with all their pairs the evidence does not depend on it.

    Parameters
    ----------
    poles : Poles
    diagram : Triangulation
        Regular triangulation of the polar balls.
    progress : callable, optional
        Called with the share of poles done, 0 to 1; what it raises stops the work.
    """
    offsets, ends, cost = _native.pole_graph(
        poles.centres,
        poles.radii,
        poles.samples.astype(np.int32),
        shown_poles(diagram).view(np.uint8),
        poles.sample_count,
        diagram.cells,
        diagram.neighbours,
        MOST_PARTNERS,
        progress,
    )
    np.log(cost, out=cost)  # in place: at millions of samples another array would count
    np.negative(cost, out=cost)
    return Intersections(offsets, ends, cost)


def opposites(poles: Poles, representative: SmallIndices) -> Opposites:
    """Return the two poles of each sample, with the certainty that they lie on different sides.

    Parameters
    ----------
    poles : Poles
    representative : (p,) int
        For each pole the one that stands for it; pairs that one pole stands for are left out.
    """
    pairs = poles.pairs.astype(np.int32)
    flatness = _native.flatness_of_pairs(
        poles.centres, pairs, poles.sites, poles.pair_samples.astype(np.int32)
    )
    first, second = representative[pairs].T
    useful = (flatness > 0.0) & (first != second)
    flatness = np.minimum(flatness, FLATTEST)
    certainty = flatness * _trust(poles)
    return Opposites(first[useful], second[useful], flatness[useful], certainty[useful])


def _trust(poles: Poles) -> Floats:
    """Return (k,) how much a sample's cell looks like one on a surface, 0 to 1.

    A sample of a surface has at least one pole much farther away than the next samples, even in a
    thin wall; an outlier's cell is round, and says nothing.  Where noise makes most cells round,
    both poles are asked for, and only cells rounder than usual are doubted.
    """
    room = poles.room[poles.pair_samples]
    balls = poles.radii[poles.pairs]
    length = balls.max(axis=1, initial=0.0) / room
    if not len(length):
        return length
    if np.median(length) < NOISY:
        length = balls.min(axis=1) / room
    certain = min(LONG, TYPICAL * float(np.median(length)))
    trust: Floats = np.minimum(1.0, length / certain) ** STEEPNESS
    return trust
