import numpy as np
import pytest
from symmetry.bodies import ellipsoid, jug, no_planes, vase

from meshlab_symrecon.geometry.planes import plane_angles
from meshlab_symrecon.symmetry.preparation import prepare
from meshlab_symrecon.symmetry.revolution import (
    COUNT,
    FEWEST_PLANES,
    Axis,
    meridians,
    on_axis,
    revolution_axis,
)

TOLERANCE = 0.006
HANDLE = np.array([[0.0, 1.0, 0.0, 0.0]])  # the jug's plane


def planes_through(axis, turns):
    first, second = np.linalg.svd(axis.direction[np.newaxis])[2][1:]
    normals = np.cos(turns)[:, np.newaxis] * first + np.sin(turns)[:, np.newaxis] * second
    return np.column_stack([normals, -normals @ axis.point])


def slanted_axis():
    return Axis(np.array([0.05, -0.1, 0.02]), np.array([0.48, -0.6, 0.64]))


def upright_axis(cloud):
    """The z axis of the scan in the frame of the prepared cloud."""
    return Axis(-cloud.axes @ cloud.centre / cloud.scale, cloud.axes @ [0.0, 0.0, 1.0])


def box(count=6_000):
    rng = np.random.default_rng(0)
    half = np.array([1.0, 0.7, 0.4])
    areas = np.array([half[1] * half[2], half[0] * half[2], half[0] * half[1]])
    faces = rng.choice(3, count, p=areas / areas.sum())
    places = rng.uniform(-1, 1, (count, 3))
    places[np.arange(count), faces] = rng.choice([-1.0, 1.0], count)
    return places * half


@pytest.fixture(scope="module")
def clouds():
    scans = {"vase": vase(8_000), "jug": jug(8_000), "box": box()}
    return {name: prepare(scan, None, 2_000) for name, scan in scans.items()}


def test_the_axis_of_planes_through_a_line_is_that_line():
    axis = slanted_axis()
    planes = planes_through(axis, np.linspace(0.0, 3.0, 7))
    planes[::2] *= -1.0
    others = np.eye(4)[:3]
    found = revolution_axis(np.vstack([others, planes]), np.full(10, 0.8))
    assert np.linalg.norm(np.cross(found.direction, axis.direction)) < 1e-12
    assert np.linalg.norm(np.cross(found.point - axis.point, axis.direction)) < 1e-12
    assert np.linalg.norm(found.direction) == pytest.approx(1.0)


def test_badly_agreeing_planes_define_no_axis():
    planes = planes_through(slanted_axis(), np.linspace(0.0, 3.0, 7))
    assert revolution_axis(planes, np.array([0.9, 0.9, 0.9, 0.3, 0.3, 0.3, 0.3])) is None


def test_fewer_than_four_planes_define_no_axis():
    planes = planes_through(slanted_axis(), np.linspace(0.0, 2.5, FEWEST_PLANES - 1))
    assert revolution_axis(planes, np.ones(len(planes))) is None
    assert revolution_axis(no_planes(), np.zeros(0)) is None
    assert revolution_axis(np.eye(4)[:3], np.ones(3)) is None
    one_line = np.repeat(planes[:1], 8, axis=0)
    assert revolution_axis(one_line, np.ones(8)) is None


def test_planes_are_on_an_axis_up_to_a_tilt_and_a_distance():
    axis = Axis(np.zeros(3), np.array([0.0, 0.0, 1.0]))
    sines = np.sin(np.radians([0.0, 4.9, 5.1, 0.0, 0.0]))
    planes = np.column_stack(
        [np.sqrt(1 - sines**2), np.zeros(5), sines, [0.0, 0.0, 0.0, -0.019, 0.021]]
    )
    assert list(on_axis(planes, axis)) == [True, True, False, True, False]
    assert list(on_axis(-planes, axis)) == [True, True, False, True, False]
    assert on_axis(no_planes(), axis).shape == (0,)


def test_meridians_pass_through_the_axis_and_are_evenly_turned(clouds):
    axis = upright_axis(clouds["vase"])
    found = meridians(axis, clouds["vase"], TOLERANCE)
    assert found.planes.shape == (COUNT, 4)
    assert np.abs(found.planes[:, :3] @ axis.direction).max() < 1e-12
    assert np.abs(found.planes[:, :3] @ axis.point + found.planes[:, 3]).max() < 1e-12
    turns = plane_angles(found.planes, found.planes[0])
    assert np.allclose(np.sort(turns)[1:], np.repeat(np.arange(1, 31), 2)[:59] * np.pi / 60)


def test_nothing_is_off_a_pure_body_of_revolution(clouds):
    assert meridians(upright_axis(clouds["vase"]), clouds["vase"], TOLERANCE).off_body < 0.01


def test_the_meridian_through_the_handle_matches_it_best(clouds):
    cloud = clouds["jug"]
    found = meridians(upright_axis(cloud), cloud, TOLERANCE)
    assert found.off_body > 0.02
    best = found.planes[np.argmax(found.handle)]
    true = cloud.from_input(HANDLE)[0]
    assert plane_angles(best[np.newaxis], true)[0] <= np.pi / 2 / COUNT + 0.02
    apart = plane_angles(found.planes, true) > np.radians(20.0)
    assert found.handle[apart].max() < 0.5 * found.handle.max()


def test_a_box_is_no_body_of_revolution(clouds):
    cloud = clouds["box"]
    for direction in np.eye(3):
        axis = Axis(-cloud.axes @ cloud.centre / cloud.scale, cloud.axes @ direction)
        assert meridians(axis, cloud, TOLERANCE) is None


def test_an_ellipsoid_is_one_only_if_two_of_its_axes_are_equal():
    for axes, expected in (([0.5, 0.5, 0.3], True), ([0.5, 0.35, 0.3], False)):
        cloud = prepare(ellipsoid(6_000, axes), None, 1_000)
        found = meridians(upright_axis(cloud), cloud, TOLERANCE)
        assert (found is not None) is expected
