"""Point sets on which triangulations are known to fail, each a function of nothing."""

from __future__ import annotations

import numpy as np


def generic_ball():
    points = np.random.default_rng(1).normal(size=(400, 3))
    return points / np.linalg.norm(points, axis=1, keepdims=True) ** 0.5


def generic_surface():
    u, v = np.random.default_rng(2).random((2, 500)) * 2 * np.pi
    tube = 0.35 + 0.05 * np.sin(5 * u) * np.cos(4 * v)
    ring = 1 + tube * np.cos(v)
    return np.column_stack([ring * np.cos(u), ring * np.sin(u), tube * np.sin(v)])


def lattice(size, spacing=1.0):
    axis = np.arange(size) * spacing
    return np.stack(np.meshgrid(axis, axis, axis), axis=-1).reshape(-1, 3)


def lattice_surface(size=7):
    points = lattice(size)
    return points[((points == 0) | (points == size - 1)).any(axis=1)]


def latitude_longitude_sphere():
    latitude, longitude = np.meshgrid(
        np.linspace(-np.pi / 2, np.pi / 2, 13), np.arange(24) * np.pi / 12, indexing="ij"
    )
    return np.column_stack(
        [
            (np.cos(latitude) * np.cos(longitude)).ravel(),
            (np.cos(latitude) * np.sin(longitude)).ravel(),
            np.sin(latitude).ravel(),
        ]
    )


def latitude_longitude_sphere_with_repeated_poles():
    points = latitude_longitude_sphere()
    points[np.abs(points[:, 2]) == 1.0, :2] = 0.0
    return points


def random_sphere():
    points = np.random.default_rng(3).normal(size=(400, 3))
    return points / np.linalg.norm(points, axis=1, keepdims=True)


def cylinder_rings():
    angle, height = np.meshgrid(np.arange(20) * np.pi / 10, np.arange(15) * 0.25)
    return np.column_stack([np.cos(angle).ravel(), np.sin(angle).ravel(), height.ravel()])


def torus_grid():
    u, v = (a.ravel() for a in np.meshgrid(np.arange(24) * np.pi / 12, np.arange(12) * np.pi / 6))
    ring = 2 + 0.5 * np.cos(v)
    return np.column_stack([ring * np.cos(u), ring * np.sin(u), 0.5 * np.sin(v)])


def two_clusters():
    points = np.random.default_rng(4).random((300, 3))
    points[150:] += 1e6
    return points


def coplanar_plus_one():
    plane = np.random.default_rng(5).random((150, 3)) * [1, 1, 0]
    return np.vstack([plane, [[0.3, 0.4, 1.0]]])


def grid_plane_plus_one():
    x, y = (a.ravel() for a in np.meshgrid(np.arange(9.0), np.arange(9.0)))
    return np.vstack([np.column_stack([x, y, x + y]), [[0.0, 0.0, 5.0]]])


def collinear_plus_two():
    line = np.outer(np.arange(60.0), [1, 2, 3])
    return np.vstack([line, [[5.0, 0, 0], [0, 7.0, 1]]])


def exact_duplicates():
    points = generic_ball()[:200]
    return np.vstack([points, points[::2], points[::5]])


def near_duplicates():
    points = generic_ball()[:150]
    return np.vstack([points, np.nextafter(points, np.inf), np.nextafter(points, -np.inf)])


def lattice_near_duplicates():
    points = lattice(4) + 1.0
    return np.vstack([points, np.nextafter(points, np.inf)])


def tiny_scale():
    return generic_surface()[:250] * 1e-6


def huge_scale():
    return generic_surface()[:250] * 1e6


def far_offset():
    return generic_surface()[:250] + 3e3


def lattice_far_offset():
    return lattice(5, 0.1) + 1e3


def signed_zeros():
    points = lattice(3) - 1.0
    return np.vstack([points, np.where(points == 0, -0.0, points)])


def nested_spheres():
    points = latitude_longitude_sphere()[::3]
    return np.vstack([points, 2 * points, [[0.0, 0.0, 0.0]]])


def unlike_sizes():
    """Clusters of every size from 1 down to 1e-30."""
    points = np.random.default_rng(6).normal(size=(16, 20, 3))
    return (points * 100.0 ** -np.arange(16)[:, None, None]).reshape(-1, 3)


def beyond_floating_point_range():
    return np.random.default_rng(7).normal(size=(60, 3)) * 1e300


def below_floating_point_range():
    return np.random.default_rng(8).integers(-9, 9, size=(60, 3)) * 5e-324


def both_ends_of_floating_point_range():
    sign = np.random.default_rng(9).choice([-1.0, 1.0], size=(12, 3))
    exponent = np.random.default_rng(9).integers(-1000, 1000, size=(12, 3))
    return np.ldexp(sign, exponent)


INPUTS = [
    generic_ball,
    generic_surface,
    lattice_surface,
    latitude_longitude_sphere,
    latitude_longitude_sphere_with_repeated_poles,
    random_sphere,
    cylinder_rings,
    torus_grid,
    two_clusters,
    coplanar_plus_one,
    grid_plane_plus_one,
    collinear_plus_two,
    exact_duplicates,
    near_duplicates,
    lattice_near_duplicates,
    tiny_scale,
    huge_scale,
    far_offset,
    lattice_far_offset,
    signed_zeros,
    nested_spheres,
    unlike_sizes,
    beyond_floating_point_range,
    below_floating_point_range,
    both_ends_of_floating_point_range,
]

# the radii of these squared are beyond any float
INPUTS_WITH_POLES = [
    make
    for make in INPUTS
    if make not in {beyond_floating_point_range, both_ends_of_floating_point_range}
]
