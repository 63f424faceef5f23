import numpy as np
import pytest

from meshlab_symrecon.symmetry.confidence import (
    BROKEN_WEIGHTS,
    CLEAR_AGREEMENT,
    ENOUGH_SAMPLES,
    ENOUGH_UNCLEAR,
    LEAST_RIM_SHARE,
    MOST_BEYOND,
    RIVAL,
    THICKEST,
    WEIGHTS,
    believable,
    confidence,
    half_confidence,
    meridian_confidence,
)
from meshlab_symrecon.symmetry.open_halves import HalfEvidence
from meshlab_symrecon.symmetry.traits import TRAITS
from meshlab_symrecon.symmetry.verification import Evidence

MANY = 10_000


def evidence(agreement):
    rest = np.full(len(agreement), 0.01)
    return Evidence(rest, np.asarray(agreement, dtype=float), rest, rest)


def chances(rows, count=MANY, agreement=None, *, broken=False):
    agreement = np.ones(len(rows)) if agreement is None else agreement
    return confidence(np.asarray(rows, dtype=float), evidence(agreement), count, broken=broken)


def halves(rim_share=0.9, beyond=0.0, crossing=0.0, thickness=0.5):
    columns = np.broadcast_arrays(*np.atleast_1d(rim_share, beyond, crossing, thickness))
    return HalfEvidence(*(np.asarray(column, dtype=float) for column in columns))


AGAINST = {"near misses", "residual", "turn", "excused", "broken off", "rim excused"}
BOTH = pytest.mark.parametrize("broken", [False, True])


def weights(broken):
    return BROKEN_WEIGHTS if broken else WEIGHTS


@BOTH
def test_every_weight_belongs_to_a_trait(broken):
    assert set(weights(broken)) <= set(TRAITS)


@BOTH
@pytest.mark.parametrize("name", TRAITS)
def test_confidence_is_monotone_in_every_trait(name, broken):
    rows = np.zeros((50, len(TRAITS)))
    rows[:, TRAITS.index(name)] = np.linspace(-1.0, 1.0, 50)
    found = chances(rows, broken=broken)
    assert ((found > 0.0) & (found < 1.0)).all()
    assert (np.sign(np.diff(found)) == np.sign(weights(broken).get(name, 0.0))).all()


@BOTH
@pytest.mark.parametrize("name", sorted(set(TRAITS) - {"roughness"}))
def test_no_weight_contradicts_its_meaning(name, broken):
    assert weights(broken).get(name, 0.0) * (-1.0 if name in AGAINST else 1.0) >= 0.0


def test_the_odds_are_multiplied_trait_by_trait():
    rng = np.random.default_rng(0)
    rows = rng.normal(0.0, 0.3, (2, len(TRAITS)))
    together = chances([rows[0], rows[1], rows.sum(axis=0), np.zeros(len(TRAITS))])
    one, other, both, none = together / (1.0 - together)
    assert both * none == pytest.approx(one * other, rel=1e-9)


def test_confidence_does_not_overflow():
    found = chances(np.outer([-1e9, 1e9], [WEIGHTS.get(name, 0.0) for name in TRAITS]))
    assert found[0] == pytest.approx(0.0, abs=1e-15)
    assert found[1] == pytest.approx(1.0, abs=1e-15)


@pytest.mark.parametrize(
    ("agreement", "enough"),
    [(CLEAR_AGREEMENT, ENOUGH_SAMPLES), (CLEAR_AGREEMENT - 0.01, ENOUGH_UNCLEAR)],
)
def test_few_samples_earn_confidence_in_proportion(agreement, enough):
    rows = np.zeros((1, len(TRAITS)))
    full = chances(rows, enough, [agreement])
    assert np.array_equal(chances(rows, 10 * enough, [agreement]), full)
    assert np.allclose(chances(rows, enough // 4, [agreement]), 0.25 * full, rtol=1e-12)


def test_no_planes_have_no_confidence():
    assert chances(np.zeros((0, len(TRAITS)))).shape == (0,)
    assert half_confidence(halves(*np.zeros((4, 0)))).shape == (0,)
    assert meridian_confidence(np.zeros(0), 0.0).shape == (0,)
    assert believable(np.zeros(0), np.zeros(0), 0.5).shape == (0,)


@pytest.mark.parametrize(
    "impossible",
    [
        {"rim_share": LEAST_RIM_SHARE - 0.01},
        {"beyond": MOST_BEYOND + 0.01},
        {"thickness": THICKEST + 0.01},
        {"thickness": np.inf},
    ],
    ids=str,
)
def test_an_impossible_half_has_no_chance_at_all(impossible):
    assert half_confidence(halves())[0] > 0.9
    assert half_confidence(halves(**impossible))[0] == 0.0


def test_a_half_that_is_crossed_less_squarely_is_less_likely():
    found = half_confidence(halves(crossing=np.linspace(0.0, 0.3, 30)))
    assert (np.diff(found) < 0.0).all()
    assert half_confidence(halves(crossing=np.sin(np.radians(20.0))))[0] < 0.01
    assert half_confidence(halves(crossing=1.0))[0] < 1e-12


def test_a_meridian_needs_a_match_and_a_lead():
    found = meridian_confidence(np.linspace(0.0, 1.0, 30), 0.2)
    assert (np.diff(found) > 0.0).all()
    assert found[0] < 1e-6
    assert found[-1] > 0.95
    falling = [meridian_confidence(np.array([0.7]), rival)[0] for rival in np.linspace(0, 0.7, 30)]
    assert (np.diff(falling) < 0.0).all()
    assert falling[-1] < 0.1


@pytest.mark.parametrize("least", [0.2, 0.5, 0.9])
def test_planes_are_believable_from_the_least_confidence_on(least):
    sure = np.array([1.0, least + 0.01, least, least - 0.01, 0.0])
    found = believable(np.full(5, 0.8), sure, least)
    assert list(found) == [True, True, True, False, False]


def test_a_further_plane_must_agree_nearly_as_well_as_the_best():
    agreement = np.array([0.85, 0.86 - RIVAL, 0.84 - RIVAL, 0.99])
    assert list(believable(agreement, np.ones(4), 0.5)) == [True, True, False, True]


def test_any_plane_is_believable_to_those_who_ask_for_no_confidence():
    assert believable(np.full(3, 0.4), np.zeros(3), 0.0).all()
