"""Shapes whose answers are known in closed form, and the motions that must not matter."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


def fibonacci_sphere(count: int, radius: float = 1.0) -> np.ndarray:
    """(count, 3) evenly spread points of a sphere."""
    k = np.arange(count) + 0.5
    height = 1.0 - 2.0 * k / count
    angle = np.pi * (1.0 + np.sqrt(5.0)) * k
    ring = np.sqrt(1.0 - height**2)
    return radius * np.stack([ring * np.cos(angle), ring * np.sin(angle), height], axis=1)


def torus(count: int, major: float = 1.0, minor: float = 0.4, seed: int = 0) -> np.ndarray:
    """(count, 3) random points of a torus, uniform in area."""
    rng = np.random.default_rng(seed)
    u = rng.random(8 * count) * 2 * np.pi
    v = rng.random(8 * count) * 2 * np.pi
    keep = rng.random(8 * count) < (major + minor * np.cos(v)) / (major + minor)
    u, v = u[keep][:count], v[keep][:count]
    ring = major + minor * np.cos(v)
    return np.stack([ring * np.cos(u), ring * np.sin(u), minor * np.sin(v)], axis=1)


def torus_mesh(rows: int, columns: int) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and triangles of a torus of radii 1 and 0.4, facing outward."""
    i, j = (grid.ravel() for grid in np.meshgrid(*map(np.arange, (rows, columns)), indexing="ij"))
    u, v = 2 * np.pi * i / rows, 2 * np.pi * j / columns
    ring = 1.0 + 0.4 * np.cos(v)
    points = np.stack([ring * np.cos(u), ring * np.sin(u), 0.4 * np.sin(v)], axis=1)
    right, up = ((i + 1) % rows) * columns + j, i * columns + (j + 1) % columns
    across = ((i + 1) % rows) * columns + (j + 1) % columns
    here = i * columns + j
    faces = [np.stack([here, right, across], 1), np.stack([here, across, up], 1)]
    return points, np.concatenate(faces)


def box_lattice(steps: int) -> np.ndarray:
    """Points of the surface of the integer lattice 0..steps: cospherical everywhere."""
    grid = np.stack(np.meshgrid(*[np.arange(steps + 1.0)] * 3, indexing="ij"), -1).reshape(-1, 3)
    return grid[((grid == 0) | (grid == steps)).any(axis=1)]


def statue(count: int, seed: int = 0, missing: float = 0.25) -> np.ndarray:
    """Points of a bumpy body with the mirror plane x = 0, one side of it broken off.

    The bumps come in mirrored pairs of random places and sizes, so no other symmetry is left.
    """
    rng = np.random.default_rng(seed)
    sphere = rng.normal(size=(4 * count, 3))
    sphere /= np.linalg.norm(sphere, axis=1, keepdims=True)
    radius = np.ones(len(sphere))
    for _ in range(9):
        centre = rng.normal(size=3)
        centre /= np.linalg.norm(centre)
        width, height = rng.uniform(0.15, 0.45), rng.uniform(-0.15, 0.5)
        for side in (centre, centre * [-1, 1, 1]):
            radius += height * np.exp(-(((sphere - side) / width) ** 2).sum(axis=1))
    points = sphere * radius[:, None] * [0.7, 1.3, 1.0]
    cut = points @ [1.0, 0.35, 0.2]
    whole = points[cut <= np.quantile(cut, 1.0 - missing)]
    return whole[:count]


def rotation(seed: int) -> np.ndarray:
    """A random proper rotation."""
    q, r = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    q[:, 0] *= np.sign(np.linalg.det(q))
    return q


@dataclass(frozen=True)
class Motion:
    """x -> scale * rotation x + shift."""

    name: str
    turn: np.ndarray
    scale: float
    shift: np.ndarray

    def __call__(self, points: np.ndarray) -> np.ndarray:
        return self.scale * points @ self.turn.T + self.shift

    def back(self, points: np.ndarray) -> np.ndarray:
        return (points - self.shift) @ self.turn / self.scale

    def planes(self, planes: np.ndarray) -> np.ndarray:
        normals = planes[:, :3] @ self.turn.T
        offsets = self.scale * planes[:, 3] - normals @ self.shift
        return np.column_stack([normals, offsets])


MOTIONS = (
    Motion("rotated", rotation(1), 1.0, np.zeros(3)),
    Motion("shifted", np.eye(3), 1.0, np.array([1e3, -2e3, 5e2])),
    Motion("small", np.eye(3), 1e-3, np.zeros(3)),
    Motion("large", np.eye(3), 1e6, np.zeros(3)),
    Motion("moved", rotation(2), 37.0, np.array([100.0, 20.0, -300.0])),
)
