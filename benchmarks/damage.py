"""Damage of sampled shapes with a known answer: what a scan of a statue lacks, and what it adds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import ConvexHull, cKDTree
from scipy.spatial.transform import Rotation
from shape_surfaces import Shape

NEIGHBOURS = 10  # of the graph on which a hole grows
FLIP = 10**2.2  # radius of the sphere of hidden point removal / farthest point
VIEWS, ARC = 3, np.radians(100.0)  # of an occluded scan
EYE_DISTANCE = 2.5  # diagonals
MOST_GROWN = 30_000  # points among which holes grow; those of a larger cloud follow the nearest
BOX_MARGIN = 1.2  # box of the outliers / box of the scan


@dataclass(frozen=True)
class Damage:
    """What happens to a cloud of ``count`` samples; lengths in % of the diagonal."""

    removal: str = "region"  # region, cut, occlusion, view or none
    share: float = 0.25  # removed by a region or a cut
    blobs: int = 1  # regions
    noise: float = 0.05  # standard deviation along the normal
    outliers: float = 0.0  # share of the samples
    plinth: bool = False
    uneven: float = 1.0  # highest / lowest density
    count: int = 7000
    posed: bool = True  # turned, moved and scaled


CONDITIONS = {
    "r25": Damage(),
    "r25n05": Damage(noise=0.5),
    "r35o20pl": Damage(share=0.35, noise=0.5, outliers=0.2, plinth=True),
    "r50": Damage(share=0.5),
    "cut50": Damage(removal="cut", share=0.5),
    "occl": Damage(removal="occlusion", count=12_000),
    "blobs": Damage(share=0.3, blobs=3),
    "uneven": Damage(share=0.2, uneven=5.0),
    "sparse": Damage(count=1500),
    "view": Damage(removal="view", count=24_000),
}


@dataclass(frozen=True, eq=False)
class Scan:
    """A damaged cloud in a random pose, and what is true of it."""

    points: np.ndarray  # (n, 3)
    planes: np.ndarray  # (k, 4)  true planes
    axis: np.ndarray | None  # (2, 3)  point and direction, of a body of revolution
    centre: np.ndarray  # (3,)  of the whole object's box
    diagonal: float


def damaged(shape: Shape, damage: Damage, seed: int) -> Scan:
    """Sample a shape and damage it; the same for the same seed."""
    rng = np.random.default_rng([seed, sum(shape.name.encode())])
    low, high = shape.box
    diagonal = float(np.linalg.norm(high - low))
    centre = (low + high) / 2
    points, normals = shape.sample(round(damage.uneven * damage.count), rng)
    if damage.uneven > 1.0:
        kept = rng.permutation(len(points))
        density = damage.uneven ** -ranks(waves(points, 0.5 * diagonal, rng))
        kept = kept[rng.random(len(kept)) < density[kept]][: damage.count]
        points, normals = points[kept], normals[kept]
    plane = side_plane(shape, centre, rng)
    kept = remaining(points, normals, plane, damage, (shape, centre, diagonal), rng)
    spread = damage.noise / 100 * diagonal
    scan = points[kept] + spread * rng.normal(size=(kept.sum(), 1)) * normals[kept]
    if damage.plinth:
        scan = np.concatenate([scan, plinth(points, shape, rng, spread)])
    if damage.outliers > 0.0:
        scan = np.concatenate([scan, stray(scan, round(damage.outliers * len(points)), rng)])
    scan = rng.permutation(scan)
    if not damage.posed:
        return Scan(scan, shape.planes, shape.axis, centre, diagonal)
    return posed(scan, shape, centre, diagonal, rng)


def side_plane(shape: Shape, centre, rng) -> np.ndarray:
    """A plane (4,) on whose positive side the damage is: a true one, or any one without."""
    normal = rng.normal(size=3)
    if shape.axis is not None and (len(shape.planes) == 0 or rng.random() < 0.5):
        normal, centre = np.cross(shape.axis[1], normal), shape.axis[0]
    elif len(shape.planes):
        return shape.planes[rng.integers(len(shape.planes))] * rng.choice([-1.0, 1.0])
    normal /= np.linalg.norm(normal)
    return np.append(normal, -normal @ centre)


def remaining(points, normals, plane, damage: Damage, model, rng) -> np.ndarray:
    """Tell which points are left, (n,) bool."""
    shape, centre, diagonal = model
    heights = points @ plane[:3] + plane[3]
    removed = round(damage.share * len(points))
    if damage.removal == "region":
        return ranks(arrivals(points, heights, damage.blobs, rng)) * len(points) >= removed - 0.5
    if damage.removal == "cut":
        tilt = np.cross(plane[:3], rng.normal(size=3))
        angle = np.radians(rng.uniform(5.0, 30.0))
        way = np.cos(angle) * plane[:3] + np.sin(angle) * tilt / np.linalg.norm(tilt)
        return ranks(-(points @ way)) * len(points) >= removed - 0.5
    if damage.removal == "none":
        return np.ones(len(points), dtype=bool)
    front = np.cross(shape.up, plane[:3])
    if np.linalg.norm(front) < 0.1:  # a level plane: any horizontal direction
        front = np.cross(shape.up, rng.normal(size=3))
    front /= np.linalg.norm(front)
    beside = np.cross(front, shape.up)
    if damage.removal == "view":  # from the front or the back, within 35 degrees
        azimuths = np.array([rng.choice([0.0, np.pi]) + np.radians(rng.uniform(-35.0, 35.0))])
    else:  # from one side
        middle = rng.choice([-1.0, 1.0]) * np.pi / 2 + np.radians(rng.uniform(-45.0, 45.0))
        azimuths = middle + ARC * np.linspace(-0.5, 0.5, VIEWS)
    kept = np.zeros(len(points), dtype=bool)
    for azimuth in azimuths:
        rise = np.radians(rng.uniform(0.0, 25.0))
        level = np.cos(azimuth) * front + np.sin(azimuth) * beside
        way = np.cos(rise) * level + np.sin(rise) * shape.up
        seen = visible(points, centre + EYE_DISTANCE * diagonal * way)
        if damage.removal == "view":  # rays are even, so that slanting surface is seen thinly
            seen &= rng.random(len(points)) < np.abs(normals @ way)
        kept |= seen
    return kept


def ranks(values: np.ndarray) -> np.ndarray:
    """Ranks as shares, 0 to almost 1."""
    found = np.zeros(len(values))
    found[np.argsort(values, kind="stable")] = np.arange(len(values)) / len(values)
    return found


def waves(points: np.ndarray, width: float, rng) -> np.ndarray:
    """A smooth random field: hills of random height round random points."""
    centres = points[rng.choice(len(points), 40)]
    heights = rng.normal(size=40)
    squares = ((points[:, np.newaxis] - centres) ** 2).sum(axis=-1)
    return np.exp(-0.5 * squares / (0.4 * width) ** 2) @ heights


def arrivals(points, heights, blobs: int, rng) -> np.ndarray:
    """When ragged holes that grow along the surface reach each point.

    They start on the positive side, far from each other, and spill over only after all of it.
    """
    if len(points) > MOST_GROWN:
        some = rng.choice(len(points), MOST_GROWN, replace=False)
        times = arrivals(points[some], heights[some], blobs, rng)
        return times[cKDTree(points[some]).query(points)[1]]
    diagonal = np.linalg.norm(np.ptp(points, axis=0))
    side = np.flatnonzero(heights > 0.0)
    side = side if len(side) > 50 else np.argsort(-heights)[: len(points) // 2]
    places = points[side]
    distances, near = cKDTree(places).query(places, k=NEIGHBOURS + 1)
    field = waves(places, 0.25 * diagonal, rng) + 0.5 * waves(places, 0.1 * diagonal, rng)
    slowness = np.exp(field)
    costs = distances[:, 1:] * (slowness[:, np.newaxis] + slowness[near[:, 1:]])
    rows = np.repeat(np.arange(len(places)), NEIGHBOURS)
    graph = csr_matrix((costs.ravel(), (rows, near[:, 1:].ravel())), shape=(len(places),) * 2)
    inner = np.flatnonzero(ranks(heights[side]) > 0.4)
    seeds = [int(rng.choice(inner))]
    while len(seeds) < blobs:
        choice = rng.choice(inner, 24)
        gaps = np.linalg.norm(places[choice][:, np.newaxis] - places[seeds], axis=2).min(axis=1)
        seeds.append(int(choice[np.argmax(gaps)]))
    found = dijkstra(graph, directed=False, indices=seeds, min_only=True)
    reached = np.isfinite(found)
    if not reached.all():  # other pieces, in the order of their distance
        gaps = cKDTree(places[reached]).query(places[~reached])[0]
        found[~reached] = found[reached].max() + gaps
    times = 2.0 * found.max() + diagonal - heights
    times[side] = found
    return times


def visible(points: np.ndarray, eye: np.ndarray) -> np.ndarray:
    """Hidden point removal (Katz, Tal, Basri 2007): the hull of the points flipped at a sphere."""
    rays = points - eye
    lengths = np.linalg.norm(rays, axis=1, keepdims=True)
    flipped = rays + 2.0 * (FLIP * lengths.max() - lengths) * rays / lengths
    hull = ConvexHull(np.concatenate([flipped, np.zeros((1, 3))]))
    seen = np.zeros(len(points) + 1, dtype=bool)
    seen[hull.vertices] = True
    return seen[:-1]


def plinth(points, shape: Shape, rng, spread: float) -> np.ndarray:
    """A box under a statue, with a direction of its own, as densely sampled."""
    level = np.cross(shape.up, rng.normal(size=3))
    level /= np.linalg.norm(level)
    frame = np.stack([level, np.cross(shape.up, level), shape.up])
    local = points @ frame.T
    ground, height = local[:, 2].min(), np.ptp(local[:, 2])
    foot = local[local[:, 2] < ground + 0.15 * height]
    low, high = foot.min(axis=0), foot.max(axis=0)
    margin = rng.uniform(0.08, 0.15) * (high - low)[:2].max()
    low = np.array([*(low[:2] - margin), ground - rng.uniform(0.08, 0.12) * height])
    high = np.array([*(high[:2] + margin), ground])
    sides = high - low
    areas = sides.prod() / sides  # of the faces across each axis
    triangles = shape.triangles
    cross = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    density = len(points) / (0.5 * np.linalg.norm(cross, axis=1).sum())
    count = int(np.clip(2 * areas.sum() * density, 200, 0.4 * len(points)))
    places = low + rng.random((count, 3)) * sides
    across = rng.choice(3, count, p=areas / areas.sum())
    upper = rng.random(count) < 0.5
    rows = np.arange(count)
    places[rows, across] = np.where(upper, high[across], low[across])
    places[rows, across] += spread * rng.normal(size=count)
    return places @ frame


def stray(points, count: int, rng) -> np.ndarray:
    """Outliers in a box round the scan that is turned at random, so that it tells nothing."""
    turn = Rotation.from_quat(rng.normal(size=4)).as_matrix()
    local = points @ turn.T
    low, high = local.min(axis=0), local.max(axis=0)
    places = (low + high) / 2 + (rng.random((count, 3)) - 0.5) * BOX_MARGIN * (high - low)
    return places @ turn


def posed(points, shape: Shape, centre, diagonal: float, rng) -> Scan:
    """Turn, scale and move everything."""
    turn = Rotation.from_quat(rng.normal(size=4)).as_matrix()
    scale = float(np.exp(rng.normal()))
    shift = scale * diagonal * rng.normal(size=3)

    def moved(places):
        return scale * places @ turn.T + shift

    normals = shape.planes[:, :3] @ turn.T
    feet = moved(-shape.planes[:, 3:] * shape.planes[:, :3])
    planes = np.column_stack([normals, -np.einsum("ki,ki->k", normals, feet)])
    axis = None
    if shape.axis is not None:
        axis = np.stack([moved(shape.axis[0]), turn @ shape.axis[1]])
    return Scan(moved(points), planes, axis, moved(centre), scale * diagonal)
