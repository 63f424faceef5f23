"""What a good file holds, so that what comes back can be compared with it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

__all__ = ["Good"]


@dataclass(frozen=True, slots=True)
class Good:
    """A good file.

    Attributes
    ----------
    name : str
        Its writer, then its extension.
    content : bytes
    points, faces : int
    coordinates : (n, 3) float, or None when a reader may order or merge them
    exact : float
        How far a coordinate may be from what was written.
    """

    name: str
    content: bytes
    points: int
    faces: int
    coordinates: np.ndarray | None
    exact: float = 0.0
