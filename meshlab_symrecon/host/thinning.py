"""Scans thinned out evenly before the work starts, so that it fits into memory and time."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from meshlab_symrecon.arrays import Floats, Indices, Points
from meshlab_symrecon.errors import ParameterError
from meshlab_symrecon.host.fewest_points import FEWEST_POINTS
from meshlab_symrecon.host.meshset import add_layer, current_identifier, read_layer
from meshlab_symrecon.host.notices import warn_user
from meshlab_symrecon.host.sources import remember, source_of
from meshlab_symrecon.plugin import Layer

__all__ = ["check_most", "even_points", "thin_current"]

PROBE = 100_000  # points on which the size of a cell is guessed
TRIES = 60
CLOSE = 0.995  # share of the points asked for that is close enough
FINEST = 2.0**-60  # of the box: beyond it, cells are too many to be numbered
REACH = 2.0**30  # sizes of the bulk: what is farther away counts as if it were there
KEY_LIMIT = 1 << 62
MIXER = np.uint64(0x9E3779B97F4A7C15)  # 2^64 / golden ratio, odd: spreads bits upwards


def thin_current(mesh_set: Any, most: int) -> int:
    """Thin the current layer out evenly when it has more than ``most`` points.

    A new layer takes its place, under its label: points of the layer, bit for bit and in their
    order, with their normals, colours, quality and custom attributes. Faces are left out when
    points are, and so is the selection.

    Parameters
    ----------
    mesh_set : pymeshlab.MeshSet
    most : int
        At least 100.

    Returns
    -------
    int
        The points of the current layer now.

    Raises
    ------
    ParameterError
        ``most`` is too small.
    HostError
        As ``read_layer``.

    Warns
    -----
    SymReconWarning
        The layer was a mesh, and is a cloud now.
    """
    check_most(most)
    identifier = current_identifier(mesh_set)
    mesh = mesh_set.mesh(identifier)
    count, faces = mesh.vertex_number(), mesh.face_number()
    if count <= most:
        return int(count)
    layer = read_layer(mesh_set, identifier)
    source = source_of(mesh_set, identifier)
    mesh_set.delete_current_mesh()  # now, so that its memory is free when the part is added
    layer = _part(layer, even_points(layer.points, most))
    remember(mesh_set, add_layer(mesh_set, layer, current=True), source)
    if faces:
        warn_user(
            f"'{layer.label}' was thinned out to {len(layer.points)} points without its {faces} "
            "faces; simplify the mesh in MeshLab first to keep faces"
        )
    return len(layer.points)


def check_most(most: int) -> None:
    """Refuse a number of points that is too small to tell a statue by.

    Raises
    ------
    ParameterError
        It is below 100.
    """
    if most < FEWEST_POINTS:
        message = f"a scan must keep at least {FEWEST_POINTS} points; got {most}; ask for more"
        raise ParameterError(message)


def _part(layer: Layer, kept: Indices) -> Layer:
    def rows(values: Any) -> Any:
        return None if values is None else values[kept]

    return replace(
        layer,
        points=layer.points[kept],
        faces=layer.faces[:0],
        normals=rows(layer.normals),
        colours=rows(layer.colours),
        quality=rows(layer.quality),
        face_quality=None,
        face_colours=None,
        selected=None,
        face_selected=None,
        attributes={name: values[kept] for name, values in layer.attributes.items()},
        identifier=-1,
    )


def even_points(points: Points, most: int) -> Indices:
    """Choose at most ``most`` points, spread evenly over the surface whatever the density.

    Of each cell of a cubic grid, the point nearest to its middle stays; the cells are as small as
    the number allows. Where the cloud is sparser than the grid, all of it stays.

    Parameters
    ----------
    points : (n, 3) float
        Positions, finite.
    most : int
        At least 1.

    Returns
    -------
    (k,) int
        Which points, in their order, k at most ``most``. The same places for every order of the
        points.
    """
    if len(points) <= most:
        return np.arange(len(points))
    kept = _one_a_cell(points, points, most)
    if len(kept) < most // 2:
        near = _within_reach(points)
        kept = kept if near is points else _one_a_cell(points, near, most)
    return kept


def _within_reach(points: Points) -> Points:
    """Return the points with those brought nearer that are absurdly far from half of them.

    One point at 1e30, a scanner's word for nothing, would make all others fall into one cell.
    """
    low, high = np.quantile(points, [0.25, 0.75], axis=0)
    reach = REACH * float((high - low).max())
    near = np.clip(points, low - reach, high + reach)
    return points if reach == 0.0 or np.array_equal(near, points) else near


def _one_a_cell(points: Points, near: Points, most: int) -> Indices:
    """Choose one point of each cell, where ``near`` says in which cell each point is."""
    low = near.min(axis=0)
    widest = float((near.max(axis=0) - low).max())
    if widest == 0.0:
        return np.zeros(1, dtype=np.int64)
    size = _cell_size(near, low, widest, most)
    return np.sort(_nearest_to_middle(points, near, low, size))


def _cell_size(points: Points, low: Floats, widest: float, most: int) -> float:
    """Return an edge for which no more than ``most`` cells hold points, and hardly fewer.

    First on about one point in n, for an n-th of the cells: n times larger ones on a surface.
    """
    every = -(-len(points) // PROBE)
    size = widest / float(np.sqrt(most / every)) / 2.0
    if every > 1 and most >= every:
        size = _search(_about_one_in(points, every), low, widest, most // every, size)
        size /= float(np.sqrt(every))
    return _search(points, low, widest, most, size)


def _about_one_in(points: Points, every: int) -> Points:
    """Return some of the points, chosen by their coordinates: the same for every order."""
    mixed: NDArray[np.uint64] = np.zeros(len(points), dtype=np.uint64)
    for axis in range(3):
        bits = np.ascontiguousarray(points[:, axis]).view(np.uint64)
        mixed = (mixed ^ bits) * MIXER
        mixed ^= mixed >> np.uint64(32)
    chosen = mixed % np.uint64(every) == 0
    return points[chosen] if chosen.any() else points[:1]


def _search(points: Points, low: Floats, widest: float, most: int, start: float) -> float:
    """Follow the law by which cells become more as they become smaller, within a bracket."""
    small, large = widest * FINEST, 2.0 * widest  # the larger one holds everything in one cell
    size, before, law = start, (0.0, 0.0), -2.0
    for _ in range(TRIES):
        occupied = _distinct(_cells(points, low, size))
        if occupied > most:
            small = size
        else:
            large = size
        if CLOSE * most <= occupied <= most:
            break
        here = float(np.log(size)), float(np.log(occupied))
        if before != (0.0, 0.0) and here[0] != before[0]:
            law = min(-0.1, (here[1] - before[1]) / (here[0] - before[0]))
        before = here
        wanted = float(np.log(most * (1.0 + CLOSE) / 2.0))
        size = float(np.exp(here[0] + (wanted - here[1]) / law))
        if not small < size < large:
            size = float(np.sqrt(small) * np.sqrt(large))
    return large


def _distinct(numbers: Indices) -> int:
    ordered = np.sort(numbers)
    return 1 + int(np.count_nonzero(ordered[1:] != ordered[:-1]))


def _cells(points: Points, low: Floats, size: float) -> Indices:
    """Return a number for the cell of each point: the same for points of the same cell only."""
    places = [((points[:, axis] - low[axis]) / size).astype(np.int64) for axis in range(3)]
    widths = [int(place.max()) + 1 for place in places]
    if widths[0] * widths[1] * widths[2] >= KEY_LIMIT:  # a few points far from all others
        places = [np.unique(place, return_inverse=True)[1].reshape(-1) for place in places]
        rows = places[0] * (int(places[1].max()) + 1) + places[1]
        row = np.unique(rows, return_inverse=True)[1].reshape(-1)
        return np.asarray(row * (int(places[2].max()) + 1) + places[2])
    return (places[0] * widths[1] + places[1]) * widths[2] + places[2]


def _nearest_to_middle(points: Points, near: Points, low: Floats, size: float) -> Indices:
    """Return the point of each cell that is nearest to its middle; of several, by its place."""
    cells = _cells(near, low, size)
    distance: Floats = np.zeros(len(points))
    for axis in range(3):
        place = (near[:, axis] - low[axis]) / size
        distance += (place - np.floor(place) - 0.5) ** 2
    order = np.argsort(cells)
    cells, distance = cells[order], distance[order]
    begins = np.flatnonzero(np.concatenate([[True], cells[1:] != cells[:-1]]))
    members = np.diff(begins, append=len(cells))
    nearest = distance == np.repeat(np.minimum.reduceat(distance, begins), members)
    order, cells = order[nearest], cells[nearest]
    if len(order) > len(begins):
        by_place = np.lexsort((order, *points[order].T[::-1], cells))
        order, cells = order[by_place], cells[by_place]
    return order[np.concatenate([[True], cells[1:] != cells[:-1]])]
