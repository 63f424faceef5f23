"""The Power Crust: a closed surface and a medial axis from samples.

N. Amenta, S. Choi, R. K. Kolluri, "The power crust", ACM Symposium on Solid Modeling 2001.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from meshlab_symrecon.arrays import Faces, Floats, Indices, Points, as_points
from meshlab_symrecon.geometry.bounds import SPACE
from meshlab_symrecon.geometry.surfaces import Topology, topology
from meshlab_symrecon.geometry.triangulation import Triangulation, regular_triangulation
from meshlab_symrecon.one_thread import in_one_thread
from meshlab_symrecon.powercrust.caps import find_caps
from meshlab_symrecon.powercrust.crust import (
    JOINS_DONE,
    WALLS_DONE,
    contracted,
    crust_walls,
    joined_at_samples,
)
from meshlab_symrecon.powercrust.interpolating import interpolating_faces
from meshlab_symrecon.powercrust.kept_memory import kept_memory
from meshlab_symrecon.powercrust.labelling import Labels, label_poles
from meshlab_symrecon.powercrust.medial_axis import MedialAxis, medial_axis
from meshlab_symrecon.powercrust.normal_cloud import normalised
from meshlab_symrecon.powercrust.poles import Poles
from meshlab_symrecon.powercrust.progress import part
from meshlab_symrecon.powercrust.recipe import Recipe
from meshlab_symrecon.powercrust.stages import Stages
from meshlab_symrecon.powercrust.surface import Surface, convex_hull
from meshlab_symrecon.powercrust.trimming import trim
from meshlab_symrecon.powercrust.usable_poles import UsablePoles, usable_poles

__all__ = ["PowerCrust", "reconstruct"]

NO_AXIS = MedialAxis(np.zeros((0, 3)), np.zeros(0), np.zeros((0, 3), dtype=np.int64))


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


@in_one_thread
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
    with kept_memory(len(given)):
        return _reconstructed(given, recipe, stages)


def _reconstructed(given: Points, recipe: Recipe, stages: Stages) -> PowerCrust:
    cloud = normalised(given)
    usable = usable_poles(cloud.samples, recipe, stages)
    cloud = cloud.without(usable.outliers)
    body = _body(usable, cloud.samples, recipe, stages)
    room = usable.poles.room
    surface, largest_cap, opened = _trimmed(body.surface, cloud.samples, room, recipe, stages)
    stages.end()
    axis = body.axis
    return PowerCrust(
        points=cloud.at_samples(surface.points, surface.nearest, given),
        faces=surface.faces,
        nearest=cloud.source[surface.nearest],
        axis=replace(axis, points=cloud.to_input(axis.points), radii=axis.radii / cloud.scale),
        topology=topology(surface.faces),
        largest_cap=largest_cap,
        opened=opened,
        poles=usable.found,
        dropped_poles=usable.dropped,
        unreached_poles=body.labels.unreached,
        flipped_poles=body.labels.flipped,
        outliers=int(np.count_nonzero(usable.outliers)),
        hull=not body.labels.inside.any(),
        seconds=stages.seconds,
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Body:
    """What the samples bound: its surface, its axis, and the labels that both come from."""

    surface: Surface
    axis: MedialAxis
    labels: Labels


def _body(usable: UsablePoles, samples: Points, recipe: Recipe, stages: Stages) -> _Body:
    """Return the closed surface between inner and outer poles, and the axis."""
    poles = usable.poles
    diagram = _power_diagram(poles, stages)
    labels = _labels(usable, diagram, recipe, stages)
    if diagram is None or not labels.inside.any():
        return _Body(convex_hull(samples), NO_AXIS, labels)
    axis = _axis(poles, diagram, labels, recipe, stages)
    report = stages.begin("extracting the surface", until=0.95)
    if usable.voronoi is not None:
        through = interpolating_faces(usable.voronoi, poles, diagram, labels.inside)
        return _Body(Surface(through.points, through.faces, through.samples), axis, labels)
    walls = crust_walls(poles, diagram, labels.inside, progress=part(report, 0.0, WALLS_DONE))
    del diagram  # these take most of the memory
    joined = joined_at_samples(walls, poles, progress=part(report, WALLS_DONE, JOINS_DONE))
    del walls
    crust = contracted(joined, poles, progress=part(report, JOINS_DONE, 1.0))
    return _Body(Surface(crust.points, crust.faces, crust.nearest), axis, labels)


def _power_diagram(poles: Poles, stages: Stages) -> Triangulation | None:
    """Return the dual of the power diagram of the polar balls.

    A handful of cospherical samples has poles in one plane, and none.
    """
    report = stages.begin("building the power diagram", until=0.55)
    if poles.rank < SPACE:
        return None
    return regular_triangulation(poles.centres, poles.radii**2, progress=report)


def _labels(
    usable: UsablePoles, diagram: Triangulation | None, recipe: Recipe, stages: Stages
) -> Labels:
    """Return the labels of the poles; without a diagram all are outside."""
    report = stages.begin("labelling poles", until=0.7)
    if diagram is None:
        return Labels(np.zeros(len(usable.poles.centres), dtype=bool), unreached=0, flipped=0)
    return label_poles(
        usable.poles,
        diagram,
        method=recipe.labelling,
        smallest_handle=usable.limits.handle,
        progress=report,
    )


def _axis(
    poles: Poles, diagram: Triangulation, labels: Labels, recipe: Recipe, stages: Stages
) -> MedialAxis:
    """Return the axis that the recipe asks for; its thresholds are multiples of the spacing."""
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


def _trimmed(
    surface: Surface, samples: Points, room: Floats, recipe: Recipe, stages: Stages
) -> tuple[Surface, float, int]:
    """Return the surface without too wide caps, the width of its widest one, and how many went."""
    stages.begin("measuring caps", until=1.0)
    caps = find_caps(surface.points, surface.faces, surface.nearest, samples, room)
    if recipe.widest_cap == 0.0 or caps.largest <= recipe.widest_cap:
        return surface, caps.largest, 0
    trimmed = trim(surface.points, surface.faces, caps, recipe.widest_cap)
    rest = Surface(trimmed.points, trimmed.faces, surface.nearest[trimmed.vertices])
    return rest, caps.largest, trimmed.opened
