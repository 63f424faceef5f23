"""The made shapes: asymmetric ones, statues, vessels, bodies with several planes or an axis.

    python benchmarks/shapes.py [--names NAME ...] [--seeds 0 1]

prints for each shape how far its mirror images lie off it (95th percentile, % of the diagonal): for
true planes the largest, for a shape without a plane the smallest over 300 planes and the
refinements of the best.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from functools import lru_cache, partial

import asymmetric_shapes as a
import numpy as np
import regular_shapes as r
import statue_shapes as s
from mirror_icp import fibonacci_normals, mirror_icp
from scipy.spatial import cKDTree
from shape_surfaces import Shape

ASYMMETRIC: dict[str, Callable[[int], Shape]] = {
    **{f"bumps_{k}": partial(a.bumps, variant=k) for k in range(3)},
    "boxes": partial(a.boxes, turned=False),
    "boxes_turned": partial(a.boxes, turned=True),
    "ellipsoids": a.ellipsoids,
    "branches": a.branches,
    "dancer": a.dancer,
    "striding": a.striding,
    **{f"twisted_{k}": partial(a.twisted_prism, sides=k) for k in (3, 4, 5)},
    "bent_animal": a.bent_animal,
    "sheared_animal": a.sheared_animal,
    "twisted_bust": a.twisted_bust,
    **{f"pinwheel_{k}": partial(a.pinwheel, blades=k) for k in range(2, 8)},
    "screw": a.screw,
    "spring": a.spring,
    "stair": a.stair,
    "terrain": a.terrain,
    "knot_2_3": partial(a.knot, around=2, along=3),
    "knot_2_5": partial(a.knot, around=2, along=5),
    "knot_3_4": partial(a.knot, around=3, along=4),
    "snail": partial(a.snail, tall=False),
    "shell": partial(a.snail, tall=True),
    "rock_9": partial(a.rock, count=9),
    "rock_14": partial(a.rock, count=14),
}
STATUES: dict[str, Callable[[int], Shape]] = {
    "bump_statue": s.bump_statue,
    "bust": s.bust,
    "bust_relief": partial(s.bust, relief=True),
    "figure": s.figure,
    "figure_posed": partial(s.figure, pose=0.18),
    "figure_posed_more": partial(s.figure, pose=0.35),
    "animal": s.animal,
    "animal_posed": partial(s.animal, pose=0.18),
    "animal_posed_more": partial(s.animal, pose=0.35),
    "bird": s.bird,
}
VESSELS: dict[str, Callable[[int], Shape]] = {
    name: partial(r.vessel, name=name) for name in ("jug", "teapot", "vase_one_handle", "amphora")
}
REGULAR: dict[str, Callable[[int], Shape]] = {
    "box": r.box,
    "cube": r.cube,
    **{f"star_{k}": partial(r.star_prism, points=k) for k in (4, 5, 6)},
    "cross": r.cross,
    "table": r.table,
    "chair": r.chair,
    "cylinder": r.cylinder,
    "torus": r.torus,
    "revolution": r.revolution,
}
SYMMETRIC = {**STATUES, **VESSELS, **REGULAR}
SHAPES = {**SYMMETRIC, **ASYMMETRIC}


DIRECTIONS = 300
LEAST_GAP = 3.0  # % of the diagonal: bodies nearer to symmetric by chance are drawn again
BY_CHANCE = ("bumps", "boxes", "ellipsoids", "branches", "terrain", "rock", "sheared")


@lru_cache(maxsize=8)
def made(name: str, seed: int) -> Shape:
    """Return a shape by its name; the same for the same seed."""
    shape = SHAPES[name](seed)
    if name.startswith(BY_CHANCE):
        while nearest_to_symmetric(shape)[0] < LEAST_GAP:
            seed += 1_000_000
            shape = SHAPES[name](seed)
    return shape


def mirror_gap(shape: Shape, planes: np.ndarray, count: int = 1500) -> np.ndarray:
    """How far mirrored samples lie off the shape: 95th percentile, % of the diagonal, (k,)."""
    surface = shape.sample(60_000, np.random.default_rng(1))[0]
    points = shape.sample(count, np.random.default_rng(2))[0]
    tree, diagonal = cKDTree(surface), np.linalg.norm(np.ptp(surface, axis=0))
    heights = planes[:, :3] @ points.T + planes[:, 3:]
    images = points - 2.0 * heights[..., np.newaxis] * planes[:, np.newaxis, :3]
    distances = tree.query(images)[0]
    return 100 * np.quantile(distances, 0.95, axis=1) / diagonal


def nearest_to_symmetric(shape: Shape) -> tuple[float, np.ndarray]:
    """The smallest mirror gap of 300 planes through the middle, the best refined by mirror ICP."""
    points, normals = shape.sample(8000, np.random.default_rng(3))
    scale = np.linalg.norm(np.ptp(points, axis=0))
    directions = fibonacci_normals(DIRECTIONS)
    starts = np.column_stack([directions, -directions @ points.mean(axis=0)])
    starts = starts[np.argsort(mirror_gap(shape, starts, 300))[:20]]
    tree, queries = cKDTree(points), (points[:1000], normals[:1000])
    tolerances = scale * np.geomspace(0.1, 0.03, 20)
    fitted = [mirror_icp(queries, (points, normals), tree, p, tolerances) for p in starts]
    planes = np.concatenate([starts, fitted])
    gaps = mirror_gap(shape, planes)
    return float(gaps.min()), planes[np.argmin(gaps)]


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--names", nargs="+", choices=list(SHAPES), default=list(SHAPES))
    parser.add_argument("--seeds", nargs="+", type=int, default=[0])
    options = parser.parse_args()
    for name in options.names:
        for seed in options.seeds:
            shape = made(name, seed)
            line = f"{name:16s} {seed:4d} {shape.kind:10s} {len(shape.planes)} planes"
            if shape.symmetric:
                through = r.upright_planes(5) if shape.axis is not None else shape.planes[:0]
                gaps = mirror_gap(shape, np.concatenate([shape.planes, through]))
                print(f"{line}: at most {gaps.max():.2f} % off", flush=True)
            else:
                gap, plane = nearest_to_symmetric(shape)
                print(f"{line}: at least {gap:.2f} % off, at {np.round(plane, 2)}", flush=True)


if __name__ == "__main__":
    main()
