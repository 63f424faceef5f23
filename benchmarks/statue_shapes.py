"""Made statues, each a function of a seed: bumps, a bust, a figure, an animal, a bird.

Up is z, and they face -y.  The plane is x = 0; of a posed statue it is that of the trunk.
"""

from __future__ import annotations

import numpy as np
from shape_surfaces import Shape, blended, capsule, chain, ellipsoid, level_set, pair, radial

SIDEWAYS = np.array([[1.0, 0.0, 0.0, 0.0]])
MUCH = 0.25  # radians a joint


def turned_about_z(angle: float) -> np.ndarray:
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])


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


def posed(name: str, pose: float, triangles) -> Shape:
    if pose == 0.0:
        return Shape(name, "statue", triangles, SIDEWAYS)
    name = f"{name}_posed_more" if pose > MUCH else f"{name}_posed"
    return Shape(name, "posed", triangles, SIDEWAYS)


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


def figure(seed: int, *, pose: float = 0.0) -> Shape:
    parts = figure_parts(np.random.default_rng([3, seed]), pose)
    triangles = level_set(blended(parts, 0.015), *FIGURE_BOX, cells=110)
    return posed("figure", pose, triangles)


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


def animal(seed: int, *, pose: float = 0.0) -> Shape:
    parts = animal_parts(np.random.default_rng([4, seed]), pose)
    triangles = level_set(blended(parts, 0.015), *ANIMAL_BOX, cells=110)
    return posed("animal", pose, triangles)


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
