"""Exemplars that stand for a cloud: how many, where, and whatever the input is."""

from __future__ import annotations

import numpy as np
import pytest
import shapes
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist

from meshlab_symrecon.clustering import exemplar_levels, simplification
from meshlab_symrecon.clustering import surface_variation as sv
from meshlab_symrecon.clustering.distinct_points import distinct_points
from meshlab_symrecon.clustering.exact_count import with_exact_count
from meshlab_symrecon.clustering.exemplar_levels import (
    HEXAGON,
    QUICK,
    THOROUGH,
    Level,
    propagate_once,
    propagate_to_count,
    settled,
)
from meshlab_symrecon.clustering.messages import Schedule, propagate_dense
from meshlab_symrecon.clustering.simplification import simplify
from meshlab_symrecon.clustering.surface_variation import (
    EDGE,
    bending,
    surface_variation,
    wanted_density,
)
from meshlab_symrecon.errors import GeometryError, ParameterError

STATUE = shapes.statue(2000, seed=3)
CLOUDS = {
    "one": np.zeros((1, 3)),
    "two": np.eye(3)[:2],
    "three": np.eye(3),
    "all the same": np.ones((50, 3)),
    "line": np.outer(np.arange(60.0), [1.0, 2.0, 3.0]),
    "plane": np.column_stack([np.random.default_rng(1).random((60, 2)), np.zeros(60)]),
    "lattice": shapes.box_lattice(3),
    "duplicates": np.repeat(np.random.default_rng(2).random((15, 3)), 5, axis=0),
    "tiny": 1e-30 * np.random.default_rng(3).random((40, 3)),
    "far away": 1e3 + 1e-6 * np.random.default_rng(4).random((40, 3)),
    "a clump and a point far off": np.vstack(
        [np.random.default_rng(6).random((70, 3)), [[1e4] * 3]]
    ),
    "huge": 1e60 * np.random.default_rng(5).random((40, 3)),
}


def square(count: int, seed: int = 0) -> np.ndarray:
    """Return random points of the unit square."""
    rng = np.random.default_rng(seed)
    return np.column_stack([rng.random((count, 2)), np.zeros(count)])


def net_similarity(level: Level, preferences: np.ndarray, chosen: np.ndarray) -> float:
    losses = (level.mass[:, None] * cdist(level.points, level.points[chosen]) ** 2).min(axis=1)
    return float(preferences[chosen].sum() - losses.sum())


@pytest.mark.parametrize("name", CLOUDS)
def test_every_count_is_met_and_every_point_has_its_nearest_exemplar(name):
    points = CLOUDS[name]
    for count in range(1, len(points) + 1):
        found = simplify(points, count=count)
        assert len(found.chosen) == count
        assert (np.diff(found.chosen) > 0).all()
        assert np.array_equal(found.label[found.chosen], np.arange(count))
        distances = cdist(points, points[found.chosen])
        own = distances[np.arange(len(points)), found.label]
        np.testing.assert_allclose(own, distances.min(axis=1), rtol=1e-12)
        assert found.preference <= 0.0


@pytest.mark.parametrize("name", CLOUDS)
def test_every_preference_gives_exemplars(name):
    points = CLOUDS[name]
    numbers = [len(simplify(points, preference=-value).chosen) for value in (1e-9, 1.0, 16.0, 1e12)]
    assert numbers[0] == len(np.unique(points, axis=0))
    assert numbers == sorted(numbers, reverse=True)
    assert numbers[-1] == (2 if "far off" in name else 1)  # where it is sparse little is enough


def test_equal_points_come_after_all_distinct_ones():
    points = CLOUDS["duplicates"]
    kept = points[simplify(points, count=15).chosen]
    assert len(np.unique(kept, axis=0)) == 15
    assert simplify(points, count=15).chosen.tolist() == list(range(0, 75, 5))
    assert simplify(points, count=17).chosen.tolist() == [0, 1, 2, *range(5, 75, 5)]


def test_a_lone_point_is_its_own_exemplar_whatever_is_asked():
    level = Level.of(np.zeros((1, 3)), np.array([7.0]), 4.0, 3.0)
    assert level.unit == 1.0 / 7.0
    assert propagate_once(level, 1.0, THOROUGH).messages.exemplars.tolist() == [0]


def test_two_heaps_have_an_exemplar_each():
    rng = np.random.default_rng(0)
    heaps = rng.normal(size=(80, 3))
    heaps[30:, 0] += 100.0
    assert (heaps[simplify(heaps, count=2).chosen, 0] > 50).tolist() == [False, True]


@pytest.mark.parametrize("motion", shapes.MOTIONS, ids=lambda motion: motion.name)
def test_the_same_points_are_chosen_after_a_motion(motion):
    rest, moved = (simplify(points, count=300) for points in (STATUE, motion(STATUE)))
    assert len(np.intersect1d(rest.chosen, moved.chosen)) >= 297
    assert moved.preference == pytest.approx(rest.preference, rel=1e-3)


def test_the_same_points_are_chosen_in_any_order():
    order = np.random.default_rng(0).permutation(len(STATUE))
    rest, shuffled = simplify(STATUE, count=300), simplify(STATUE[order], count=300)
    assert np.array_equal(np.sort(order[shuffled.chosen]), rest.chosen)
    assert np.array_equal(order[shuffled.chosen[shuffled.label]], rest.chosen[rest.label[order]])
    again = simplify(STATUE, count=300)
    assert np.array_equal(again.chosen, rest.chosen)


@pytest.mark.parametrize("preference", [-1.0, -4.0, -16.0, -100.0, -1600.0])
def test_the_number_of_exemplars_follows_from_the_preference(preference):
    points = shapes.torus(4000, seed=2)
    found = simplify(points, preference=preference, detail=0.0)
    share = np.sqrt(-preference / HEXAGON)
    assert len(found.chosen) == pytest.approx(len(points) / share, rel=0.15)
    back = simplify(points, count=len(found.chosen), detail=0.0)
    assert back.preference == pytest.approx(preference, rel=0.15)


def test_messages_along_the_graph_choose_as_messages_between_all_points_do():
    cloud = distinct_points(STATUE[:800])
    level = Level.of(cloud.points, cloud.mass, 4.0, 4.0)
    found = propagate_once(level, level.area(200), THOROUGH).messages
    assert found.converged
    table = -cdist(cloud.points, cloud.points, "sqeuclidean")
    np.fill_diagonal(table, level.preferences(level.area(200)))
    whole = propagate_dense(table, Schedule(0.8, 2000, 15))
    assert whole.converged
    shared = len(np.intersect1d(found.exemplars, whole.exemplars))
    assert shared >= 0.97 * max(len(found.exemplars), len(whole.exemplars))


def test_mass_counts_as_so_many_equal_points():
    cloud = distinct_points(STATUE[:500])
    mass = 1.0 + np.random.default_rng(0).integers(0, 4, 500)
    level = Level.of(cloud.points, mass, 4.0, 0.0)
    found = propagate_once(level, level.area(120), THOROUGH).messages
    copies = mass.astype(int)
    many = np.repeat(cloud.points, copies, axis=0)
    first = np.cumsum(copies) - copies
    preferences = level.preferences(level.area(120))
    table = -cdist(many, many, "sqeuclidean")
    table[:, np.setdiff1d(np.arange(len(many)), first)] = -1e6  # a copy is no candidate
    np.fill_diagonal(table, -1e6)
    table[first, first] = preferences
    whole = propagate_dense(table, Schedule(0.8, 2000, 15))
    place = np.searchsorted(first, whole.exemplars)
    assert np.array_equal(first[place], whole.exemplars)
    ours, theirs = (net_similarity(level, preferences, x) for x in (found.exemplars, place))
    assert ours == pytest.approx(theirs, rel=0.01)
    blind = Level.of(cloud.points, np.ones(500), 4.0, 0.0)
    unweighted = propagate_once(blind, blind.area(120), THOROUGH).messages.exemplars
    assert net_similarity(level, preferences, unweighted) < 1.015 * theirs


def test_an_even_cloud_is_covered_evenly_without_detail():
    points = square(20_000)
    kept = points[simplify(points, count=1000, detail=0.0).chosen]
    inner = (np.abs(kept[:, :2] - 0.5) < 0.4).all(axis=1)
    gaps = cKDTree(kept).query(kept[inner], k=2)[0][:, 1] * np.sqrt(1000)
    assert gaps.min() > 0.35  # a random choice has 0.02 here, a square lattice 1
    assert gaps.std() / gaps.mean() < 0.2  # random: 0.52
    away = cKDTree(kept).query(points)[0].max() * np.sqrt(1000)
    assert away < 1.05  # random: about 1.7


def test_no_seam_shows_where_the_input_changes_its_density():
    rng = np.random.default_rng(0)
    points = square(20_000)
    points = points[(points[:, 0] > 0.5) | (rng.random(20_000) < 0.3)]
    kept = points[simplify(points, count=1200, detail=0.0).chosen]
    inner = kept[(np.abs(kept[:, :2] - 0.5) < 0.45).all(axis=1)]
    sparse, dense = (np.count_nonzero((inner[:, 0] > 0.5) == side) for side in (False, True))
    assert dense / sparse == pytest.approx(1.0, abs=0.12)  # of the input: 3.3


def test_exemplars_gather_where_the_surface_bends():
    rng = np.random.default_rng(1)
    flat = square(6000)
    cap = shapes.fibonacci_sphere(1200)
    bump = 0.1 * cap[cap[:, 2] > 0.0] + [0.5, 0.5, 0.0]
    outside = np.hypot(flat[:, 0] - 0.5, flat[:, 1] - 0.5) > 0.1
    points = np.concatenate([flat[outside], bump])
    points = points[rng.permutation(len(points))]

    def share(detail: float) -> float:
        kept = points[simplify(points, count=400, detail=detail).chosen]
        return float(np.mean(np.hypot(kept[:, 0] - 0.5, kept[:, 1] - 0.5) < 0.102))

    shares = [share(detail) for detail in (0.0, 2.0, 8.0)]
    assert shares[0] < shares[1] < shares[2]
    assert shares[2] > 1.5 * shares[0]


@pytest.mark.parametrize("curvature", [0.02, 0.05, 0.1])
def test_surface_variation_tells_the_curvature(curvature):
    turn, radius = (np.random.default_rng(0).random((2, 200_000)).T * [2 * np.pi, 1.0]).T
    radius = np.sqrt(radius)
    disc = np.column_stack(
        [radius * np.cos(turn), radius * np.sin(turn), curvature * radius**2 / 2]
    )
    found = surface_variation(disc, np.arange(len(disc), dtype=np.int32)[None])[:1]
    assert bending(found)[0] == pytest.approx(curvature, rel=0.01)
    assert found[0] == pytest.approx(curvature**2 / 24, rel=0.02)


def test_surface_variation_of_a_plane_is_0_and_of_a_ball_a_third():
    rng = np.random.default_rng(0)
    ball = rng.normal(size=(100_000, 3))
    everyone = np.arange(len(ball), dtype=np.int32)[None]
    assert surface_variation(ball, everyone)[0] == pytest.approx(1 / 3, abs=0.005)
    assert surface_variation(ball * [1.0, 1.0, 0.0], everyone)[0] == pytest.approx(0.0, abs=1e-12)
    assert surface_variation(np.zeros((3, 3)), np.zeros((3, 2), dtype=np.int32)).tolist() == [0] * 3


def test_the_surface_variation_of_a_right_angle():
    rng = np.random.default_rng(0)
    disc = rng.uniform(-1.0, 1.0, (400_000, 2))
    disc = disc[(disc**2).sum(axis=1) < 1.0]
    folded = np.column_stack([disc[:, 0], np.maximum(disc[:, 1], 0.0), np.maximum(-disc[:, 1], 0)])
    everyone = np.arange(len(folded), dtype=np.int32)[None]
    assert surface_variation(folded, everyone)[0] == pytest.approx(EDGE, rel=0.01)


def test_the_wanted_density_is_that_of_the_formula_above_its_floor():
    variation = np.array([0.0, 0.0, 0.01, EDGE, 0.2])
    density = 1.0 + 3.0 * (np.sqrt(24.0 * variation) + 2.0 * (variation / EDGE) ** 2)
    mostly_flat = np.array([100.0, 1.0, 1.0, 1.0, 1.0])
    np.testing.assert_allclose(wanted_density(variation, mostly_flat, 3.0), density)
    area = np.array([1.0, 1.0, 1.0, 100.0, 1.0])
    floor = 0.65 * (density * area).sum() / area.sum()
    assert floor > density[2] > 2.0
    found = wanted_density(variation, area, 3.0)
    np.testing.assert_allclose(found, np.maximum(density, floor) / floor)
    assert found.min() == 1.0
    assert (wanted_density(variation, area, 0.0) == 1.0).all()


def test_a_thin_spike_keeps_its_tip():
    rng = np.random.default_rng(0)
    length = rng.random(400)
    turn = 2 * np.pi * rng.random(400)
    round_it = 0.02 * (1.0 - length)
    spike = np.column_stack([round_it * np.cos(turn), round_it * np.sin(turn), 1.0 + length / 2])
    points = np.concatenate([shapes.fibonacci_sphere(8000), spike])

    def kept(detail: float) -> int:
        chosen = points[simplify(points, count=600, detail=detail).chosen]
        return np.count_nonzero(chosen[:, 2] > 1.02)

    assert kept(3.0) > 2 * kept(0.0)


def test_working_in_parts_changes_nothing(monkeypatch):
    whole = simplify(STATUE, count=300)
    monkeypatch.setattr(exemplar_levels, "CHUNK", 97)
    monkeypatch.setattr(sv, "CHUNK", 97)
    parts = simplify(STATUE, count=300)
    assert np.array_equal(parts.chosen, whole.chosen)
    assert np.array_equal(parts.label, whole.label)


def test_many_points_stop_early_and_are_counted_as_exactly(monkeypatch):
    thorough = simplify(STATUE, count=300)
    monkeypatch.setattr(simplification, "MANY", 100)
    quick = simplify(STATUE, count=300)
    assert len(quick.chosen) == 300
    assert quick.iterations < thorough.iterations
    assert len(np.intersect1d(quick.chosen, thorough.chosen)) > 240


@pytest.mark.parametrize("change", [-1, 1])
def test_the_exact_step_takes_the_best_single_change(change):
    cloud = distinct_points(STATUE[:150])
    level = Level.of(cloud.points, cloud.mass, 5.0, 2.0)
    found = propagate_to_count(level, 30, THOROUGH)
    preferences = level.preferences(found.area)
    before = found.messages.exemplars
    after = with_exact_count(level, found, len(before) + change)
    changed = np.setxor1d(before, after)
    assert len(changed) == 1
    candidates = before if change < 0 else np.setdiff1d(np.arange(150), before)
    best = max(
        candidates, key=lambda point: net_similarity(level, preferences, np.setxor1d(before, point))
    )
    assert changed[0] == best


@pytest.mark.parametrize("count", [1, 5, 60, 149, 150])
def test_the_exact_step_reaches_any_count(count):
    cloud = distinct_points(STATUE[:150])
    level = Level.of(cloud.points, cloud.mass, 5.0, 2.0)
    found = propagate_to_count(level, 30, THOROUGH)
    after = with_exact_count(level, found, count)
    assert len(np.unique(after)) == count


@pytest.mark.parametrize("name", ["line", "lattice", "a clump and a point far off"])
def test_levels_between_leave_enough_to_choose_from(name, monkeypatch):
    seen = []

    def spy(level, count, schedule):
        seen.append(len(level.points))
        return propagate_to_count(level, count, schedule)

    monkeypatch.setattr(simplification, "propagate_to_count", spy)
    points = CLOUDS[name]
    for count in range(1, len(points) // 16 + 1):  # three levels and more
        seen.clear()
        simplify(points, count=count)
        levels = int(np.ceil(np.log(len(points) / count) / np.log(4.0) - 1e-9))
        before_last = len(points) * (count / len(points)) ** (1.0 - 1.0 / levels)
        assert seen[0] >= np.floor(0.8 * before_last)


def level_of(count: int) -> tuple[Level, float]:
    cloud = distinct_points(STATUE)
    level = Level.of(cloud.points, cloud.mass, len(STATUE) / count, 3.0)
    return level, level.area(count)


@pytest.mark.parametrize("schedule", [QUICK, THOROUGH], ids=["quick", "thorough"])
@pytest.mark.parametrize("count", [200, 600, 1000])
def test_the_preferences_that_are_found_give_the_number_nearly(count, schedule):
    level, _ = level_of(count)
    found = propagate_to_count(level, count, schedule)
    assert len(found.messages.exemplars) == pytest.approx(count, rel=0.025)


def test_messages_that_keep_turning_single_points_have_settled():
    level, area = level_of(600)
    early = propagate_once(level, area, Schedule(0.6, 30, 10))
    assert not early.messages.converged
    assert settled(level, early)
    best = propagate_once(level, area, Schedule(0.8, 2000, 10))
    assert best.messages.converged
    assert settled(level, best)
    early, best = (level.net_similarity(area, found.messages.exemplars) for found in (early, best))
    assert early == pytest.approx(best, rel=1e-3)


@pytest.mark.parametrize("iterations", [1, 10, 20])
def test_messages_that_are_stopped_too_early_have_not_settled(iterations):
    level, area = level_of(600)
    early = propagate_once(level, area, Schedule(0.8, iterations, 10))
    assert len(early.messages.exemplars) >= 1
    assert not settled(level, early)


def test_the_earlier_exemplars_are_those_of_earlier():
    level, area = level_of(600)
    early, later = (
        propagate_once(level, area, Schedule(0.8, most, 10)).messages for most in (25, 35)
    )
    assert np.array_equal(later.earlier, early.exemplars)
    assert not np.array_equal(later.exemplars, early.exemplars)
    done = propagate_once(level, area, Schedule(0.8, 2000, 10)).messages
    assert np.array_equal(done.earlier, done.exemplars)


def test_net_similarity_is_that_of_the_definition():
    level, area = level_of(600)
    chosen = np.arange(0, 2000, 7)
    expected = net_similarity(level, level.preferences(area), chosen)
    assert level.net_similarity(area, chosen) == pytest.approx(expected, rel=1e-12)


def test_stopped_messages_are_told(monkeypatch):
    assert simplify(STATUE, count=600).converged
    monkeypatch.setattr(simplification, "THOROUGH", Schedule(0.8, 5, 10))
    found = simplify(STATUE, count=600)
    assert not found.converged
    assert len(found.chosen) == 600


@pytest.mark.parametrize("count", [50.0, np.int32(50), np.float64(50.0)])
def test_a_whole_number_of_any_type_is_a_count(count):
    assert np.array_equal(simplify(STATUE, count=count).chosen, simplify(STATUE, count=50).chosen)


@pytest.mark.parametrize("scale", [1e-200, 1e160])
def test_extents_beyond_floats_are_refused(scale):
    with pytest.raises(GeometryError, match=r"simplification needs points that extend .* units"):
        simplify(scale * STATUE, count=50)


def test_progress_rises_to_1():
    told = []
    simplify(STATUE, count=30, progress=lambda fraction, message: told.append((fraction, message)))
    fractions = [fraction for fraction, _ in told]
    assert fractions[0] == 0.0
    assert fractions[-1] == 1.0
    assert (np.diff(fractions) > 0).all()
    assert told[0][1] == "messages of level 1 of 4"


BAD = {
    "needs a count or a preference, and not both; got count=None and preference=None": {},
    "needs a count or a preference, and not both; got count=5": {"count": 5, "preference": -1.0},
    "count must lie between 1 and the 2000 points there are; got 0": {"count": 0},
    "count must lie between 1 and the 2000 points there are; got 2001": {"count": 2001},
    "count must be a whole number; got 50.5; round it": {"count": 50.5},
    "count must be a whole number; got nan": {"count": np.nan},
    "count must be a whole number; got inf": {"count": np.inf},
    "count must be a whole number; got '50'": {"count": "50"},
    "preference must be below 0, and at least -1e[+]12 squared spacings; got 0": {"preference": 0},
    "preference must be below 0, .* got nan": {"preference": np.nan},
    "detail must lie between 0 and 100; got -1": {"count": 5, "detail": -1.0},
    "detail must lie between 0 and 100; got nan": {"count": 5, "detail": np.nan},
}


@pytest.mark.parametrize("message", BAD)
def test_numbers_that_make_no_sense_are_refused(message):
    with pytest.raises(ParameterError, match=message):
        simplify(STATUE, **BAD[message])


@pytest.mark.parametrize("points", [np.zeros((0, 3)), np.zeros((5, 2)), np.full((5, 3), np.nan)])
def test_what_is_no_cloud_is_refused(points):
    with pytest.raises(GeometryError):
        simplify(points, count=1)
