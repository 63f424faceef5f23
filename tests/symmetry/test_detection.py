import dataclasses

import numpy as np
import pytest

from meshlab_symrecon.errors import GeometryError, ParameterError
from meshlab_symrecon.geometry.planes import plane_angles
from meshlab_symrecon.symmetry.detection import DetectionOptions, detect_reflection_planes

TRUE = np.array([1.0, 0.0, 0.0, 0.0])


def turn(seed):
    matrix = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    return matrix * np.sign(np.linalg.det(matrix))


def assert_same_plane(plane, expected, diagonal, centre, degrees, share):
    """Angles differ by less than degrees, offsets at the centre by less than a share of the size."""
    assert np.degrees(plane_angles(plane[np.newaxis], expected)[0]) < degrees
    sign = np.sign(plane[:3] @ expected[:3])
    gap = sign * (plane[:3] @ centre + plane[3]) - (expected[:3] @ centre + expected[3])
    assert abs(gap) < share * diagonal


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_plane_of_a_body_with_a_quarter_missing(shapes, seed, noise):
    rng = np.random.default_rng(seed)
    whole = shapes.blob(6_000, seed, mirrored=True)
    direction = rng.normal(0, 0.3, 3) + [1.0, 0.0, 0.0]
    scan = shapes.bitten(whole, direction, 0.25)
    scan = scan + rng.normal(0, noise, scan.shape)
    found = detect_reflection_planes(scan)
    assert len(found.planes) >= 1
    diagonal = np.linalg.norm(np.ptp(whole, axis=0))
    assert_same_plane(found.planes[0], TRUE, diagonal, whole.mean(axis=0), 1.0, 0.01)
    assert np.allclose(np.linalg.norm(found.planes[:, :3], axis=1), 1.0)
    assert (np.diff(found.confidence) <= 0).all()
    assert ((found.confidence >= 0.5) & (found.confidence <= 1)).all()
    assert found.residual[0] < 0.01
    assert found.converged


def test_plane_of_a_box_with_horns(shapes):
    scan = shapes.bitten(shapes.box_with_horns(5_000, 0), [0.8, 0.0, 0.6], 0.2)
    found = detect_reflection_planes(scan)
    assert_same_plane(found.planes[0], TRUE, 3.0, np.zeros(3), 0.5, 0.005)


def test_two_of_three_planes_of_an_ellipsoid_come_with_the_third():
    directions = np.random.default_rng(0).normal(size=(6_000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    found = detect_reflection_planes(directions * [1.0, 0.7, 0.45])
    assert len(found.planes) >= 3
    cosines = np.abs(found.planes[:3, :3])
    assert sorted(cosines.argmax(axis=1)) == [0, 1, 2]
    assert cosines.max(axis=1).min() > np.cos(np.radians(0.5))


@pytest.mark.parametrize("seed", range(4))
def test_an_asymmetric_body_has_no_plane(shapes, seed):
    found = detect_reflection_planes(shapes.blob(6_000, 50 + seed, mirrored=False))
    assert found.planes.shape == (0, 4)
    assert found.support.shape == found.residual.shape == found.confidence.shape == (0,)


@pytest.mark.parametrize("share", [0.0, 0.25])
def test_a_chiral_body_has_no_plane(shapes, share):
    scan = shapes.bitten(shapes.twisted_prism(7_000, 0), [1.0, 0.3, 0.2], share)
    assert detect_reflection_planes(scan).planes.shape == (0, 4)


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e6])
@pytest.mark.parametrize("seed", [0, 1])
def test_planes_follow_motions_and_scale(shapes, statue, scale, seed):
    at_rest = detect_reflection_planes(statue).planes[0]
    matrix, shift = turn(seed), np.random.default_rng(seed).normal(0, 10, 3)
    moved = scale * (statue @ matrix.T + shift)
    found = detect_reflection_planes(moved).planes[0]
    normal = matrix @ at_rest[:3]
    expected = np.append(normal, scale * (at_rest[3] - normal @ shift))
    diagonal = np.linalg.norm(np.ptp(moved, axis=0))
    assert_same_plane(found, expected, diagonal, moved.mean(axis=0), 0.1, 0.001)


def test_permuted_points_give_the_same_bytes(statue):
    found = detect_reflection_planes(statue)
    shuffled = detect_reflection_planes(np.random.default_rng(0).permutation(statue))
    for field in dataclasses.fields(found):
        one, other = getattr(found, field.name), getattr(shuffled, field.name)
        assert np.asarray(one).tobytes() == np.asarray(other).tobytes()


def test_same_seed_gives_the_same_bytes_and_the_input_stays(statue):
    before = statue.copy()
    one = detect_reflection_planes(statue, rng=np.random.default_rng(4))
    other = detect_reflection_planes(statue, rng=np.random.default_rng(4))
    assert one.planes.tobytes() == other.planes.tobytes()
    assert one.confidence.tobytes() == other.confidence.tobytes()
    assert np.array_equal(statue, before)


def test_outward_normals_may_be_given(statue):
    plain = detect_reflection_planes(statue).planes[0]
    hinted = detect_reflection_planes(statue, statue / np.linalg.norm(statue, axis=1)[:, None])
    assert_same_plane(hinted.planes[0], plain, 3.0, np.zeros(3), 0.2, 0.002)


def test_duplicated_points_change_nothing_much(statue):
    found = detect_reflection_planes(np.repeat(statue, 2, axis=0)).planes
    assert_same_plane(found[0], TRUE, 3.0, np.zeros(3), 1.0, 0.01)


DEGENERATE = {
    **{f"{count} points": np.random.default_rng(0).random((count, 3)) for count in range(5)},
    "coinciding": np.ones((500, 3)),
    "collinear": np.outer(np.linspace(0, 1, 500), [1.0, 2.0, 3.0]) + 5.0,
    "coplanar": np.random.default_rng(1).random((500, 3)) * [1.0, 1.0, 0.0] + 7.0,
}


@pytest.mark.parametrize("case", DEGENERATE)
def test_degenerate_clouds_are_refused_with_a_sentence(case):
    with pytest.raises(GeometryError, match="detection of reflection planes needs .*; got .*; "):
        detect_reflection_planes(DEGENERATE[case])


@pytest.mark.parametrize("count", [5, 6, 8, 12, 20, 40, 100])
def test_a_handful_of_random_points_has_no_plane(count):
    found = detect_reflection_planes(np.random.default_rng(count).random((count, 3)))
    assert found.planes.shape == (0, 4)


def test_points_that_are_not_finite_are_refused(statue):
    broken = statue.copy()
    broken[7, 1] = np.nan
    with pytest.raises(GeometryError, match="first at index 7"):
        detect_reflection_planes(broken)


def test_normals_of_another_cloud_are_refused(statue):
    with pytest.raises(GeometryError, match="normals are needed"):
        detect_reflection_planes(statue, np.ones((3, 3)))


@pytest.mark.parametrize(
    "wrong",
    [
        {"max_planes": 0},
        {"max_planes": 100},
        {"min_confidence": -0.1},
        {"min_confidence": float("nan")},
        {"sample_count": 10},
    ],
    ids=str,
)
def test_options_out_of_range_are_refused(wrong):
    with pytest.raises(ParameterError, match=f"{next(iter(wrong))} must lie between"):
        DetectionOptions(**wrong)


def test_options_limit_the_answer(shapes):
    directions = np.random.default_rng(0).normal(size=(3_000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    cloud = directions * [1.0, 0.7, 0.45]
    one = detect_reflection_planes(cloud, options=DetectionOptions(max_planes=1))
    assert one.planes.shape == (1, 4)
    certain = detect_reflection_planes(
        shapes.blob(3_000, 50, mirrored=False), options=DetectionOptions(min_confidence=0.0)
    )
    assert len(certain.planes) >= 1
    assert certain.confidence.max() < 0.5


def test_progress_is_reported_to_its_end(statue):
    calls = []
    detect_reflection_planes(statue, progress=lambda *call: calls.append(call))
    fractions = [fraction for fraction, _ in calls]
    assert fractions == sorted(fractions)
    assert fractions[0] == 0.0
    assert fractions[-1] == 1.0
    assert all(isinstance(message, str) and message for _, message in calls)
