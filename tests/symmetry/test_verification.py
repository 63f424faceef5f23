import dataclasses

import numpy as np
import pytest
from symmetry import numpy_loops

from meshlab_symrecon import _native
from meshlab_symrecon.symmetry.preparation import prepare
from meshlab_symrecon.symmetry.verification import Evidence, _rules, examine


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
        ({"queries": np.full(300, 10**6, dtype=np.int32)}, IndexError),
        ({"queries": np.full(300, -1, dtype=np.int32)}, IndexError),
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
