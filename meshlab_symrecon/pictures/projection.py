"""The camera: parallel projection of a scene onto a grid of pixels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from meshlab_symrecon.arrays import Floats, Points, as_points
from meshlab_symrecon.errors import ParameterError

__all__ = ["Camera", "Screen", "fit", "open_screen"]

PARALLEL = 1e-9  # squared sine below which `up` runs along the direction of view


@dataclass(frozen=True, slots=True)
class Camera:
    """An orthographic camera.

    Parameters
    ----------
    direction : three floats
        The way the camera looks, from the eye into the scene.
    up : three floats
        What is up in the picture; only its part across ``direction`` counts.
    target : three floats, optional
        The point in the middle of the picture; without it the scene is fitted.
    height : float, optional
        What the picture's height spans, in the units of the scene; without it the scene is fitted.

    Raises
    ------
    ParameterError
        ``up`` runs along ``direction``, one of them is zero or not finite, or ``height`` is not
        positive.
    """

    direction: tuple[float, float, float]
    up: tuple[float, float, float] = (0.0, 1.0, 0.0)
    target: tuple[float, float, float] | None = None
    height: float | None = None

    def __post_init__(self) -> None:
        forward, up = np.array(self.direction, dtype=float), np.array(self.up, dtype=float)
        cross = np.cross(forward, up)
        sine = (cross @ cross) / max((forward @ forward) * (up @ up), np.finfo(float).tiny)
        if not (np.isfinite(sine) and sine > PARALLEL):
            message = (
                "a camera needs a direction and an up that are finite, not zero and not parallel; "
                f"got {self.direction} and {self.up}; turn one of them"
            )
            raise ParameterError(message)
        if self.height is not None and not (np.isfinite(self.height) and self.height > 0.0):
            message = f"a camera's height must be positive; got {self.height}; leave it out to fit"
            raise ParameterError(message)

    def axes(self) -> Floats:
        """Return the rotation from the scene to the camera: rows right, up, towards the viewer."""
        back = -np.array(self.direction, dtype=float)
        back /= np.linalg.norm(back)
        right = np.cross(np.array(self.up, dtype=float), back)
        right /= np.linalg.norm(right)
        return np.array([right, np.cross(back, right), back])


@dataclass(frozen=True, slots=True, eq=False)
class Screen:
    """A camera set before a grid of ``width`` x ``height`` pixels, each ``unit`` wide."""

    axes: Floats  # (3, 3)  right, up, towards the viewer
    target: Floats  # (3,)  what is seen in the middle
    unit: float  # the side of one pixel, in the units of the scene
    width: int
    height: int

    def project(self, points: Points) -> Points:
        """Return (n, 3) columns, rows (in pixels, downwards) and depths (in pixels, away)."""
        seen = (points - self.target) @ self.axes.T / self.unit
        columns, rows = self.width / 2 + seen[:, 0], self.height / 2 - seen[:, 1]
        return np.column_stack([columns, rows, -seen[:, 2]])

    def unproject(self, pixels: Points) -> Points:
        """Return the points of the scene at these columns, rows and depths."""
        half = np.array([self.width / 2, self.height / 2, 0.0])
        seen = (pixels - half) * np.array([1.0, -1.0, -1.0]) * self.unit
        points: Points = seen @ self.axes + self.target
        return points


def fit(camera: Camera, points: Points, size: tuple[int, int], margin: float = 0.06) -> Camera:
    """Aim the camera so that all the points fill a picture of this size.

    Parameters
    ----------
    camera : Camera
        Its direction and up are kept.
    points : (n, 3) float
        What must be seen.
    size : two ints
        Width and height of the picture in pixels.
    margin : float
        What stays free on every side, as a share of the picture.

    Raises
    ------
    GeometryError
        No point at all, or a coordinate that is not finite.
    """
    axes = camera.axes()
    seen = as_points(points, minimum=1) @ axes.T
    low, high = seen.min(axis=0), seen.max(axis=0)
    spans = np.maximum(high - low, np.finfo(float).tiny)
    height = max(spans[1], spans[0] * size[1] / size[0]) / (1.0 - 2.0 * margin)
    if height < 1e-12 * max(1.0, float(np.abs(seen).max())):
        height = 1.0  # a single point: any height shows it
    x, y, z = (low + high) / 2 @ axes
    return replace(camera, target=(float(x), float(y), float(z)), height=float(height))


def open_screen(camera: Camera, scene: Sequence[Points], width: int, height: int) -> Screen:
    """Set a camera before a grid of pixels; fit it to the scene if it is not aimed yet."""
    if camera.target is None or camera.height is None:
        fitted = fit(camera, np.concatenate(scene), (width, height))
        camera = replace(
            fitted,
            target=camera.target or fitted.target,
            height=camera.height or fitted.height,
        )
    assert camera.height is not None  # noqa: S101  fit() has set it
    return Screen(camera.axes(), np.array(camera.target), camera.height / height, width, height)
