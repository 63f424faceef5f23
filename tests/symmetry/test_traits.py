from types import SimpleNamespace

import numpy as np
import pytest
from symmetry.bodies import as_prepared, even_sphere, no_planes, symmetric_cloud

from meshlab_symrecon.symmetry.preparation import prepare
from meshlab_symrecon.symmetry.traits import (
    CHANCE_MERIT,
    FEW_EXCUSED,
    MOST_LEAD,
    RIVALS,
    TRAITS,
    VARIANT,
    _excused,
    _lead,
    _worst_regions,
    merit,
    traits,
    whole_symmetry,
)
from meshlab_symrecon.symmetry.verification import Evidence, Landings, examine

TOLERANCE = 0.006


def evidence(support, agreement, contradiction=0.01, residual=0.002):
    support = np.asarray(support, dtype=float)
    rest = (np.broadcast_to(np.asarray(x, float), support.shape) for x in (contradiction, residual))
    return Evidence(support, np.asarray(agreement, dtype=float), *rest)


def measured(cloud, planes):
    found = examine(planes, cloud, len(cloud.samples), TOLERANCE, exact=True)
    return found, dict(zip(TRAITS, traits(planes, found, cloud, TOLERANCE).T, strict=True))


@pytest.fixture(scope="module")
def exact():
    """An exactly symmetric cloud, its plane and three wrong ones."""
    points, normals, plane = symmetric_cloud(0)
    rng = np.random.default_rng(1)
    wrong = rng.normal(size=(3, 4)) * [1.0, 1.0, 1.0, 0.1]
    planes = np.vstack([plane, wrong])
    planes /= np.linalg.norm(planes[:, :3], axis=1, keepdims=True)
    return (*measured(as_prepared(points, normals), planes), planes)


def test_an_exact_plane_has_the_best_of_all_traits(exact):
    _, found, _ = exact
    for name in ("agreement", "fine agreement", "cleanness", "worst regions", "rim agreement"):
        assert found[name][0] == pytest.approx(1.0, abs=1e-9), name
    for name in ("fine relief", "relief", "coarse relief"):
        assert found[name][0] == pytest.approx(1.0, abs=1e-9), name
    for name in ("residual", "turn", "broken off"):
        assert found[name][0] == pytest.approx(0.0, abs=1e-5), name
    for name in ("excused", "rim excused"):
        assert found[name][0] == FEW_EXCUSED, name
    assert found["support"][0] == found["support"].max()
    assert found["near misses"][0] == found["near misses"].min()
    assert found["lead"][0] == MOST_LEAD


def test_wrong_planes_have_worse_traits(exact):
    _, found, _ = exact
    for name in ("agreement", "fine agreement", "cleanness", "worst regions", "relief", "support"):
        assert (found[name][1:] < found[name][0]).all(), name
    for name in ("residual", "turn", "near misses"):
        assert (found[name][1:] > found[name][0]).all(), name


def test_traits_stay_in_their_ranges(statue, some_planes):
    cloud = prepare(statue, None, 1_000)
    evidence, found = measured(cloud, some_planes)
    shares = ("agreement", "fine agreement", "cleanness", "worst regions", "excused")
    for name in (*shares, "broken off", "rim agreement", "rim excused"):
        assert ((found[name] >= 0.0) & (found[name] <= 1.0 + 1e-12)).all(), name
    for name in ("fine relief", "relief", "coarse relief"):
        assert (np.abs(found[name]) <= 1.0 + 1e-12).all(), name
    assert ((found["turn"] >= 0.0) & (found["turn"] <= 45.0)).all()
    assert ((found["lead"] >= 0.0) & (found["lead"] <= MOST_LEAD)).all()
    assert all(np.isfinite(column).all() for column in found.values())
    assert np.array_equal(found["agreement"], evidence.agreement)
    assert np.array_equal(found["residual"], 100.0 * evidence.residual)
    assert len(np.unique(found["roughness"])) == 1


def test_traits_of_a_plane_do_not_depend_on_how_it_is_written(statue, some_planes):
    cloud = prepare(statue, None, 500)
    planes = some_planes[::6]
    _, one = measured(cloud, planes)
    _, other = measured(cloud, -planes)
    for name in TRAITS:
        assert np.abs(one[name] - other[name]).max() < 1e-9, name


def test_without_holes_the_rims_agree_as_all_does():
    cloud = prepare(even_sphere(3_000) * [1.0, 0.8, 0.6], None, 500)
    planes = np.array([[1.0, 0.0, 0.0, 0.0], [0.6, 0.8, 0.0, 0.0]])
    _, found = measured(cloud, planes)
    assert not cloud.border.any()
    assert np.array_equal(found["rim agreement"], found["agreement"])
    assert (found["rim excused"] == FEW_EXCUSED).all()
    assert (found["excused"] == FEW_EXCUSED).all()


def test_no_planes_have_no_traits(statue):
    cloud = prepare(statue, None, 50)
    found = examine(no_planes(), cloud, 50, TOLERANCE, exact=True)
    assert traits(no_planes(), found, cloud, TOLERANCE).shape == (0, len(TRAITS))
    assert merit(found).shape == (0,)
    assert whole_symmetry(found).shape == (0,)


def test_few_points_have_finite_traits():
    cloud = prepare(np.random.default_rng(0).random((8, 3)), None, 2_500)
    _, found = measured(cloud, np.eye(4)[:3])
    assert all(np.isfinite(column).all() for column in found.values())


def test_merit_rises_with_agreement_and_support():
    found = merit(evidence([0.2, 0.3, 0.3, 0.0], [0.5, 0.5, 0.6, 0.0]))
    assert found[0] < found[1] < found[2]
    assert found[3] < found[0]
    assert np.isfinite(found).all()


def tilted(degrees, shifts):
    turn = np.radians(degrees)
    return np.stack([np.cos(turn), np.sin(turn), np.zeros(len(turn)), shifts], axis=1)


def test_variants_of_a_plane_are_no_rivals_however_they_are_written():
    angle, shift = np.degrees(VARIANT[0]), VARIANT[1]
    planes = tilted([0.0, 0.9 * angle, 0.0], [0.2, 0.2, 0.2 + 0.9 * shift])
    alone = _lead(planes[:1], evidence([0.3], [0.7]))[0]
    among = _lead(planes * [[1.0], [-1.0], [-1.0]], evidence([0.3] * 3, [0.7] * 3))
    assert np.allclose(among[0], alone)
    apart = tilted([0.0, 1.1 * angle, 0.0], [0.2, 0.2, 0.2 + 1.1 * shift])
    assert _lead(apart, evidence([0.3] * 3, [0.7] * 3))[0] < alone


def test_lead_is_the_distance_from_the_mean_of_nine_rivals():
    planes = tilted([0.0, 40.0, 80.0], [0.0] * 3)
    found = evidence([0.4, 0.2, 0.1], [0.9, 0.5, 0.4])
    ordering = merit(found)
    best = sorted([*ordering[1:], *[CHANCE_MERIT] * RIVALS])[-RIVALS:]
    assert _lead(planes, found)[0] == pytest.approx(ordering[0] - np.mean(best))


def test_true_planes_of_a_box_are_no_rivals_but_others_are():
    planes = tilted([0.0, 90.0], [0.0, 0.0])
    whole = evidence([0.9, 0.9], [0.95, 0.95], contradiction=0.0)
    one = evidence([0.9, 0.9], [0.95, 0.95], contradiction=[0.0, 0.02])
    alone = _lead(planes[:1], evidence([0.9], [0.95]))[0]
    assert np.allclose(_lead(planes, whole), alone)
    assert (_lead(planes, one) < alone).all()


def test_whole_symmetry_needs_agreement_support_and_nothing_against_it():
    found = evidence([0.9, 0.9, 0.2, 0.9], [0.95, 0.8, 0.95, 0.95], [0.0, 0.0, 0.0, 0.02])
    assert list(whole_symmetry(found)) == [True, False, False, False]


def landings(worth, excused=0, broken_off=0, weights=1.0):
    """Landings of one plane that are worth something, and nothing else."""
    worth = np.atleast_2d(np.asarray(worth, dtype=float))
    zeros, every = np.zeros(worth.shape), np.ones(worth.shape)
    flags = (zeros + excused > 0, zeros + broken_off > 0)
    return Landings(zeros.astype(np.int64), every * weights, zeros, every, worth, *flags)


def test_excused_is_a_share_of_what_is_not_broken_off():
    found = landings(np.zeros(10), [1, 1, 1, *[0] * 7], [*[0] * 5, *[1] * 5])
    broken, whole = SimpleNamespace(broken=True), SimpleNamespace(broken=False)
    assert _excused(found, broken)[0] == pytest.approx(3 / 5)
    lighter = landings(np.zeros(10), [1, 1, 1, *[0] * 7], 0, [*[0.5] * 5, *[1.0] * 5])
    assert _excused(lighter, broken)[0] == pytest.approx(1.5 / 7.5)
    assert _excused(found, whole)[0] == pytest.approx(3 / 5)
    assert _excused(lighter, whole)[0] == FEW_EXCUSED


def test_the_worst_regions_are_those_of_the_lower_fifth():
    """Forty clusters of ten samples, of which each agrees a little better than the one before."""
    sites = np.random.default_rng(0).permutation(np.arange(40.0))
    places = np.zeros((400, 3))
    places[:, 0] = np.tile(sites, 10)
    worth = places[:, 0] / 39.0
    assert _worst_regions(landings(worth), places)[0] == pytest.approx(0.2)
    # Regions that are mostly excused are not judged.
    excused = places[:, 0] < 20
    upper = np.quantile(np.arange(20, 40) / 39.0, 0.2)
    assert _worst_regions(landings(worth, excused), places)[0] == pytest.approx(upper)
    assert _worst_regions(landings(worth, np.ones(400)), places)[0] == 0.0


def test_what_is_known_to_be_broken_off_is_not_excused_by_holes(statue):
    whole = even_sphere(6_000) * [1.0, 0.7, 0.5]
    cloud = prepare(whole[whole[:, 0] > -0.6], None, 1_000)
    # Across x = 0.3 much of the body falls beyond the break at x = -0.6, across y = 0 nothing does.
    planes = cloud.from_input(np.array([[1.0, 0.0, 0.0, -0.15], [0.0, 1.0, 0.0, 0.0]]))
    _, found = measured(cloud, planes)
    assert found["broken off"][0] > 0.05
    assert found["broken off"][1] < 0.01
    assert found["excused"][0] < 0.05
    assert (found["excused"] + found["broken off"] <= 1.0).all()
