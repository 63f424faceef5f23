"""Each step of the recipe on its own."""

import numpy as np
import pytest
import shapes
from scipy.spatial import cKDTree

from meshlab_symrecon.geometry.triangulation import circumcentres, delaunay, regular_triangulation
from meshlab_symrecon.powercrust.attributes import carry_over
from meshlab_symrecon.powercrust.labelling import label_poles
from meshlab_symrecon.powercrust.poles import enclose, find_poles


def torus_poles(count=1500):
    samples = shapes.torus(count, seed=11)
    return samples, find_poles(delaunay(enclose(samples)), count)


def test_the_enclosure_is_a_cube_round_the_box():
    samples = shapes.fibonacci_sphere(100) * [3.0, 2.0, 1.0] + np.array([5.0, 0, 0])
    corners = enclose(samples)[100:]
    centre = corners.mean(axis=0)
    np.testing.assert_allclose(centre, [5, 0, 0], atol=0.1)
    sides = np.sort(np.linalg.norm(corners - corners[0], axis=1))[1:4]
    np.testing.assert_allclose(sides, sides[0])
    assert sides[0] == pytest.approx(8 * 6, rel=0.05)  # eight times the longest extent, 6


def test_poles_are_the_farthest_voronoi_vertices_on_either_side():
    samples, poles = torus_poles(300)
    voronoi = delaunay(enclose(samples))
    centres = circumcentres(voronoi)
    for (first, second), sample in zip(poles.pairs, poles.pair_samples, strict=True):
        own = centres[(voronoi.cells == sample).any(axis=1)] - samples[sample]
        lengths = np.linalg.norm(own, axis=1)
        assert np.isclose(poles.radii[first], lengths.max(), rtol=1e-12)
        behind = own @ own[np.argmax(lengths)] <= 0
        assert np.isclose(poles.radii[second], lengths[behind].max(), rtol=1e-12)


def test_no_sample_lies_in_a_polar_ball():
    samples, poles = torus_poles()
    gaps = np.linalg.norm(samples[None] - poles.centres[:, None], axis=2).min(axis=1)
    assert (gaps > poles.radii * (1 - 1e-9)).all()


def test_labels_are_the_side_of_the_torus():
    _, poles = torus_poles()
    labels = label_poles(poles, regular_triangulation(poles.centres, poles.radii**2))
    x, y, z = poles.centres.T
    truly_inside = (np.hypot(x, y) - 1) ** 2 + z**2 < 0.4**2
    certain = poles.radii > 0.1
    assert np.array_equal(labels.inside[certain], truly_inside[certain])
    assert labels.unreached == 0


def test_attributes_are_exact_at_samples_and_between_their_neighbours_elsewhere():
    samples = shapes.fibonacci_sphere(200)
    values = samples @ [1.0, 2.0, 3.0]
    assert np.array_equal(carry_over(samples, values, samples), values)
    between = carry_over(samples, values, 0.9 * samples)
    assert values.min() <= between.min()
    assert between.max() <= values.max()
    assert np.unique(carry_over(samples, np.ones(200), 0.9 * samples)).tolist() == [1.0]
    colours = np.random.default_rng(0).random((200, 4))
    assert carry_over(samples, colours, samples[:7]).tolist() == colours[:7].tolist()


def test_spacing_is_the_distance_to_the_nearest_sample():
    samples = np.random.default_rng(31).random((400, 3)) * [3.0, 1.0, 0.1]
    poles = find_poles(delaunay(enclose(samples)), len(samples))
    apart = cKDTree(samples).query(samples, k=5)[0]
    np.testing.assert_array_equal(poles.spacing, apart[:, 1])
    # most of the four nearest samples are Delaunay neighbours; a far fourth does not count
    assert np.all(poles.room >= apart[:, 1:4].mean(axis=1) * (1 - 1e-12))
    assert np.median(poles.room / apart[:, 1:].mean(axis=1)) < 1.001
