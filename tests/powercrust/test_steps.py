"""Each step of the recipe on its own."""

import itertools

import numpy as np
import pytest
import shapes
from scipy.spatial import cKDTree

from meshlab_symrecon import _native
from meshlab_symrecon.geometry.surfaces import topology
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


def test_any_labels_give_a_closed_manifold():
    """The crust is closed by construction, so even random labels must not open it."""
    _, poles = torus_poles(400)
    diagram = regular_triangulation(poles.centres, poles.radii**2)
    hull = np.zeros(len(poles.centres), dtype=bool)
    cell, corner = np.nonzero(diagram.neighbours < 0)
    for step in (1, 2, 3):
        hull[diagram.cells[cell, (corner + step) % 4]] = True
    rng = np.random.default_rng(0)
    for _ in range(5):
        inside = (rng.random(len(hull)) < 0.5) & ~hull
        offsets, corners, inner, outer = _native.mixed_edge_polygons(
            diagram.cells, diagram.neighbours, inside.astype(np.uint8)
        )
        assert inside[inner].all()
        assert not inside[outer].any()
        faces = np.array(
            [
                (corners[start], corners[k], corners[k + 1])
                for start, end in itertools.pairwise(offsets)
                for k in range(start + 1, end - 1)
            ]
        ).astype(np.int64)
        shape = topology(faces)
        assert shape.closed
        assert shape.edge_manifold
        assert shape.vertex_manifold
        assert shape.oriented


def test_an_inner_pole_on_the_hull_is_refused():
    points = np.random.default_rng(1).random((20, 3))
    cells = delaunay(points)
    with pytest.raises(ValueError, match="hull"):
        _native.mixed_edge_polygons(
            cells.cells, cells.neighbours, (np.arange(20) < 10).astype(np.uint8)
        )


def test_contraction_keeps_the_topology_of_a_torus_and_of_a_tetrahedron():
    points, faces = shapes.torus_mesh(24, 36)
    shortest = np.full(len(points), 0.3)
    none = np.full(len(points), -1, dtype=np.int32)
    moved, kept = _native.contract_edges(points, faces.astype(np.int32), none, points, shortest)
    assert len(moved) < len(points) / 2
    shape = topology(kept.astype(np.int64))
    assert (shape.closed, shape.vertex_manifold, shape.genus) == (True, True, 1)

    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    sides = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], dtype=np.int32)
    same = np.zeros(4, dtype=np.int32)
    _, left = _native.contract_edges(corners, sides, same, corners, np.full(4, 9.0))
    assert len(left) == 4


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
    # not all of the four nearest samples are Delaunay neighbours, but most are
    assert np.all(poles.room >= apart[:, 1:].mean(axis=1) * (1 - 1e-12))
    assert np.median(poles.room / apart[:, 1:].mean(axis=1)) < 1.001
