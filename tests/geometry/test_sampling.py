import numpy as np
import pytest
from scipy.spatial import cKDTree

from meshlab_symrecon import _native
from meshlab_symrecon.geometry.sampling import (
    canonical_order,
    farthest_point_order,
    principal_frame,
    thin_by_voxels,
    voxel_labels,
    voxel_means,
)


def sphere(count, seed=0):
    points = np.random.default_rng(seed).normal(size=(count, 3))
    return points / np.linalg.norm(points, axis=1, keepdims=True)


def test_canonical_order_is_lexicographic_and_undoes_permutations():
    rng = np.random.default_rng(0)
    points = rng.integers(0, 4, size=(200, 3)).astype(float)  # many ties
    ordered = points[canonical_order(points)]
    assert [tuple(row) for row in ordered] == sorted(tuple(row) for row in points)
    shuffled = rng.permutation(points)
    assert np.array_equal(shuffled[canonical_order(shuffled)], ordered)


def test_principal_frame_turns_with_the_cloud():
    rng = np.random.default_rng(1)
    points = rng.gamma(2.0, size=(500, 3)) * [5.0, 2.0, 1.0]
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    centre, axes = principal_frame(points)
    moved_centre, moved_axes = principal_frame(points @ turn.T + 3.0)
    assert np.allclose(moved_centre, centre @ turn.T + 3.0)
    assert np.allclose(moved_axes, axes @ turn.T)
    assert np.allclose(axes @ axes.T, np.eye(3))


def test_voxels_of_a_lattice_are_its_points():
    lattice = np.stack(np.meshgrid(*[np.arange(4.0)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    labels, count = voxel_labels(np.repeat(lattice, 3, axis=0), 1.0)
    assert count == 64
    assert (np.bincount(labels) == 3).all()
    means = voxel_means(np.repeat(lattice, 3, axis=0), labels, count)
    assert np.array_equal(means[canonical_order(means)], lattice[canonical_order(lattice)])


@pytest.mark.parametrize("target", [300, 5_000, 20_000])
@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e6])
def test_thinning_meets_its_target_at_any_scale(target, scale):
    points = sphere(60_000) * scale
    labels, count = thin_by_voxels(points, target)
    assert 0.8 * target <= count <= 1.1 * target
    assert np.array_equal(np.unique(labels), np.arange(count))


def test_small_clouds_are_not_thinned():
    labels, count = thin_by_voxels(sphere(50), 50)
    assert count == 50
    assert np.array_equal(labels, np.arange(50))


def test_farthest_points_are_an_even_sample_at_every_length():
    points = np.vstack([sphere(3_000), sphere(3_000, 1) * 0.01 + [1.0, 0.0, 0.0]])
    order = farthest_point_order(points, 200)
    assert len(set(order)) == 200
    for length in (20, 60, 200):
        chosen = points[order[:length]]
        gap = cKDTree(chosen).query(chosen, k=2)[0][:, 1].min()
        cover = cKDTree(chosen).query(points)[0].max()
        assert cover <= gap  # Gonzalez: what is left is nearer than the chosen are to each other


def test_farthest_points_of_few_and_no_points():
    assert sorted(farthest_point_order(sphere(7), 20)) == list(range(7))
    assert farthest_point_order(np.zeros((0, 3)), 5).shape == (0,)


def farthest_in_turn(points, count):
    order = [int(np.argmax(((points - points.mean(axis=0)) ** 2).sum(axis=1)))]
    gaps = np.full(len(points), np.inf)
    while len(order) < count:
        gaps = np.minimum(gaps, ((points - points[order[-1]]) ** 2).sum(axis=1))
        order.append(int(np.argmax(gaps)))
    return order


@pytest.mark.parametrize("count", [1, 2, 7, 8, 9, 300])
def test_farthest_points_are_those_of_a_plain_search(count):
    rng = np.random.default_rng(count)
    lattice = rng.integers(0, 5, size=(count, 3)).astype(float)  # ties, and points twice
    for points in (rng.normal(size=(count, 3)), lattice):
        for wanted in (1, count // 2 + 1, count):
            found = farthest_point_order(points, wanted).tolist()
            assert found == farthest_in_turn(points, wanted)


def test_more_farthest_points_than_points_are_refused():
    with pytest.raises(ValueError, match="more points"):
        _native.farthest_points(np.zeros((3, 3)), 4, 0)
    with pytest.raises(ValueError, match="more points"):
        _native.farthest_points(np.zeros((3, 3)), 1, 3)
