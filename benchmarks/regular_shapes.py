"""Made vessels, bodies of revolution and bodies with several planes, each a function of a seed.

Up is z; a single plane is x = 0.
"""

from __future__ import annotations

import numpy as np
from shape_surfaces import (
    Shape,
    blended,
    box_corners,
    capsule,
    chain,
    convex_parts,
    level_set,
    loft,
    prism,
)

SIDEWAYS = np.array([[1.0, 0.0, 0.0, 0.0]])
LEVEL = np.array([[0.0, 0.0, 1.0, 0.0]])
UPRIGHT_AXIS = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


def upright_planes(count: int, first: float = 0.0) -> np.ndarray:
    """Planes through the z axis, evenly turned; ``first`` is the angle of a normal."""
    angles = first + np.pi * np.arange(count) / count
    nothing = np.zeros(count)
    return np.column_stack([np.cos(angles), np.sin(angles), nothing, nothing])


VESSEL_BOX = (-0.85, -1.05, -0.05), (0.85, 1.05, 1.45)


def vessel_field(rng, *, hollow: bool):
    """A body of revolution with a foot, a belly and a neck, hollow from the mouth down or not."""
    heights = np.array([0.0, 0.08, 0.2, 0.5, 0.85, 1.05, 1.2])
    radii = np.array([0.28, 0.26, 0.34, 0.48, 0.3, 0.17, 0.24]) * rng.uniform(0.9, 1.1, 7)
    fine = np.linspace(0.0, 1.2, 200)
    profile = np.interp(fine, heights, radii)
    profile = np.convolve(np.pad(profile, 10, mode="edge"), np.full(21, 1 / 21), mode="valid")

    def distance(points):
        radius = np.linalg.norm(points[:, :2], axis=1)
        wall = radius - np.interp(points[:, 2], fine, profile)
        body = np.maximum(0.8 * wall, np.abs(points[:, 2] - 0.6) - 0.6)
        inner = np.maximum(0.8 * (wall + 0.07), 0.8 - points[:, 2])
        return np.maximum(body, -inner) if hollow else body

    return distance


def arc(start, end, bulge: float, count: int = 12) -> np.ndarray:
    """Half an ellipse in the plane x = 0 between two places, bulging along -y or +y."""
    share = np.linspace(0.0, np.pi, count)
    start, end = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    middle, half = (start + end) / 2, (start - end) / 2
    away = np.array([0.0, bulge, 0.0])
    return middle + np.cos(share)[:, np.newaxis] * half + np.sin(share)[:, np.newaxis] * away


def vessel(seed: int, name: str) -> Shape:
    """Jug (hollow) and vase have one handle, the teapot a spout, the amphora (hollow) two."""
    rng = np.random.default_rng([6, seed])
    body = vessel_field(rng, hollow=name in ("jug", "amphora"))
    width, reach = rng.uniform(0.04, 0.06), rng.uniform(0.3, 0.45)
    planes = SIDEWAYS
    low, high = (0, 0.36, 0.45), (0, 0.18, 1.08)
    if name == "vase_one_handle":
        parts = [chain(arc(low, high, reach), width)]
    elif name == "jug":
        lip = capsule((0, -0.16, 1.12), (0, -0.36, 1.2), 0.09, 0.05)
        parts = [chain(arc((0, 0.4, 0.3), (0, 0.2, 1.1), reach), width), lip]
    elif name == "teapot":
        parts = [
            chain(arc((0, 0.36, 0.3), (0, 0.28, 0.85), reach), width),
            capsule((0, -0.35, 0.4), (0, -0.85, 0.95), 0.12, 0.06),
            capsule((0, 0, 1.2), (0, 0, 1.3), 0.07),  # knob of the lid
        ]
    else:
        flip = np.array([1.0, -1.0, 1.0])
        parts = [chain(arc(low, high, reach) * sign, width) for sign in (1.0, flip)]
        planes = upright_planes(2)
    return Shape(name, "vessel", level_set(blended([body, *parts], 0.01), *VESSEL_BOX), planes)


def revolution(seed: int) -> Shape:
    """A turned body: every plane through its axis is true."""
    rng = np.random.default_rng([7, seed])
    along = np.linspace(0.0, 1.0, 120)
    radius = 0.35 + 0.1 * along
    for _ in range(4):
        height, width = rng.uniform(-0.12, 0.25), rng.uniform(0.05, 0.15)
        radius = radius + height * np.exp(-0.5 * ((along - rng.random()) / width) ** 2)
    return Shape("revolution", "round", turned(radius, 1.6 * along), axis=UPRIGHT_AXIS)


def turned(radius, height, columns: int = 360) -> np.ndarray:
    angles = np.linspace(0, 2 * np.pi, columns, endpoint=False)
    rings = [radius[:, np.newaxis] * wave(angles) for wave in (np.cos, np.sin)]
    return loft(np.stack([*rings, np.broadcast_to(height[:, np.newaxis], rings[0].shape)], -1))


def cylinder(seed: int) -> Shape:
    half = np.random.default_rng([8, seed]).uniform(0.6, 1.2)
    height = np.array([-half, half])
    triangles = turned(np.full(2, 0.5), height)
    return Shape("cylinder", "round", triangles, LEVEL, UPRIGHT_AXIS)


# ---------------------------------------------------------------------------------- several planes


def convex_shape(name: str, kind: str, parts: list[np.ndarray], planes: np.ndarray) -> Shape:
    triangles, hidden = convex_parts(parts)
    return Shape(name, kind, triangles, planes, hidden=hidden if len(parts) > 1 else None)


def box(seed: int) -> Shape:
    sides = np.cumprod(np.random.default_rng([9, seed]).uniform(1.25, 1.6, 3))
    return convex_shape("box", "several", [box_corners((0, 0, 0), sides)], np.eye(3, 4))


def cube(seed: int) -> Shape:  # all cubes are alike
    axes = np.eye(3)
    diagonal = [axes[a] + sign * axes[b] for a, b in ((0, 1), (0, 2), (1, 2)) for sign in (1, -1)]
    normals = np.concatenate([axes, np.array(diagonal) / np.sqrt(2.0)])
    planes = np.column_stack([normals, np.zeros(9)])
    return convex_shape("cube", "several", [box_corners((0, 0, 0), (1, 1, 1))], planes)


def star_prism(seed: int, points: int) -> Shape:
    rng = np.random.default_rng([10, points, seed])
    angles = np.pi * np.arange(2 * points) / points
    radius = np.where(np.arange(2 * points) % 2, rng.uniform(0.45, 0.6), 1.0)
    tips = radius[:, np.newaxis] * np.column_stack([np.cos(angles), np.sin(angles)])
    high = rng.uniform(0.2, 0.4)
    parts = [
        prism(np.array([[0.0, 0.0], tips[k - 1], tips[k], tips[k + 1]]), -high, high)
        for k in range(0, 2 * points - 1, 2)
    ]
    planes = np.concatenate([upright_planes(points, np.pi / 2), LEVEL])
    return convex_shape(f"star_{points}", "several", parts, planes)


def cross(seed: int) -> Shape:
    """A Latin cross: sideways, and front to back."""
    rng = np.random.default_rng([11, seed])
    wide, high = rng.uniform(0.5, 0.7), rng.uniform(1.0, 1.3)
    parts = [
        box_corners((0, 0, 0), (0.16, 0.14, high)),
        box_corners((0, 0, 0.35 * high), (wide, 0.12, 0.15)),
    ]
    return convex_shape("cross", "several", parts, np.eye(2, 4))


def table(seed: int) -> Shape:
    rng = np.random.default_rng([12, seed])
    long, wide = rng.uniform(0.9, 1.2), rng.uniform(0.5, 0.7)
    parts = [box_corners((0, 0, 0.7), (long, wide, 0.06))]
    for x in (-1, 1):
        for y in (-1, 1):
            leg = (x * (long - 0.15), y * (wide - 0.15), 0.33)
            parts.append(box_corners(leg, (0.07, 0.07, 0.33)))
    return convex_shape("table", "several", parts, np.eye(2, 4))


def chair(seed: int) -> Shape:
    rng = np.random.default_rng([13, seed])
    wide, high = rng.uniform(0.4, 0.5), rng.uniform(0.45, 0.65)
    parts = [
        box_corners((0, 0, 0.5), (wide, 0.45, 0.06)),
        box_corners((0, 0.41, 0.54 + high), (wide, 0.05, high)),
    ]
    for x in (-1, 1):
        for y in (-1, 1):
            parts.append(box_corners((x * (wide - 0.08), y * 0.36, 0.23), (0.05, 0.05, 0.24)))
    return convex_shape("chair", "several", parts, SIDEWAYS)


def torus(seed: int) -> Shape:
    small = np.random.default_rng([14, seed]).uniform(0.2, 0.45)
    angles = np.linspace(0, 2 * np.pi, 90, endpoint=False)
    rings = np.linspace(0, 2 * np.pi, 240, endpoint=False)[:, np.newaxis]
    away, height = 1 + small * np.cos(angles), small * np.sin(angles)
    surface = [away * np.cos(rings), away * np.sin(rings), np.broadcast_to(height, (240, 90))]
    triangles = loft(np.stack(surface, axis=-1)[:, ::-1], closed=True)
    return Shape("torus", "round", triangles, LEVEL, UPRIGHT_AXIS)
