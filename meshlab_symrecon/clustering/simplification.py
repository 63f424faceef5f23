"""Simplification of a cloud: exemplars by affinity propagation, closer together where it bends."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from numbers import Real

import numpy as np

from meshlab_symrecon.arrays import Indices, Points, as_points
from meshlab_symrecon.clustering.assignment import nearest_exemplars
from meshlab_symrecon.clustering.distinct_points import WeightedPoints, distinct_points
from meshlab_symrecon.clustering.exact_count import with_exact_count
from meshlab_symrecon.clustering.exemplar_levels import (
    HEXAGON,
    QUICK,
    THOROUGH,
    Level,
    Passing,
    propagate_once,
    propagate_to_count,
    settled,
)
from meshlab_symrecon.errors import ParameterError
from meshlab_symrecon.geometry.bounds import require_extent
from meshlab_symrecon.one_thread import in_one_thread

__all__ = ["DETAIL", "LARGEST_DETAIL", "SimplifiedPoints", "simplify"]

DETAIL, LARGEST_DETAIL = 3.0, 100.0
LARGEST_PREFERENCE = 1e12  # squared spacings
STEP = 4.0  # points that an exemplar stands for, at most, in one message passing
FEWEST = 0.8  # exemplars of a level that is not the last / those asked for
MANY = 200_000  # points from which on single exemplars may still change in the end

Progress = Callable[[float, str], None]


@dataclass(frozen=True, slots=True, eq=False)
class SimplifiedPoints:
    """Which points stand for a cloud.

    Attributes
    ----------
    chosen : (m,) int
        Indices of the exemplars, ascending.
    label : (n,) int
        Place in ``chosen`` of the exemplar that stands for each point.
    preference : float
        Preference of a point on a plane, in squared mean spacings, see `simplify`; 0 when all
        distinct points were kept without any message.
    converged : bool
        Whether the last messages had settled: the exemplars, or their net similarity to 0.1 %
        over the last iterations. The exemplars are valid in any case.
    iterations : int
        Of all message passings.
    """

    chosen: Indices
    label: Indices
    preference: float
    converged: bool
    iterations: int


@in_one_thread
def simplify(
    points: Points,
    *,
    count: int | None = None,
    preference: float | None = None,
    detail: float = DETAIL,
    progress: Progress | None = None,
) -> SimplifiedPoints:
    """Choose points that stand for a cloud, more of them where its surface bends.

    Parameters
    ----------
    points : (n, 3) float
        Positions, at least one.
    count : int, optional
        Exactly how many points to choose, from 1 to n.
    preference : float, optional
        In place of a count: the similarity of a point to itself on a plane, in squared mean
        spacings, below 0. ``-p`` gives one exemplar for about ``2.5 sqrt(p)`` points there, and the
        more where the surface bends.
    detail : float
        How much closer exemplars stand where the surface bends (`wanted_density`). 0: even.
    progress : callable, optional
        Told the fraction done and the stage.

    Returns
    -------
    SimplifiedPoints
        Deterministic; the same for every order of the points and after every motion, but for ties.

    Raises
    ------
    GeometryError
        Wrong shape, no points, a coordinate that is not finite, or an extent that floats cannot
        square.
    ParameterError
        Neither or both of count and preference, one out of range, or a count that is not whole.

    Notes
    -----
    As in *Incomplete Surface Reconstruction for Statue Point Cloud based on Symmetry*: similarities
    ``-|x_i - x_k|^2``, preferences raised by surface variation. Beyond it: how far they are raised
    follows from the wanted density (`exemplar_levels`); messages run along nearest neighbours; and
    where an exemplar stands for more than four points, exemplars are chosen among exemplars, each
    of which counts as the points that it stands for. Equal points are one, of their number's mass.
    """
    given = as_points(points, minimum=1)
    require_extent(given, "simplification")
    count = None if count is None else _whole(count)
    _check(len(given), count, preference, detail)
    cloud = distinct_points(given)
    if len(cloud.points) == 1 or (count is not None and count >= len(cloud.points)):
        chosen = _with_duplicates(cloud.source, len(given), count or 1)
        return SimplifiedPoints(chosen, _labels(given, chosen), preference or 0.0, True, 0)
    found = _descend(cloud, count, preference, detail, progress or _silent)
    chosen = np.sort(found.kept.source)
    return SimplifiedPoints(
        chosen,
        _labels(given, chosen),
        preference or found.preference,
        found.converged,
        found.iterations,
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Descent:
    """Where the exemplars of exemplars have led."""

    kept: WeightedPoints
    preference: float
    converged: bool
    iterations: int


def _descend(
    cloud: WeightedPoints,
    count: int | None,
    preference: float | None,
    detail: float,
    tell: Progress,
) -> _Descent:
    """Choose exemplars among exemplars until one stands for as many points as asked for."""
    total = len(cloud.points)
    flat = np.sqrt(-(preference or 0.0) / HEXAGON) if count is None else total / count
    share = min(max(float(flat), 1.0), float(total))
    levels = max(1, int(np.ceil(np.log(share) / np.log(STEP) - 1e-9)))
    step = share ** (1.0 / levels)
    iterations = 0
    for number in range(1, levels):
        tell(1.0 - step ** (1 - number), f"messages of level {number} of {levels}")
        level = Level.of(cloud.points, cloud.mass, step, detail)
        wanted = None if count is None else round(total / step**number)
        found, exemplars = _coarser(level, wanted, step**number)
        cloud = cloud.reduced(exemplars)
        iterations += found.iterations
    tell(1.0 - step ** (1 - levels), f"messages of level {levels} of {levels}")
    schedule = THOROUGH if len(cloud.points) < MANY else QUICK
    level = Level.of(cloud.points, cloud.mass, step, detail)
    if count is None:
        found = propagate_once(level, float(flat) * level.unit, schedule)
        exemplars = found.messages.exemplars
    else:
        found = propagate_to_count(level, count, schedule)
        exemplars = with_exact_count(level, found, count)
    tell(1.0, "done")
    return _Descent(
        cloud.reduced(exemplars),
        -HEXAGON * (found.area / level.unit) ** 2,
        settled(level, found),
        iterations + found.iterations,
    )


def _coarser(level: Level, wanted: int | None, share: float) -> tuple[Passing, Indices]:
    """Choose about ``wanted`` exemplars, or one for ``share`` input points on flat parts."""
    if wanted is None:
        found = propagate_once(level, share * level.unit, QUICK)
        return found, found.messages.exemplars
    found = propagate_once(level, level.area(wanted), QUICK)
    if len(found.messages.exemplars) >= FEWEST * wanted:
        return found, found.messages.exemplars
    # The levels that follow need enough to choose from.
    return found, with_exact_count(level, found, wanted)


def _with_duplicates(first: Indices, total: int, count: int) -> Indices:
    """Return all distinct points, and as many of the others as it takes, from the first."""
    others = np.delete(np.arange(total), first)
    return np.sort(np.concatenate([first, others[: count - len(first)]]))


def _labels(points: Points, chosen: Indices) -> Indices:
    label = nearest_exemplars(points, points[chosen])
    label[chosen] = np.arange(len(chosen))
    return label


def _whole(count: object) -> int:
    """Return a number without fraction, of whatever type, as an integer."""
    if isinstance(count, Real) and float(count).is_integer():
        return int(float(count))
    message = f"count must be a whole number; got {count!r:.60}; round it"
    raise ParameterError(message)


def _check(points: int, count: int | None, preference: float | None, detail: float) -> None:
    """Refuse numbers that ask for nothing that there is."""
    if (count is None) == (preference is None):
        message = (
            "simplification needs a count or a preference, and not both; "
            f"got count={count} and preference={preference}; give one of them"
        )
        raise ParameterError(message)
    if count is not None and not 1 <= count <= points:
        message = f"count must lie between 1 and the {points} points there are; got {count}"
        raise ParameterError(message)
    if preference is not None and not -LARGEST_PREFERENCE <= preference < 0.0:
        message = (
            f"preference must be below 0, and at least {-LARGEST_PREFERENCE:g} squared spacings; "
            f"got {preference}; -16 leaves about a tenth of the points"
        )
        raise ParameterError(message)
    if not 0.0 <= detail <= LARGEST_DETAIL:
        message = f"detail must lie between 0 and {LARGEST_DETAIL:g}; got {detail}; change it"
        raise ParameterError(message)


def _silent(fraction: float, message: str) -> None:
    """Report progress to nobody."""
