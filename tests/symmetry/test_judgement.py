import numpy as np
import pytest
from symmetry.bodies import as_prepared, ellipsoid, jug, no_planes, symmetric_cloud, vase

from meshlab_symrecon.geometry.planes import plane_angles
from meshlab_symrecon.symmetry.candidates import vote
from meshlab_symrecon.symmetry.cascade import TOLERANCE, refine_and_verify
from meshlab_symrecon.symmetry.exemplars import choose_exemplars
from meshlab_symrecon.symmetry.hypotheses import VARIANT
from meshlab_symrecon.symmetry.judgement import FINE_SHARE, judge, judge_again, judge_drawn
from meshlab_symrecon.symmetry.preparation import prepare
from meshlab_symrecon.symmetry.traits import TRAITS, merit, traits

HANDLE = np.array([[0.0, 1.0, 0.0, 0.0]])
MIDDLE = np.array([[1.0, 0.0, 0.0, 0.0]])


def searched(scan):
    cloud = prepare(scan, None, 2_500)
    candidates = vote(cloud, 1_000, 12_000, np.random.default_rng(0))
    return cloud, choose_exemplars(cloud, candidates.planes)[0]


@pytest.fixture(scope="module")
def jugged():
    return searched(jug(8_000))


def assert_plane(found, true, degrees, share):
    assert np.degrees(plane_angles(found[np.newaxis], true)[0]) < degrees
    assert abs(np.sign(found[:3] @ true[:3]) * found[3] - true[3]) < share


def test_the_plane_through_the_handle_of_a_jug_wins_and_the_other_meridians_go(jugged):
    cloud, starts = jugged
    true = cloud.from_input(HANDLE)[0]
    found = judge(cloud, starts)
    assert_plane(found.planes[0], true, 1.0, 0.01)
    assert found.chances[0] > 0.5
    assert (found.chances[1:] < 0.5 * found.chances[0]).all()


def test_one_meridian_of_a_pure_body_of_revolution_stands_for_all():
    cloud, starts = searched(vase(8_000))
    found = judge(cloud, starts)
    axis = cloud.axes @ [0.0, 0.0, 1.0]
    believed = found.planes[found.chances >= 0.5]
    assert len(believed) == 1
    assert (np.abs(believed[:, :3] @ axis) < np.sin(np.radians(1.0))).all()
    middle = -cloud.axes @ cloud.centre / cloud.scale
    assert (np.abs(believed[:, :3] @ middle + believed[:, 3]) < 0.01).all()


@pytest.mark.parametrize("seed", [3, 7])
def test_half_a_body_has_the_plane_it_was_cut_at(shapes, seed):
    whole = shapes.blob(12_000, seed, mirrored=True)
    cloud, starts = searched(whole[whole[:, 0] > 0.0])
    found = judge(cloud, starts)
    assert_plane(found.planes[0], cloud.from_input(MIDDLE)[0], 0.5, 0.005)
    assert found.chances[0] > 0.5


def test_a_half_needs_no_other_planes(shapes):
    half = ellipsoid(12_000, [0.7, 1.0, 0.6])
    cloud = prepare(half[half[:, 0] > 0.0], None, 500)
    found = judge(cloud, no_planes())
    assert found.planes.shape == (1, 4)
    assert_plane(found.planes[0], cloud.from_input(MIDDLE)[0], 0.5, 0.005)


def test_planes_differ_and_the_likeliest_comes_first(jugged, statue):
    for cloud, starts in (jugged, searched(statue)):
        found = judge(cloud, starts)
        assert (np.diff(found.chances) <= 0.0).all()
        assert ((found.chances >= 0.0) & (found.chances <= 1.0)).all()
        assert len(found.planes) == len(found.chances) == len(found.evidence.support)
        assert np.allclose(np.linalg.norm(found.planes[:, :3], axis=1), 1.0)
        for row, plane in enumerate(found.planes):
            others = np.delete(found.planes, row, axis=0)
            signs = np.sign(others[:, :3] @ plane[:3])
            variants = plane_angles(others, plane) < VARIANT[0]
            variants &= np.abs(signs * others[:, 3] - plane[3]) < VARIANT[1]
            assert not variants.any()


def test_of_variants_the_one_that_fits_best_stays(statue):
    cloud, starts = searched(statue)
    planes, evidence = refine_and_verify(cloud, starts)
    fine = traits(planes, evidence, cloud, TOLERANCE)[:, TRAITS.index("fine agreement")]
    fit = merit(evidence) + FINE_SHARE * fine
    found = judge(cloud, starts).planes
    nearest = [int(np.argmin(plane_angles(planes, plane))) for plane in found]
    settled = [plane_angles(planes[[k]], plane)[0] for k, plane in zip(nearest, found, strict=True)]
    kept = [k for k, angle in zip(nearest, settled, strict=True) if angle < np.radians(1.0)]
    assert 1 < len(kept) < len(planes)
    for row in kept:
        signs = np.where(planes[:, :3] @ planes[row, :3] < 0.0, -1.0, 1.0)
        variants = plane_angles(planes, planes[row]) < VARIANT[0]
        variants &= np.abs(signs * planes[:, 3] - planes[row, 3]) < VARIANT[1]
        assert fit[row] >= fit[variants].max()


def test_whole_bodies_without_starts_have_no_planes():
    points, normals, _ = symmetric_cloud(0)
    found = judge(as_prepared(points, normals), no_planes())
    assert found.planes.shape == (0, 4)
    assert found.chances.shape == found.evidence.support.shape == (0,)


def test_drawn_planes_come_back_in_their_order_with_their_chances(statue):
    cloud, starts = searched(statue)
    true = cloud.from_input(MIDDLE)
    wrong = cloud.from_input(np.array([[0.0, 1.0, 0.0, 0.0], [0.0, 0.6, 0.8, 0.1]]))
    found = judge_drawn(cloud, starts, np.vstack([wrong[:1], true, wrong[1:]]))
    assert found.planes.shape == (3, 4)
    assert_plane(found.planes[1], true[0], 0.5, 0.005)
    assert found.chances[1] > found.chances[[0, 2]].max()
    assert found.evidence.support[1] == found.evidence.support.max()


@pytest.mark.parametrize("seed", [3, 7])
def test_a_plane_drawn_at_the_cut_of_a_half_goes_to_its_rim_and_others_do_not(shapes, seed):
    whole = shapes.blob(12_000, seed, mirrored=True)
    cloud, starts = searched(whole[whole[:, 0] > 0.0])
    true = cloud.from_input(MIDDLE)[0]
    tilted = true + 0.1 * np.append(np.cross(true[:3], [0.3, 0.5, 0.8]), 0.3)
    away = cloud.from_input(np.array([[0.0, 1.0, 0.0, 0.0]]))[0]
    drawn = np.stack([true, away, -tilted / np.linalg.norm(tilted[:3])])
    found = judge_drawn(cloud, starts, drawn)
    for row in (0, 2):
        assert_plane(found.planes[row], true, 0.5, 0.005)
        assert found.chances[row] > 0.5
    assert plane_angles(found.planes[1:2], true)[0] > np.radians(20.0)
    assert found.chances[1] < found.chances[0]


def test_no_drawn_planes_are_none(statue):
    cloud = prepare(statue, None, 200)
    found = judge_drawn(cloud, no_planes(), no_planes())
    assert found.planes.shape == (0, 4)
    assert found.chances.shape == found.evidence.agreement.shape == (0,)


def test_chosen_rows_go_together(jugged):
    found = judge(*jugged)
    rows = np.array([len(found.planes) - 1, 0])
    chosen = found.take(rows)
    assert np.array_equal(chosen.planes, found.planes[rows])
    assert np.array_equal(chosen.chances, found.chances[rows])
    assert np.array_equal(chosen.evidence.residual, found.evidence.residual[rows])


def test_a_base_taken_for_a_plinth_costs_no_plane_its_chance(shapes):
    """Half of a body, as if the other half had been left out; with it, the plane is certain."""
    scan = shapes.blob(6_000, 3, mirrored=True)
    whole, starts = searched(scan)
    part = prepare(scan[scan[:, 1] > 0.0], None, 2_500)
    weak = judge(part, part.from_input(whole.to_input(starts)))
    again = judge_again(weak, part, whole)
    nearest = int(np.argmin(plane_angles(again.planes, part.from_input(MIDDLE)[0])))
    assert_plane(again.planes[nearest], part.from_input(MIDDLE)[0], 1.0, 0.01)
    strong = judge(whole, starts).chances[0]
    assert again.chances[nearest] >= 0.9 * strong
    assert (np.diff(again.chances) <= 0.0).all()


def test_what_a_plinth_adds_never_lowers_a_chance(statue):
    cloud, starts = searched(statue)
    found = judge(cloud, starts)
    again = judge_again(found, cloud, prepare(statue, None, 2_500, plinth=True))
    assert np.array_equal(again.chances, np.maximum(found.chances, again.chances))
