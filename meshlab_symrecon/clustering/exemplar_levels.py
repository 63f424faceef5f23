"""Affinity propagation on a cloud whose preferences ask for a density of exemplars.

With mass μ on the unit of area and one exemplar on the area A, hexagonal clusters have the net
similarity -(|p| + c μ A²) / A on the unit of area, c = 5 / (18 √3) (Fejes Tóth 1953). It is largest
where::

    p = -c μ A²

so the wanted area says what the preference must be.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from meshlab_symrecon.arrays import Floats, Indices, Points
from meshlab_symrecon.clustering.messages import Propagation, Schedule, propagate_sparse
from meshlab_symrecon.clustering.neighbour_graph import Neighbours
from meshlab_symrecon.clustering.surface_variation import (
    point_density,
    surface_variation,
    wanted_density,
)

__all__ = [
    "HEXAGON",
    "QUICK",
    "THOROUGH",
    "Level",
    "Passing",
    "propagate_once",
    "propagate_to_count",
    "settled",
]

HEXAGON = 5.0 / (18.0 * np.sqrt(3.0))  # mean squared distance to the centre of a hexagon / its area
CHUNK = 65_536  # points whose neighbours are looked up together
EDGES, EXTRA_EDGES = 4.0, 8  # of a point, for each point that an exemplar stands for; and beside
SEEN = 3.0  # neighbourhood of the surface variation / points that an exemplar stands for
LEAST_SEEN = 8
QUICK = Schedule(0.6, 40, 10)  # the net similarity has settled by then, to 1e-4
THOROUGH = Schedule(0.8, 400, 10)  # so has every single exemplar, as a rule
SETTLED = 1e-3  # relative change of net similarity, over the last iterations, that is none
TIE_BREAK = 1e-3  # of a preference: lattices settle, and no cluster is worse by more
TRIALS = 3  # of the preference
CLOSE = 0.01  # relative error of a count that ends the search
LARGEST_STEP = 4.0  # factor on the area between two of them
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
        Wanted density of exemplars, but for a factor: 1 where it is least.
    """

    points: Points
    mass: Floats
    similarities: Floats
    targets: NDArray[np.int32]
    density: Floats
    mass_density: Floats
    detail: Floats

    @classmethod
    def of(cls, points: Points, mass: Floats, share: float, detail: float) -> Level:
        """Connect points, of which an exemplar is to stand for about ``share``."""
        edges = min(int(EDGES * share) + EXTRA_EDGES, len(points) - 1)
        similarities, targets = _neighbours(points, edges + 1)
        seen = min(max(LEAST_SEEN, round(SEEN * share)) + 1, edges + 1)
        density, mass_density = point_density(similarities[:, :seen], targets[:, :seen], mass)
        variation = surface_variation(points, targets[:, :seen])
        wanted = wanted_density(variation, 1.0 / density, detail)
        return cls(points, mass, similarities, targets, density, mass_density, wanted)

    @property
    def unit(self) -> float:
        """The area that an input point has, as a rule."""
        return 1.0 / float(np.median(self.mass_density))

    def preferences(self, area: float) -> Floats:
        """Return the preferences that ask for one exemplar on ``area`` on flat parts."""
        wanted: Floats = -HEXAGON * self.mass_density * (area / self.detail) ** 2
        return wanted

    def area(self, count: float) -> float:
        """Return the area an exemplar, on flat parts, that gives ``count`` of them.

        No point can be more than one exemplar.
        """
        asked = self.detail / self.density
        low, high = float(asked.min()) * 1e-3, float(asked.sum())
        for _ in range(BISECTIONS):
            middle = float(np.sqrt(low * high))
            enough = np.minimum(1.0, asked / middle).sum() > count
            low, high = (middle, high) if enough else (low, middle)
        return float(np.sqrt(low * high))

    def net_similarity(self, area: float, exemplars: Indices) -> float:
        """Return the sum of the preferences of exemplars and of the similarities to them."""
        distances = cKDTree(self.points[exemplars]).query(self.points)[0]
        return float(self.preferences(area)[exemplars].sum() - (self.mass * distances**2).sum())

    def exemplars(self, area: float, schedule: Schedule) -> Propagation:
        """Pass messages with the preferences of an area an exemplar."""
        table = self.similarities * self.mass[:, np.newaxis]
        table[:, 0] = self.preferences(area) * (1.0 - TIE_BREAK * _noise(self.points))
        return propagate_sparse(
            table,
            self.targets,
            schedule.damping,
            schedule.max_iter,
            schedule.convergence_iter,
        )


@dataclass(frozen=True, slots=True, eq=False)
class Passing:
    """Messages, and the preferences that they had.

    Attributes
    ----------
    messages : Propagation
    area : float
        Area an exemplar, on flat parts, that the preferences ask for.
    iterations : int
        Of this passing and those before it.
    """

    messages: Propagation
    area: float
    iterations: int


def propagate_once(level: Level, area: float, schedule: Schedule) -> Passing:
    """Pass messages with preferences that ask for one exemplar on ``area`` on flat parts."""
    messages = level.exemplars(area, schedule)
    return Passing(messages, area, messages.iterations)


def propagate_to_count(level: Level, count: int, schedule: Schedule) -> Passing:
    """Look for the preferences that give a number of exemplars, and pass messages with them.

    The number of exemplars falls with the area that is asked for, nearly: each trial tells the
    next.

    Parameters
    ----------
    level : Level
    count : int
        Wanted exemplars.
    schedule : Schedule
        Of the last messages.

    Returns
    -------
    Passing
        Near in number.
    """
    area, iterations = level.area(count), 0
    for _ in range(TRIALS):
        messages = level.exemplars(area, QUICK)
        iterations += messages.iterations
        ratio = len(messages.exemplars) / count
        if abs(ratio - 1.0) <= CLOSE:
            break
        area *= float(np.clip(ratio, 1.0 / LARGEST_STEP, LARGEST_STEP))
    if schedule is QUICK:
        return Passing(messages, area, iterations)
    last = propagate_once(level, area, schedule)
    return Passing(last.messages, area, iterations + last.iterations)


def settled(level: Level, found: Passing) -> bool:
    """Say whether the exemplars, or at least their net similarity, no longer changed in the end.

    Single points between two equally good exemplars may turn for hundreds of iterations, in which
    net similarity changes by less than 1e-4.
    """
    if found.messages.converged:
        return True
    if not len(found.messages.earlier):
        return False
    before = level.net_similarity(found.area, found.messages.earlier)
    after = level.net_similarity(found.area, found.messages.exemplars)
    return abs(after - before) <= SETTLED * abs(after)


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
