"""Exemplars taken away and added, one by one, until there are exactly as many as wanted."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from meshlab_symrecon.arrays import Booleans, Floats, Indices
from meshlab_symrecon.clustering.exemplar_levels import Level, Passing

__all__ = ["with_exact_count"]


def with_exact_count(level: Level, found: Passing, count: int) -> Indices:
    """Take away, or add, the exemplars that cost the net similarity least, or serve it most.

    Parameters
    ----------
    level : Level
        The cloud. A new exemplar serves points that are connected with it.
    found : Passing
        Its exemplars, and their preferences.
    count : int
        Wanted number, from 1 to n.

    Returns
    -------
    (count,) int
        Chosen points, ascending.

    Notes
    -----
    Several go or come in one round where they do not share a cluster, which gives what one by one
    would give, but for the order.
    """
    preferences = level.preferences(found.area)
    chosen = np.zeros(len(level.points), dtype=np.bool_)
    chosen[found.messages.exemplars] = True
    while (number := int(np.count_nonzero(chosen))) > count:
        chosen[_least_useful(level, preferences, chosen, number - count)] = False
    while (number := int(np.count_nonzero(chosen))) < count:
        chosen[_most_useful(level, preferences, chosen, count - number)] = True
    return np.flatnonzero(chosen)


def _least_useful(level: Level, preferences: Floats, chosen: Booleans, most: int) -> Indices:
    """Return up to ``most`` exemplars whose clusters do best without them."""
    exemplars = np.flatnonzero(chosen)
    distances, nearest = cKDTree(level.points[exemplars]).query(level.points, k=2)
    losses = level.mass * (distances[:, 1] ** 2 - distances[:, 0] ** 2)
    lost = np.bincount(nearest[:, 0], weights=losses, minlength=len(exemplars))
    order = np.argsort(lost + preferences[exemplars], kind="stable")
    everyone = np.arange(len(exemplars))
    touched = _grouped(
        np.concatenate([everyone, nearest[:, 0]]),
        np.concatenate([everyone, nearest[:, 1]]),
        len(exemplars),
    )
    return exemplars[_apart(order, touched, len(exemplars), most)]


def _most_useful(level: Level, preferences: Floats, chosen: Booleans, most: int) -> Indices:
    """Return up to ``most`` points that would gain most as exemplars."""
    points, targets = level.points, level.targets
    distances, nearest = cKDTree(points[chosen]).query(points)
    gained = np.zeros(len(points))
    for column in targets.T:  # one neighbour of all points at a time, which bounds the memory
        nearer = distances**2 - ((points - points[column]) ** 2).sum(axis=1)
        gained += np.bincount(
            column, weights=level.mass * np.maximum(nearer, 0.0), minlength=len(points)
        )
    candidates = np.flatnonzero(~chosen)
    order = candidates[np.argsort(-(gained + preferences)[candidates], kind="stable")]
    order = order[: 8 * most]
    rivals = [nearest[targets[point]] for point in order]
    taken = _apart(np.arange(len(order)), rivals, len(points), most)
    return order[taken]


def _grouped(groups: Indices, members: Indices, count: int) -> list[Indices]:
    """Return the distinct members of each group."""
    pairs = np.unique(groups * count + members)
    return np.split(pairs % count, np.searchsorted(pairs // count, np.arange(1, count)))


def _apart(order: Indices, touched: list[Indices], count: int, most: int) -> Indices:
    """Return the first in order that touch nothing that those before them touch."""
    taken = np.zeros(count, dtype=np.bool_)
    found = []
    for place in order:
        own = touched[place]
        if taken[own].any():
            continue
        taken[own] = True
        found.append(place)
        if len(found) == most:
            break
    return np.array(found, dtype=np.int64)
