"""The Power Crust: a closed surface and a medial axis from samples.

N. Amenta, S. Choi, R. K. Kolluri, "The power crust", ACM Symposium on Solid Modeling 2001.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from meshlab_symrecon.arrays import Booleans, Faces, Indices, Points, as_points
from meshlab_symrecon.errors import GeometryError
from meshlab_symrecon.geometry.bounds import SPACE, is_solid
from meshlab_symrecon.geometry.surfaces import Topology, topology
from meshlab_symrecon.geometry.triangulation import (
    Triangulation,
    delaunay,
    regular_triangulation,
)
from meshlab_symrecon.powercrust.caps import find_caps
from meshlab_symrecon.powercrust.crust import contracted, crust_walls, joined_at_samples
from meshlab_symrecon.powercrust.interpolating import interpolating_faces
from meshlab_symrecon.powercrust.labelling import METHODS, Labels, label_poles
from meshlab_symrecon.powercrust.medial_axis import MedialAxis, medial_axis
from meshlab_symrecon.powercrust.near_poles import join_near_poles
from meshlab_symrecon.powercrust.normal_cloud import normalised
from meshlab_symrecon.powercrust.outliers import outliers
from meshlab_symrecon.powercrust.poles import Poles, enclose, find_poles
from meshlab_symrecon.powercrust.progress import part
from meshlab_symrecon.powercrust.small_balls import NoiseLimits, drop_small_balls, noise_limits
from meshlab_symrecon.powercrust.stages import Stages
from meshlab_symrecon.powercrust.trimming import trim

__all__ = ["METHODS", "SURFACES", "PowerCrust", "Recipe", "reconstruct"]

SURFACES = ("power crust", "interpolating")
NO_AXIS = MedialAxis(np.zeros((0, 3)), np.zeros(0), np.zeros((0, 3), dtype=np.int64))
HANDLE_OF_BALL = 1.5  # a handle needs a ball so much larger than the smallest one kept


@dataclass(frozen=True, slots=True)
class Recipe:
    """How to reconstruct; lengths are multiples of the local spacing of the samples.

    Attributes
    ----------
    surface : str
        One of `SURFACES`: ``power crust``, the faces of the power diagram between inner and outer
        poles, or ``interpolating``, triangles between samples.
    labelling : str
        One of `METHODS`: how inner poles are told from outer ones.
    smallest_ball : float or None
        Smaller polar balls are dropped; None chooses by the noise of the samples.
    keep_outliers : bool
        Samples that belong to no surface count like all others.
    widest_cap : float
        Holes of the samples wider than this are left open; 0 closes all.
    with_axis, with_outer_axis : bool
        Also return the medial axis, and its part outside the surface.
    axis_noise, axis_redundancy : float
        Thresholds that simplify the medial axis; see `medial_axis`.
    """

    surface: str = SURFACES[0]
    labelling: str = METHODS[0]
    smallest_ball: float | None = None
    keep_outliers: bool = False
    widest_cap: float = 0.0
    with_axis: bool = True
    with_outer_axis: bool = False
    axis_noise: float = 0.0
    axis_redundancy: float = 0.0

    def __post_init__(self) -> None:
        """Check the recipe.

        Raises
        ------
        GeometryError
            A surface that does not exist, or a negative length.
        """
        if self.surface not in SURFACES:
            names = " or ".join(map(repr, SURFACES))
            raise GeometryError(f"a surface is {names}; got {self.surface!r}; choose one of these")
        lengths = {
            "smallest_ball": self.smallest_ball or 0.0,
            "widest_cap": self.widest_cap,
            "axis_noise": self.axis_noise,
            "axis_redundancy": self.axis_redundancy,
        }
        for name, length in lengths.items():
            if not 0.0 <= length < np.inf:
                message = f"{name} is a multiple of the spacing, 0 or more; got {length}; change it"
                raise GeometryError(message)


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """Triangles, and the sample nearest to each vertex."""

    points: Points  # (v, 3)
    faces: Faces  # (m, 3)
    nearest: Indices  # (v,)


@dataclass(frozen=True, slots=True, eq=False)
class PowerCrust:
    """A surface with its medial axis, in the units of the points given, and how it was made.

    Attributes
    ----------
    points : (v, 3) float
    faces : (m, 3) int
        Counter-clockwise seen from outside.
    nearest : (v,) int
        Of the points given, the one that each vertex is nearest to.
    axis : MedialAxis
        Empty unless the recipe asks for it.
    topology : Topology
    largest_cap : float
        Width of the widest hole that the surface spans, in multiples of the spacing there.
    opened : int
        Caps left out.
    poles, dropped_poles : int
        Distinct poles; those among them with balls too small to use.
    unreached_poles : int
        Poles that no evidence labels; they count as outside.
    flipped_poles : int
        Poles of islands and bubbles too small to belong to the shape.
    outliers : int
        Samples that belong to no surface, left out.
    hull : bool
        The samples were too sparse or too flat to tell inside from outside, so the surface is
        their convex hull.
    seconds : mapping
        Wall time of each stage.
    """

    points: Points
    faces: Faces
    nearest: Indices
    axis: MedialAxis
    topology: Topology
    largest_cap: float
    opened: int
    poles: int
    dropped_poles: int
    unreached_poles: int
    flipped_poles: int
    outliers: int
    hull: bool
    seconds: Mapping[str, float]


def reconstruct(
    points: Points,
    recipe: Recipe | None = None,
    *,
    progress: Callable[[float, str], None] | None = None,
) -> PowerCrust:
    """Reconstruct a closed surface and its medial axis from samples.

    Parameters
    ----------
    points : (n, 3) float
        Samples; at least four that are not in one plane.
    recipe : Recipe, optional
        Choices of the method.
    progress : callable, optional
        Told the fraction done and the stage.

    Raises
    ------
    GeometryError
        Wrong shape, a coordinate that is not finite, fewer than four samples, or samples in one
        plane.

    Notes
    -----
    Steps as in section 3 of the paper.  Deviations: outliers, and the small balls of noisy samples,
    are left out; labels come from a minimum cut (see ``labelling``); clusters of coincident power
    vertices are joined (see ``crust``).
    """
    recipe = recipe or Recipe()
    stages = Stages(progress)
    given = as_points(points)
    cloud = normalised(given)
    voronoi, poles, strange = _surface_poles(cloud.samples, recipe, stages)
    cloud = cloud.without(strange)
    limits = _limits(poles, recipe)
    found = len(poles.centres)
    poles, dropped = drop_small_balls(poles, limits.ball)
    poles = join_near_poles(poles)
    diagram = _power_diagram(poles, stages)
    labels = _labels(poles, diagram, recipe, limits, stages)
    hull = diagram is None or not labels.inside.any()
    axis = NO_AXIS
    if diagram is None or hull:
        surface = _convex_hull(cloud.samples)
    else:
        axis = _axis(poles, diagram, labels, recipe, stages)
        report = stages.begin("extracting the surface", until=0.95)
        if voronoi is not None:
            through = interpolating_faces(voronoi, poles, diagram, labels.inside)
            surface = Surface(through.points, through.faces, through.samples)
        else:
            walls = crust_walls(poles, diagram, labels.inside, progress=part(report, 0.0, 0.4))
            del diagram  # these take most of the memory
            joined = joined_at_samples(walls, poles, progress=part(report, 0.4, 0.65))
            del walls
            crust = contracted(joined, poles, progress=part(report, 0.65, 1.0))
            del joined
            surface = Surface(crust.points, crust.faces, crust.nearest)
    surface, largest_cap, opened = _trimmed(surface, cloud.samples, poles, recipe, stages)
    stages.end()
    return PowerCrust(
        points=cloud.at_samples(surface.points, surface.nearest, given),
        faces=surface.faces,
        nearest=cloud.source[surface.nearest],
        axis=replace(axis, points=cloud.to_input(axis.points), radii=axis.radii / cloud.scale),
        topology=topology(surface.faces),
        largest_cap=largest_cap,
        opened=opened,
        poles=found,
        dropped_poles=dropped,
        unreached_poles=labels.unreached,
        flipped_poles=labels.flipped,
        outliers=int(np.count_nonzero(strange)),
        hull=hull,
        seconds=stages.seconds,
    )


def _surface_poles(
    samples: Points, recipe: Recipe, stages: Stages
) -> tuple[Triangulation | None, Poles, Booleans]:
    """Return the Delaunay triangulation, where it is still needed, the poles, and the outliers."""
    report = stages.begin("triangulating the samples", until=0.2)
    voronoi = delaunay(enclose(samples), progress=report)
    stages.begin("finding poles", until=0.25)
    poles = find_poles(voronoi, len(samples))
    needed = voronoi if recipe.surface == "interpolating" else None  # it takes a lot of memory
    nobody = np.zeros(len(samples), dtype=bool)
    strange = nobody if recipe.keep_outliers else outliers(voronoi, poles)
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


def _power_diagram(poles: Poles, stages: Stages) -> Triangulation | None:
    """Return the dual of the power diagram of the polar balls.

    A handful of cospherical samples has poles in one plane, and none.
    """
    report = stages.begin("building the power diagram", until=0.55)
    if poles.rank < SPACE:
        return None
    return regular_triangulation(poles.centres, poles.radii**2, progress=report)


def _labels(
    poles: Poles,
    diagram: Triangulation | None,
    recipe: Recipe,
    limits: NoiseLimits,
    stages: Stages,
) -> Labels:
    report = stages.begin("labelling poles", until=0.7)
    if diagram is None:
        return Labels(np.zeros(len(poles.centres), dtype=bool), unreached=0, flipped=0)
    return label_poles(
        poles,
        diagram,
        method=recipe.labelling,
        smallest_handle=limits.handle,
        progress=report,
    )


def _axis(
    poles: Poles, diagram: Triangulation, labels: Labels, recipe: Recipe, stages: Stages
) -> MedialAxis:
    if not recipe.with_axis:
        return NO_AXIS
    stages.begin("extracting the medial axis", until=0.75)
    spacing = float(np.median(poles.room))
    return medial_axis(
        poles,
        diagram,
        labels.inside,
        noise=recipe.axis_noise * spacing,
        redundancy=recipe.axis_redundancy * spacing,
        outer=recipe.with_outer_axis,
    )


def _convex_hull(samples: Points) -> Surface:
    """Return the hull of the samples: the closed surface of those that enclose no volume."""
    cells = delaunay(samples)
    sides = np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]])  # outward, opposite each corner
    cell, corner = np.nonzero(cells.neighbours < 0)
    used, faces = np.unique(cells.cells[cell[:, None], sides[corner]], return_inverse=True)
    return Surface(samples[used], faces.reshape(-1, 3).astype(np.int64), used.astype(np.int64))


def _trimmed(
    surface: Surface, samples: Points, poles: Poles, recipe: Recipe, stages: Stages
) -> tuple[Surface, float, int]:
    """Return the surface without too wide caps, the width of its widest one, and how many went."""
    stages.begin("measuring caps", until=1.0)
    caps = find_caps(surface.points, surface.faces, surface.nearest, samples, poles.room)
    if recipe.widest_cap == 0.0 or caps.largest <= recipe.widest_cap:
        return surface, caps.largest, 0
    trimmed = trim(surface.points, surface.faces, caps, recipe.widest_cap)
    rest = Surface(trimmed.points, trimmed.faces, surface.nearest[trimmed.vertices])
    return rest, caps.largest, trimmed.opened
