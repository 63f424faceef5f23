"""Surfaces of made shapes: triangles (m, 3, 3) of radial, lofted, convex and implicit bodies."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from scipy.spatial import ConvexHull

Field = Callable[[np.ndarray], np.ndarray]  # (n, 3) -> (n,), negative inside

NO_PLANES = np.zeros((0, 4))
INSIDE = -1e-9  # of a convex part: deeper points are hidden
TETRAHEDRA = np.array(  # of a cube whose corner number has the bits z, y, x, round its diagonal 0-7
    [[0, 1, 3, 7], [0, 1, 5, 7], [0, 2, 3, 7], [0, 2, 6, 7], [0, 4, 5, 7], [0, 4, 6, 7]]
)


@dataclass(frozen=True, eq=False)
class Shape:
    """A surface and its true planes.

    A body of revolution has an ``axis``, a point and a direction: all planes through it are true.
    """

    name: str
    kind: str
    triangles: np.ndarray  # (m, 3, 3)  corners, outward
    planes: np.ndarray = field(default_factory=lambda: NO_PLANES)  # (k, 4)
    axis: np.ndarray | None = None  # (2, 3)
    hidden: Callable[[np.ndarray], np.ndarray] | None = None  # points inside another part
    up: np.ndarray = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))

    @property
    def symmetric(self) -> bool:
        return len(self.planes) > 0 or self.axis is not None

    @property
    def box(self) -> tuple[np.ndarray, np.ndarray]:
        corners = self.triangles.reshape(-1, 3)
        return corners.min(axis=0), corners.max(axis=0)

    def sample(self, count: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
        """(count, 3) points uniform in area, and their unit normals."""
        cross = np.cross(
            self.triangles[:, 1] - self.triangles[:, 0], self.triangles[:, 2] - self.triangles[:, 0]
        )
        areas = np.linalg.norm(cross, axis=1)
        shares = np.cumsum(areas)
        points, normals = np.zeros((0, 3)), np.zeros((0, 3))
        while len(points) < count:
            wanted = max(64, int(1.5 * (count - len(points)) if self.hidden else count))
            face = np.searchsorted(shares, rng.random(wanted) * shares[-1])
            root, along = np.sqrt(rng.random(wanted)), rng.random(wanted)
            weights = np.stack([1 - root, root * (1 - along), root * along], axis=1)
            drawn = np.einsum("nk,nki->ni", weights, self.triangles[face])
            seen = ~self.hidden(drawn) if self.hidden else np.ones(wanted, dtype=bool)
            points = np.concatenate([points, drawn[seen]])
            unit = cross[face[seen]] / np.maximum(areas[face[seen]], 1e-300)[:, np.newaxis]
            normals = np.concatenate([normals, unit])
        return points[:count], normals[:count]


def directions(level: int = 6) -> tuple[np.ndarray, np.ndarray]:
    """An icosphere: unit vectors, symmetric across the coordinate planes, and faces."""
    golden = (1 + 5**0.5) / 2
    signs = [(a, b * golden) for a in (-1.0, 1.0) for b in (-1.0, 1.0)]
    points = np.array([np.roll([0.0, a, b], turn) for turn in range(3) for a, b in signs])
    faces = ConvexHull(points).simplices
    for _ in range(level):
        edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
        unique, which = np.unique(edges, axis=0, return_inverse=True)
        middle = len(points) + which.reshape(-1, 3)
        points = np.concatenate([points, points[unique].mean(axis=1)])
        a, b, c = faces.T
        ab, bc, ca = middle.T
        corners = [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        faces = np.concatenate([np.stack(corner, axis=1) for corner in corners])
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    return points, faces


def outward(triangles: np.ndarray) -> np.ndarray:
    """Turn triangles of a body that is star-shaped round the origin."""
    a, b, c = triangles.transpose(1, 0, 2)
    inward = np.einsum("mi,mi->m", np.cross(b - a, c - a), a + b + c) < 0
    turned = triangles.copy()
    turned[inward] = turned[inward][:, [0, 2, 1]]
    return turned


def radial(radius: Callable[[np.ndarray], np.ndarray], scale=(1.0, 1.0, 1.0)) -> np.ndarray:
    """A body that is star-shaped: ``radius`` of unit directions (n, 3)."""
    points, faces = directions()
    return outward((points * radius(points)[:, np.newaxis] * np.asarray(scale))[faces])


def loft(rings: np.ndarray, *, closed: bool = False) -> np.ndarray:
    """Triangles between rings (r, c, 3), counter-clockwise seen from the last one.

    Fans close the ends, unless the last ring is joined to the first.
    """
    following = np.roll(rings, -1, axis=0) if closed else rings[1:]
    below = rings if closed else rings[:-1]
    a, d = below, following
    b, c = np.roll(below, -1, axis=1), np.roll(following, -1, axis=1)
    sides = [np.stack(t, axis=2).reshape(-1, 3, 3) for t in ((a, b, c), (a, c, d))]
    if closed:
        return np.concatenate(sides)
    for ring, turn in ((rings[0], -1), (rings[-1], 1)):
        centre = np.broadcast_to(ring.mean(axis=0), ring.shape)
        pair = (ring, np.roll(ring, -1, axis=0))[::turn]
        sides.append(np.stack([centre, *pair], axis=1))
    return np.concatenate(sides)


def tube(curve: np.ndarray, radii: np.ndarray, columns: int = 48, *, closed: bool = False):
    """Triangles of a round tube along a curve (n, 3); frames carried along it turn least."""
    if closed:
        tangents = np.roll(curve, -1, axis=0) - np.roll(curve, 1, axis=0)
    else:
        tangents = np.gradient(curve, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    start = np.eye(3)[np.argmin(np.abs(tangents[0]))]
    frames = np.zeros_like(curve)
    for row, tangent in enumerate(tangents):
        across = start - (start @ tangent) * tangent
        frames[row] = start = across / np.linalg.norm(across)
    sides = np.cross(tangents, frames)
    turn = np.zeros(len(curve))
    if closed:  # spread over the curve by how much the last frame misses the first
        last = start - (start @ tangents[0]) * tangents[0]
        missed = np.arctan2(last @ sides[0], last @ frames[0])
        turn = -missed * np.linspace(0.0, 1.0, len(curve), endpoint=False)
    angles = np.linspace(0, 2 * np.pi, columns, endpoint=False) + turn[:, np.newaxis]
    circle = np.cos(angles)[..., np.newaxis] * frames[:, np.newaxis]
    circle = circle + np.sin(angles)[..., np.newaxis] * sides[:, np.newaxis]
    rings = curve[:, np.newaxis] + radii[:, np.newaxis, np.newaxis] * circle
    return loft(rings, closed=closed)


def level_set(inside: Field, low, high, cells: int = 88) -> np.ndarray:
    """Triangles of the surface where a field is 0, by marching tetrahedra.

    ``cells`` along the longest edge of the box, which has to hold the body.
    """
    low, high = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    step = (high - low).max() / cells
    shape = np.ceil((high - low) / step).astype(int) + 1
    middle = (low + high) / 2
    axes = [middle[k] + step * (np.arange(shape[k]) - (shape[k] - 1) / 2) for k in range(3)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    values = inside(grid) + 1e-12  # no corner on the surface
    bits = (np.arange(8)[:, np.newaxis] >> np.arange(3)) & 1
    strides = np.array([shape[1] * shape[2], shape[2], 1])
    cubes = np.stack(np.meshgrid(*(np.arange(n - 1) for n in shape), indexing="ij"), axis=-1)
    corners = (cubes.reshape(-1, 3) @ strides)[:, np.newaxis] + bits @ strides
    below = values[corners] < 0
    corners = corners[below.any(axis=1) & ~below.all(axis=1)]
    tetrahedra = corners[:, TETRAHEDRA].reshape(-1, 4)
    order = np.argsort(values[tetrahedra], axis=1)
    tetrahedra = np.take_along_axis(tetrahedra, order, axis=1)  # inner corners first
    count = (values[tetrahedra] < 0).sum(axis=1)

    def crossing(rows, first, second):
        p, q = tetrahedra[rows, first], tetrahedra[rows, second]
        share = (values[p] / (values[p] - values[q]))[:, np.newaxis]
        return grid[p] + share * (grid[q] - grid[p])

    found = []
    for inner, edges in (
        (1, [(0, 1), (0, 2), (0, 3)]),
        (3, [(3, 0), (3, 1), (3, 2)]),
        (2, [(0, 2), (0, 3), (1, 3)]),
        (2, [(0, 2), (1, 3), (1, 2)]),
    ):
        rows = np.flatnonzero(count == inner)
        triangle = np.stack([crossing(rows, *edge) for edge in edges], axis=1)
        normal = np.cross(triangle[:, 1] - triangle[:, 0], triangle[:, 2] - triangle[:, 0])
        away = grid[tetrahedra[rows, 3]] - grid[tetrahedra[rows, 0]]
        wrong = np.einsum("mi,mi->m", normal, away) < 0
        triangle[wrong] = triangle[wrong][:, [0, 2, 1]]
        found.append(triangle)
    return np.concatenate(found)


def convex_parts(parts: list[np.ndarray]) -> tuple[np.ndarray, Callable[[np.ndarray], np.ndarray]]:
    """Triangles of the convex hulls of point sets, and a test for what lies inside one of them."""
    hulls = [ConvexHull(part) for part in parts]
    triangles = []
    for hull, part in zip(hulls, parts, strict=True):
        middle = part.mean(axis=0)
        triangles.append(outward(part[hull.simplices] - middle) + middle)

    def hidden(points: np.ndarray) -> np.ndarray:
        deep = [
            (points @ hull.equations[:, :3].T + hull.equations[:, 3]).max(axis=1) < INSIDE
            for hull in hulls
        ]
        return np.any(deep, axis=0)

    return np.concatenate(triangles), hidden


def box_corners(centre, half, turn=None) -> np.ndarray:
    """(8, 3) corners of a box, turned by a matrix."""
    signs = np.array([[a, b, c] for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)], dtype=float)
    corners = signs * np.asarray(half)
    return (corners if turn is None else corners @ turn.T) + np.asarray(centre)


def prism(outline: np.ndarray, low: float, high: float, top_scale: float = 1.0) -> np.ndarray:
    """(2 n, 3) corners of a prism over an outline (n, 2)."""
    ends = [(outline, low), (outline * top_scale, high)]
    return np.concatenate([np.column_stack([xy, np.full(len(xy), z)]) for xy, z in ends])


# ------------------------------------------------------------------------------------------ fields


def ellipsoid(centre, radii, turn=None) -> Field:
    centre, radii = np.asarray(centre, dtype=float), np.asarray(radii, dtype=float)

    def distance(points):
        local = (points - centre) if turn is None else (points - centre) @ turn
        scaled = np.linalg.norm(local / radii, axis=1)
        slope = np.maximum(np.linalg.norm(local / radii**2, axis=1), 1e-9)
        return np.maximum(scaled * (scaled - 1.0) / slope, -radii.min())

    return distance


def capsule(start, end, radius: float, end_radius: float | None = None) -> Field:
    """Round the segment between two points; the radius may change along it."""
    start, along = np.asarray(start, dtype=float), np.subtract(end, start, dtype=float)
    last = radius if end_radius is None else end_radius

    def distance(points):
        share = np.clip((points - start) @ along / max(along @ along, 1e-12), 0.0, 1.0)
        gap = np.linalg.norm(points - start - share[:, np.newaxis] * along, axis=1)
        return gap - (radius + share * (last - radius))

    return distance


def chain(curve: np.ndarray, radius: float) -> Field:
    """Round a polyline (n, 3)."""
    links = [capsule(a, b, radius) for a, b in pairwise(curve)]
    return lambda points: np.min([link(points) for link in links], axis=0)


def blended(parts: list[Field], width: float = 0.02) -> Field:
    """Smooth union: a soft minimum that does not depend on the order."""

    def distance(points):
        values = np.stack([part(points) for part in parts])
        least = values.min(axis=0)
        return least - width * np.log(np.exp(-(values - least) / width).sum(axis=0))

    return distance


def mirrored(part: Field) -> Field:
    """The mirror image across x = 0."""
    return lambda points: part(points * [-1.0, 1.0, 1.0])


def pair(part: Field) -> list[Field]:
    """A part and its mirror image across x = 0."""
    return [part, mirrored(part)]
