"""The medial axis and its two thresholds."""

import itertools

import numpy as np
import pytest
import shapes
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from meshlab_symrecon.geometry.triangulation import delaunay, regular_triangulation
from meshlab_symrecon.powercrust.labelling import label_poles
from meshlab_symrecon.powercrust.medial_axis import medial_axis
from meshlab_symrecon.powercrust.poles import enclose, find_poles


def steps(samples):
    poles = find_poles(delaunay(enclose(samples)), len(samples))
    diagram = regular_triangulation(poles.centres, poles.radii**2)
    return poles, diagram, label_poles(poles, diagram).inside


@pytest.fixture(scope="module")
def torus_steps():
    return steps(shapes.torus(3000, seed=21))


def capsule(count, seed):
    """Random points of the surface at distance 0.3 from the segment of x from -1 to 1."""
    rng = np.random.default_rng(seed)
    directions = rng.normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    points = 0.3 * directions
    points[:, 0] += np.sign(points[:, 0])
    on_side = rng.random(count) < 2.0 / 2.6  # areas: 2 pi r 2 against 4 pi r^2
    ring = directions[on_side, 1:] / np.linalg.norm(directions[on_side, 1:], axis=1, keepdims=True)
    points[on_side, 0] = rng.uniform(-1, 1, len(ring))
    points[on_side, 1:] = 0.3 * ring
    return points + 1e-4 * rng.normal(size=(count, 3))


def pieces(axis):
    count = len(axis.points)
    joined = coo_matrix((np.ones(len(axis.edges)), axis.edges.T), shape=(count, count))
    return connected_components(joined, directed=False)[0]


def test_a_sphere_is_one_ball():
    rng = np.random.default_rng(1)
    samples = shapes.fibonacci_sphere(900) * (1 + 1e-4 * rng.normal(size=(900, 1)))
    axis = medial_axis(*steps(samples), noise=0.1, redundancy=0.02)
    assert axis.points.shape == (1, 3)
    assert np.linalg.norm(axis.points) < 0.01
    assert axis.radii == pytest.approx([1.0], abs=0.01)
    assert len(axis.edges) == len(axis.faces) == 0
    assert not axis.outer.any()


def test_a_capsule_is_its_segment():
    axis = medial_axis(*steps(capsule(4000, 2)), noise=0.1, redundancy=0.05)
    along, off = axis.points[:, 0], np.linalg.norm(axis.points[:, 1:], axis=1)
    assert off.max() < 0.05
    np.testing.assert_allclose(axis.radii, 0.3, atol=0.05)
    assert np.abs(along).max() < 1.05
    assert np.diff(np.sort(along), prepend=-1.0, append=1.0).max() < 0.15
    assert pieces(axis) == 1
    # a curve: most of its edges are in no triangle
    assert len(axis.faces) < len(axis.edges) / 2 < len(axis.points)


def test_a_torus_is_its_circle(torus_steps):
    axis = medial_axis(*torus_steps, noise=0.1, redundancy=0.05)
    assert len(axis.points) < len(torus_steps[0].centres) / 20
    ring = np.hypot(axis.points[:, 0], axis.points[:, 1])
    np.testing.assert_allclose(ring, 1.0, atol=0.05)
    np.testing.assert_allclose(axis.points[:, 2], 0.0, atol=0.05)
    np.testing.assert_allclose(axis.radii, 0.4, atol=0.05)
    angles = np.sort(np.arctan2(axis.points[:, 1], axis.points[:, 0]))
    assert np.diff(angles, append=angles[0] + 2 * np.pi).max() < 0.25
    assert pieces(axis) == 1


@pytest.mark.parametrize("redundancy", [0.01, 0.05, 0.2])
def test_kept_balls_cover_the_others_but_for_the_threshold(torus_steps, redundancy):
    poles, _, inside = torus_steps
    axis = medial_axis(*torus_steps, noise=0.05, redundancy=redundancy)
    centres, radii = poles.centres[inside], poles.radii[inside]
    centres, radii = centres[radii >= 0.05], radii[radii >= 0.05]
    apart = np.linalg.norm(centres[:, None] - axis.points[None], axis=2)
    sticks_out = (apart + radii[:, None] - axis.radii[None]).min(axis=1)
    assert sticks_out.max() < redundancy
    # and it is a simplification: no two kept neighbours could absorb each other
    first, second = axis.edges.T
    between = np.linalg.norm(axis.points[first] - axis.points[second], axis=1)
    assert (between - np.abs(axis.radii[first] - axis.radii[second]) >= redundancy).all()
    assert axis.radii.min() >= 0.05


def brute_force_shape(diagram, member):
    cells = np.sort(diagram.cells[:, :], axis=1).tolist()
    return tuple(
        {
            corners
            for cell in cells
            for corners in itertools.combinations(cell, size)
            if all(member[list(corners)])
        }
        for size in (2, 3)
    )


def test_nothing_is_lost_without_thresholds():
    poles, diagram, inside = steps(shapes.statue(400, seed=5))
    axis = medial_axis(poles, diagram, inside)
    shown = np.flatnonzero(inside & ~diagram.hidden)
    assert np.array_equal(axis.points, poles.centres[shown])
    assert np.array_equal(axis.radii, poles.radii[shown])
    edges, triangles = brute_force_shape(diagram, inside & ~diagram.hidden)
    assert len(axis.edges) == len(edges)
    assert len(axis.faces) == len(triangles)
    assert {tuple(sorted(row)) for row in shown[axis.edges].tolist()} == edges
    assert {tuple(sorted(row)) for row in shown[axis.faces].tolist()} == triangles


def test_absorbing_is_contracting_edges_in_the_order_of_radii():
    """Against plain sets: contract edges of the largest ball first, until none is redundant."""
    poles, diagram, inside = steps(shapes.statue(300, seed=6))
    member = inside & ~diagram.hidden & (poles.radii >= 0.1)
    edges, triangles = brute_force_shape(diagram, member)
    joined = {pole: set() for pole in np.flatnonzero(member)}
    for a, b in edges:
        joined[a].add(b)
        joined[b].add(a)
    stands_for = {pole: pole for pole in joined}
    for pole in sorted(joined, key=lambda pole: -poles.radii[pole]):
        if stands_for[pole] != pole:
            continue
        while True:
            apart = {
                other: np.linalg.norm(poles.centres[other] - poles.centres[pole])
                - (poles.radii[pole] - poles.radii[other])
                for other in joined[pole]
                if poles.radii[other] <= poles.radii[pole]
            }
            near = [other for other, gap in apart.items() if gap < 0.08]
            if not near:
                break
            for other in near:
                stands_for[other] = pole
                for third in joined.pop(other):
                    joined[third].discard(other)
                    if third != pole:
                        joined[third].add(pole)
                        joined[pole].add(third)
    axis = medial_axis(poles, diagram, inside, noise=0.1, redundancy=0.08)
    kept = np.array(sorted(joined))
    assert np.array_equal(axis.points, poles.centres[kept])
    contracted = {
        frozenset(stands_for[corner] for corner in simplex) for simplex in edges | triangles
    }
    assert {frozenset(row) for row in kept[axis.edges].tolist()} == {
        simplex for simplex in contracted if len(simplex) == 2
    }
    assert {frozenset(row) for row in kept[axis.faces].tolist()} == {
        simplex for simplex in contracted if len(simplex) == 3
    }
    assert len(axis.edges) == sum(len(simplex) == 2 for simplex in contracted)


def test_the_outer_part_stays_apart_and_near(torus_steps):
    poles, _, inside = torus_steps
    axis = medial_axis(*torus_steps, outer=True)
    inner = medial_axis(*torus_steps)
    assert np.array_equal(axis.points[~axis.outer], inner.points)
    assert np.count_nonzero(axis.outer) > 100
    assert (axis.outer[axis.edges[:, 0]] == axis.outer[axis.edges[:, 1]]).all()
    assert (np.ptp(axis.outer[axis.faces].astype(int), axis=1) == 0).all()
    distant = {tuple(row) for row in poles.centres[poles.outermost | inside].tolist()}
    assert not distant & {tuple(row) for row in axis.points[axis.outer].tolist()}
    # the hole of the torus: outer balls along the axis of revolution, of the radius of the hole
    hole = axis.outer & (np.abs(axis.points[:, 2]) < 0.05) & (axis.radii > 0.3)
    assert hole.any()
    np.testing.assert_allclose(np.hypot(*axis.points[hole, :2].T), 0.0, atol=0.1)
    np.testing.assert_allclose(axis.radii[hole], 0.6, atol=0.05)


def test_nothing_left_is_empty(torus_steps):
    axis = medial_axis(*torus_steps, noise=9.0, redundancy=1.0, outer=True)
    assert axis.points.shape == (0, 3)
    assert axis.radii.shape == (0,)
    assert axis.faces.shape == (0, 3)
    assert axis.edges.shape == (0, 2)
    assert axis.outer.shape == (0,)
