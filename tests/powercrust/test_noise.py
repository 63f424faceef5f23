"""Outliers, small balls and small handles."""

import itertools

import numpy as np
import pytest
import shapes

from meshlab_symrecon import _native
from meshlab_symrecon.geometry.surfaces import topology
from meshlab_symrecon.geometry.triangulation import delaunay, regular_triangulation
from meshlab_symrecon.powercrust.crust import crust_faces
from meshlab_symrecon.powercrust.handles import without_small_handles
from meshlab_symrecon.powercrust.outliers import outliers
from meshlab_symrecon.powercrust.poles import CUBE, Poles, enclose, find_poles
from meshlab_symrecon.powercrust.small_balls import (
    THIN,
    NoiseLimits,
    drop_small_balls,
    noise_limits,
    relative_sizes,
)


def poles_of(samples):
    voronoi = delaunay(enclose(samples))
    return voronoi, find_poles(voronoi, len(samples))


def told(samples):
    return outliers(*poles_of(samples))


def off_the_torus(points, distance):
    ring = np.hypot(np.hypot(points[:, 0], points[:, 1]) - 1.0, points[:, 2])
    return points[np.abs(ring - 0.4) > distance]


@pytest.mark.parametrize("share", [0.01, 0.05, 0.1])
def test_outliers_in_the_box_are_told_and_samples_are_not(share):
    rng = np.random.default_rng(int(1000 * share))
    samples = shapes.torus(6000, seed=4)
    stray = off_the_torus(rng.uniform(-1.5, 1.5, (int(6000 * share), 3)), 0.2)
    marked = told(np.concatenate([samples, stray]))
    assert np.mean(marked[:6000]) < 0.002
    assert np.mean(marked[6000:]) > 0.97


def test_clean_samples_have_no_outliers():
    for samples in (shapes.torus(3000, seed=1), shapes.fibonacci_sphere(900)):
        assert not told(samples).any()
    assert not told(shapes.box_lattice(12)).any()
    assert np.count_nonzero(told(shapes.statue(3000))) <= 1  # uneven: one lies quite alone


def test_a_sparse_half_of_a_surface_is_kept():
    samples = shapes.torus(12_000, seed=2)
    keep = (samples[:, 0] > 0) | (np.random.default_rng(3).random(len(samples)) < 0.1)
    assert np.mean(told(samples[keep])) < 0.002


def test_two_bodies_far_apart_are_kept():
    ball = shapes.fibonacci_sphere(500)
    assert not told(np.concatenate([ball, 0.5 * ball + 20.0])).any()


def test_outliers_follow_motion_scale_and_order():
    rng = np.random.default_rng(5)
    samples = np.concatenate([shapes.torus(3000, seed=5), rng.uniform(-1.5, 1.5, (60, 3))])
    marked = told(samples)
    assert marked.any()
    order = rng.permutation(len(samples))
    np.testing.assert_array_equal(told(samples[order]), marked[order])
    np.testing.assert_array_equal(told(samples * 2.0**-20), marked)
    turned = told(samples @ shapes.rotation(6).T)
    assert np.count_nonzero(turned != marked) <= 2  # rounding moves who is at a threshold


def test_links_match_brute_force():
    samples = np.random.default_rng(8).random((120, 3))
    voronoi, poles = poles_of(samples)
    loose = np.zeros(120, dtype=np.uint8)
    loose[::10] = 1
    piece = _native.linked_pieces(voronoi.sites, voronoi.cells, poles.room, loose, 0.9)
    label = np.arange(120)
    for cell in voronoi.cells:
        for a, b in itertools.combinations(cell, 2):
            if max(a, b) < 120 and not loose[a] and not loose[b]:
                apart = np.linalg.norm(samples[a] - samples[b])
                if apart <= 0.9 * min(poles.room[a], poles.room[b]):
                    label[label == label[a]] = label[b]
    together = label[:, None] == label
    np.testing.assert_array_equal(piece[:, None] == piece, together)
    assert 13 < len(np.unique(piece)) < 120


@pytest.mark.parametrize("change", ["room", "loose", "cells"])
def test_links_refuse_what_does_not_fit(change):
    voronoi, poles = poles_of(np.random.default_rng(9).random((20, 3)))
    cells, room, loose = voronoi.cells, poles.room, np.zeros(20, dtype=np.uint8)
    if change == "room":
        room = np.ones(50)
    elif change == "loose":
        loose = loose[:3]
    else:
        cells = cells + 20
    with pytest.raises(ValueError, match=r"a sample are needed|unknown sites"):
        _native.linked_pieces(voronoi.sites, cells, room, loose, 1.0)


def test_clean_samples_keep_all_balls():
    for samples in (shapes.torus(3000, seed=1), shapes.statue(3000), shapes.fibonacci_sphere(500)):
        poles = poles_of(samples)[1]
        assert noise_limits(poles) == NoiseLimits(ball=0.0, handle=THIN)
        assert drop_small_balls(poles, 0.0) == (poles, 0)


def test_a_thin_wall_is_no_noise():
    """A tube whose wall is thinner than the spacing: every inner ball is small."""
    rng = np.random.default_rng(12)
    turn, height = rng.random((2, 6000)) * [[2 * np.pi], [2.0]]
    radius = np.where(rng.random(6000) < 0.5, 1.0, 0.97)
    samples = np.stack([radius * np.cos(turn), radius * np.sin(turn), height], axis=1)
    poles = poles_of(samples)[1]
    assert np.median(poles.radii[poles.pairs].min(axis=1) / poles.room[poles.pair_samples]) < 1.5
    assert noise_limits(poles) == NoiseLimits(ball=0.0, handle=THIN)


def test_a_little_noise_limits_handles_alone():
    rng = np.random.default_rng(13)
    samples = shapes.torus(6000, seed=11) + rng.normal(0.0, 0.02, (6000, 3))
    assert noise_limits(poles_of(samples)[1]) == NoiseLimits(ball=0.0, handle=1.5)


def test_noisy_samples_lose_the_balls_inside_their_band():
    rng = np.random.default_rng(11)
    samples = shapes.torus(6000, seed=11) + rng.normal(0.0, 0.05, (6000, 3))
    poles = poles_of(samples)[1]
    smallest = noise_limits(poles).ball
    assert smallest > 0.0
    kept, dropped = drop_small_balls(poles, smallest)
    assert dropped == len(poles.centres) - len(kept.centres) > 0
    assert ((relative_sizes(kept) >= smallest) | kept.outermost).all()
    # what is left of the pairs are the pairs with both balls left, in their order
    large = (relative_sizes(poles) >= smallest) | poles.outermost
    both = large[poles.pairs].all(axis=1)
    np.testing.assert_array_equal(kept.pair_samples, poles.pair_samples[both])
    np.testing.assert_array_equal(kept.centres[kept.pairs], poles.centres[poles.pairs[both]])


def labelled_lattice(steps, chosen):
    """A jittered lattice of equal balls, with the chosen ones inside."""
    grid = np.stack(np.meshgrid(*[np.arange(steps)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    jitter = np.random.default_rng(0).uniform(-0.05, 0.05, grid.shape)
    diagram = regular_triangulation(grid + jitter, np.ones(len(grid)))
    return diagram, np.array([chosen(*place) for place in grid])


def genus_and_pieces(diagram, inside):
    count = len(inside)
    poles = Poles(
        sites=np.concatenate([diagram.sites, 100.0 * CUBE]),
        centres=diagram.sites,
        radii=np.ones(count),
        samples=np.repeat(np.arange(count)[:, None], 4, axis=1),
        pairs=np.zeros((0, 2), dtype=int),
        pair_samples=np.zeros(0, dtype=int),
        outermost=np.zeros(count, dtype=bool),
        spacing=np.full(count, 1e-9),
        room=np.ones(count),
    )
    shape = topology(crust_faces(poles, diagram, inside).faces)
    return shape.genus, shape.components


def ring(x, y, z):
    return 2 <= z <= 4 and 2 <= x <= 11 and 2 <= y <= 11 and not (5 <= x <= 8 and 5 <= y <= 8)


def bridged_ring(x, y, z):
    return ring(x, y, z) or (y == 6 and z == 3 and 2 <= x <= 11)


def pierced_ring(x, y, z):
    return ring(x, y, z) and not (x == 3 and y == 6)


@pytest.mark.parametrize("chosen", [bridged_ring, pierced_ring])
def test_thin_bridges_and_tunnels_go_and_the_ring_stays(chosen):
    diagram, inside = labelled_lattice(14, chosen)
    _, wanted = labelled_lattice(14, ring)
    assert genus_and_pieces(diagram, wanted) == (1, 1)
    assert genus_and_pieces(diagram, inside) == (2, 1)
    sizes = np.where(inside == wanted, 2.0, 0.5)
    outer = np.zeros(len(inside), dtype=bool)
    mended = without_small_handles(diagram, inside, outer, sizes, 1.0)
    assert genus_and_pieces(diagram, mended) == (1, 1)
    assert np.count_nonzero(mended != wanted) <= 3  # the bridge is cut, not taken away
    kept = without_small_handles(diagram, inside, outer, sizes, 0.1)
    np.testing.assert_array_equal(kept, inside)


def test_a_handle_of_small_balls_alone_goes():
    diagram, inside = labelled_lattice(14, ring)
    sizes = np.full(len(inside), 0.5)
    outer = np.zeros(len(inside), dtype=bool)
    outer[0] = True
    mended = without_small_handles(diagram, inside, outer, sizes, 1.0)
    assert genus_and_pieces(diagram, mended) == (0, 1)


@pytest.mark.parametrize("change", ["certain", "size", "cells"])
def test_growth_refuses_what_does_not_fit(change):
    diagram, inside = labelled_lattice(3, lambda x, y, z: x + y + z == 3)
    wanted, certain, size = inside.astype(np.uint8), inside.astype(np.uint8), np.ones(27)
    cells = diagram.cells
    if change == "certain":
        certain = certain[1:]
    elif change == "size":
        size = size[1:]
    else:
        cells = cells + 27
    with pytest.raises(ValueError, match=r"entry a site|unknown sites"):
        _native.grow_without_loops(cells, wanted, certain, size)
