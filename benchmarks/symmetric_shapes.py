"""Made shapes with mirror planes, each a function of a seed: statues, vessels, regular bodies.

Up is z.  The plane of bodies with one plane is x = 0, and they face -y.
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
    ellipsoid,
    level_set,
    loft,
    pair,
    prism,
    radial,
)

SIDEWAYS = np.array([[1.0, 0.0, 0.0, 0.0]])
LEVEL = np.array([[0.0, 0.0, 1.0, 0.0]])
POSE = 0.3  # radians by which joints of a posed statue differ
UPRIGHT_AXIS = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


def upright_planes(count: int, first: float = 0.0) -> np.ndarray:
    """Planes through the z axis, evenly turned; ``first`` is the angle of a normal."""
    angles = first + np.pi * np.arange(count) / count
    nothing = np.zeros(count)
    return np.column_stack([np.cos(angles), np.sin(angles), nothing, nothing])


def turned_about_z(angle: float) -> np.ndarray:
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])


# ----------------------------------------------------------------------------------------- statues


def bump_radius(rng, count: int, *, both: bool, tall=(0.3, 0.8), wide=(0.2, 0.45)):
    """Radius of a body of random bumps, on both sides of x = 0 or not."""
    centres = rng.normal(size=(count, 3))
    centres /= np.linalg.norm(centres, axis=1, keepdims=True)
    heights, widths = rng.uniform(*tall, count), rng.uniform(*wide, count)

    def radius(unit):
        total = np.ones(len(unit))
        for centre, height, width in zip(centres, heights, widths, strict=True):
            for side in (1.0, -1.0) if both else (1.0,):
                squares = ((unit - centre * [side, 1.0, 1.0]) ** 2).sum(axis=1)
                total += height * np.exp(-0.5 * squares / width**2)
        return total

    return radius


def bump_statue(seed: int) -> Shape:
    rng = np.random.default_rng([1, seed])
    scale = rng.uniform(0.6, 1.4, 3)
    return Shape("bump_statue", "statue", radial(bump_radius(rng, 6, both=True), scale), SIDEWAYS)


def bust_parts(rng) -> list:
    wide, deep, long = rng.uniform(0.9, 1.1, 3)
    head = 1.05
    parts = [
        ellipsoid((0, 0, head), (0.19 * wide, 0.23 * deep, 0.27 * long)),
        ellipsoid((0, -0.05, head - 0.16), (0.13 * wide, 0.17 * deep, 0.14)),  # jaw
        capsule((0, -0.20 * deep, head + 0.04), (0, -0.29 * deep, head - 0.05), 0.025, 0.045),
        capsule((0, 0.02, 0.9), (0, 0.05, 0.6), 0.11, 0.13),  # neck
        ellipsoid((0, 0.03, 0.38), (0.46 * wide, 0.22, 0.22)),  # shoulders
        ellipsoid((0, -0.06, 0.28), (0.30 * wide, 0.22 * deep, 0.24)),  # chest
        capsule((0, 0.02, 0.14), (0, 0.02, -0.05), 0.16, 0.22),  # foot of the bust
        ellipsoid((0, 0.12, head + 0.10), (0.2 * wide, 0.2, 0.2)),  # hair
        capsule((0, 0.30, head), (0, 0.34, head - 0.05), 0.07),  # knot of hair
    ]
    parts += pair(ellipsoid((0.2 * wide, 0.03, head), (0.03, 0.06, 0.08)))  # ears
    parts += pair(capsule((0.05, -0.2 * deep, head + 0.08), (0.11, -0.17, head + 0.07), 0.03))
    return parts


def bust(seed: int, *, relief: bool = False) -> Shape:
    """With ``relief``, small details on one side: not exact."""
    rng = np.random.default_rng([2, seed])
    parts = bust_parts(rng)
    if relief:
        parts += [
            ellipsoid((0.16, -0.25, 0.34), (0.06, 0.03, 0.06)),  # a brooch
            chain(np.array([[0.17, 0.1, 1.1], [0.2, 0.16, 0.85], [0.22, 0.14, 0.62]]), 0.035),
            capsule((-0.3, -0.1, 0.5), (0.1, -0.24, 0.2), 0.03),  # a fold
        ]
    triangles = level_set(blended(parts), (-0.6, -0.45, -0.35), (0.6, 0.5, 1.45))
    return Shape("bust_relief" if relief else "bust", "statue", triangles, SIDEWAYS)


def limb(start, lengths, swings, sways, radii) -> list:
    """Two links that hang from a place; swing is about x (to the front), sway about y (out)."""
    places = [np.asarray(start, dtype=float)]
    for length, swing, sway in zip(lengths, swings, sways, strict=True):
        down = [np.sin(sway), -np.sin(swing) * np.cos(sway), -np.cos(swing) * np.cos(sway)]
        places.append(places[-1] + length * np.array(down))
    links = zip(places[:-1], places[1:], radii[:-1], radii[1:], strict=True)
    return [capsule(*link) for link in links] + [
        capsule(places[-1], places[-1] + [0.0, -0.10, -0.01], 1.15 * radii[-1])
    ]


def figure_parts(rng, pose: float) -> list:
    """A standing figure; limbs, and a turned head, differ by up to ``pose`` radians a joint."""
    broad, stout = rng.uniform(0.9, 1.15, 2)
    arm_swings, arm_sways = rng.uniform(-0.2, 0.5, 2), rng.uniform(0.15, 0.45, 2)
    leg_swings, leg_sways = rng.uniform(-0.1, 0.15, 2), rng.uniform(0.05, 0.15, 2)
    turn = turned_about_z(1.2 * pose * rng.choice([-1.0, 1.0]))
    parts = [
        ellipsoid((0, 0, 1.32), (0.23 * broad, 0.14 * stout, 0.28)),  # chest
        ellipsoid((0, -0.05, 1.06), (0.17 * stout, 0.16 * stout, 0.18)),  # belly
        ellipsoid((0, 0.05, 0.92), (0.19 * stout, 0.16, 0.15)),  # hips
        capsule((0, 0.02, 1.5), (0, 0, 1.66), 0.065),
        ellipsoid((0, 0, 1.76), (0.10, 0.125, 0.15)),
        ellipsoid(turn @ [0, 0.10, 1.74], (0.08, 0.08, 0.1)),  # hair
        capsule(turn @ [0, -0.1, 1.77], turn @ [0, -0.155, 1.73], 0.025, 0.03),  # nose
    ]
    for side in (1.0, -1.0):
        change = pose * rng.uniform(-1.0, 1.0, 8)
        arm = limb(
            (0.22 * broad, 0, 1.5), (0.3, 0.28), arm_swings + change[:2],
            arm_sways + 0.5 * np.abs(change[2:4]), (0.07, 0.06, 0.05),
        )  # fmt: skip
        leg = limb(
            (0.11 * broad, 0.02, 0.9), (0.43, 0.42), leg_swings + 0.5 * change[4:6],
            leg_sways + 0.2 * np.abs(change[6:]), (0.11, 0.08, 0.06),
        )  # fmt: skip
        for part in arm + leg:
            parts.append(pair(part)[0 if side > 0 else 1])
    return parts


FIGURE_BOX = (-0.95, -0.95, -0.15), (0.95, 0.95, 2.3)


def figure(seed: int, *, posed: bool = False) -> Shape:
    parts = figure_parts(np.random.default_rng([3, seed]), POSE if posed else 0.0)
    triangles = level_set(blended(parts, 0.015), *FIGURE_BOX, cells=110)
    return Shape(
        *(("figure_posed", "posed") if posed else ("figure", "statue")), triangles, SIDEWAYS
    )


def animal_parts(rng, pose: float) -> list:
    """Four legs, a tail and a head, along y; ``pose`` in radians a joint."""
    long, stout, leg = rng.uniform(0.8, 1.2), rng.uniform(0.85, 1.2), rng.uniform(0.8, 1.2)
    ear, nose, tail = rng.uniform(0.8, 1.6), rng.uniform(0.7, 1.4), rng.uniform(0.5, 1.2)
    front, back = -0.42 * long, 0.42 * long
    neck, head = np.array([0.0, front, 0.08]), np.array([0.0, front - 0.22, 0.36])
    turn = turned_about_z(1.5 * pose * rng.choice([-1.0, 1.0]))

    def turned(place):
        return neck + turn @ (np.asarray(place, dtype=float) - neck)

    parts = [
        ellipsoid((0, 0.3 * front, 0), (0.22 * stout, 0.42 * long, 0.24 * stout)),
        ellipsoid((0, 0.7 * back, 0.02), (0.2 * stout, 0.26 * long, 0.21 * stout)),
        capsule(neck, turned(head), 0.14 * stout, 0.10),
        ellipsoid(turned(head), (0.12, 0.12, 0.12)),
        capsule(turned(head), turned(np.add(head, (0, -0.2 * nose, -0.08))), 0.09, 0.055),
    ]
    for side in (1.0, -1.0):
        root = np.add(head, (0.07 * side, 0.02, 0.08))
        tip = np.add(head, (0.10 * side, 0.05, 0.10 + 0.06 * ear))
        parts.append(capsule(turned(root), turned(tip), 0.04, 0.03))
    sway = pose * rng.uniform(-2.0, 2.0)
    bend = np.array([0.0, back + 0.17 * long, 0.1])
    end = bend + tail * np.array([0.3 * np.sin(sway), 0.3 * np.cos(sway), 0.12])
    parts += [capsule((0, back, 0.06), bend, 0.07, 0.05), capsule(bend, end, 0.05, 0.035)]
    for y in (front + 0.1, back - 0.02):
        swing = rng.uniform(-0.15, 0.15, 2)
        for side in (1.0, -1.0):
            swings = swing + 1.2 * pose * rng.uniform(-1, 1, 2)
            links = limb(
                (0.12 * stout, y, -0.08), (0.26 * leg, 0.26 * leg), swings, (0.03, 0.0),
                (0.09, 0.065, 0.055),
            )  # fmt: skip
            parts += [pair(link)[0 if side > 0 else 1] for link in links]
    return parts


ANIMAL_BOX = (-0.62, -1.2, -0.95), (0.62, 1.25, 0.85)


def animal(seed: int, *, posed: bool = False) -> Shape:
    parts = animal_parts(np.random.default_rng([4, seed]), POSE if posed else 0.0)
    triangles = level_set(blended(parts, 0.015), *ANIMAL_BOX, cells=110)
    return Shape(
        *(("animal_posed", "posed") if posed else ("animal", "statue")), triangles, SIDEWAYS
    )


def bird(seed: int) -> Shape:
    rng = np.random.default_rng([5, seed])
    spread, lean = rng.uniform(0.3, 0.8), rng.uniform(0.2, 0.6)
    tail = np.array([0.0, 0.42, -0.32 * np.sin(lean) - 0.1])
    parts = [
        ellipsoid((0, 0, 0), (0.22, 0.28, 0.32)),
        ellipsoid((0, -0.14, 0.42), (0.15, 0.16, 0.15)),
        capsule((0, -0.24, 0.42), (0, -0.42, 0.36), 0.06, 0.025),  # beak
        capsule((0, 0.15, -0.15), tail, 0.13, 0.07),
        capsule((0, 0, -0.2), (0, 0.02, -0.6), 0.08),  # stump that it sits on
        ellipsoid((0, 0.02, -0.68), (0.2, 0.28, 0.09)),
    ]
    elbow = np.array([0.3 * np.sin(spread) + 0.2, 0.08, 0.12])
    tip = np.add(elbow, (0.45 * np.sin(spread), 0.3, -0.32 * np.cos(spread)))
    parts += pair(capsule((0.14, 0.0, 0.14), elbow, 0.08, 0.07))
    parts += pair(capsule(elbow, tip, 0.08, 0.045))
    triangles = level_set(blended(parts), (-0.95, -0.5, -0.8), (0.95, 0.7, 0.65))
    return Shape("bird", "statue", triangles, SIDEWAYS)


# ----------------------------------------------------------------------------------------- vessels

VESSEL_BOX = (-0.85, -1.05, -0.05), (0.85, 1.05, 1.45)


def vessel_field(rng):
    """A body of revolution with a foot, a belly, a neck and a hollow mouth."""
    heights = np.array([0.0, 0.08, 0.2, 0.5, 0.85, 1.05, 1.2])
    radii = np.array([0.28, 0.26, 0.34, 0.48, 0.3, 0.17, 0.24]) * rng.uniform(0.9, 1.1, 7)
    fine = np.linspace(0.0, 1.2, 200)
    profile = np.interp(fine, heights, radii)
    profile = np.convolve(np.pad(profile, 10, mode="edge"), np.full(21, 1 / 21), mode="valid")

    def distance(points):
        radius = np.linalg.norm(points[:, :2], axis=1)
        wall = radius - np.interp(points[:, 2], fine, profile)
        body = np.maximum(0.8 * wall, np.abs(points[:, 2] - 0.6) - 0.6)
        hollow = np.maximum(0.8 * (wall + 0.07), 0.8 - points[:, 2])
        return np.maximum(body, -hollow)

    return distance


def arc(start, end, bulge: float, count: int = 12) -> np.ndarray:
    """Half an ellipse in the plane x = 0 between two places, bulging along -y or +y."""
    share = np.linspace(0.0, np.pi, count)
    start, end = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    middle, half = (start + end) / 2, (start - end) / 2
    away = np.array([0.0, bulge, 0.0])
    return middle + np.cos(share)[:, np.newaxis] * half + np.sin(share)[:, np.newaxis] * away


def vessel(seed: int, name: str) -> Shape:
    """Jug and vase have one handle, the teapot a spout as well, the amphora two handles."""
    rng = np.random.default_rng([6, seed])
    body = vessel_field(rng)
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
