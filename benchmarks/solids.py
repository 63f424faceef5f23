"""Solids with a known inside: sampled, asked for their inside, with their topology.

Those of triangles are read from files; the others are level sets of functions.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
import pymeshlab
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from meshlab_symrecon.geometry.surfaces import face_normals, topology

GRID = 200  # columns a side, in which triangles are looked up


@dataclass(frozen=True)
class Model:
    """A solid: points of its surface, a test for its inside, and its topology."""

    sample: Callable[[int, np.random.Generator], np.ndarray]
    inside: Callable[[np.ndarray], np.ndarray]
    shape: tuple[int, int] | None  # pieces and genus, where they are known


# ----------------------------------------------------------------------------- models of triangles


def crossings_above(points, corners):
    """Whether an odd number of triangles lies above each point."""
    low = corners[:, :, :2].min(axis=(0, 1))
    step = (corners[:, :, :2].max(axis=(0, 1)) - low) / GRID
    first = np.floor((corners[:, :, :2].min(axis=1) - low) / step).astype(int)
    last = np.floor((corners[:, :, :2].max(axis=1) - low) / step).astype(int)
    wide, high = (last - first + 1).T
    triangle = np.repeat(np.arange(len(corners)), wide * high)
    place = np.arange(len(triangle)) - np.repeat(np.cumsum(wide * high) - wide * high, wide * high)
    column = first[triangle, 0] + place % wide[triangle]
    row = first[triangle, 1] + place // wide[triangle]
    key = column * (GRID + 1) + row
    order = np.argsort(key, kind="stable")
    key, triangle = key[order], triangle[order]

    cell = np.floor((points[:, :2] - low) / step).astype(int)
    within = ((cell >= 0) & (cell <= GRID)).all(axis=1)
    wanted = np.where(within, cell[:, 0] * (GRID + 1) + cell[:, 1], -1)
    start, end = np.searchsorted(key, wanted), np.searchsorted(key, wanted, side="right")
    point = np.repeat(np.arange(len(points)), end - start)
    place = np.arange(len(point)) - np.repeat(np.cumsum(end - start) - (end - start), end - start)
    a, b, c = corners[triangle[start[point] + place]].transpose(1, 0, 2)
    p = points[point]

    def turn(u, v):
        return (u[:, 0] - p[:, 0]) * (v[:, 1] - p[:, 1]) - (u[:, 1] - p[:, 1]) * (v[:, 0] - p[:, 0])

    weights = np.stack([turn(b, c), turn(c, a), turn(a, b)])
    hit = (weights > 0).all(axis=0) | (weights < 0).all(axis=0)
    area = np.where(hit, weights.sum(axis=0), 1.0)
    height = (weights[0] * a[:, 2] + weights[1] * b[:, 2] + weights[2] * c[:, 2]) / area
    return np.bincount(point[hit & (height > p[:, 2])], minlength=len(points)) % 2 == 1


def on_triangles(points, faces, count, rng):
    """(count, 3) points on the triangles, uniform in area."""
    areas = np.linalg.norm(face_normals(points, faces), axis=1)
    face = rng.choice(len(faces), count, p=areas / areas.sum())
    u, v = rng.random((2, count))
    flip = u + v > 1
    u[flip], v[flip] = 1 - u[flip], 1 - v[flip]
    a, b, c = (points[faces[face, k]] for k in range(3))
    return a + u[:, None] * (b - a) + v[:, None] * (c - a)


def mesh_model(path):
    mesh_set = pymeshlab.MeshSet()
    mesh_set.load_new_mesh(str(path))
    mesh = mesh_set.current_mesh()
    points, faces = mesh.vertex_matrix(), mesh.face_matrix().astype(np.int64)
    shape = topology(faces)

    def inside(queries):
        turns = Rotation.random(3, random_state=0).as_matrix()
        votes = [crossings_above(queries @ t.T, points[faces] @ t.T) for t in turns]
        return np.sum(votes, axis=0) >= 2

    manifold = shape.closed and shape.vertex_manifold
    return Model(
        partial(on_triangles, points, faces),
        inside,
        (shape.components, shape.genus) if manifold else None,
    )


# -------------------------------------------------------------------------------- analytic models


def implicit_model(field, half_size, genus, pieces=1):
    """The solid field < 0, within a box."""
    half_size = np.asarray(half_size, dtype=float)

    def gradient(points, step=1e-5):
        shifts = step * np.eye(3)
        return np.stack([(field(points + s) - field(points - s)) / (2 * step) for s in shifts], -1)

    def sample(count, rng):
        """Points near the surface, uniform in volume, moved onto it."""
        found = []
        while sum(map(len, found)) < count:
            points = rng.uniform(-1.1, 1.1, (10 * count, 3)) * half_size
            points = points[np.abs(field(points)) < 0.2]
            slope = np.maximum(np.linalg.norm(gradient(points), axis=1), 1e-9)
            points = points[np.abs(field(points)) / slope < 0.01]
            for _ in range(6):
                slopes = gradient(points)
                square = np.maximum((slopes**2).sum(axis=1), 1e-12)
                points = points - (field(points) / square)[:, None] * slopes
            found.append(points[np.abs(field(points)) < 1e-6])
        return np.concatenate(found)[:count]

    return Model(sample, lambda points: field(points) < 0, (pieces, genus))


def tube(curve, radius):
    """Points nearer to a curve than the radius; it is dense enough to pass for smooth."""
    tree = cKDTree(curve)
    return lambda points: tree.query(points)[0] - radius


def superquadric(sizes, power):
    sizes = np.asarray(sizes)
    return lambda p: (np.abs(p / sizes) ** power).sum(axis=1) ** (1 / power) - 1


def ring(points, centre=0.0):
    return np.hypot(np.hypot(points[:, 0] - centre, points[:, 1]) - 1, points[:, 2])


def bumpy(points):
    length = np.linalg.norm(points, axis=1)
    x, y, z = (points / np.maximum(length, 1e-9)[:, None]).T
    return length - 1 - 0.15 * np.sin(6 * x) * np.sin(7 * y) * np.cos(5 * z)


def bar_across(points):
    """Distance to the diameter of the ring."""
    return np.hypot(np.maximum(np.abs(points[:, 0]) - 1, 0), np.hypot(points[:, 1], points[:, 2]))


def bowl(points):
    shell = np.abs(np.linalg.norm(points, axis=1) - 0.9) - 0.08
    return np.maximum(shell, points[:, 2] - 0.2)


def wavy_sheet(points):
    x, y, z = points.T
    height = z - 0.15 * np.sin(3 * x) * np.cos(4 * y)
    return np.maximum.reduce([np.abs(height) - 0.06, np.abs(x) - 1, np.abs(y) - 1])


def cup(points):
    """A bowl with a handle."""
    x, y, z = points.T
    handle = np.hypot(np.hypot(x - 0.95, z + 0.2) - 0.25, y) - 0.07
    return np.minimum(bowl(points), np.maximum(handle, 0.85 - np.linalg.norm(points, axis=1)))


def two_balls(points):
    apart = np.stack([np.abs(points[:, 0]) - 0.7, points[:, 1], points[:, 2]], axis=1)
    return np.linalg.norm(apart, axis=1) - 0.6


def frame(points):
    """Tubes along the edges of a cube: a surface of genus five."""
    near = np.sort(np.abs(points), axis=1)
    arms = [np.maximum(near[:, 0] - 0.7, 0), near[:, 1] - 0.7, near[:, 2] - 0.7]
    return np.linalg.norm(arms, axis=0) - 0.16


def comb(points):
    """A slab with deep, narrow slots."""
    x, y, z = points.T
    body = superquadric([1, 0.5, 0.4], 8)(points)
    slots = np.minimum(0.05 - np.abs((x + 0.2) % 0.4 - 0.2), 0.2 + z)
    return np.maximum(body, slots)


def analytic_models():
    t = np.linspace(0, 2 * np.pi, 3000)
    trefoil = np.stack(
        [np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)], axis=1
    )
    helix = np.stack([np.cos(3 * t), np.sin(3 * t), t / np.pi - 1], axis=1)
    return {
        "torus": implicit_model(lambda p: ring(p) - 0.4, (1.4, 1.4, 0.4), 1),
        "barred ring": implicit_model(
            lambda p: np.minimum(ring(p), bar_across(p)) - 0.2, (1.2, 1.2, 0.2), 2
        ),
        "two rings": implicit_model(
            lambda p: np.minimum(ring(p, -0.6), ring(p, 0.6)) - 0.2, (1.8, 1.2, 0.2), 3
        ),
        "box": implicit_model(superquadric([1, 0.7, 0.5], 8), (1, 0.7, 0.5), 0),
        "pillow": implicit_model(superquadric([1, 1, 0.6], 1.5), (1, 1, 0.6), 0),
        "plate": implicit_model(superquadric([1, 0.8, 0.03], 8), (1, 0.8, 0.03), 0),
        "trefoil": implicit_model(tube(trefoil, 0.4), (3.4, 3.4, 1.4), 1),
        "spring": implicit_model(tube(helix, 0.15), (1.2, 1.2, 1.2), 0),
        "bumpy ball": implicit_model(bumpy, (1.15, 1.15, 1.15), 0),
        "thin ring": implicit_model(lambda p: ring(p) - 0.1, (1.1, 1.1, 0.1), 1),
        "wavy sheet": implicit_model(wavy_sheet, (1, 1, 0.21), 0),
        "cup": implicit_model(cup, (1.27, 1, 1), 1),
        "two balls": implicit_model(two_balls, (1.3, 0.6, 0.6), 0, pieces=2),
        "frame": implicit_model(frame, (0.86, 0.86, 0.86), 5),
        "comb": implicit_model(comb, (1, 0.5, 0.4), 0),
        "bowl": implicit_model(bowl, (1, 1, 1), 0),
    }
