"""Inner and outer poles, told apart by evidence that travels through the power diagram."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshlab_symrecon import _native
from meshlab_symrecon.arrays import Booleans, Indices
from meshlab_symrecon.errors import GeometryError
from meshlab_symrecon.geometry.triangulation import Triangulation
from meshlab_symrecon.powercrust.handles import without_small_handles
from meshlab_symrecon.powercrust.minimum_cut import corrected_by_cuts, path_costs
from meshlab_symrecon.powercrust.pole_graph import (
    Intersections,
    Opposites,
    covering_poles,
    intersections,
    opposites,
    shown_poles,
)
from meshlab_symrecon.powercrust.poles import Poles
from meshlab_symrecon.powercrust.progress import Progress, part
from meshlab_symrecon.powercrust.propagation import propagated
from meshlab_symrecon.powercrust.small_balls import relative_sizes

__all__ = ["METHODS", "SMALLEST_PIECE", "Labels", "label_poles"]

METHODS = ("min cut", "propagation")

SMALLEST_PIECE = 0.005  # share of the samples; a smaller island or bubble is noise
GRAPH_DONE = 0.4  # share of the time
PATHS_DONE = 0.7  # share of the rest


@dataclass(frozen=True, slots=True, eq=False)
class Labels:
    """Which poles lie inside.

    Attributes
    ----------
    inside : (p,) bool
    unreached : int
        Poles that no path of evidence reaches; they count as outside.
    flipped : int
        Poles of islands and bubbles too small to be part of the shape, turned over.
    """

    inside: Booleans
    unreached: int
    flipped: int


def label_poles(
    poles: Poles,
    diagram: Triangulation,
    *,
    method: str = METHODS[0],
    smallest_handle: float = 0.0,
    progress: Progress | None = None,
) -> Labels:
    """Tell inner poles from outer ones.

    Parameters
    ----------
    poles : Poles
    diagram : Triangulation
        Regular triangulation of the polar balls.
    method : str
        One of `METHODS`: ``min cut`` weighs all evidence against each other and bears noise,
        outliers and holes; ``propagation`` is the greedy queue of the paper.
    smallest_handle : float
        In multiples of the local spacing: a handle without a ball of this size on its narrowest way
        is cut or filled.
    progress : callable, optional
        Called with the share done, 0 to 1; what it raises stops the work.

    Raises
    ------
    GeometryError
        No such method.
    """
    if method not in METHODS:
        names = " or ".join(map(repr, METHODS))
        raise GeometryError(f"poles are labelled by {names}; got {method!r}; choose one of these")
    shown = shown_poles(diagram)
    outer = _certainly_outside(poles, diagram)
    near = intersections(poles, diagram, progress=part(progress, 0.0, GRAPH_DONE))
    across = opposites(poles, diagram.representative)
    rest = part(progress, GRAPH_DONE, 1.0)
    if method == "min cut":
        inside, reached = _by_minimum_cut(near, across, outer, progress=rest)
    else:
        inside, reached = propagated(near, across, poles.radii, outer, progress=rest)
    del near, across  # the handles need the memory
    inside &= reached & shown
    if smallest_handle > 0.0:
        sizes = relative_sizes(poles)
        inside = without_small_handles(diagram, inside, outer, sizes, smallest_handle)
    cover = covering_poles(poles, diagram)
    samples = np.bincount(cover[poles.pairs].ravel(), minlength=len(cover))
    inside, flipped = _without_small_pieces(diagram, inside, outer, samples)
    return Labels(
        inside=inside[cover],
        unreached=int(np.count_nonzero(~reached & shown)),
        flipped=flipped,
    )


def _by_minimum_cut(
    near: Intersections, across: Opposites, outer: Booleans, *, progress: Progress | None
) -> tuple[Booleans, Booleans]:
    """Return which poles lie inside, and which ones any evidence reaches, (p,) bool each."""
    costs = path_costs(near, across, outer, progress=part(progress, 0.0, PATHS_DONE))
    inside = corrected_by_cuts(near, across, costs, outer, progress=part(progress, PATHS_DONE, 1.0))
    return inside, np.isfinite(costs[0]) | np.isfinite(costs[1])


def _certainly_outside(poles: Poles, diagram: Triangulation) -> Booleans:
    """Return (p,) True for poles that lie outside for certain, and for those on the hull."""
    outer = np.zeros(len(poles.centres), dtype=bool)
    outer[diagram.representative[poles.outermost]] = True
    cell, corner = np.nonzero(diagram.neighbours < 0)
    for step in (1, 2, 3):
        outer[diagram.cells[cell, (corner + step) % 4]] = True
    return outer


def _without_small_pieces(
    diagram: Triangulation, inside: Booleans, outer: Booleans, samples: Indices
) -> tuple[Booleans, int]:
    """Turn over islands and bubbles that a negligible share of the samples lies on.

    Pieces are connected through the faces of the power diagram, so turning one over keeps the
    surface closed.  ``samples`` counts the samples of each pole.
    """
    turned = _native.turn_small_pieces(
        diagram.cells,
        inside.view(np.uint8),
        outer.view(np.uint8),
        samples.astype(np.int32),
        SMALLEST_PIECE * samples.sum() / 2,
    ).view(np.bool_)
    return turned, int(np.count_nonzero((turned != inside) & shown_poles(diagram)))
