"""The poles that a surface is made of: without those of outliers, of noise and of repetition."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from meshlab_symrecon.arrays import Booleans, Points
from meshlab_symrecon.geometry.bounds import is_solid
from meshlab_symrecon.geometry.triangulation import Triangulation, delaunay
from meshlab_symrecon.powercrust.near_poles import join_near_poles
from meshlab_symrecon.powercrust.outliers import outliers
from meshlab_symrecon.powercrust.poles import Poles, enclose, find_poles
from meshlab_symrecon.powercrust.recipe import Recipe
from meshlab_symrecon.powercrust.small_balls import NoiseLimits, drop_small_balls, noise_limits
from meshlab_symrecon.powercrust.stages import Stages

__all__ = ["UsablePoles", "usable_poles"]

HANDLE_OF_BALL = 1.5  # a handle needs a ball so much larger than the smallest one kept


@dataclass(frozen=True, slots=True, eq=False)
class UsablePoles:
    """Poles, and what was left out on the way to them.

    Attributes
    ----------
    poles : Poles
    limits : NoiseLimits
        What is too small to be trusted.
    voronoi : Triangulation or None
        Delaunay triangulation that the poles were found in, where the recipe needs it later: it
        takes a lot of memory.
    found, dropped : int
        Distinct poles; those among them with balls too small to use.
    outliers : (n,) bool
        Samples that belong to no surface; the poles are those of the others.
    """

    poles: Poles
    limits: NoiseLimits
    voronoi: Triangulation | None
    found: int
    dropped: int
    outliers: Booleans


def usable_poles(samples: Points, recipe: Recipe, stages: Stages) -> UsablePoles:
    """Find the poles of samples, and keep those that tell of the surface.

    Parameters
    ----------
    samples : (n, 3) float
        Distinct, and not in one plane.
    recipe : Recipe
    stages : Stages
        Told of the triangulation and of the search.
    """
    voronoi, poles, strange = _surface_poles(samples, recipe, stages)
    limits = _limits(poles, recipe)
    found = len(poles.centres)
    poles, dropped = drop_small_balls(poles, limits.ball)
    return UsablePoles(join_near_poles(poles), limits, voronoi, found, dropped, strange)


def _surface_poles(
    samples: Points, recipe: Recipe, stages: Stages
) -> tuple[Triangulation | None, Poles, Booleans]:
    """Return the Delaunay triangulation, where it is still needed, the poles, and the outliers."""
    report = stages.begin("triangulating the samples", until=0.2)
    voronoi = delaunay(enclose(samples), progress=report)
    report = stages.begin("finding poles", until=0.25)
    poles = find_poles(voronoi, len(samples))
    report(0.6)
    needed = voronoi if recipe.surface == "interpolating" else None
    nobody = np.zeros(len(samples), dtype=bool)
    strange = nobody if recipe.keep_outliers else outliers(voronoi, poles)
    report(0.8)
    if not strange.any() or not is_solid(samples[~strange]):
        return needed, poles, nobody
    again = replace(recipe, keep_outliers=True)
    needed, poles, _ = _surface_poles(samples[~strange], again, stages)
    return needed, poles, strange


def _limits(poles: Poles, recipe: Recipe) -> NoiseLimits:
    """Return the limits that the recipe asks for, else those that suit the samples."""
    if recipe.smallest_ball is None:
        return noise_limits(poles)
    return NoiseLimits(recipe.smallest_ball, HANDLE_OF_BALL * recipe.smallest_ball)
