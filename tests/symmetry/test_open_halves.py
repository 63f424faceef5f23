import dataclasses

import numpy as np
import pytest
from symmetry.bodies import ellipsoid, even_sphere, no_planes

from meshlab_symrecon.geometry.planes import plane_angles
from meshlab_symrecon.symmetry.confidence import half_confidence
from meshlab_symrecon.symmetry.open_halves import examine_halves, rim_planes
from meshlab_symrecon.symmetry.preparation import prepare

MIDDLE = np.array([[1.0, 0.0, 0.0, 0.0]])


def cut(points, plane):
    return points[points @ plane[:3] + plane[3] > 0.0]


@pytest.fixture(scope="module")
def halves(shapes):
    """Bodies cut in two at a mirror plane, and that plane."""
    level = np.array([0.0, 0.0, 1.0, 0.0])
    return {
        "ellipsoid": (cut(ellipsoid(12_000, [0.7, 1.0, 0.6]), MIDDLE[0]), MIDDLE[0]),
        "lying ellipsoid": (cut(ellipsoid(12_000, [0.8, 1.0, 0.6]), level), level),
        "blob": (cut(shapes.blob(12_000, 3, mirrored=True), MIDDLE[0]), MIDDLE[0]),
        "other blob": (cut(shapes.blob(12_000, 7, mirrored=True), MIDDLE[0]), MIDDLE[0]),
    }


@pytest.mark.parametrize("name", ["ellipsoid", "lying ellipsoid", "blob", "other blob"])
def test_the_rim_of_a_half_is_its_mirror_plane(halves, name):
    points, plane = halves[name]
    cloud = prepare(points, None, 500)
    found = rim_planes(cloud)
    assert found.shape == (1, 4)
    true = cloud.from_input(plane[np.newaxis])[0]
    assert np.degrees(plane_angles(found, true)[0]) < 0.5
    assert abs(found[0, 3] * np.sign(found[0, :3] @ true[:3]) - true[3]) < 0.005
    evidence = examine_halves(found, cloud)
    assert evidence.rim_share[0] > 0.8
    assert evidence.beyond[0] < 0.001
    assert evidence.crossing[0] < 0.1
    assert half_confidence(evidence)[0] > 0.5


@pytest.mark.parametrize("degrees", [0.0, 20.0, 40.0])
def test_a_ball_is_crossed_at_the_sine_of_the_cut_s_latitude(degrees):
    """On a ball the cosine between the surface's normal and the cut's is the height of the cut."""
    latitude = np.sin(np.radians(degrees))
    for side in (-1.0, 1.0):
        points = ellipsoid(12_000, [1.0, 1.0, 1.0])
        cloud = prepare(points[points[:, 2] > side * latitude], None, 500)
        crossing = examine_halves(rim_planes(cloud), cloud).crossing[0]
        assert crossing == pytest.approx(latitude, abs=0.03)


def test_a_ball_s_cap_is_as_thick_as_it_is_high():
    points = ellipsoid(12_000, [1.0, 1.0, 1.0])
    cloud = prepare(points[points[:, 2] > 0.0], None, 500)
    assert examine_halves(rim_planes(cloud), cloud).thickness[0] == pytest.approx(0.5, abs=0.02)
    cloud = prepare(points[points[:, 2] > -0.8], None, 500)
    assert examine_halves(rim_planes(cloud), cloud).thickness[0] == pytest.approx(0.9, abs=0.02)


def test_planes_elsewhere_are_not_the_rim(halves):
    points, plane = halves["ellipsoid"]
    cloud = prepare(points, None, 500)
    inside = cloud.from_input(np.array([plane - [0.0, 0.0, 0.0, 0.3], [0.0, 1.0, 0.0, 0.0]]))
    found = examine_halves(inside, cloud)
    assert (found.rim_share < 0.3).all()
    assert (found.beyond > 0.1).all()
    assert (half_confidence(found) == 0.0).all()


def test_the_way_a_plane_is_written_does_not_matter(halves):
    points, _ = halves["blob"]
    cloud = prepare(points, None, 500)
    planes = np.vstack([rim_planes(cloud), np.eye(4)[:2]])
    one, other = examine_halves(planes, cloud), examine_halves(-planes, cloud)
    for field in dataclasses.fields(one):
        assert np.allclose(getattr(one, field.name), getattr(other, field.name), rtol=1e-9)


def test_a_whole_body_has_no_rim_plane_and_no_half():
    cloud = prepare(even_sphere(4_000), None, 100)
    assert rim_planes(cloud).shape == (0, 4)
    found = examine_halves(np.eye(4)[:3], cloud)
    assert (found.rim_share == 0.0).all()
    assert (half_confidence(found) == 0.0).all()


def test_no_planes_have_no_evidence(statue):
    found = examine_halves(no_planes(), prepare(statue, None, 10))
    for field in dataclasses.fields(found):
        assert getattr(found, field.name).shape == (0,)
    assert half_confidence(found).shape == (0,)


def test_a_cloud_that_is_all_border_has_finite_evidence(statue):
    cloud = prepare(statue, None, 10)
    everywhere = np.ones(len(cloud.points), dtype=bool)
    zero = np.zeros(len(cloud.points))
    cloud = dataclasses.replace(cloud, border=everywhere, border_distance=zero)
    found = examine_halves(np.eye(4)[:3], cloud)
    assert (found.crossing == 1.0).all()
    assert ((found.rim_share >= 0.0) & (found.rim_share <= 1.0)).all()
    assert (half_confidence(found) == 0.0).all()
