"""Binary files that say how many points they hold, of which MeshLab leaves some out in silence."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from meshlab_symrecon.host.announced import announced_points

__all__ = ["notes_on_points"]

CTM_MARK, CTM_COUNT = b"OCTM", slice(12, 16)


def notes_on_points(path: Path, extension: str, read: int) -> tuple[str, ...]:
    """Return a warning when MeshLab read fewer points than a file says that it holds."""
    count = _COUNTERS.get(extension)
    points = count(path) if count is not None else None
    if points is None or read >= points:
        return ()
    words = f"{path}: MeshLab left out {points - read} of {points} points: those that are marked as"
    return (f"{words} invalid, or whose coordinates are not numbers",)


def _e57(path: Path) -> int | None:
    announced = announced_points(path)
    return None if announced is None else announced.points


def _ctm(path: Path) -> int | None:
    with path.open("rb") as file:
        header = file.read(CTM_COUNT.stop)
    return int.from_bytes(header[CTM_COUNT], "little") if header.startswith(CTM_MARK) else None


_COUNTERS: Mapping[str, Callable[[Path], int | None]] = {"ctm": _ctm, "e57": _e57}
