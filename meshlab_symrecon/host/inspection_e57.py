"""E57 files, scans that say how many points they hold: how many MeshLab left out of them."""

from __future__ import annotations

from pathlib import Path

from meshlab_symrecon.host.announced import announced_points

__all__ = ["notes_on_scans"]


def notes_on_scans(path: Path, extension: str, read: int) -> tuple[str, ...]:
    """Return a warning when MeshLab read fewer points than an E57 file announces."""
    announced = announced_points(path) if extension == "e57" else None
    if announced is None or read >= announced.points:
        return ()
    points = announced.points
    words = f"{path}: MeshLab left out {points - read} of {points} points: those that are marked as"
    return (f"{words} invalid, or whose coordinates are not numbers",)
