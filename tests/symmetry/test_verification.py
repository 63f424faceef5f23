import dataclasses

import numpy as np
import pytest
from symmetry import numpy_loops

from meshlab_symrecon import _native
from meshlab_symrecon.symmetry import verification
from meshlab_symrecon.symmetry.preparation import prepare
from meshlab_symrecon.symmetry.verification import Evidence, Landings, _rules, examine, land


def evidence_of(points, planes):
    cloud = prepare(points, None, 1_500)
    planes = cloud.from_input(np.asarray(planes, dtype=float))
    return examine(planes, cloud, 1_500, 0.006, exact=True)


def test_a_hole_costs_support_but_is_no_contradiction(shapes):
    whole = shapes.blob(8_000, 5, mirrored=True)
    true = [[1.0, 0.0, 0.0, 0.0]]
    full = evidence_of(whole, true)
    holed = evidence_of(shapes.bitten(whole, [1.0, 0.3, 0.2], 0.25), true)
    assert full.support[0] > 0.9
    assert holed.support[0] < full.support[0] - 0.15
    assert holed.agreement[0] > 0.9
    assert holed.contradiction[0] < 0.01


def test_a_wrong_plane_of_a_whole_body_is_contradicted(shapes):
    whole = shapes.blob(8_000, 5, mirrored=True)
    wrong = evidence_of(whole, [[0.0, 1.0, 0.0, 0.0], [0.6, 0.0, 0.8, 0.1]])
    assert (wrong.agreement < 0.6).all()
    assert (wrong.contradiction > 0.1).all()


def test_evidence_of_chosen_rows(shapes):
    found = evidence_of(shapes.blob(4_000, 6, mirrored=True), np.eye(4)[:3])
    chosen = found.take(np.array([2, 0]))
    assert np.array_equal(chosen.support, found.support[[2, 0]])
    assert np.array_equal(chosen.residual, found.residual[[2, 0]])


@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize("tolerance", [0.006, 0.025])
def test_all_is_as_in_the_sums_of_numpy(statue, some_planes, exact, tolerance):
    cloud = prepare(statue, None, 900)
    nearest = numpy_loops.partners_of(cloud, exact)
    found = examine(some_planes, cloud, 800, tolerance, exact=exact)
    expected = Evidence(*numpy_loops.examined(some_planes, cloud, 800, nearest, tolerance))
    assert expected.support.max() > 0.3  # a true plane is among them,
    assert expected.contradiction.max() > 0.1  # and a wrong one
    assert (expected.agreement > expected.support + 0.01).any()  # and a hole
    for field in dataclasses.fields(Evidence):
        values, wanted = getattr(found, field.name), getattr(expected, field.name)
        assert np.abs(values - wanted).max() < 1e-12, field.name


def test_agreement_of_a_plane_that_holes_excuse_everywhere_is_a_share(statue):
    """What matches an excused query a little is not judged either."""
    cloud = prepare(statue, None, 300)
    rims = dataclasses.replace(cloud, border_distance=np.zeros(len(cloud.points)))
    heights = np.linspace(0.3, 0.6, 40)
    planes = np.column_stack([np.zeros((40, 2)), np.ones(40), heights])
    found = examine(planes, rims, 300, 0.025, exact=True)
    assert (found.support < 0.01).any()
    assert (found.support > 0.0).any()
    assert ((found.agreement >= 0.0) & (found.agreement <= 1.0)).all()


def test_no_planes_have_no_evidence(statue):
    cloud = prepare(statue, None, 300)
    assert examine(np.zeros((0, 4)), cloud, 300, 0.006, exact=False).support.shape == (0,)


@pytest.mark.parametrize(
    ("change", "error"),
    [
        ({"normals": np.zeros((3, 3))}, ValueError),
        ({"oriented": np.zeros(3, dtype=np.uint8)}, ValueError),
        ({"border_distance": np.zeros(3)}, ValueError),
        ({"distinctness": np.zeros(3)}, ValueError),
        ({"queries": np.full(300, 10**6, dtype=np.int32)}, ValueError),
        ({"queries": np.full(300, -1, dtype=np.int32)}, ValueError),
    ],
)
def test_arrays_that_do_not_fit_together_are_refused(statue, change, error):
    cloud = prepare(statue, None, 300)
    arguments = {
        "planes": np.eye(4)[:1],
        "queries": cloud.samples.astype(np.int32),
        "distinctness": cloud.distinctness,
        "field": cloud.field,
        "normals": cloud.normals,
        "oriented": cloud.oriented.view(np.uint8),
        "border_distance": cloud.border_distance,
        "exact": False,
        "rules": _rules(cloud, 0.006),
    }
    assert _native.examine(**arguments).shape == (1, 4)
    with pytest.raises(error):
        _native.examine(**(arguments | change))


@pytest.fixture(scope="module")
def cut_off(shapes):
    """A body that ends at a plane, with a hole elsewhere; planes across which it is looked at."""
    whole = shapes.blob(7_000, 4, mirrored=True)
    left = whole[whole @ [0.0, 0.6, 0.8] > -0.5]
    top = left[np.argmax(left[:, 1])]
    cloud = prepare(left[np.linalg.norm(left - top, axis=1) > 0.3], None, 900)
    rng = np.random.default_rng(2)
    planes = rng.normal(0, 1, (30, 4))
    planes[:, 3] *= 0.1
    planes = np.vstack([planes, cloud.from_input(np.array([[1.0, 0.0, 0.0, 0.0]]))])
    return cloud, planes / np.linalg.norm(planes[:, :3], axis=1, keepdims=True)


@pytest.mark.parametrize("tolerance", [0.0025, 0.02])
def test_landings_are_as_in_the_sums_of_numpy(cut_off, tolerance):
    cloud, planes = cut_off
    nearest = numpy_loops.partners_of(cloud, exact=True)
    expected = numpy_loops.landings(planes, cloud, cloud.samples, nearest, tolerance)
    found = land(planes, cloud, cloud.samples, tolerance)
    assert expected["excused"].any()
    assert expected["broken_off"].any()
    for field in dataclasses.fields(Landings):
        values, wanted = getattr(found, field.name), expected[field.name]
        assert values.shape == (len(planes), len(cloud.samples))
        if values.dtype.kind == "f":
            assert np.abs(values - wanted).max() < 1e-9, field.name
        else:
            assert np.array_equal(values, wanted), field.name


@pytest.mark.parametrize("tolerance", [0.0025, 0.02])
def test_landings_are_the_terms_of_the_sums(cut_off, tolerance):
    cloud, planes = cut_off
    found = land(planes, cloud, cloud.samples, tolerance)
    evidence = examine(planes, cloud, len(cloud.samples), tolerance, exact=True)
    matched = found.weights * found.worth
    judged = ~(found.excused | found.broken_off)
    support = matched.sum(axis=1) / found.weights.sum(axis=1)
    blamed = np.maximum((found.weights * judged).sum(axis=1), numpy_loops.TINY)
    agreement = (matched * judged).sum(axis=1) / blamed
    assert np.abs(support - evidence.support).max() < 1e-12
    assert np.abs(agreement - evidence.agreement).max() < 1e-12
    expected = numpy_loops.examined(
        planes, cloud, len(cloud.samples), numpy_loops.partners_of(cloud, exact=True), tolerance
    )
    for name, wanted in zip(("contradiction", "residual"), expected[2:], strict=True):
        assert np.abs(getattr(evidence, name) - wanted).max() < 1e-9


def test_no_image_has_two_excuses_and_a_match_needs_none(cut_off):
    cloud, planes = cut_off
    found = land(planes, cloud, cloud.samples, 0.006)
    assert not (found.excused & found.broken_off).any()
    assert (found.worth[found.excused | found.broken_off] < verification.NO_MATCH).all()
    assert ((found.worth >= 0.0) & (found.worth <= 1.0)).all()


def test_what_is_broken_off_contradicts_nothing_and_is_not_judged(cut_off):
    cloud, planes = cut_off
    gone = dataclasses.replace(cloud, broken_off=np.array([0.0, 0.0, 0.0, -1.0]))
    missing = examine(planes, gone, len(gone.samples), 0.006, exact=True)
    plain = examine(planes, cloud, len(cloud.samples), 0.006, exact=True)
    assert (missing.contradiction == 0.0).all()
    assert (plain.contradiction > 0.0).any()
    assert (missing.agreement >= plain.agreement - 1e-12).all()
    assert np.array_equal(missing.support, plain.support)


def test_rows_are_as_if_each_plane_and_query_were_alone(cut_off):
    cloud, planes = cut_off
    together = land(planes, cloud, cloud.samples, 0.006)
    for row in (0, 13):
        alone = land(planes[[row]], cloud, cloud.samples[5:9], 0.006)
        for field in dataclasses.fields(Landings):
            wanted = getattr(together, field.name)[[row], 5:9]
            assert np.array_equal(getattr(alone, field.name), wanted)


def test_evidence_is_joined_in_order(cut_off):
    cloud, planes = cut_off
    whole = examine(planes, cloud, 300, 0.006, exact=False)
    parts = [examine(part, cloud, 300, 0.006, exact=False) for part in (planes[:4], planes[4:])]
    joined = parts[0].joined(parts[1])
    for field in dataclasses.fields(Evidence):
        assert np.array_equal(getattr(joined, field.name), getattr(whole, field.name))


@pytest.mark.parametrize(("planes", "queries"), [(0, 300), (2, 0), (0, 0)])
def test_landings_of_nothing_have_their_shape(cut_off, planes, queries):
    cloud, some = cut_off
    found = land(some[:planes], cloud, cloud.samples[:queries], 0.006)
    for field in dataclasses.fields(Landings):
        assert getattr(found, field.name).shape == (planes, queries)


@pytest.mark.parametrize(
    ("change", "error"),
    [
        ({"normals": np.zeros((3, 3))}, ValueError),
        ({"oriented": np.zeros(3, dtype=np.uint8)}, ValueError),
        ({"border_distance": np.zeros(3)}, ValueError),
        ({"queries": np.array([10**6], dtype=np.int32)}, ValueError),
        ({"queries": np.array([-1], dtype=np.int32)}, ValueError),
    ],
)
def test_landings_of_arrays_that_do_not_fit_together_are_refused(cut_off, change, error):
    cloud, planes = cut_off
    arguments = {
        "planes": planes,
        "queries": cloud.samples.astype(np.int32),
        "field": cloud.field,
        "normals": cloud.normals,
        "oriented": cloud.oriented.view(np.uint8),
        "border_distance": cloud.border_distance,
        "exact": True,
        "rules": _rules(cloud, 0.006),
    }
    assert len(_native.landings(**arguments)) == 6
    with pytest.raises(error):
        _native.landings(**(arguments | change))


def test_a_break_that_is_no_plane_is_refused(statue):
    cloud = dataclasses.replace(prepare(statue, None, 10), broken_off=np.zeros(3))
    with pytest.raises(ValueError, match="a plane has four numbers"):
        _rules(cloud, 0.006)
