"""What a file was found to hold before MeshLab reads it, and which coordinates nobody can use."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from meshlab_symrecon.errors import FileError

__all__ = ["LARGEST", "Held", "check_box", "unusable"]

LARGEST = 1e100  # of a coordinate: squares, and products of three, stay far from overflow


@dataclass(frozen=True, slots=True)
class Held:
    """What a file holds.

    Attributes
    ----------
    points : int
    unusable : int
        How many of them have a coordinate that is not a number.
    lost_faces : int
        How many faces use one of those.
    notes : tuple of str
        What the user should know of the file, whole sentences.
    merged : bool
        Whether MeshLab makes one point of all that are in one place.
    triangles : int or None
        How many its faces can be cut into; None when that was not counted.
    """

    points: int
    unusable: int = 0
    lost_faces: int = 0
    notes: tuple[str, ...] = ()
    merged: bool = False
    triangles: int | None = None


def unusable(path: Path, points: Any, first: int = 0) -> Any:
    """Say of each point whether a coordinate is not a number.

    Parameters
    ----------
    path : Path
    points : (n, 3) float
    first : int
        How many points of the file come before these.

    Raises
    ------
    FileError
        A coordinate is infinite, or so large that lengths overflow.
    """
    numbers = points if points.dtype.kind == "f" else points.astype(np.float64)
    most = min(LARGEST, float(np.finfo(numbers.dtype).max))
    if len(numbers) and -most <= numbers.min() and numbers.max() <= most:  # false for NaN
        return np.zeros(len(numbers), dtype=np.bool_)
    with np.errstate(invalid="ignore"):
        sizes = np.abs(numbers)
        large = sizes > most
    if large.any():
        row, axis = (int(index) for index in np.argwhere(large)[0])
        value = float(points[row, axis])
        message = f"{path}: point {first + row + 1} has the coordinate {value:g}"
        raise FileError(f"{message}, with which nothing can be measured; remove that point")
    return np.isnan(sizes).any(axis=1)


def check_box(path: Path, mesh: Any) -> None:
    """Check the bounding box of a layer that was loaded.

    Raises
    ------
    FileError
        It is infinite, or so large that lengths overflow.
    """
    box = mesh.bounding_box()
    corners = np.concatenate([box.min(), box.max()])
    if not (np.abs(corners) <= LARGEST).all():
        largest = float(corners[np.argmax(np.nan_to_num(np.abs(corners), nan=np.inf))])
        message = f"{path} has a point with the coordinate {largest:g}"
        raise FileError(f"{message}, with which nothing can be measured; remove that point")
