"""Exact Delaunay and regular triangulation (about 12 seconds)."""

from __future__ import annotations

import importlib.util
import itertools
import math
import signal
import subprocess
import sys
import types
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from meshlab_symrecon import _native
from meshlab_symrecon.errors import GeometryError
from meshlab_symrecon.geometry import triangulation as module
from meshlab_symrecon.geometry.triangulation import (
    circumcentres,
    delaunay,
    regular_triangulation,
)


def neighbour_module(name: str) -> types.ModuleType:
    """Import a support module of this folder under any import mode."""
    spec = importlib.util.spec_from_file_location(name, Path(__file__).with_name(f"{name}.py"))
    loaded = importlib.util.module_from_spec(spec)
    sys.modules[name] = loaded
    spec.loader.exec_module(loaded)
    return loaded


checks = neighbour_module("triangulation_checks")
inputs = neighbour_module("triangulation_inputs")

STAGES = {"all": 0, "filter": 1, "double-double": 2, "exact": 3}
UNDECIDED = 2


def sign(value) -> int:
    return (value > 0) - (value < 0)


def poles_of(triangulation):
    """Both poles of every used site: the farthest circumcentre, and the farthest opposite it."""
    centres = circumcentres(triangulation)
    around = [[] for _ in triangulation.sites]
    for cell, vertices in enumerate(triangulation.cells.tolist()):
        for site in vertices:
            around[site].append(cell)
    chosen = {}
    for site, cells in enumerate(around):
        offsets = centres[cells] - triangulation.sites[site]
        lengths = np.linalg.norm(offsets, axis=1)
        usable = np.isfinite(lengths)
        if not usable.any():
            continue
        first = int(np.argmax(np.where(usable, lengths, -1.0)))
        chosen.setdefault(cells[first], lengths[first] ** 2)
        unit = offsets[first] / max(lengths[first], 1e-300)
        opposite = usable & (np.where(usable[:, None], offsets, 0.0) @ unit < 0)
        if opposite.any():
            second = int(np.argmax(np.where(opposite, lengths, -1.0)))
            chosen.setdefault(cells[second], lengths[second] ** 2)
    return centres[list(chosen)], np.array(list(chosen.values()))


# --- predicates ----------------------------------------------------------------------------------


def exact_orientation(points):
    p = [[Fraction(float(x)) for x in row] for row in points]
    return sign(
        fraction_determinant([[x - y for x, y in zip(row, p[0], strict=True)] for row in p[1:]])
    )


def exact_power(points, weights):
    """+1 when the fifth site is in conflict with the (positive) cell of the first four."""
    p = [[Fraction(float(x)) for x in row] for row in points]
    w = [Fraction(float(x)) for x in weights]
    rows = [
        [*row, sum(x * x for x in row) - weight, Fraction(1)]
        for row, weight in zip(p, w, strict=True)
    ]
    rows = [[x - y for x, y in zip(row, rows[4], strict=True)][:4] for row in rows[:4]]
    return -sign(fraction_determinant(rows))


def fraction_determinant(rows):
    if len(rows) == 1:
        return rows[0][0]
    return sum(
        (-1) ** k * rows[0][k] * fraction_determinant([row[:k] + row[k + 1 :] for row in rows[1:]])
        for k in range(len(rows))
    )


def adversarial_sites():
    """Five sites each: generic, near a plane, near a sphere, on integers, at extreme scales."""
    random = np.random.default_rng(11)
    for _ in range(60):
        yield random.normal(size=(5, 3)), random.normal(size=5)
    for _ in range(60):
        yield random.integers(0, 3, (5, 3)).astype(float), random.integers(0, 3, 5).astype(float)
    for _ in range(100):  # on a plane or a sphere up to rounding, then moved by some ulps
        flat = random.normal(size=(5, 2)) @ random.normal(size=(2, 3)) + random.normal(size=3)
        round_ = random.normal(size=(5, 3))
        round_ /= np.linalg.norm(round_, axis=1, keepdims=True)
        for points in (flat, round_, round_ + 1000.0):
            ulps = random.integers(-1, 2, points.shape)
            yield points + ulps * np.spacing(points), np.zeros(5)
    for _ in range(60):  # orthogonal to one ball up to rounding, as poles are
        points = random.normal(size=(5, 3))
        yield points, (points**2).sum(axis=1) * (1 + random.integers(-1, 2, 5) * 2.0**-53)
    for power in (-1070, -400, -150, 150, 500, 1000):
        points = np.ldexp(random.integers(-8, 9, (5, 3)).astype(float), power)
        yield points, np.zeros(5)
        yield points + np.spacing(points), np.ldexp(random.normal(size=5), power)
    yield np.ldexp(random.normal(size=(5, 3)), random.integers(-1000, 1000, (5, 3))), np.zeros(5)


@pytest.mark.parametrize("stage", STAGES)
def test_a_certified_sign_is_the_exact_one(stage):
    decided = 0
    for points, weights in adversarial_sites():
        found = _native.orientation(points[:4], STAGES[stage])
        power = _native.power_test(points, weights, STAGES[stage])
        if stage in {"all", "exact"}:
            assert UNDECIDED not in {found, power}
        assert found in {UNDECIDED, exact_orientation(points[:4])}
        assert power in {UNDECIDED, exact_power(points, weights)}
        decided += (found != UNDECIDED) + (power != UNDECIDED)
    assert decided > 120  # no stage hides behind never deciding


def permanent_of_power_test(points, weights):
    p = [[Fraction(float(x)) for x in row] for row in points]
    w = [Fraction(float(x)) for x in weights]
    rows = []
    for row, weight in zip(p[:4], w[:4], strict=True):
        arm = [abs(x - y) for x, y in zip(row, p[4], strict=True)]
        rows.append([*arm, sum(x * x for x in arm) + abs(weight - w[4])])
    return sum(
        math.prod(rows[i][k] for i, k in enumerate(order))
        for order in itertools.permutations(range(4))
    )


def power_determinant(points, weights):
    p = [[Fraction(float(x)) for x in row] for row in points]
    w = [Fraction(float(x)) for x in weights]
    rows = []
    for row, weight in zip(p[:4], w[:4], strict=True):
        arm = [x - y for x, y in zip(row, p[4], strict=True)]
        rows.append([*arm, sum(x * x for x in arm) - weight + w[4]])
    return -fraction_determinant(rows)


def test_the_fine_determinant_keeps_its_bound_and_is_the_same_on_every_machine():
    for points, weights in adversarial_sites():
        if not 1e-30 < np.abs(points).max() < 1e30:
            continue  # the fine stage is not asked
        plain, used = (
            _native.fine_power_determinant(points, weights, fused) for fused in (False, True)
        )
        assert plain == used
        error = abs(Fraction(plain) - power_determinant(points, weights))
        rounding = abs(Fraction(plain)) * Fraction(2) ** -53
        bound = permanent_of_power_test(points, weights) * 256 * Fraction(2) ** -106
        assert error <= bound + rounding + Fraction(2) ** -700


def test_double_doubles_decide_what_rounding_leaves_of_a_sphere():
    random = np.random.default_rng(12)
    undecided = np.zeros(2, dtype=int)
    for _ in range(300):
        points = random.normal(size=(5, 3))
        points /= np.linalg.norm(points, axis=1, keepdims=True)
        for row, stage in enumerate(("filter", "double-double")):
            found = _native.power_test(points, np.zeros(5), STAGES[stage])
            undecided[row] += found == UNDECIDED
    assert undecided[0] > 150
    assert undecided[1] < 5


def test_signs_alternate_under_permutation():
    for points, weights in itertools.islice(adversarial_sites(), 40, 200, 7):
        orientation = _native.orientation(points[:4])
        power = _native.power_test(points, weights)
        for order in itertools.permutations(range(5)):
            parity = round(np.linalg.det(np.eye(5)[list(order)]))
            assert _native.power_test(points[list(order)], weights[list(order)]) == parity * power
            if order[4] == 4:
                assert _native.orientation(points[list(order[:4])]) == parity * orientation


def test_perturbation_agrees_with_its_definition():
    random = np.random.default_rng(13)
    ties = 0
    for _ in range(300):
        points = np.unique(random.integers(0, 3, (9, 3)), axis=0).astype(float)
        points = random.permutation(points)[:5]
        weights = np.zeros(5)
        turn = _native.orientation(points[:4])
        if len(points) < 5 or turn == 0:
            continue
        if turn < 0:
            points[[0, 1]] = points[[1, 0]]
        ties += _native.power_test(points, weights) == 0
        exact = checks.ExactSites.of(points, weights)
        ranks = np.lexsort(points.T[::-1]).argsort()
        expected = -checks.perturbed_power_sign(exact, ranks, (0, 1, 2, 3), 4)
        assert _native.perturbed_power_test(points, weights) == expected
    assert ties > 30


@pytest.mark.parametrize("predicate", [_native.power_test, _native.perturbed_power_test])
def test_predicates_refuse_a_wrong_count(predicate):
    with pytest.raises(ValueError, match="five points"):
        predicate(np.zeros((4, 3)), np.zeros(4))
    with pytest.raises(ValueError, match="one weight"):
        predicate(np.zeros((5, 3)), np.zeros(4))
    with pytest.raises(ValueError, match="four points"):
        _native.orientation(np.zeros((5, 3)))


# --- small cases against all subsets -------------------------------------------------------------


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("weighted", [False, True], ids=["delaunay", "regular"])
@pytest.mark.parametrize("integer", [False, True], ids=["generic", "degenerate"])
def test_cells_are_those_of_the_definition(seed, weighted, integer):
    random = np.random.default_rng(seed)
    for _ in range(25):
        count = int(random.integers(4, 9))
        if integer:
            points = np.unique(random.integers(0, 3, (count, 3)), axis=0).astype(float)
            weights = random.integers(0, 3, len(points)).astype(float)
        else:
            points, weights = random.normal(size=(count, 3)), random.normal(size=count)
        order = random.permutation(len(points))
        points, weights = points[order], weights * weighted
        if np.linalg.matrix_rank(points - points[0]) < 3:
            continue
        result = regular_triangulation(points, weights)
        checks.assert_valid(result)
        assert checks.cell_set(result) == checks.brute_force(points, weights)


# --- the zoo -------------------------------------------------------------------------------------


@pytest.mark.parametrize("make", inputs.INPUTS, ids=lambda make: make.__name__)
def test_delaunay_of_hard_input_is_valid(make):
    points = make()
    result = delaunay(points)
    checks.assert_valid(result)
    assert not result.hidden.any()
    order = np.random.default_rng(0).permutation(len(points))
    labels = result.representative  # of duplicates another one may be used
    shuffled = delaunay(points[order])
    assert checks.cell_set(shuffled, labels[order]) == checks.cell_set(result)


@pytest.mark.parametrize("make", inputs.INPUTS_WITH_POLES, ids=lambda make: make.__name__)
def test_poles_of_hard_input_triangulate(make):
    poles, weights = poles_of(delaunay(make()))
    usable = np.isfinite(poles).all(axis=1) & np.isfinite(weights)
    poles, weights = poles[usable], weights[usable]
    checks.assert_valid(regular_triangulation(poles, weights))


@pytest.mark.parametrize("size", [2, 3, 5, 8, 12])
def test_lattices_are_triangulated_with_the_right_volume(size):
    result = delaunay(inputs.lattice(size))
    checks.assert_valid(result)
    exact = checks.ExactSites.of(result.sites, result.weights)
    assert exact.orientations(result.cells.astype(np.int64)).sum() == 6 * (size - 1) ** 3


@pytest.mark.parametrize(
    ("points", "rank"),
    [
        (np.zeros((0, 3)), 0),
        (np.zeros((7, 3)), 0),
        (np.ones((3, 3)), 0),
        (np.outer(np.arange(9.0), [1, 2, 3]), 1),
        (np.random.default_rng(0).random((20, 3)) * [1, 1, 0], 2),
        (np.eye(3), 2),
    ],
)
def test_flat_input_is_refused_with_its_rank(points, rank):
    with pytest.raises(GeometryError, match=f"got {len(points)} points of rank {rank}"):
        delaunay(points)


# --- weights -------------------------------------------------------------------------------------


def test_equal_weights_are_no_weights():
    points = inputs.generic_ball()
    assert checks.cell_set(regular_triangulation(points, np.full(len(points), 7.5))) == (
        checks.cell_set(delaunay(points))
    )


@pytest.mark.parametrize("spread", [0.01, 0.1, 1.0, 100.0])
def test_weights_hide_sites_but_lose_none(spread):
    points = inputs.generic_ball()
    weights = np.random.default_rng(14).random(len(points)) * spread
    result = regular_triangulation(points, weights)
    checks.assert_valid(result)
    assert result.hidden.any() == (spread > 0.01)


def test_weights_on_a_lattice_hide_all_inner_sites():
    points = inputs.lattice(6)
    corner = ((points == 0) | (points == 5)).all(axis=1)
    result = regular_triangulation(points, np.where(corner, 1e3, 0.0))
    checks.assert_valid(result)
    assert np.array_equal(~result.hidden, corner)


def test_the_heaviest_of_equal_positions_is_used():
    points = np.vstack([inputs.generic_ball()[:50]] * 3)
    weights = np.repeat([0.1, 0.3, 0.3], 50)
    result = regular_triangulation(points, weights)
    checks.assert_valid(result)
    assert np.array_equal(result.representative, np.tile(np.arange(50, 100), 3))


def test_a_common_weight_or_motion_of_the_paraboloid_changes_nothing():
    points = np.random.default_rng(15).integers(-50, 50, (120, 3)).astype(float)
    weights = np.random.default_rng(16).integers(0, 400, 120).astype(float)
    expected = checks.cell_set(regular_triangulation(points, weights))
    assert checks.cell_set(regular_triangulation(points, weights + 4096.0)) == expected
    moved = regular_triangulation(points + np.array([1024.0, -2048.0, 512.0]), weights)
    assert checks.cell_set(moved) == expected
    scaled = regular_triangulation(points * 2.0**300, weights * 2.0**600)
    assert checks.cell_set(scaled) == expected


@pytest.mark.parametrize("factor", [1e-6, 0.3, 1e6])
def test_cells_follow_similarity_motions(factor):
    points = inputs.generic_surface()
    weights = np.random.default_rng(17).random(len(points)) * 1e-3
    rotation = np.linalg.qr(np.random.default_rng(18).normal(size=(3, 3)))[0]
    expected = checks.cell_set(regular_triangulation(points, weights))
    moved = factor * (points @ rotation.T + 10.0)
    assert checks.cell_set(regular_triangulation(moved, factor**2 * weights)) == expected


def test_input_stays_and_output_repeats():
    points = inputs.torus_grid()
    weights = np.random.default_rng(19).random(len(points)) * 0.1
    before = points.copy(), weights.copy()
    first, second = regular_triangulation(points, weights), regular_triangulation(points, weights)
    assert np.array_equal(points, before[0])
    assert np.array_equal(weights, before[1])
    for name in ("cells", "neighbours", "representative", "hidden", "hidden_cell"):
        assert getattr(first, name).tobytes() == getattr(second, name).tobytes()
        assert not getattr(first, name).flags.writeable


# --- size, progress, borders ---------------------------------------------------------------------


def test_a_larger_surface_is_valid_and_has_the_usual_number_of_cells():
    random = np.random.default_rng(20)
    direction = random.normal(size=(4000, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    radius = 1 + 0.2 * np.sin(3 * direction[:, :1]) * np.cos(4 * direction[:, 1:2])
    result = delaunay(direction * radius)
    checks.assert_valid(result)
    checks.assert_valid(regular_triangulation(*poles_of(result)))
    assert 5.5 < len(result.cells) / 4000 < 8.0


def test_progress_rises_to_one():
    reports = []
    delaunay(np.random.default_rng(21).random((40_000, 3)), progress=reports.append)
    assert len(reports) > 2
    assert reports == sorted(reports)
    assert reports[-1] == 1.0


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_an_error_in_progress_stops_the_work_at_once(share):
    error = InterruptedError("enough")
    reports = []

    def stop(fraction):
        reports.append(fraction)
        if fraction >= share:
            raise error

    with pytest.raises(InterruptedError) as caught:
        delaunay(np.random.default_rng(21).random((40_000, 3)), progress=stop)
    assert caught.value is error
    assert all(fraction < share for fraction in reports[:-1])
    assert share <= reports[-1] < share + 0.5


@pytest.mark.skipif(sys.platform == "win32", reason="a clock of Posix")
def test_an_interrupt_from_the_keyboard_stops_the_work():
    """The signal comes after some work, not after some time, which the machine may give others."""
    points = np.random.default_rng(25).random((400_000, 3))
    reports = []

    def watch(fraction):
        if fraction > 0.02 >= max(reports, default=0.0):
            signal.setitimer(signal.ITIMER_PROF, 0.01)
        reports.append(fraction)

    before = signal.signal(signal.SIGPROF, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            delaunay(points, progress=watch)
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)
    assert 0.02 < reports[-1] < 0.5


@pytest.mark.parametrize(
    ("weights", "message"),
    [
        (np.zeros(3), r"shape \(400,\)"),
        (np.zeros((400, 1)), r"shape \(400,\)"),
        (["heavy"] * 400, r"must be numbers in an array of shape \(400,\)"),
        (np.full(400, np.nan), "400 values with NaN or infinity"),
        (np.r_[np.zeros(399), np.inf], "index 399"),
    ],
)
def test_bad_weights_are_refused(weights, message):
    with pytest.raises(GeometryError, match=message):
        regular_triangulation(inputs.generic_ball(), weights)


def test_too_many_points_are_refused(monkeypatch):
    monkeypatch.setattr(module, "MAXIMUM_SITES", 399)
    with pytest.raises(GeometryError, match="at most 399 points; got 400"):
        delaunay(inputs.generic_ball())


@pytest.mark.parametrize("wrong", [-1, 3])
def test_poles_of_unknown_sites_are_refused(wrong):
    with pytest.raises(ValueError, match="unknown sites"):
        _native.find_poles(np.eye(3), np.array([[0, 1, 2, wrong]], dtype=np.int32), 3)


def test_the_curve_order_has_every_position_once_whatever_the_order_of_the_points():
    random = np.random.default_rng(26)
    for _ in range(20):
        points = random.integers(-2, 3, (int(random.integers(1, 300)), 3)) * random.choice([1, 0.1])
        points[random.random(points.shape) < 0.2] *= -1.0  # zeros of either sign
        order = _native.curve_order(points)
        _, first = np.unique(points + 0.0, axis=0, return_index=True)
        assert np.array_equal(np.sort(order), np.sort(first))
        shuffle = random.permutation(len(points))
        assert np.array_equal(points[shuffle][_native.curve_order(points[shuffle])], points[order])
    assert len(_native.curve_order(np.zeros((0, 3)))) == 0


def test_neighbours_in_the_curve_order_are_near():
    points = np.random.default_rng(27).random((4096, 3))
    steps = np.linalg.norm(np.diff(points[_native.curve_order(points)], axis=0), axis=1)
    assert np.median(steps) < 2.0 / 16  # 16 points along each side


def test_cells_of_unknown_sites_are_refused():
    with pytest.raises(ValueError, match="unknown sites"):
        _native.orthocentres(np.eye(3), np.zeros(3), np.array([[0, 1, 2, 3]], dtype=np.int32))


# --- circumcentres -------------------------------------------------------------------------------


def exact_centre(points, weights):
    p = [[Fraction(float(x)) for x in row] for row in points]
    w = [Fraction(float(x)) for x in weights]
    arms = [[x - y for x, y in zip(row, p[0], strict=True)] for row in p[1:]]
    lifts = [sum(x * x for x in arm) - a + w[0] for arm, a in zip(arms, w[1:], strict=True)]
    determinant = 2 * fraction_determinant(arms)
    offset = []
    for k in range(3):
        replaced = [[*arm[:k], lift, *arm[k + 1 :]] for arm, lift in zip(arms, lifts, strict=True)]
        offset.append(fraction_determinant(replaced) / determinant)
    return offset, [x + y for x, y in zip(p[0], offset, strict=True)]


@pytest.mark.parametrize("make", inputs.INPUTS, ids=lambda make: make.__name__)
@pytest.mark.parametrize("weighted", [False, True], ids=["circumcentre", "orthocentre"])
def test_centres_are_accurate_even_in_flat_cells(make, weighted):
    points = make()
    scale = np.ptp(points, axis=0).max() if np.ptp(points / 2) < 1e150 else 0.0
    weights = np.random.default_rng(22).random(len(points)) * 0.01 * scale**2 * weighted
    result = regular_triangulation(points, weights)
    centres = circumcentres(result)
    assert centres.shape == (len(result.cells), 3)
    flattest = np.argsort(-np.abs(np.nan_to_num(centres)).max(axis=1))[:40]
    for cell in {*flattest.tolist(), *range(0, len(centres), max(1, len(centres) // 40))}:
        offset, centre = exact_centre(points[result.cells[cell]], weights[result.cells[cell]])
        if max(abs(x) for x in centre) > Fraction(1e308):
            continue
        reach = max(abs(x) for x in offset)
        for k in range(3):
            error = abs(Fraction(float(centres[cell, k])) - centre[k])
            rounding = abs(centre[k]) * Fraction(2) ** -52 + Fraction(5e-324)
            assert error <= reach * Fraction(1.001e-12) + rounding


# --- oracle --------------------------------------------------------------------------------------

ORACLE = """
import os, sys
import numpy as np
from CGAL.CGAL_Kernel import Point_3, Weighted_point_3
from CGAL.CGAL_Triangulation_3 import Delaunay_triangulation_3, Regular_triangulation_3
points, weights = np.load(sys.argv[1]), np.load(sys.argv[2])
positions = [Point_3(*map(float, p)) for p in points]
if weights.any():
    balls = [Weighted_point_3(p, float(w)) for p, w in zip(positions, weights)]
    triangulation = Regular_triangulation_3()
    triangulation.insert(balls)
else:
    triangulation = Delaunay_triangulation_3(positions)
site = {tuple(p): i for i, p in enumerate(points.tolist())}
def position(vertex):
    p = vertex.point()
    p = p.point() if weights.any() else p
    return p.x(), p.y(), p.z()
cells = [[site[position(c.vertex(k))] for k in range(4)] for c in triangulation.finite_cells()]
np.save(sys.argv[3], np.array(cells))
os._exit(0)  # the wrapper complains about every object that it frees
"""


@pytest.mark.parametrize("weighted", [False, True], ids=["delaunay", "regular"])
def test_cells_are_those_of_cgal_on_generic_input(weighted, tmp_path):
    if importlib.util.find_spec("CGAL") is None:
        pytest.skip("the oracle needs the cgal wheel")
    points = np.random.default_rng(23).random((3000, 3))
    weights = np.random.default_rng(24).random(3000) * 0.01 * weighted
    files = [tmp_path / f"{name}.npy" for name in ("points", "weights", "cells")]
    np.save(files[0], points)
    np.save(files[1], weights)
    subprocess.run([sys.executable, "-c", ORACLE, *map(str, files)], check=True)
    expected = {tuple(sorted(cell)) for cell in np.load(files[2]).tolist()}
    assert checks.cell_set(regular_triangulation(points, weights)) == expected
