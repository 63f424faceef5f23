"""Made shapes without a mirror plane, each a function of a seed.  Up is z."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation
from shape_surfaces import (
    Shape,
    blended,
    box_corners,
    capsule,
    convex_parts,
    ellipsoid,
    level_set,
    loft,
    radial,
    tube,
)
from statue_shapes import (
    ANIMAL_BOX,
    animal_parts,
    bump_radius,
    bust_parts,
    figure_parts,
    turned_about_z,
)

KIND = "asymmetric"
FARTHEST = 2.2  # of a rock, before it is stretched


def bumps(seed: int, variant: int) -> Shape:
    """Bodies of random bumps: few and broad, many and narrow, stretched."""
    rng = np.random.default_rng([21, variant, seed])
    count, tall, wide = [(5, (0.4, 1.0), (0.3, 0.5)), (10, (0.4, 0.9), (0.15, 0.3)),
                         (6, (0.3, 0.8), (0.2, 0.45))][variant]  # fmt: skip
    scale = rng.uniform(0.6, 1.4, 3) * ([1.0, 1.0, 2.0] if variant == 2 else [1.0, 1.0, 1.0])
    turn = Rotation.random(random_state=int(rng.integers(2**31))).as_matrix()
    triangles = radial(bump_radius(rng, count, both=False, tall=tall, wide=wide)) @ turn * scale
    return Shape(f"bumps_{variant}", KIND, triangles)


def boxes(seed: int, *, turned: bool) -> Shape:
    """A heap of boxes, parallel like a building or turned."""
    rng = np.random.default_rng([22, int(turned), seed])
    parts, place = [], np.zeros(3)
    for _ in range(6):
        half = rng.uniform(0.15, 0.6, 3)
        turn = None
        if turned:
            turn = Rotation.random(random_state=int(rng.integers(2**31))).as_matrix()
        parts.append(box_corners(place, half, turn))
        step = rng.choice([-1.0, 1.0], 3) * rng.uniform(0.5, 1.0, 3) * half
        place = place + step
    triangles, hidden = convex_parts(parts)
    return Shape("boxes_turned" if turned else "boxes", KIND, triangles, hidden=hidden)


def ellipsoids(seed: int) -> Shape:
    rng = np.random.default_rng([23, seed])
    parts, place = [], np.zeros(3)
    for _ in range(7):
        turn = Rotation.random(random_state=int(rng.integers(2**31))).as_matrix()
        parts.append(ellipsoid(place, rng.uniform(0.12, 0.45, 3), turn))
        way = rng.normal(size=3)
        place = place * 0.5 + way / np.linalg.norm(way) * rng.uniform(0.35, 0.6)
    return Shape("ellipsoids", KIND, level_set(blended(parts), [-1.6] * 3, [1.6] * 3))


def branches(seed: int) -> Shape:
    """A tree of capsules."""
    rng = np.random.default_rng([24, seed])
    tips, parts = [(np.zeros(3), np.array([0.0, 0.0, 1.0]), 0.16)], []
    while len(parts) < 13:
        start, way, radius = tips.pop(0)
        end = start + way * rng.uniform(0.4, 0.65)
        parts.append(capsule(start, end, radius, 0.75 * radius))
        for _ in range(2):
            bent = way + rng.normal(0.0, 0.75, 3)
            tips.append((end, bent / np.linalg.norm(bent), 0.75 * radius))
    field = blended(parts, 0.015)
    return Shape("branches", KIND, level_set(field, (-1.7, -1.7, -0.8), (1.7, 1.7, 2.4), cells=110))


def dancer(seed: int) -> Shape:
    """A figure whose trunk is bent, with every limb and the head in a pose of its own."""
    rng = np.random.default_rng([25, seed])

    def way(swing, sway):
        down = [np.sin(sway), -np.sin(swing) * np.cos(sway), -np.cos(swing) * np.cos(sway)]
        return np.array(down)

    side = rng.choice([-1.0, 1.0])
    lean = side * rng.uniform(0.35, 0.55)
    hips, twist = np.array([0.0, 0.0, 1.0]), turned_about_z(side * rng.uniform(0.4, 0.7))
    waist = hips + 0.25 * np.array([np.sin(lean), 0.0, np.cos(lean)])
    chest = waist + 0.25 * np.array([np.sin(0.4 * lean), -0.1, np.cos(0.4 * lean)])
    head = chest + 0.38 * np.array([-np.sin(lean), -0.2, np.cos(lean)])
    parts = [
        capsule(hips, waist, 0.16, 0.14), capsule(waist, chest, 0.15, 0.17),
        capsule(chest, head, 0.07), ellipsoid(head, (0.11, 0.13, 0.15)),
        capsule(head, head + twist @ [0.02, -0.16, -0.02], 0.03),
    ]  # fmt: skip
    raised, low = rng.uniform(1.8, 2.6), rng.uniform(0.1, 0.5)
    for hand, (swing, sway) in ((side, (0.3, raised)), (-side, (1.0, low))):
        shoulder = chest + twist @ [0.2 * hand, 0.0, 0.08]
        elbow = shoulder + 0.3 * way(swing, hand * sway)
        wrist = elbow + 0.28 * way(swing + rng.uniform(0.3, 1.2), hand * (sway + 0.3))
        parts += [capsule(shoulder, elbow, 0.075, 0.06), capsule(elbow, wrist, 0.06, 0.05)]
    for foot, (swing, bend) in ((side, (0.1, -0.1)), (-side, (rng.uniform(0.8, 1.2), -1.0))):
        hip = np.add(hips, (0.11 * foot, 0.0, -0.05))
        knee = hip + 0.43 * way(swing, foot * rng.uniform(0.05, 0.5))
        ankle = knee + 0.42 * way(swing + bend, foot * 0.1)
        parts += [capsule(hip, knee, 0.11, 0.08), capsule(knee, ankle, 0.08, 0.06)]
        parts.append(capsule(ankle, np.add(ankle, (0.05 * foot, -0.13, -0.02)), 0.06))
    field = blended(parts, 0.015)
    return Shape("dancer", KIND, level_set(field, (-1.2, -1.2, -0.15), (1.2, 1.0, 2.4), cells=110))


def twisted_prism(seed: int, sides: int) -> Shape:
    """An n-gon, or for five a star, turned along its axis and thinner at the top."""
    rng = np.random.default_rng([26, sides, seed])
    twist, taper = rng.choice([-1, 1]) * rng.uniform(1.0, 1.8), rng.uniform(0.0, 0.4)
    height = rng.uniform(1.6, 2.4)
    angles = np.linspace(0, 2 * np.pi, 60 * sides, endpoint=False)
    sector = 2 * np.pi / sides
    radius = np.cos(sector / 2) / np.cos(angles % sector - sector / 2)
    if sides == 5:
        radius = 0.55 + 0.45 * np.abs((angles % sector) / sector * 2 - 1)
    along = np.linspace(0, 1, 160)[:, np.newaxis]
    turn, wide = angles + twist * along, 0.6 * (1 - taper * along) * radius
    level = np.broadcast_to(height * along, turn.shape)
    rings = np.stack([wide * np.cos(turn), wide * np.sin(turn), level], axis=-1)
    return Shape(f"twisted_{sides}", KIND, loft(rings))


def bent_animal(seed: int) -> Shape:
    """An animal bent sideways as if lying curled."""
    rng = np.random.default_rng([27, seed])
    corners = level_set(blended(animal_parts(rng, 0.0), 0.015), *ANIMAL_BOX, cells=110)
    bend = rng.choice([-1, 1]) * rng.uniform(0.9, 1.3)  # radians a unit of length
    x, y, z = np.moveaxis(corners, -1, 0)
    away = 1 / bend - x
    bent = np.stack([1 / bend - away * np.cos(bend * y), away * np.sin(bend * y), z], axis=-1)
    return Shape("bent_animal", KIND, bent)


def sheared_animal(seed: int) -> Shape:
    rng = np.random.default_rng([28, seed])
    corners = level_set(blended(animal_parts(rng, 0.0), 0.015), *ANIMAL_BOX, cells=110)
    shear = np.eye(3)
    shear[0, 1:] = rng.choice([-1, 1], 2) * rng.uniform(0.45, 0.7, 2)
    return Shape("sheared_animal", KIND, corners @ shear.T)


def twisted_bust(seed: int) -> Shape:
    rng = np.random.default_rng([29, seed])
    box = (-0.6, -0.45, -0.35), (0.6, 0.5, 1.45)
    corners = level_set(blended(bust_parts(rng)), *box)
    angle = rng.choice([-1, 1]) * rng.uniform(1.2, 1.8) * corners[..., 2]
    lean = rng.choice([-1, 1]) * 0.3 * corners[..., 2] ** 2
    x, y, z = np.moveaxis(corners, -1, 0)
    cosine, sine = np.cos(angle), np.sin(angle)
    turned = np.stack([cosine * x - sine * y + lean, sine * x + cosine * y, z], axis=-1)
    return Shape("twisted_bust", KIND, turned)


def pinwheel(seed: int, blades: int) -> Shape:
    """Blades like saw teeth on a cone, leaning: rotations of order n and nothing else."""
    rng = np.random.default_rng([30, blades, seed])
    lean, steep = rng.choice([-1, 1]) * rng.uniform(0.5, 0.9), rng.uniform(0.3, 0.6)
    angles = np.linspace(0, 2 * np.pi, 80 * blades, endpoint=False)
    phase = (angles * blades / (2 * np.pi)) % 1.0
    tooth = np.where(phase < 0.85, phase / 0.85, (1 - phase) / 0.15)
    along = np.linspace(0, 1, 80)[:, np.newaxis]
    radius = (0.45 + 0.55 * tooth) * (1 - steep * along)
    turn = (angles if lean > 0 else -angles)[:: 1 if lean > 0 else -1] + lean * along
    radius = radius if lean > 0 else radius[:, ::-1]
    level = np.broadcast_to(rng.uniform(0.5, 0.9) * along, turn.shape)
    rings = np.stack([radius * np.cos(turn), radius * np.sin(turn), level], axis=-1)
    return Shape(f"pinwheel_{blades}", KIND, loft(rings))


def screw(seed: int) -> Shape:
    """A deep thread round a core, and a head on one side."""
    rng = np.random.default_rng([31, seed])
    turns, hand = rng.uniform(2.0, 3.5), rng.choice([-1, 1])
    angles = np.linspace(0, 2 * np.pi, 240, endpoint=False)
    along = np.linspace(0, 1, 260)[:, np.newaxis]
    wave = np.cos(angles - hand * 2 * np.pi * turns * along)
    wide = 0.32 + 0.16 * wave
    wide = np.where(along > 0.9, 0.55 + 0.1 * np.cos(angles - 1.0), wide)
    level = np.broadcast_to(1.8 * along, wide.shape)
    rings = np.stack([wide * np.cos(angles), wide * np.sin(angles), level], axis=-1)
    return Shape("screw", KIND, loft(rings))


def spring(seed: int) -> Shape:
    rng = np.random.default_rng([32, seed])
    turns, hand = rng.uniform(1.6, 2.6), rng.choice([-1, 1])
    share = np.linspace(0, 1, 300)
    angle = hand * 2 * np.pi * turns * share
    curve = np.column_stack([0.6 * np.cos(angle), 0.6 * np.sin(angle), 0.42 * turns * share])
    return Shape("spring", KIND, tube(curve, np.full(300, rng.uniform(0.1, 0.15))))


def stair(seed: int) -> Shape:
    """A winding stair round a post."""
    rng = np.random.default_rng([33, seed])
    hand, count = rng.choice([-1, 1]), int(rng.integers(10, 15))
    rise, turn = rng.uniform(0.14, 0.2), hand * rng.uniform(0.35, 0.5)
    parts = [box_corners((0, 0, count * rise / 2), (0.12, 0.12, count * rise / 2 + 0.1))]
    for step in range(count):
        slab = box_corners((0.45, 0, 0), (0.42, 0.16, 0.06))
        parts.append(slab @ turned_about_z(step * turn).T + [0, 0, step * rise])
    triangles, hidden = convex_parts(parts)
    return Shape("stair", KIND, triangles, hidden=hidden)


def terrain(seed: int) -> Shape:
    """Hills on a crooked patch of land, closed below."""
    rng = np.random.default_rng([34, seed])
    angles = np.linspace(0, 2 * np.pi, 300, endpoint=False)
    reach = 1 + sum(
        rng.uniform(0.1, 0.25) * np.cos(k * angles + rng.uniform(0, 6.3)) for k in (1, 2, 3)
    )
    edge = reach[:, np.newaxis] * np.column_stack([np.cos(angles), np.sin(angles)])
    hills = [(rng.uniform(-0.8, 0.8, 2), rng.uniform(0.2, 0.8), rng.uniform(0.2, 0.4))
             for _ in range(9)]  # fmt: skip

    def height(xy):
        squares = [((xy - centre) ** 2).sum(axis=-1) / width**2 for centre, _, width in hills]
        return 0.3 + sum(h[1] * np.exp(-0.5 * s) for h, s in zip(hills, squares, strict=True))

    shrink = np.linspace(1, 0.01, 120)[:, np.newaxis, np.newaxis]
    top = shrink * edge
    below = np.broadcast_to(edge, (2, *edge.shape))
    levels = np.stack([np.zeros(300), 0.5 * height(edge)])
    walls = np.concatenate([below, levels[..., np.newaxis]], axis=-1)
    land = np.concatenate([top, height(top)[..., np.newaxis]], axis=-1)
    return Shape("terrain", KIND, loft(np.concatenate([walls, land])))


def knot(seed: int, around: int, along: int) -> Shape:
    """A torus knot, which is never its own mirror image."""
    rng = np.random.default_rng([35, around, along, seed])
    share = np.linspace(0, 2 * np.pi, 480, endpoint=False)
    small, hand = rng.uniform(0.4, 0.5), rng.choice([-1, 1])
    away = 1 + small * np.cos(along * share)
    turn = around * share
    curve = np.column_stack(
        [away * np.cos(turn), away * np.sin(turn), hand * small * np.sin(along * share)]
    )
    stretch = np.sqrt(rng.uniform(0.6, 1.6, 3))
    radius = 0.16 if along < 5 else 0.12
    return Shape(
        f"knot_{around}_{along}", KIND, tube(curve * stretch, np.full(480, radius), closed=True)
    )


def snail(seed: int, *, tall: bool) -> Shape:
    """A shell: a tube that winds outwards and down while it widens."""
    rng = np.random.default_rng([36, int(tall), seed])
    turns, growth = rng.uniform(2.0, 2.8), rng.uniform(0.14, 0.2)
    hand, drop = rng.choice([-1, 1]), 2.4 if tall else 0.9
    angle = np.linspace(0, 2 * np.pi * turns, 400)
    size = np.exp(growth * (angle - angle[-1]))
    curve = np.column_stack([np.cos(angle) * size, hand * np.sin(angle) * size, -drop * size])
    return Shape("shell" if tall else "snail", KIND, tube(curve, 0.5 * size))


def rock(seed: int, count: int) -> Shape:
    """The hull of random points, rounded: a soft minimum over its planes."""
    rng = np.random.default_rng([37, count, seed])
    normals = rng.normal(size=(count, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.concatenate([normals, [[0, 0, -1.0]]])
    depth = rng.uniform(0.35, 1.0, len(normals))
    stretch = rng.uniform(0.6, 1.5, 3)

    def radius(unit):
        inverse = np.maximum(unit @ normals.T / depth, 1e-3)
        return ((inverse**14).sum(axis=1) + FARTHEST**-14) ** (-1 / 14)

    return Shape(f"rock_{count}", KIND, radial(radius, stretch))


def striding(seed: int) -> Shape:
    """A figure so posed that no plane is left."""
    rng = np.random.default_rng([38, seed])
    corners = level_set(
        blended(figure_parts(rng, 1.0), 0.015), (-1.2, -1.3, -0.3), (1.2, 1.3, 2.4), cells=110
    )
    lean = rng.choice([-1, 1]) * rng.uniform(0.18, 0.28)
    corners = corners + lean * corners[..., 2:] ** 2 * np.array([1.0, 0.0, 0.0])
    return Shape("striding", KIND, corners)
