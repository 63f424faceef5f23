"""Planes fitted to clouds whose normals are known."""

from __future__ import annotations

import numpy as np
import pytest
import shapes

from meshlab_symrecon.geometry.local_planes import _least_axes, local_planes


def test_normals_and_spacing_of_a_lattice_are_exact():
    flat = np.stack(np.meshgrid(*[np.arange(30.0)] * 2), -1).reshape(-1, 2)
    points = np.column_stack([flat, np.zeros(len(flat))]) @ shapes.rotation(0).T
    found = local_planes(points)
    upright = shapes.rotation(0)[:, 2]
    np.testing.assert_allclose(np.abs(found.normals @ upright), 1.0, atol=1e-12)
    inner = ((flat > 0) & (flat < 29)).all(axis=1)
    np.testing.assert_allclose(found.spacing[inner], 1.0, atol=1e-12)


def test_normals_of_a_sphere_face_its_centre():
    points = shapes.fibonacci_sphere(5000)
    cosines = np.abs(np.einsum("ij,ij->i", local_planes(points).normals, points))
    assert np.degrees(np.arccos(cosines.clip(max=1.0))).max() < 1.5


@pytest.mark.parametrize("scale", [1e-20, 1.0, 1e20])
@pytest.mark.parametrize(
    "spread",
    [
        (0.0, 1.0, 2.0), (0.0, 1.0, 1.0), (1e-9, 1e-3, 1.0), (0.9, 1.0, 1.1), (1.0, 1.0, 2.0),
        (0.0, 0.0, 1.0), (1.0, 1.0, 1.0), (0.0, 0.0, 0.0), (1.0 - 1e-9, 1.0, 5.0),
    ],
)  # fmt: skip
def test_axes_of_least_spread_are_eigenvectors_to_the_last_digits(spread, scale):
    turns = np.stack([shapes.rotation(seed) for seed in range(50)])
    matrices = np.einsum("mij,j,mkj->mik", turns, np.array(spread) * scale, turns)
    axes = _least_axes(matrices)
    np.testing.assert_allclose(np.linalg.norm(axes, axis=1), 1.0, atol=1e-12)
    along = np.einsum("mij,mj->mi", matrices, axes)
    np.testing.assert_allclose(along, spread[0] * scale * axes, atol=1e-12 * scale)


def test_noise_is_met_with_more_neighbours():
    """Noise of one spacing: a dozen neighbours would be off by more than 15 degrees."""
    rng = np.random.default_rng(0)
    flat = rng.uniform(0.0, 60.0, (3600, 2))  # a point a unit square
    rough = np.column_stack([flat, rng.normal(scale=1.0, size=len(flat))])
    inner = ((flat > 6) & (flat < 54)).all(axis=1)
    off = np.degrees(np.arccos(np.abs(local_planes(rough).normals[inner, 2]).clip(max=1.0)))
    assert np.median(off) < 8.0


def test_the_order_of_the_points_does_not_matter():
    points = shapes.statue(2000, seed=1)
    order = np.random.default_rng(0).permutation(len(points))
    found, again = local_planes(points), local_planes(points[order])
    cosines = np.einsum("ij,ij->i", found.normals[order], again.normals)
    np.testing.assert_allclose(np.abs(cosines), 1.0, atol=1e-12)
    np.testing.assert_allclose(again.spacing, found.spacing[order], rtol=1e-12)


def test_four_points_are_enough():
    assert np.isfinite(local_planes(np.vstack([np.eye(3), np.zeros(3)])).normals).all()
