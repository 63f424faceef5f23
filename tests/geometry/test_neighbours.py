import numpy as np
import pytest
from scipy.spatial import cKDTree

from meshlab_symrecon.geometry.neighbours import (
    border_points,
    local_spacing,
    nearest_field,
    principal_normals,
    tangent_bases,
    without_outliers,
)


def sphere(count):
    steps = np.arange(count) + 0.5
    polar, turn = np.arccos(1 - 2 * steps / count), np.pi * (1 + 5**0.5) * steps
    return np.stack(
        [np.cos(turn) * np.sin(polar), np.sin(turn) * np.sin(polar), np.cos(polar)], axis=1
    )


def test_spacing_of_a_lattice_is_its_step():
    lattice = np.stack(np.meshgrid(*[np.arange(5.0)] * 3), axis=-1).reshape(-1, 3)
    assert np.allclose(local_spacing(2.5 * lattice, 3), 2.5)
    assert np.array_equal(local_spacing(lattice[:1]), [0.0])


def test_outliers_are_left_out_and_the_surface_stays():
    clutter = np.random.default_rng(0).uniform(-3, 3, size=(40, 3))
    clutter = clutter[np.abs(np.linalg.norm(clutter, axis=1) - 1) > 0.3]
    kept = without_outliers(np.vstack([sphere(3_000), clutter]), 2.0, rounds=2)
    assert np.array_equal(kept, np.arange(3_000))


def test_normals_of_a_sphere_are_radial_and_its_roughness_is_the_sagitta():
    points = sphere(4_000)
    normals, roughness = principal_normals(points, points, 16)
    assert np.abs(np.einsum("ni,ni->n", normals, points)).min() > 0.999
    radius = np.sqrt(16 * 4 / 4_000)  # of a cap of 16 points: area pi r^2 = 16 * 4 pi / 4000
    # Heights -s/2 with s uniform in 0 .. r^2 deviate by r^2 / (2 sqrt 12).
    assert np.median(roughness) == pytest.approx(radius**2 / (2 * np.sqrt(12)), rel=0.1)


def test_tangents_complete_an_orthonormal_basis():
    normals = sphere(100)
    first, second = tangent_bases(normals)
    frames = np.stack([normals, first, second], axis=1)
    assert np.allclose(frames @ frames.transpose(0, 2, 1), np.eye(3), atol=1e-14)


def test_border_of_a_hemisphere_is_its_rim_and_a_sphere_has_none():
    points = sphere(6_000)
    assert not border_points(points, points).any()
    half = points[points[:, 2] > 0]
    border = border_points(half, half)
    spacing = np.median(local_spacing(half, 1))
    assert border[half[:, 2] < 0.7 * spacing].mean() > 0.9
    assert not border[half[:, 2] > 4 * spacing].any()


def test_field_is_exact_near_the_cloud_and_close_elsewhere():
    points = sphere(3_000)
    field = nearest_field(points, 0.02, 0.3, 10**7)
    rng = np.random.default_rng(1)
    places = rng.uniform(-1.25, 1.25, size=(5_000, 3))
    exact = cKDTree(points).query(places)[0]
    looked_up = np.linalg.norm(points[field.lookup(places)] - places, axis=1)
    assert (looked_up - exact).max() <= 4 * 0.02  # a place and a point each move by half a cell
    near = points[rng.integers(0, 3_000, 2_000)] + rng.normal(0, 0.005, size=(2_000, 3))
    found = np.linalg.norm(points[field.closest(near)] - near, axis=1)
    assert np.allclose(found, cKDTree(points).query(near)[0], atol=1e-15)


def test_field_respects_its_limit_of_cells():
    field = nearest_field(sphere(500), 0.001, 0.1, 10_000)
    assert field.indices.size < 1.3 * 10_000
    assert field.cell > 0.001
