"""What a job will take: memory estimated before it starts, and refused when there is not enough."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from meshlab_symrecon.errors import SizeError, UnknownFilterError
from meshlab_symrecon.host.announced import Announced, announced_points
from meshlab_symrecon.host.fewest_points import FEWEST_POINTS
from meshlab_symrecon.host.filter_names import known_today
from meshlab_symrecon.host.free_memory import available_memory, used_memory

__all__ = [
    "RECONSTRUCT",
    "Announced",
    "announced_points",
    "available_memory",
    "check_memory",
    "check_rest",
    "memory_needed",
]

RECONSTRUCT = (
    "compute_normal_for_point_clouds",
    "generate_reflection_planes",
    "generate_mirror_completed_points",
    "generate_surface_reconstruction_power_crust",
)

MEGABYTE, GIGABYTE = 10**6, 10**9
DIGITS = 2  # of the number of points that is recommended


@dataclass(frozen=True, slots=True)
class Cost:
    """The memory of one step, in bytes a point of the layer that it works on.

    Attributes
    ----------
    base : int
        Bytes, whatever the size.
    work : int
        While it runs, on top of the document.
    kept : int
        What its new layers add to the document.
    points : float or None
        The next step's points for each of this one's; None when nobody knows.
    """

    base: int
    work: int
    kept: int = 0
    points: float | None = 1.0


@dataclass(frozen=True, slots=True)
class _Room:
    """Bytes that a job may take.

    ``limited``: somebody has said so, or the machine has no more. ``shared``: other inputs take
    some, too.
    """

    free: int
    limited: bool
    shared: bool = False

    @property
    def in_words(self) -> str:
        shown = _gigabytes(self.free)
        words = f"the limit leaves {shown}" if self.limited else f"{shown} are free"
        return f"{words} beside the other inputs" if self.shared else words

    @property
    def way_out(self) -> str:
        return "raise the limit" if self.limited else "use a machine with more memory"


# Measured with ``benchmarks/growth.py``: the peak of resident memory of a process of its own for
# each step, two statues with 15 % missing, 10^4 ... 10^7 points (the crust to 10^6); rounded up.
PROCESS = 140 * MEGABYTE  # Python and its libraries
READ_POINT, READ_FACE = 90, 75  # bytes: of a layer, while it is read
SAVED_POINT = 70  # bytes: while it is written
COSTS = {
    "compute_normal_for_point_clouds": Cost(0, 90),
    "generate_reflection_planes": Cost(100 * MEGABYTE, 230),
    # A statue of which a sixth is missing has a fifth more points afterwards.
    "generate_mirror_completed_points": Cost(260 * MEGABYTE, 430, kept=130, points=1.2),
    "generate_surface_reconstruction_power_crust": Cost(60 * MEGABYTE, 2_200, kept=500, points=2.2),
    "generate_simplified_points": Cost(60 * MEGABYTE, 900, kept=90, points=None),
    "compute_scalar_by_mirror_symmetry_per_vertex": Cost(160 * MEGABYTE, 350, kept=16),
}
ANY = Cost(0, 250, points=None)  # a filter that nothing is known of: two more copies of the layer
# Filters that leave the current layer about as large as it was.
KEEPING = re.compile(
    r"(?:compute|apply|set|get|transfer)_|meshing_(?:re_orient|invert|repair|poly_to_tri|"
    r"close_holes|remove_(?:duplicate|unreferenced|null|folded))"
)


def memory_needed(points: int, faces: int = 0, steps: Sequence[str] = RECONSTRUCT) -> int:
    """Estimate the memory of a job, in bytes of the whole process.

    The estimate is an upper bound for scans of which up to a sixth is missing: reading,
    the steps one after the other on the layer that the step before has made, and writing. After a
    step of which nobody knows how many points it leaves, as a simplification, no further ones
    are looked at.

    Parameters
    ----------
    points, faces : int
        Of the layer that is read.
    steps : sequence of str
        Filters by any of their names, in their order; none for reading and writing alone. By
        default the whole method.
    """
    count = float(points)
    document = READ_POINT * count + READ_FACE * faces
    peak = document
    for step in steps:
        cost = _cost(step)
        peak = max(peak, document + cost.base + cost.work * count)
        document += cost.kept * count
        if cost.points is None:
            return PROCESS + int(max(peak, document))
        count *= cost.points
    return PROCESS + int(max(peak, document + SAVED_POINT * count))


def _cost(step: str) -> Cost:
    try:
        found = known_today(step)
    except UnknownFilterError:
        found = None
    name = "" if found is None else found.python_name
    if name in COSTS:
        return COSTS[name]
    return replace(ANY, points=1.0) if KEEPING.match(name) else ANY


def check_memory(
    paths: str | Path | Iterable[str | Path],
    limit: int | None = None,
    *,
    most: int | None = None,
    steps: Sequence[str] = RECONSTRUCT,
    work: str = "reconstruct",
    option: str = "--max-points",
) -> None:
    """Refuse a job that would need more memory than there is, before it starts.

    Files that do not announce their size are passed over.

    Parameters
    ----------
    paths : path or paths
        What is read into one document, twice what is given twice; the steps work on the largest.
    limit : int, optional
        Bytes that the whole process may take; what is available when left out.
    most : int, optional
        The points to which the scan will be thinned after it was read.
    steps : sequence of str
        As for ``memory_needed``.
    work : str
        What messages call the job.
    option : str
        What thins a scan in the command at hand; empty when nothing does.

    Raises
    ------
    SizeError
        The estimate is above the limit; the message says what to do.
    """
    listed = [paths] if isinstance(paths, str | Path) else list(paths)
    sizes = [(announced_points(path), path) for path in listed]
    known = [(size, path) for size, path in sizes if size is not None]
    if not known:
        return
    size, largest = max(known, key=lambda pair: pair[0].points)
    read = sum(READ_POINT * each.points + READ_FACE * each.faces for each, _ in known)
    beside = read - (READ_POINT * size.points + READ_FACE * size.faces)
    free = (available_memory() if limit is None else limit) - beside
    room = _Room(free, limit is not None, beside > 0)
    problem = _problem(size, room, most, steps, work, option)
    if problem:
        about = "" if size.exact else "about "
        raise SizeError(f"{largest} has {about}{size.points} points; {problem}")


def check_rest(
    path: Path,
    points: int,
    steps: Sequence[str],
    limit: int | None = None,
    *,
    measured: int,
    option: str = "--max-points",
) -> None:
    """Refuse the rest of a job when the document in memory turns out larger than was expected.

    Parameters
    ----------
    path : Path
        The scan, for the message.
    points : int
        Of the current layer.
    steps : sequence of str
        What is still to be done with it.
    limit : int, optional
        Bytes that the whole process may take; what is available when left out.
    measured : int
        The points that the job began with.
    option : str
        As for ``check_memory``.

    Raises
    ------
    SizeError
        The estimate is above the limit; the message says what to do.
    """
    room = _Room(available_memory() if limit is None else limit - used_memory(), limit is not None)
    needed = _on_top(points, steps)
    if needed > room.free:
        share = max(0.0, room.free / needed)
        fitting = _rounded(int(share * measured))
        raise SizeError(
            f"{path}: {points} points need about {_gigabytes(needed)} more in "
            f"'{steps[-1]}' and {room.in_words}; {_advice(fitting, option, room)}"
        )


def _on_top(points: int, steps: Sequence[str]) -> int:
    """Return what steps need on top of a document that is in memory."""
    return memory_needed(points, 0, steps) - PROCESS - READ_POINT * points


def _problem(
    size: Announced, room: _Room, most: int | None, steps: Sequence[str], work: str, option: str
) -> str:
    """Return what is wrong, and what to do; empty when nothing is."""
    reading = memory_needed(size.points, size.faces, ())
    if reading > room.free:
        return (
            f"reading them alone needs about {_gigabytes(reading)} and {room.in_words}; "
            f"split the file into parts, or {room.way_out}"
        )
    used = size.points if most is None else min(most, size.points)
    thinned = used < size.points
    needed = memory_needed(used, 0 if thinned else size.faces, steps)
    if needed <= room.free:
        return ""
    fitting = _fitting(room.free, steps, used)
    on = f" on {used} of them" if thinned else ""
    much = f"needs about {_gigabytes(needed)} and {room.in_words}"
    return f"{work}{on} {much}; {_advice(fitting, option, room)}"


def _advice(fitting: int, option: str, room: _Room) -> str:
    if fitting < FEWEST_POINTS:
        return room.way_out if room.limited else f"close other programs, or {room.way_out}"
    if option:
        return (
            f"run it with {option} {fitting}, which thins the scan out evenly first, "
            f"or {room.way_out}"
        )
    return (
        f"simplify it to {fitting} points first (symrecon apply "
        f"generate_simplified_point_cloud IN -o OUT --samplenum {fitting}), "
        f"or {room.way_out}"
    )


def _fitting(free: int, steps: Sequence[str], points: int) -> int:
    """Return the largest round number of points, below ``points``, that fits."""
    low, high = 0, points
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if memory_needed(middle, 0, steps) <= free else (low, middle)
    return _rounded(low)


def _rounded(count: int) -> int:
    """Round down to a few digits."""
    unit = 10 ** max(0, len(str(count)) - DIGITS)
    return count // unit * unit


def _gigabytes(count: int) -> str:
    shown = max(0, count) / GIGABYTE
    return f"{shown:.0f} GB" if shown >= 10.0 else f"{shown:.1f} GB"
