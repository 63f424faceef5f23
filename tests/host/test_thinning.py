"""Scans thinned out: what stays is as it was, even, and the same for every order."""

from __future__ import annotations

import numpy as np
import pymeshlab
import pytest
from scipy.spatial import cKDTree

from meshlab_symrecon.errors import ParameterError, SymReconWarning
from meshlab_symrecon.host.files import load, save_current
from meshlab_symrecon.host.meshset import add_layer, read_layer
from meshlab_symrecon.host.sources import input_files
from meshlab_symrecon.host.thinning import even_points, thin_current
from meshlab_symrecon.plugin import Layer

NO_FACES = np.zeros((0, 3), np.int64)


def sphere(count, seed=0):
    points = np.random.default_rng(seed).normal(size=(count, 3))
    return points / np.linalg.norm(points, axis=1, keepdims=True)


def rows(points):
    return {tuple(row) for row in points.tolist()}


@pytest.mark.parametrize("most", [100, 1_000, 20_000, 49_990])
def test_no_more_than_asked_for_and_hardly_fewer(most):
    points = sphere(50_000)
    kept = even_points(points, most)
    assert 0.98 * most <= len(kept) <= most
    assert (np.diff(kept) > 0).all()


def test_enough_room_keeps_everything():
    assert np.array_equal(even_points(sphere(500), 500), np.arange(500))


def test_the_order_of_the_points_does_not_count():
    points = sphere(150_000)
    points[:2_000] = points[40_000:42_000]  # places measured twice
    order = np.random.default_rng(1).permutation(len(points))
    for most in (300, 30_000):
        one, other = even_points(points, most), even_points(points[order], most)
        assert rows(points[one]) == rows(points[order][other])


@pytest.mark.parametrize("far", [1e9, 1e19, 1e30, 3.4e38, -1e100])
def test_points_absurdly_far_off_leave_room_for_the_others(far):
    points = sphere(5_000)
    points[:1_000] = far * np.random.default_rng(2).uniform(1.0, 2.0, (1_000, 3))
    for cloud in (points, points[999:]):
        kept = even_points(cloud, 1_000)
        assert 900 <= len(kept) <= 1_000
        assert np.abs(cloud[kept]).max() > 0.9 * abs(far)
        order = np.random.default_rng(1).permutation(len(cloud))
        assert rows(cloud[kept]) == rows(cloud[order][even_points(cloud[order], 1_000)])


def test_half_of_the_points_in_one_place_are_one():
    points = sphere(5_000)
    points[1_000:] = 0.0
    assert len(even_points(points, 2_000)) == 1_001


def test_what_is_dense_and_what_is_sparse_come_out_alike():
    points = sphere(400_000)
    lower = points[:, 2] < 0.0
    thin = lower | (np.arange(len(points)) % 8 == 0)
    scan = points[thin]
    kept = scan[even_points(scan, 3_000)]
    below = np.count_nonzero(kept[:, 2] < 0.0)
    assert below == pytest.approx(len(kept) / 2, rel=0.04)  # 8 / 9 of the scan
    ideal = np.sqrt(4.0 * np.pi / len(kept))  # edge of a square of each one's area
    assert cKDTree(kept).query(scan)[0].max() < 2.0 * ideal


def test_scale_and_far_points_do_not_matter():
    points = sphere(60_000)
    scaled = even_points(points * 2.0**90, 5_000)
    assert np.array_equal(scaled, even_points(points, 5_000))
    far = np.vstack([points, [[1e12, 0.0, 0.0], [0.0, -1e12, 3e11]]])
    assert 4_900 <= len(even_points(far, 5_000)) <= 5_000


@pytest.mark.parametrize(
    ("points", "most", "expected"),
    [
        (np.zeros((400, 3)), 100, 1),
        (np.repeat(sphere(60), 10, axis=0), 100, 60),
        (np.outer(np.arange(1_000.0), [1.0, 2.0, 3.0]), 1, 1),
    ],
)
def test_places_measured_many_times_stay_once(points, most, expected):
    kept = even_points(points, most)
    assert len(kept) == expected
    assert len(rows(points[kept])) == expected


def test_points_on_a_line_and_in_a_volume():
    rng = np.random.default_rng(3)
    line = np.outer(rng.random(20_000), [1.0, 2.0, 3.0])
    for points in (line, rng.random((20_000, 3))):
        assert 970 <= len(even_points(points, 1_000)) <= 1_000


def cloud(tmp_path):
    rng = np.random.default_rng(5)
    given = Layer(
        points=sphere(5_000) + 1e-9 * rng.normal(size=(5_000, 3)),
        faces=NO_FACES,
        label="scan",
        normals=rng.normal(size=(5_000, 3)),
        quality=rng.normal(size=5_000),
        colours=rng.integers(0, 256, (5_000, 4)) / 255.0,
        attributes={"intensity": rng.normal(size=5_000)},
    )
    mesh_set = pymeshlab.MeshSet(verbose=False)
    add_layer(mesh_set, given, current=True)
    path = tmp_path / "scan.ply"
    save_current(mesh_set, path)
    return path


def test_a_layer_keeps_all_that_its_points_had(tmp_path):
    path = cloud(tmp_path)
    mesh_set = load(path)
    whole = read_layer(mesh_set, 0)
    assert thin_current(mesh_set, 700) == mesh_set.current_mesh().vertex_number() <= 700
    assert mesh_set.mesh_number() == 1
    part = read_layer(mesh_set, mesh_set.current_mesh_id())
    kept = even_points(whole.points, 700)
    assert part.label == whole.label
    assert np.array_equal(part.points, whole.points[kept])
    assert np.array_equal(part.normals, whole.normals[kept])
    assert np.array_equal(part.quality, whole.quality[kept])
    assert np.array_equal(part.colours, whole.colours[kept])
    assert np.array_equal(part.attributes["intensity"], whole.attributes["intensity"][kept])
    assert path.resolve() in input_files(mesh_set)  # the scan stays an input


def test_a_small_layer_stays_itself(tmp_path):
    mesh_set = load(cloud(tmp_path))
    assert thin_current(mesh_set, 5_000) == 5_000
    assert mesh_set.current_mesh_id() == 0


def test_of_a_mesh_the_points_are_left_and_other_layers_stay():
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.create_cube()
    mesh_set.create_sphere(subdiv=4)
    with pytest.warns(SymReconWarning, match="without its 5120 faces; simplify the mesh"):
        assert thin_current(mesh_set, 500) <= 500
    assert mesh_set.mesh_number() == 2
    assert mesh_set.mesh(0).face_number() == 12
    assert mesh_set.current_mesh().face_number() == 0


def test_too_few_points_are_refused():
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.create_sphere(subdiv=4)
    with pytest.raises(ParameterError, match="at least 100 points; got 99; ask for more"):
        thin_current(mesh_set, 99)
