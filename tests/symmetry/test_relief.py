import dataclasses

import numpy as np
import pytest
from symmetry.bodies import as_prepared, even_sphere, no_planes, symmetric_cloud

from meshlab_symrecon import _native
from meshlab_symrecon.geometry.planes import reflect, reflect_directions
from meshlab_symrecon.symmetry.preparation import RELIEF_RADII
from meshlab_symrecon.symmetry.relief import relief_agreement
from meshlab_symrecon.symmetry.verification import land


def wavy(count, seed, height=0.05):
    """A square with one smooth bump in its middle, and its upward normals."""
    places = np.random.default_rng(seed).uniform(-1, 1, (count, 2))
    rise = height * np.exp(-0.5 * (places**2).sum(axis=1) / 0.15**2)
    slopes = -places * rise[:, np.newaxis] / 0.15**2
    normals = np.column_stack([-slopes, np.ones(count)])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return np.column_stack([places, rise]), normals


@pytest.mark.parametrize(("size", "radius"), [(1.0, 0.25), (1.0, 0.5), (4.0, 1.0)])
def test_relief_of_a_sphere_is_that_of_a_cap(size, radius):
    """A ball of radius r cuts off a cap of height r^2 / 2R; heights on a sphere are uniform."""
    directions = even_sphere(20_000)
    found = _native.relief(size * directions, directions, radius)
    assert np.abs(found + radius / (4.0 * size)).max() < 0.01 * radius / size
    assert np.abs(found.mean() + radius / (4.0 * size)) < 5e-4 * radius / size


def test_relief_of_a_plane_is_zero():
    places = np.random.default_rng(0).uniform(size=(500, 2))
    plane = np.column_stack([places, np.full(500, 0.3)])
    upwards = np.broadcast_to([0.0, 0.0, 1.0], plane.shape).copy()
    assert np.abs(_native.relief(plane, upwards, 0.2)).max() < 1e-15


def test_a_bump_is_negative_and_a_hollow_positive():
    points, normals = wavy(4_000, 0)
    middle = np.argmin((points[:, :2] ** 2).sum(axis=1))
    bump = _native.relief(points, normals, 0.15)
    hollow = _native.relief(points * [1, 1, -1], normals * [-1, -1, 1], 0.15)
    assert bump[middle] < -0.05
    assert hollow[middle] > 0.05


def test_relief_goes_with_the_mirror_image_and_changes_sign_with_the_side():
    points, normals = wavy(1_500, 1)
    plane = np.array([0.36, 0.48, 0.8, -0.7])
    found = _native.relief(points, normals, 0.2)
    mirrored = reflect(points, plane), reflect_directions(normals, plane)
    assert np.abs(_native.relief(*mirrored, 0.2) - found).max() < 1e-12
    assert np.array_equal(_native.relief(points, -normals, 0.2), -found)
    assert np.ptp(found) > 0.05


@pytest.mark.parametrize("radius", [1e-300, 1e-9, 0.004, 0.3, 10.0])
@pytest.mark.parametrize("count", [1, 2, 300])
def test_relief_is_the_mean_height_over_the_ball(count, radius):
    rng = np.random.default_rng(count)
    points, normals = rng.normal(size=(2, count, 3))
    offsets = points - points[:, np.newaxis]
    inside = (offsets**2).sum(axis=2) <= radius**2
    heights = np.einsum("ijk,ik->ij", offsets, normals)
    expected = (heights * inside).sum(axis=1) / (inside.sum(axis=1) * radius)
    assert np.abs(_native.relief(points, normals, radius) - expected).max() < 1e-12


def test_relief_of_nothing_is_nothing():
    assert _native.relief(np.zeros((0, 3)), np.zeros((0, 3)), 0.1).shape == (0,)


@pytest.mark.parametrize("radius", [0.0, -1.0, np.nan])
def test_a_radius_that_is_none_is_refused(radius):
    with pytest.raises(ValueError, match="a radius is positive"):
        _native.relief(np.zeros((4, 3)), np.zeros((4, 3)), radius)


def test_normals_of_other_points_are_refused():
    with pytest.raises(ValueError, match="one entry a point"):
        _native.relief(np.zeros((4, 3)), np.zeros((3, 3)), 0.1)


def agreements(cloud, planes):
    landings = land(planes, cloud, cloud.samples, 0.006)
    return relief_agreement(landings, cloud, cloud.samples)


def test_bumps_fall_on_bumps_across_the_true_plane_only():
    points, normals, plane = symmetric_cloud(1)
    cloud = as_prepared(points, normals)
    wrong = np.append(plane[:3], plane[3] + 0.02)
    true, others = agreements(cloud, np.stack([plane, wrong]))
    assert np.abs(true - 1.0).max() < 1e-9
    assert (others < 0.9).all()
    assert np.abs(others).max() <= 1.0


def test_relief_that_is_turned_inside_out_speaks_against_a_plane():
    points, normals, plane = symmetric_cloud(2)
    cloud = as_prepared(points, normals)
    signs = np.where(points @ plane[:3] + plane[3] > 0.0, 1.0, -1.0)[:, np.newaxis]
    spread = cloud.relief - cloud.relief.mean(axis=0)
    twisted = dataclasses.replace(cloud, relief=signs * spread)
    assert (agreements(twisted, plane[np.newaxis]) < -0.9).all()


def test_nothing_is_compared_without_sides_or_beside_rims():
    points, normals, plane = symmetric_cloud(3)
    cloud = as_prepared(points, normals)
    none = np.zeros(len(points))
    for change in ({"oriented": none.astype(bool)}, {"border_distance": none}):
        blind = dataclasses.replace(cloud, **change)
        assert (agreements(blind, plane[np.newaxis]) == 0.0).all()


def test_relief_agreement_of_no_planes():
    cloud = as_prepared(*symmetric_cloud()[:2])
    assert agreements(cloud, no_planes()).shape == (0, len(RELIEF_RADII))
