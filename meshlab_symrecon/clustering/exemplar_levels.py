"""Affinity propagation on a cloud whose preferences ask for a density of exemplars.

With mass μ on the unit of area and one exemplar on the area A, hexagonal clusters have the net
similarity -(|p| + γ μ A²) / A on the unit of area, γ = 5 / (18 √3) (Fejes Tóth 1953). It is largest
where::

    p = -γ μ A²

so the wanted area says what the preference must be.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from meshlab_symrecon.arrays import Floats, Points
from meshlab_symrecon.clustering.messages import Propagation, propagate_sparse
from meshlab_symrecon.clustering.neighbour_graph import Neighbours
from meshlab_symrecon.clustering.surface_variation import (
    bending,
    point_density,
    surface_variation,
)

__all__ = ["HEXAGON", "Level", "Passing", "propagate_once", "propagate_to_count"]

HEXAGON = 5.0 / (18.0 * np.sqrt(3.0))  # mean squared distance to the centre of a hexagon / its area
CHUNK = 65_536  # points whose neighbours are looked up together
EXTRA_EDGES = 8  # of each point, beside
EDGES = 4.0  # so many times the points that an exemplar stands for
SEEN = 3.0  # neighbourhood of the surface variation / points that an exemplar stands for
LEAST_SEEN = 8
DAMPING, MOST_ITERATIONS, CALM = 0.7, 150, 10
TIE_BREAK = 1e-3  # of a preference: lattices settle, no measured choice is overruled
CLOSE = 0.005  # relative error of a count that ends the search
LARGEST_STEP = 4.0  # factor on the preference between two of them
BISECTIONS = 60


@dataclass(frozen=True, slots=True, eq=False)
class Level:
    """A cloud with its neighbour graph.

    Attributes
    ----------
    points : (n, 3) float
        Distinct positions.
    mass : (n,) float
        Number of input points that each stands for.
    similarities, targets : (n, k)
        Negative squared distances to the nearest points, itself first, and which they are.
    density, mass_density : (n,) float
        Points and mass on the unit of area.
    detail : (n,) float
        Wanted density of exemplars, but for a factor: 1 on a plane.
    """

    points: Points
    mass: Floats
    similarities: Floats
    targets: NDArray[np.int32]
    density: Floats
    mass_density: Floats
    detail: Floats

    @classmethod
    def of(cls, points: Points, mass: Floats, count: int, detail: float) -> Level:
        """Connect points, of which about ``count`` are to become exemplars."""
        share = len(points) / count
        edges = min(int(EDGES * share) + EXTRA_EDGES, len(points) - 1)
        similarities, targets = _neighbours(points, edges + 1)
        seen = min(max(LEAST_SEEN, round(SEEN * share)) + 1, edges + 1)
        variation = surface_variation(points, targets[:, :seen])
        return cls(
            points,
            mass,
            similarities,
            targets,
            *point_density(similarities[:, :seen], targets[:, :seen], mass),
            1.0 + detail * bending(variation),
        )

    def preferences(self, area: float) -> Floats:
        """Return the preferences that ask for one exemplar on ``area`` where there is no detail."""
        wanted: Floats = -HEXAGON * self.mass_density * (area / self.detail) ** 2
        return wanted

    def area(self, count: int) -> float:
        """Return the area an exemplar, where there is no detail, that gives ``count`` of them.

        No point can be more than one exemplar.
        """
        asked = self.detail / self.density
        low, high = asked.min() * 1e-3, asked.sum()
        for _ in range(BISECTIONS):
            middle = float(np.sqrt(low * high))
            enough = np.minimum(1.0, asked / middle).sum() > count
            low, high = (middle, high) if enough else (low, middle)
        return float(np.sqrt(low * high))

    def exemplars(self, area: float) -> Propagation:
        """Pass messages with the preferences of an area an exemplar."""
        table = self.similarities * self.mass[:, np.newaxis]
        table[:, 0] = self.preferences(area) * (1.0 - TIE_BREAK * _noise(self.points))
        return propagate_sparse(table, self.targets, DAMPING, MOST_ITERATIONS, CALM)


@dataclass(frozen=True, slots=True, eq=False)
class Passing:
    """Messages, and the preferences that they had.

    Attributes
    ----------
    messages : Propagation
    area : float
        Area an exemplar, where there is no detail, that the preferences ask for.
    iterations : int
        Of this passing and those before it.
    """

    messages: Propagation
    area: float
    iterations: int


def propagate_once(level: Level, area: float) -> Passing:
    """Pass messages with preferences that ask for one exemplar on ``area`` without detail."""
    messages = level.exemplars(area)
    return Passing(messages, area, messages.iterations)


def propagate_to_count(level: Level, count: int, trials: int) -> Passing:
    """Look for the preferences that give a number of exemplars, and pass messages with them.

    The number of exemplars falls with the area that is asked for, nearly: each trial tells the
    next.

    Parameters
    ----------
    level : Level
    count : int
        Wanted exemplars.
    trials : int
        Message passings at most.

    Returns
    -------
    Passing
        The nearest in number.
    """
    area, iterations = level.area(count), 0
    best, least = None, np.inf
    for _ in range(trials):
        messages = level.exemplars(area)
        iterations += messages.iterations
        found = len(messages.exemplars)
        error = abs(found - count)
        if error < least:
            best, least = (messages, area), error
        if error <= CLOSE * count:
            break
        area *= float(np.clip(found / count, 1.0 / LARGEST_STEP, LARGEST_STEP))
    assert best is not None  # noqa: S101  there is at least one trial
    return Passing(*best, iterations)


def _neighbours(points: Points, width: int) -> tuple[Floats, NDArray[np.int32]]:
    """Connect each point with itself and the nearest others, ``width`` in all."""
    graph = Neighbours(points)
    similarities: Floats = np.zeros((len(points), width))
    targets = np.zeros((len(points), width), dtype=np.int32)
    for first in range(0, len(points), CHUNK):
        rows = slice(first, first + CHUNK)
        members = np.arange(len(points), dtype=np.int32)[rows]
        similarities[rows], targets[rows] = graph.nearest(members, width)
    return similarities, targets


def _noise(points: Points) -> Floats:
    """Return a number from 0 to 1 for each point, by the order of distances from the centre.

    Moving or shuffling the cloud changes that order only among equals.
    """
    order = np.argsort((points**2).sum(axis=1), kind="stable")
    noise: Floats = np.zeros(len(points))
    noise[order] = np.random.default_rng(0).random(len(points))
    return noise
