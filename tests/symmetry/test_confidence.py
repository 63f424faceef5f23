import numpy as np
import pytest

from meshlab_symrecon.symmetry.confidence import (
    believable,
    confidence,
    family_sizes,
    merit,
    whole_symmetry,
)
from meshlab_symrecon.symmetry.verification import Evidence


def evidence(support, agreement, contradiction=0.0, residual=0.002):
    support = np.asarray(support, dtype=float)
    return Evidence(
        support,
        np.asarray(agreement, dtype=float),
        np.broadcast_to(np.asarray(contradiction, dtype=float), support.shape),
        np.broadcast_to(np.asarray(residual, dtype=float), support.shape),
    )


def through_axis(degrees):
    turn = np.radians(degrees)
    zero = np.zeros_like(turn)
    return np.stack([np.cos(turn), np.sin(turn), zero, zero], axis=1)


def chances(found, count=2500, sizes=None):
    sizes = np.ones(len(found.support)) if sizes is None else np.asarray(sizes, dtype=float)
    return confidence(found, sizes, 0.001, count)


def test_confidence_rises_with_support_and_falls_with_contradiction_and_family():
    def chance(sizes=None, **kwargs):
        return chances(evidence(**{"support": [0.3], "agreement": [0.7], **kwargs}), sizes=sizes)

    assert chance(support=[0.35]) > chance()
    assert chance(contradiction=0.01) < chance()
    assert chance(sizes=[2]) < chance()
    assert 0.0 < chance()[0] < 1.0


def test_a_plane_that_leads_the_others_is_more_likely():
    alone = chances(evidence([0.3, 0.05, 0.05], [0.7, 0.3, 0.3]))[0]
    crowded = chances(evidence([0.3, 0.29, 0.29], [0.7, 0.7, 0.7]))[0]
    assert alone > crowded


def test_a_symmetric_body_may_have_only_true_planes():
    three = chances(evidence([0.95] * 3, [0.96] * 3))
    assert (three > 0.9).all()
    many = chances(evidence([0.95] * 30, [0.96] * 30))  # a ball
    assert np.allclose(many, three[0])
    crowd = chances(evidence([0.95] * 30, [0.96] * 30, contradiction=0.01))  # nearly a ball
    assert (crowd < 0.5).all()


def test_planes_that_something_contradicts_stay_rivals():
    whole = evidence([0.6] * 9, [0.95, *[0.7] * 8], contradiction=[0.0, *[0.01] * 8])
    lone = evidence([0.6], [0.7], contradiction=[0.01])
    assert chances(whole)[1] < chances(lone)[0]
    assert chances(whole)[0] > chances(lone)[0]
    assert list(whole_symmetry(whole)) == [True, *[False] * 8]
    assert not whole_symmetry(evidence([0.3], [0.95]))[0]


def test_few_samples_earn_confidence_in_proportion():
    clear = evidence([0.6, 0.1], [0.9, 0.9])
    assert np.allclose(chances(clear, 25), 0.25 * chances(clear), rtol=1e-12)
    unclear = evidence([0.6, 0.1], [0.8, 0.2])
    assert np.allclose(chances(unclear, 375), 0.25 * chances(unclear), rtol=1e-12)


def test_no_planes_have_no_confidence():
    none = evidence([], [])
    assert chances(none).shape == (0,)
    assert merit(none).shape == (0,)
    assert believable(none, np.zeros(0), 0.5).shape == (0,)


def test_planes_of_a_nearly_round_body_are_a_family_and_lone_planes_are_not():
    planes = through_axis([0.0, 10.0, 20.0, 90.0])
    nearly = evidence([0.6] * 4, [0.85] * 4)
    assert np.array_equal(family_sizes(planes, nearly), [2, 3, 2, 1])
    perfectly = evidence([0.6] * 4, [0.99] * 4)
    assert np.array_equal(family_sizes(planes, perfectly), [1, 1, 1, 1])


@pytest.mark.parametrize(("second", "expected"), [(0.84, True), (0.7, False)])
def test_a_further_plane_must_agree_nearly_as_well_as_the_best(second, expected):
    found = evidence([0.6, 0.6], [0.85, second])
    assert list(believable(found, np.array([0.9, 0.9]), 0.65)) == [True, expected]
    assert list(believable(found, np.array([0.9, 0.6]), 0.65)) == [True, False]
