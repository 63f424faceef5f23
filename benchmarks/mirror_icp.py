"""Mirror ICP, on its own: a plane is fitted so that a mirrored cloud falls on itself."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

REACH = 2.5  # tolerances within which a partner counts


def mirror_icp(queries, surface, tree: cKDTree, plane, tolerances) -> np.ndarray:
    """Fit a plane so that the mirrored queries fall on the surface; point to plane.

    ``queries`` and ``surface`` are pairs of points and unit normals.  Partners farther than REACH
    tolerances do not count; one step for each tolerance.
    """
    points, directions = queries
    normal, offset = plane[:3].copy(), float(plane[3])
    for tolerance in tolerances:
        heights = points @ normal + offset
        images = points - 2.0 * heights[:, np.newaxis] * normal
        distances, partners = tree.query(images, distance_upper_bound=REACH * tolerance)
        near = np.flatnonzero(np.isfinite(distances))
        if len(near) < 20:
            break
        targets, facing = surface[0][partners[near]], surface[1][partners[near]]
        turned = directions[near] - 2.0 * np.outer(directions[near] @ normal, normal)
        alike = np.abs(np.einsum("ni,ni->n", turned, facing))
        weights = np.exp(-0.5 * (distances[near] / tolerance) ** 2) * np.maximum(alike - 0.5, 0.0)
        gaps = np.einsum("ni,ni->n", images[near] - targets, facing)
        first = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
        first /= np.linalg.norm(first)
        axes = np.stack([first, np.cross(normal, first)])
        along = facing @ normal
        # images move by -2 ((p . u) n + h u) for a turn towards u, by -2 n for the offset
        columns = [(points[near] @ axis) * along + heights[near] * (facing @ axis) for axis in axes]
        jacobian = -2.0 * np.column_stack([*columns, along])
        system = (jacobian * weights[:, np.newaxis]).T @ jacobian
        system += 1e-6 * max(np.trace(system), 1e-12) * np.eye(3)
        move = -np.linalg.solve(system, jacobian.T @ (weights * gaps))
        move *= min(1.0, 0.15 / max(np.abs(move).max(), 1e-12))
        normal = normal + move[:2] @ axes
        length = np.linalg.norm(normal)
        normal, offset = normal / length, (offset + move[2]) / length
    return np.append(normal, offset)


def fibonacci_normals(count: int) -> np.ndarray:
    """Even directions of a half sphere."""
    steps = np.arange(count) + 0.5
    height, turn = steps / count, np.pi * (1 + 5**0.5) * steps
    away = np.sqrt(1 - height**2)
    return np.column_stack([away * np.cos(turn), away * np.sin(turn), height])
