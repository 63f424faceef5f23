import numpy as np

from meshlab_symrecon.symmetry.preparation import prepare
from meshlab_symrecon.symmetry.verification import examine


def evidence_of(points, planes):
    cloud = prepare(points, None, 1_500)
    planes = np.asarray(planes, dtype=float)
    planes[:, 3] = (planes[:, 3] + planes[:, :3] @ cloud.centre) / cloud.scale
    return examine(planes, cloud, 1_500, cloud.field.closest, 0.006)


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
