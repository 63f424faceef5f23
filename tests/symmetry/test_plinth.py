import numpy as np
import pytest

from meshlab_symrecon.symmetry.detection import detect_reflection_planes
from meshlab_symrecon.symmetry.plinth import off_plinth


def box(count, half, centre, rng):
    """Even samples of all six faces."""
    half = np.asarray(half)
    areas = np.array([half[1] * half[2], half[0] * half[2], half[0] * half[1]])
    faces = rng.choice(3, count, p=areas / areas.sum())
    places = rng.uniform(-1, 1, size=(count, 3))
    places[np.arange(count), faces] = rng.choice([-1.0, 1.0], count)
    return places * half + centre


def on_plinth(statue, rng, yaw=0.4):
    """A statue on a box whose sides are turned; the box comes last. Its diagonal is 1."""
    low = statue[:, 2].min()
    plinth = box(len(statue) // 2, [0.8, 0.9, 0.12], [0.0, 0.0, low - 0.121], rng)
    turn = np.array([[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1.0]])
    cloud = np.vstack([statue, plinth @ turn.T])
    return cloud / np.linalg.norm(np.ptp(cloud, axis=0))


@pytest.mark.parametrize("noise", [0.0, 0.003])
@pytest.mark.parametrize("seed", range(3))
def test_a_plinth_goes_and_its_statue_stays(shapes, seed, noise):
    rng = np.random.default_rng(seed)
    statue = shapes.blob(4_000, seed, mirrored=True)
    cloud = on_plinth(statue, rng)
    matrix = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    cloud = cloud @ matrix.T + rng.normal(0, noise, cloud.shape)
    order = rng.permutation(len(cloud))
    stays = np.empty(len(cloud), dtype=bool)
    stays[order] = off_plinth(cloud[order])
    assert stays[: len(statue)].mean() > 0.97  # the foot of the statue goes with the plinth
    assert stays[len(statue) :].mean() < 0.02


def test_what_has_no_plinth_stays_whole(shapes):
    for seed in range(3):
        statue = shapes.blob(5_000, seed, mirrored=True)
        for cloud in (statue, statue[statue[:, 2] > -0.4]):  # the other one is cut off flat, open
            assert off_plinth(cloud / np.linalg.norm(np.ptp(cloud, axis=0))).all()
    prism = shapes.twisted_prism(5_000, 0)
    assert off_plinth(prism / np.linalg.norm(np.ptp(prism, axis=0))).all()


@pytest.mark.parametrize("count", [5, 60, 399])
def test_a_few_points_have_no_plinth(count):
    assert off_plinth(np.random.default_rng(0).random((count, 3))).shape == (count,)
    assert off_plinth(np.random.default_rng(0).random((count, 3))).all()


def test_a_slab_is_no_plinth_of_nothing():
    slab = box(4_000, [0.5, 0.4, 0.05], [0.0, 0.0, 0.0], np.random.default_rng(0))
    assert off_plinth(slab).all()


def test_the_plane_of_a_statue_is_found_on_a_turned_plinth_and_none_for_an_asymmetric_one(shapes):
    rng = np.random.default_rng(5)
    statue = shapes.bitten(shapes.blob(7_000, 3, mirrored=True), [1.0, 0.25, -0.15], 0.25)
    found = detect_reflection_planes(on_plinth(statue, rng))
    assert abs(found.planes[0, 0]) > np.cos(np.radians(1.0))
    asymmetric = shapes.blob(6_000, 50, mirrored=False)
    assert detect_reflection_planes(on_plinth(asymmetric, rng)).planes.shape == (0, 4)
