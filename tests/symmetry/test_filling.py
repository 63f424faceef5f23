from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial import cKDTree
from symmetry.bodies import even_sphere

from meshlab_symrecon.geometry.planes import reflect
from meshlab_symrecon.symmetry.filling import any_missing, fill
from meshlab_symrecon.symmetry.surroundings import surroundings

PLANE = np.array([1.0, 0.0, 0.0, 0.0])
MIDDLE = np.array([0.8, 0.0, 0.6])
GAP = 1.0


@pytest.fixture(scope="module")
def sphere():
    return even_sphere(6_000)


def hollow(sphere, radius, middle=MIDDLE):
    return sphere[np.linalg.norm(sphere - middle, axis=1) > radius]


def around_of(points, *, outward=False):
    return surroundings(points, points if outward else None, 2.0 * 3**0.5)


def filled(scan, *, outward=False, gap=GAP):
    """Return the scan's surroundings, its images, and which of them fill it."""
    around, images = around_of(scan, outward=outward), reflect(scan, PLANE)
    chosen = fill(around, images, np.arange(len(scan)), PLANE, gap)
    assert any_missing(around, images, np.arange(len(scan)), PLANE, gap) or not chosen.any()
    return around, images, chosen


@pytest.mark.parametrize("outward", [False, True])
@pytest.mark.parametrize("radius", [0.2, 0.5, 0.8])
def test_a_hole_on_one_side_is_filled_and_nothing_else(sphere, radius, outward):
    scan = hollow(sphere, radius)
    around, images, chosen = filled(scan, outward=outward)
    fillings, missing = images[chosen], sphere[np.linalg.norm(sphere - MIDDLE, axis=1) <= radius]
    assert (np.linalg.norm(fillings - MIDDLE, axis=1) < radius).all()
    assert cKDTree(scan).query(fillings)[0].min() > 0.5 * around.usual
    reached = cKDTree(np.vstack([scan, fillings])).query(missing)[0]
    assert reached.max() < 1.5 * around.usual
    assert len(fillings) == pytest.approx(len(missing), rel=3.0 * around.usual / radius)


def test_what_both_sides_lack_stays_open(sphere):
    other = MIDDLE * [-1.0, 1.0, 1.0]
    scan = hollow(hollow(sphere, 0.4), 0.4, other)
    assert not filled(scan)[2].any()


def test_a_whole_body_gets_nothing(sphere):
    half = sphere[sphere[:, 0] < 0.0]
    around, images, chosen = filled(np.vstack([half, reflect(half, PLANE)]))
    assert not chosen.any()
    assert not any_missing(around, images, np.arange(len(images)), PLANE, GAP)


def test_a_wider_gap_fills_no_more(sphere):
    scan = hollow(sphere, 0.5)
    chosen = [filled(scan, gap=gap)[2] for gap in (0.5, 1.0, 2.0, 4.0, 100.0)]
    for more, fewer in pairwise(chosen):
        assert (more | ~fewer).all()
        assert more.sum() > fewer.sum() or not more.any()
    assert not chosen[-1].any()


@pytest.mark.parametrize("outward", [False, True])
def test_a_skin_over_the_other_side_is_no_hole(sphere, outward):
    leaning = sphere + np.where(sphere[:, :1] > 0.0, 1.0, -1.0) * [0.0, 0.02, 0.0]
    assert not filled(leaning, outward=outward)[2].any()


def test_the_back_of_a_thin_wall_is_filled_when_normals_tell_it_from_the_front():
    steps = (np.arange(60) + 0.5) / 60
    grid = np.stack(np.meshgrid(steps, steps, [0.0]), axis=-1).reshape(-1, 3)
    left, right = grid * [-1.0, 1.0, 1.0], grid
    lower = left - [0.0, 0.0, 0.02]  # the wall is as thick as the spacing
    scan = np.vstack([left, lower, right])
    normals = np.repeat([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.0, 0.0, 1.0]], 3_600, axis=0)
    for given, expected in ((normals, 3_600), (None, 0)):
        around = surroundings(scan, given, np.sqrt(5.0))
        chosen = fill(around, reflect(scan, PLANE), np.arange(len(scan)), PLANE, GAP)
        assert np.count_nonzero(chosen) == pytest.approx(expected, rel=0.05)
        assert (np.flatnonzero(chosen) // 3_600 == 1).all()  # images of the back


def test_stray_images_are_no_hole(sphere):
    scan = hollow(sphere, 0.5)
    around = around_of(scan)
    stray = np.random.default_rng(0).uniform(-2.0, 2.0, (60, 3))
    stray = stray[np.abs(np.linalg.norm(stray, axis=1) - 1.0) > 0.3]
    images = np.vstack([reflect(scan, PLANE), stray])
    origin = np.concatenate([np.arange(len(scan)), np.arange(len(stray))])
    chosen = fill(around, images, origin, PLANE, GAP)
    assert not chosen[len(scan) :].any()
    assert np.array_equal(chosen[: len(scan)], filled(scan)[2])


def test_no_images_fill_nothing(sphere):
    around, none = around_of(sphere), np.zeros(0, dtype=np.int64)
    assert fill(around, np.zeros((0, 3)), none, PLANE, GAP).shape == (0,)
    assert not any_missing(around, np.zeros((0, 3)), none, PLANE, GAP)
