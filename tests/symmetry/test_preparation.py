import dataclasses

import numpy as np
import pytest
from scipy.spatial import cKDTree
from symmetry.bodies import ellipsoid, even_sphere, no_planes

from meshlab_symrecon.symmetry.preparation import BASE_COUNT, PreparedCloud, prepare

VALUES = ("points", "normals", "border_distance", "distinctness", "relief", "broken_off")


@pytest.fixture(scope="module")
def prepared(statue):
    return prepare(statue, None, 800)


def random_planes(count, seed=0):
    planes = np.random.default_rng(seed).normal(size=(count, 4))
    return planes / np.linalg.norm(planes[:, :3], axis=1, keepdims=True)


def test_planes_come_back_from_the_frame_of_the_cloud(statue, prepared):
    planes = random_planes(40)
    assert np.abs(prepared.to_input(prepared.from_input(planes)) - planes).max() < 1e-12
    assert np.abs(prepared.from_input(prepared.to_input(planes)) - planes).max() < 1e-12
    assert prepared.from_input(no_planes()).shape == (0, 4)
    assert prepared.to_input(no_planes()).shape == (0, 4)


def test_distances_from_planes_are_the_same_in_either_frame(statue, prepared):
    planes = random_planes(40)
    inside = (statue - prepared.centre) @ prepared.axes.T / prepared.scale
    framed = prepared.from_input(planes)
    heights = statue @ planes[:, :3].T + planes[:, 3]
    assert np.allclose(
        inside @ framed[:, :3].T + framed[:, 3], heights / prepared.scale, atol=1e-12
    )


def test_points_of_a_clean_cloud_are_points_of_the_scan(statue, prepared):
    back = prepared.points * prepared.scale @ prepared.axes + prepared.centre
    assert cKDTree(statue).query(back)[0].max() < 1e-12
    assert len(prepared.points) > 0.95 * len(statue)


def test_the_prepared_cloud_has_unit_size_and_orthonormal_axes(prepared):
    low, high = np.quantile(prepared.points, [0.005, 0.995], axis=0)
    assert np.linalg.norm(high - low) == pytest.approx(1.0, abs=1e-9)
    assert np.abs(prepared.points.mean(axis=0)).max() < 0.02
    assert np.abs(prepared.axes @ prepared.axes.T - np.eye(3)).max() < 1e-12
    assert np.allclose(np.linalg.norm(prepared.normals, axis=1), 1.0)


def test_derived_values_are_those_of_the_points(prepared):
    points = prepared.points
    root = prepared.root_covariance
    assert np.allclose(root @ root, np.cov(points.T, bias=True), atol=1e-15)
    assert np.allclose(root, root.T)
    nearest = cKDTree(points).query(points, k=2)[0][:, 1]
    assert prepared.spacing == pytest.approx(np.median(nearest))
    assert len(np.unique(prepared.samples)) == len(prepared.samples) == 800
    assert (prepared.border_distance[prepared.border] >= 0.0).all()


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("handed", [1.0, -1.0])
def test_the_prepared_cloud_is_the_same_wherever_the_scan_is(statue, prepared, scale, handed):
    rng = np.random.default_rng(3)
    matrix = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    matrix[0] *= handed * np.sign(np.linalg.det(matrix))
    moved = scale * (rng.permutation(statue) @ matrix.T + rng.normal(0, 3, 3))
    found = prepare(moved, None, 800)
    assert found.scale == pytest.approx(scale * prepared.scale)
    order = cKDTree(found.points).query(prepared.points)[1]
    for name in VALUES:
        values, wanted = getattr(found, name), getattr(prepared, name)
        if name == "normals":
            known = prepared.oriented
            assert np.array_equal(found.oriented[order], known)
            assert np.abs(values[order][known] - wanted[known]).max() < 1e-6
        elif name in ("points", "border_distance"):
            assert np.abs(values[order] - wanted).max() < 1e-9
        elif name == "relief":
            assert np.abs(values[order][known] - wanted[known]).max() < 1e-6
        else:
            assert np.abs(values - wanted).max() < 1e-9
    assert np.array_equal(found.border[order], prepared.border)
    assert np.array_equal(order[prepared.samples], found.samples)


def test_a_permuted_scan_gives_the_same_bytes(statue, prepared):
    again = prepare(np.random.default_rng(4).permutation(statue), None, 800)
    for field in dataclasses.fields(PreparedCloud):
        if field.name != "field":
            values, wanted = getattr(again, field.name), getattr(prepared, field.name)
            assert np.asarray(values).tobytes() == np.asarray(wanted).tobytes(), field.name


def test_normals_of_the_scan_tell_the_sides(statue):
    inwards = -statue / np.linalg.norm(statue, axis=1, keepdims=True)
    cloud = prepare(statue, inwards, 10)
    radial = (cloud.points @ cloud.axes * cloud.scale + cloud.centre) @ cloud.axes.T
    towards = np.einsum("ij,ij->i", cloud.normals, radial)
    assert (towards[cloud.oriented] > 0.0).all()  # all inwards: turned round
    assert cloud.oriented.mean() > 0.8


@pytest.mark.parametrize("count", [5_000, 30_000, 100_000])
def test_the_level_that_is_searched_is_bounded(count):
    cloud = prepare(even_sphere(count), None, 10)
    assert min(count, 0.8 * BASE_COUNT) <= len(cloud.points) <= 1.1 * BASE_COUNT
    assert np.abs(cloud.scale - 2 * 3**0.5) < 0.05
    assert cloud.oriented.all()


def test_a_whole_body_has_no_rims():
    cloud = prepare(even_sphere(4_000), None, 100)
    assert not cloud.border.any()
    assert np.isinf(cloud.border_distance).all()
    assert cloud.rim_plane is None
    assert (cloud.distinctness == 1.0).all()


def test_noise_is_measured_and_smoothed_away():
    rng = np.random.default_rng(0)
    clean = ellipsoid(20_000, [1.0, 0.8, 0.6])
    noise = 0.006 * 2 * np.sqrt(2.0)  # of the diagonal
    cloud = prepare(clean + rng.normal(0, noise, clean.shape), None, 10)
    assert cloud.roughness == pytest.approx(noise / cloud.scale, rel=0.25)
    back = cloud.points @ cloud.axes * cloud.scale + cloud.centre
    off = np.linalg.norm(back / [1.0, 0.8, 0.6], axis=1) - 1.0
    assert np.sqrt((off**2).mean()) < 0.6 * noise
    assert prepare(clean, None, 10).roughness < 0.1 * cloud.roughness


def test_samples_on_a_large_flat_face_are_less_distinct():
    rng = np.random.default_rng(0)
    dome = ellipsoid(5_000, [0.5, 0.4, 0.45])
    dome = dome[dome[:, 2] > 0.0]
    floor = rng.uniform(-0.6, 0.6, (1_500, 2))
    floor = np.column_stack([floor, np.zeros(len(floor))])
    cloud = prepare(np.vstack([dome, floor]), None, 1_500)
    heights = (cloud.points[cloud.samples] * cloud.scale @ cloud.axes + cloud.centre)[:, 2]
    assert cloud.distinctness[heights < 0.01].mean() < 0.5
    assert cloud.distinctness[heights > 0.1].min() > 0.8
