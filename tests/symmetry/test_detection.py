import dataclasses

import numpy as np
import pytest

from meshlab_symrecon.errors import GeometryError, ParameterError
from meshlab_symrecon.geometry.planes import plane_angles
from meshlab_symrecon.symmetry.detection import (
    DetectionOptions,
    detect_reflection_planes,
    refine_reflection_planes,
    verified_planes,
)

TRUE = np.array([1.0, 0.0, 0.0, 0.0])


@pytest.fixture(scope="module")
def at_rest(statue):
    """What is found in the statue where it stands."""
    return detect_reflection_planes(statue)


def turn(seed):
    matrix = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    return matrix * np.sign(np.linalg.det(matrix))


def assert_same_plane(plane, expected, diagonal, centre, degrees, share):
    """Angles differ by less than degrees, offsets by less than a share of the diagonal."""
    assert np.degrees(plane_angles(plane[np.newaxis], expected)[0]) < degrees
    sign = np.sign(plane[:3] @ expected[:3])
    gap = sign * (plane[:3] @ centre + plane[3]) - (expected[:3] @ centre + expected[3])
    assert abs(gap) < share * diagonal


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_plane_of_a_body_with_a_quarter_missing(shapes, seed, noise):
    rng = np.random.default_rng(seed)
    whole = shapes.blob(6_000, seed, mirrored=True)
    direction = np.array([1.0, 0.0, 0.0]) + rng.normal(0, 0.3, 3)
    scan = shapes.bitten(whole, direction, 0.25)
    scan = scan + rng.normal(0, noise, scan.shape)
    found = detect_reflection_planes(scan)
    assert len(found.planes) >= 1
    diagonal = np.linalg.norm(np.ptp(whole, axis=0))
    assert_same_plane(found.planes[0], TRUE, diagonal, whole.mean(axis=0), 1.0, 0.01)
    assert np.allclose(np.linalg.norm(found.planes[:, :3], axis=1), 1.0)
    assert (np.diff(found.confidence) <= 0).all()
    least = DetectionOptions().min_confidence
    assert ((found.confidence >= least) & (found.confidence <= 1)).all()
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


@pytest.mark.parametrize(("scale", "seed"), [(1e-6, 0), (1e-3, 1), (1.0, 2), (1e6, 3)])
def test_planes_follow_motions_and_scale(statue, at_rest, scale, seed):
    matrix, shift = turn(seed), np.random.default_rng(seed).normal(0, 10, 3)
    rng = np.random.default_rng(seed)
    moved = scale * (rng.permutation(statue) @ matrix.T + shift)
    found = detect_reflection_planes(moved)
    assert found.planes.shape == at_rest.planes.shape
    diagonal = np.linalg.norm(np.ptp(moved, axis=0))
    for plane, resting in zip(found.planes, at_rest.planes, strict=True):
        normal = matrix @ resting[:3]
        expected = np.append(normal, scale * (resting[3] - normal @ shift))
        degrees = np.degrees(1e-3)
        assert_same_plane(plane, expected, diagonal, moved.mean(axis=0), degrees, 1e-3)
    assert np.allclose(found.confidence, at_rest.confidence, atol=0.01)


def test_permuted_points_give_the_same_bytes(statue, at_rest):
    found = at_rest
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


def test_outward_normals_may_be_given(statue, at_rest):
    plain = at_rest.planes[0]
    hinted = detect_reflection_planes(statue, statue / np.linalg.norm(statue, axis=1)[:, None])
    assert_same_plane(hinted.planes[0], plain, 3.0, np.zeros(3), 0.2, 0.002)


def test_duplicated_points_change_nothing(statue, at_rest):
    copies = np.where(np.arange(len(statue)) % 3 == 0, 20, 2)
    found = detect_reflection_planes(np.repeat(statue, copies, axis=0))
    assert found.planes.tobytes() == at_rest.planes.tobytes()
    assert found.confidence.tobytes() == at_rest.confidence.tobytes()


def test_a_point_measured_over_and_over_is_no_cloud_of_its_own():
    points = np.vstack([np.ones((500, 3)), np.random.default_rng(0).random((6, 3))])
    assert detect_reflection_planes(points).planes.shape == (0, 4)


DEGENERATE = {
    **{f"{count} points": np.random.default_rng(0).random((count, 3)) for count in range(5)},
    "coinciding": np.ones((500, 3)),
    "collinear": np.outer(np.linspace(0, 1, 500), [1.0, 2.0, 3.0]) + 5.0,
    "coplanar": np.random.default_rng(1).random((500, 3)) * [1.0, 1.0, 0.0] + 7.0,
}


@pytest.mark.parametrize("case", DEGENERATE)
def test_degenerate_clouds_are_refused_with_a_sentence(case):
    with pytest.raises(GeometryError, match=r"detection of reflection planes needs .*; got .*; "):
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
    assert certain.confidence.max() < DetectionOptions().min_confidence


def test_all_verified_planes_begin_with_those_that_are_reported(statue, at_rest):
    found = verified_planes(statue, options=DetectionOptions())
    count = len(at_rest.planes)
    assert len(found.planes) >= count
    assert np.array_equal(found.planes[0], at_rest.planes[0])
    assert np.array_equal(found.confidence[0], at_rest.confidence[0])
    reported = [row.tobytes() for row in found.planes]
    assert all(row.tobytes() in reported for row in at_rest.planes)
    assert (np.diff(found.confidence) <= 0.0).all()
    assert len(found.evidence.support) == len(found.planes)


def beside(plane, degrees, shift):
    aside = np.cross(plane[:3], [0.3, 0.5, 0.8])
    aside *= np.tan(np.radians(degrees)) / np.linalg.norm(aside)
    moved = np.append(plane[:3] + aside, plane[3] + shift)
    return moved / np.linalg.norm(moved[:3])


def test_drawn_planes_move_to_where_the_cloud_fits_and_keep_their_order(statue, at_rest):
    diagonal = np.linalg.norm(np.ptp(statue, axis=0))
    wrong = np.array([0.0, 0.0, 1.0, 0.0])
    drawn = np.stack([wrong, -3.0 * beside(TRUE, 8.0, 0.04 * diagonal), TRUE])
    found = refine_reflection_planes(statue, drawn)
    assert found.planes.shape == (3, 4)
    assert found.support.shape == found.residual.shape == found.confidence.shape == (3,)
    for row in (1, 2):
        plane = found.planes[row]
        assert_same_plane(plane, at_rest.planes[0], diagonal, np.zeros(3), np.degrees(1e-3), 1e-3)
        assert plane[np.argmax(np.abs(plane[:3]))] > 0.0
    assert found.confidence[0] < found.confidence[1:].min()


def test_drawn_planes_follow_motions_and_scale(statue):
    drawn = beside(TRUE, 6.0, 0.1)
    matrix, shift, scale = turn(5), np.array([3.0, -2.0, 7.0]), 1e-6
    moved = scale * (statue @ matrix.T + shift)
    normal = matrix @ drawn[:3]
    also = np.append(normal, scale * (drawn[3] - normal @ shift))
    resting = refine_reflection_planes(statue, [drawn]).planes[0]
    found = refine_reflection_planes(moved, [also]).planes[0]
    normal = matrix @ resting[:3]
    expected = np.append(normal, scale * (resting[3] - normal @ shift))
    diagonal = np.linalg.norm(np.ptp(moved, axis=0))
    assert_same_plane(found, expected, diagonal, moved.mean(axis=0), np.degrees(1e-3), 1e-3)


def test_no_drawn_planes_are_none(statue):
    found = refine_reflection_planes(statue, np.zeros((0, 4)))
    assert found.planes.shape == (0, 4)
    assert found.support.shape == found.residual.shape == found.confidence.shape == (0,)


@pytest.mark.parametrize(
    ("planes", "sentence"),
    [
        ([[0.0, 0.0, 0.0, 1.0]], "planes need a normal"),
        ([[1.0, 0.0, 0.0]], "planes must have shape"),
        ([[1.0, 0.0, np.nan, 0.0]], "planes must be finite"),
    ],
)
def test_planes_that_are_none_are_refused(statue, planes, sentence):
    with pytest.raises(GeometryError, match=sentence):
        refine_reflection_planes(statue, planes)


@pytest.mark.parametrize("case", DEGENERATE)
def test_planes_drawn_in_degenerate_clouds_are_refused_with_a_sentence(case):
    with pytest.raises(GeometryError, match=r"detection of reflection planes needs .*; got .*; "):
        refine_reflection_planes(DEGENERATE[case], [TRUE])


@pytest.mark.parametrize("count", [5, 6, 12, 40])
def test_a_handful_of_points_takes_drawn_planes_with_little_confidence(count):
    points = np.random.default_rng(count).random((count, 3))
    found = refine_reflection_planes(points, [[1.0, 0.0, 0.0, -0.5], [0.0, 1.0, 0.0, -0.5]])
    assert found.planes.shape == (2, 4)
    assert np.isfinite(found.planes).all()
    assert (found.confidence < 0.5).all()


def test_a_scan_from_one_side_is_judged_without_error():
    """An open sheet: all rims, few normals with a known side."""
    places = np.random.default_rng(0).uniform(-1, 1, (600, 2))
    sheet = np.column_stack([places, 0.2 * places[:, 0] ** 2 + 0.1 * places[:, 1] ** 3])
    found = verified_planes(sheet, options=DetectionOptions())
    assert np.isfinite(found.planes).all()
    assert ((found.confidence >= 0.0) & (found.confidence <= 1.0)).all()


def test_progress_is_reported_to_its_end(statue):
    calls = []
    detect_reflection_planes(statue, progress=lambda *call: calls.append(call))
    fractions = [fraction for fraction, _ in calls]
    assert fractions == sorted(fractions)
    assert fractions[0] == 0.0
    assert fractions[-1] == 1.0
    assert all(isinstance(message, str) and message for _, message in calls)
