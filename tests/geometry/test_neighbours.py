import numpy as np
import pytest
from scipy.spatial import cKDTree

from meshlab_symrecon import _native
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


def test_a_lookup_is_right_to_about_a_cell():
    points = sphere(3_000)
    field = nearest_field(points, 0.02, 0.3, 10**7)
    places = np.random.default_rng(1).uniform(-1.25, 1.25, size=(5_000, 3))
    exact = cKDTree(points).query(places)[0]
    looked_up = np.linalg.norm(points[field.lookup(places)] - places, axis=1)
    assert (looked_up - exact).max() <= 3.5 * 0.02  # a place and a point each move by half a cell


@pytest.mark.parametrize("count", [1, 2, 7, 8, 9, 31, 33, 3_000])
def test_the_closest_point_is_the_closest_everywhere(count):
    rng = np.random.default_rng(count)
    points = rng.normal(size=(count, 3))
    field = nearest_field(points, 0.1, 0.3, 10**5)
    far = rng.normal(0, 5, size=(500, 3))
    places = np.vstack([points + rng.normal(0, 0.05, size=points.shape), points, far])
    assert np.array_equal(field.closest(places), cKDTree(points).query(places)[1])


@pytest.mark.parametrize("cell", [0.02, 0.2])
@pytest.mark.parametrize("within", [0.0, 0.3, 1.0, 2.0])
def test_the_closest_point_is_found_within_a_distance(cell, within):
    rng = np.random.default_rng(0)
    for count in (2, 3, 20, 200):
        points = rng.uniform(-1, 1, size=(count, 3))
        field = nearest_field(points, cell, 0.0, 10**6)
        places = rng.uniform(-2.5, 2.5, size=(2_000, 3))
        found = np.linalg.norm(points[field.closest(places, within)] - places, axis=1)
        exact = cKDTree(points).query(places)[0]
        assert np.allclose(found[exact <= within], exact[exact <= within], rtol=1e-14)
        assert (found[exact > within] > within).all()


def test_of_several_closest_points_it_is_the_first():
    lattice = np.stack(np.meshgrid(*[np.arange(5.0)] * 3), axis=-1).reshape(-1, 3)
    points = np.random.default_rng(0).permutation(np.vstack([lattice, lattice]))
    field = nearest_field(points, 0.3, 0.5, 10**6)
    places = np.vstack([lattice, lattice + 0.5, lattice + np.array([0.5, 0, 0])])
    squares = ((places[:, np.newaxis] - points) ** 2).sum(axis=2)
    assert np.array_equal(field.closest(places), squares.argmin(axis=1))


def test_places_that_are_no_numbers_find_some_point():
    field = nearest_field(sphere(100), 0.1, 0.1, 10**5)
    places = np.array([[np.nan, 0.0, 0.0], [np.inf, -np.inf, 0.0]])
    for found in (field.lookup(places), field.closest(places)):
        assert ((found >= 0) & (found < 100)).all()


def test_a_table_that_does_not_fit_its_points_is_refused():
    points, origin = np.zeros((2, 3)), np.zeros(3)
    for wrong in (2, -1):
        with pytest.raises(ValueError, match="unknown points"):
            _native.NearestField(points, np.full((1, 1, 1), wrong, dtype=np.int32), origin, 1.0)
    with pytest.raises(ValueError, match="one entry a cell"):
        _native.NearestField(points, np.zeros((0, 1, 1), dtype=np.int32), origin, 1.0)
    with pytest.raises(ValueError, match="three coordinates"):
        _native.NearestField(points, np.zeros((1, 1, 1), dtype=np.int32), origin[:2], 1.0)


def test_field_respects_its_limit_of_cells():
    field = nearest_field(sphere(500), 0.001, 0.1, 10_000)
    assert np.prod(field.shape) < 1.3 * 10_000
    assert field.cell > 0.001
