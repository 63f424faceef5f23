"""Bodies with a closed form, and prepared clouds that are known to the last digit."""

import dataclasses

import numpy as np
from scipy.spatial import cKDTree

from meshlab_symrecon import _native
from meshlab_symrecon.geometry.neighbours import nearest_field
from meshlab_symrecon.geometry.planes import reflect, reflect_directions
from meshlab_symrecon.symmetry.breaks import NOT_BROKEN
from meshlab_symrecon.symmetry.preparation import RELIEF_RADII, prepare


def even_sphere(count):
    """Points of a unit sphere on a golden spiral."""
    steps = np.arange(count) + 0.5
    height, turn = 1 - 2 * steps / count, np.pi * (1 + 5**0.5) * steps
    radius = np.sqrt(1 - height**2)
    return np.stack([np.cos(turn) * radius, np.sin(turn) * radius, height], axis=1)


def ellipsoid(count, axes, seed=0):
    """Random points of an ellipsoid, as dense everywhere."""
    axes, rng = np.asarray(axes, dtype=float), np.random.default_rng(seed)
    directions = even_sphere(6 * count)
    stretch = np.linalg.norm(directions / axes, axis=1)
    chosen = rng.random(len(directions)) < stretch / stretch.mean() / 6
    return rng.permutation(directions[chosen] * axes)


def vase(count, seed=0):
    """A body of revolution about z, closed below and above, without mirror plane across z."""
    rng = np.random.default_rng(seed)
    heights = np.linspace(-1, 1, 2_001)
    radii = belly(heights)
    strips = np.hypot(np.diff(heights), np.diff(radii)) * 0.5 * (radii[1:] + radii[:-1])
    strips = np.concatenate([[0.5 * radii[0] ** 2], strips, [0.5 * radii[-1] ** 2]])
    part = rng.choice(len(strips), count, p=strips / strips.sum())
    height = np.interp(part - 1 + rng.random(count), np.arange(len(heights)), heights)
    radius = belly(height)
    lid = (part == 0) | (part == len(strips) - 1)
    radius = np.where(lid, radius * np.sqrt(rng.random(count)), radius)
    turn = rng.uniform(0, 2 * np.pi, count)
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), height], axis=1)


def belly(height):
    """Radius of the vase."""
    return 0.45 + 0.2 * np.cos(2.0 * height + 0.6)


def jug(count, seed=0):
    """The vase with a handle at x > 0: of all its meridians, only y = 0 mirrors the handle."""
    rng = np.random.default_rng(seed)
    body = vase(count, seed)
    major, minor = 0.45, 0.08
    area = 2 * np.pi**2 * major * minor  # of half a torus
    handle = int(count * area / 8.0)
    around, across = rng.uniform(-np.pi / 2, np.pi / 2, handle), rng.uniform(0, 2 * np.pi, handle)
    reach = major + minor * np.cos(across)
    places = [0.5 + reach * np.cos(around), minor * np.sin(across), 0.1 + reach * np.sin(around)]
    places = np.stack(places, axis=1)
    outside = np.hypot(places[:, 0], places[:, 1]) > belly(places[:, 2])
    return np.vstack([body, places[outside]])


def symmetric_cloud(seed=0):
    """Samples of an ellipsoid with normals, each with its exact mirror partner, and the plane."""
    rng = np.random.default_rng(seed)
    normal = rng.normal(size=3)
    plane = np.append(normal / np.linalg.norm(normal), 0.03)
    directions = rng.normal(size=(1_500, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    shape = np.array([0.5, 0.35, 0.25])
    points = directions * shape
    normals = directions / shape
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    points = np.vstack([points, reflect(points, plane)])
    return points, np.vstack([normals, reflect_directions(normals, plane)]), plane


def as_prepared(points, normals):
    """A prepared cloud of these very points and normals, whole, where they are."""
    cloud = prepare(points, normals, 1)
    order = np.random.default_rng(0).permutation(len(points))
    return dataclasses.replace(
        cloud,
        points=points,
        normals=normals,
        oriented=np.ones(len(points), dtype=bool),
        border=np.zeros(len(points), dtype=bool),
        border_distance=np.full(len(points), np.inf),
        rim_plane=None,
        broken_off=NOT_BROKEN,
        samples=order,
        distinctness=np.ones(len(points)),
        relief=np.stack([_native.relief(points, normals, r) for r in RELIEF_RADII], axis=1),
        spacing=float(np.median(cKDTree(points).query(points, k=2)[0][:, 1])),
        field=nearest_field(points, 0.02, 0.1, 10**6),
    )


def no_planes():
    return np.zeros((0, 4))
