"""Triangulations against CGAL's on hundreds of small inputs (about 4 seconds).

Ties may be broken differently, but the balls of the cells are unique: both triangulations divide
the same polyhedra, one for each empty ball. So the sets of balls must be equal, and wherever no two
of our cells share a ball and no hidden site touches one, the sets of cells as well.
"""

from __future__ import annotations

import importlib.util
import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from meshlab_symrecon.geometry.triangulation import (
    circumcentres,
    delaunay,
    regular_triangulation,
)

SEEDS = 5
ORACLE = """
import os, sys
import numpy as np
from CGAL.CGAL_Kernel import Point_3, Weighted_point_3
from CGAL.CGAL_Triangulation_3 import Delaunay_triangulation_3, Regular_triangulation_3

def position(vertex, weighted):
    p = vertex.point()
    p = p.point() if weighted else p
    return p.x(), p.y(), p.z()

keep, cases, found = [], np.load(sys.argv[1]), {}
for name in sorted({key.rsplit(":", 1)[0] for key in cases}):
    points, weights = cases[name + ":points"], cases[name + ":weights"]
    positions = [Point_3(*p) for p in points.tolist()]
    weighted = not name.startswith("delaunay")
    if weighted:
        balls = [Weighted_point_3(p, w) for p, w in zip(positions, weights.tolist())]
        triangulation = Regular_triangulation_3()
        triangulation.insert(balls)
    else:
        triangulation = Delaunay_triangulation_3(positions)
    site = {tuple(p): i for i, p in enumerate(points.tolist())}
    cells = [
        [site[position(c.vertex(k), weighted)] for k in range(4)]
        for c in triangulation.finite_cells()
    ]
    found[name] = np.array(cells)
    keep.append(triangulation)
np.savez(sys.argv[2], **found)
os._exit(0)  # the wrapper complains about every object that it frees
"""


def neighbour_module(name: str):
    """Import a support module of this folder under any import mode."""
    if name in sys.modules:
        return sys.modules[name]
    spec = importlib.util.spec_from_file_location(name, Path(__file__).with_name(f"{name}.py"))
    loaded = importlib.util.module_from_spec(spec)
    sys.modules[name] = loaded
    spec.loader.exec_module(loaded)
    return loaded


checks = neighbour_module("triangulation_checks")


# --- families of sites: functions of a generator and of the number of sites ----------------------


def ball(rng, count):
    return rng.normal(size=(count, 3))


def bumpy_surface(rng, count):
    u, v = rng.random((2, count)) * 2 * np.pi
    tube = 0.35 + 0.05 * np.sin(rng.integers(2, 6) * u) * np.cos(4 * v)
    ring = 1 + tube * np.cos(v)
    return np.column_stack([ring * np.cos(u), ring * np.sin(u), tube * np.sin(v)])


def sphere(rng, count):
    points = rng.normal(size=(count, 3))
    return points / np.linalg.norm(points, axis=1, keepdims=True)


def clusters(rng, count):
    return rng.random((count, 3)) + 1e6 * rng.integers(0, 2, (count, 1))


def near_duplicates(rng, count):
    points = rng.random((count // 2, 3)) + 1.0
    return np.vstack([points, points + np.spacing(points) * rng.integers(-1, 2, points.shape)])


def lattice(rng, count):
    axes = [np.arange(n) for n in rng.integers(2, 2 + round(count ** (1 / 3)), 3)]
    return np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 3) * 0.1


def lattice_samples(rng, count):
    return rng.integers(0, 4, (min(count, 100), 3)).astype(float)  # with duplicates


def latitude_longitude(rng, count):
    rings = int(rng.integers(3, 9))
    latitude, longitude = np.meshgrid(
        np.linspace(-np.pi / 2, np.pi / 2, rings),
        2 * np.pi * np.arange(min(count // rings, 24)) / 24,
    )
    flat = np.cos(latitude)
    return np.stack(
        [flat * np.cos(longitude), flat * np.sin(longitude), np.sin(latitude)], axis=-1
    ).reshape(-1, 3)


def torus_grid(rng, count):
    across = int(rng.integers(4, 9))
    u = 2 * np.pi * np.arange(min(count // across, 16)) / 16
    u, v = (a.ravel() for a in np.meshgrid(u, 2 * np.pi * np.arange(across) / across))
    ring = 2 + 0.5 * np.cos(v)
    return np.column_stack([ring * np.cos(u), ring * np.sin(u), 0.5 * np.sin(v)])


def cylinder(rng, count):
    around = int(rng.integers(3, 13))
    turn, height = np.meshgrid(
        2 * np.pi * np.arange(around) / around, 0.25 * np.arange(2 + min(count // around, 10))
    )
    return np.column_stack([np.cos(turn).ravel(), np.sin(turn).ravel(), height.ravel()])


def coplanar_plus_one(rng, count):
    plane = rng.integers(0, 6, (min(count, 60), 2)).astype(float)
    return np.vstack([np.column_stack([plane, plane.sum(axis=1)]), [[0.5, 0.25, 7.0]]])


GENERIC = [ball, bumpy_surface, sphere, clusters, near_duplicates]
DEGENERATE = [
    lattice,
    lattice_samples,
    latitude_longitude,
    torus_grid,
    cylinder,
    coplanar_plus_one,
]


def moves(points):
    """Yield the points themselves, far off, tiny and huge."""
    yield points
    yield points + 1e6
    yield points * 1e-6
    yield points * 1e6


def poles(points):
    """Return all circumcentres inside twice the extent, with their squared radii."""
    triangulation = delaunay(points)
    centres = circumcentres(triangulation)
    near = np.abs(centres - points.mean(axis=0)).max(axis=1) < 2 * np.ptp(points, axis=0).max()
    reach = centres[near] - triangulation.sites[triangulation.cells[near, 0]]
    return centres[near], (reach**2).sum(axis=1)


def balls_of(rng, points):
    """Yield names and weights: none, equal, moderate and so heavy that most sites are hidden."""
    spacing = np.ptp(points, axis=0).max() ** 2 / len(points)
    yield "delaunay", np.zeros(len(points))
    yield "equal", np.full(len(points), spacing)
    yield "moderate", rng.integers(0, 5, len(points)) * 0.125 * spacing
    yield "heavy", rng.random(len(points)) ** 8 * 64 * spacing


def all_cases():
    cases = {}
    for make in GENERIC + DEGENERATE:
        for seed in range(SEEDS):
            rng = np.random.default_rng(seed)
            count = int(rng.integers(10, 400 if make in GENERIC and seed == 0 else 120))
            points = list(moves(make(rng, count)))[max(0, seed - 1)]
            for kind, weights in balls_of(rng, points):
                cases[f"{kind}:{make.__name__}:{seed}"] = points, weights
    for make in (bumpy_surface, sphere, lattice):
        for seed in range(3):
            points = make(np.random.default_rng(seed), 40)
            if np.ptp(points, axis=0).min() > 0:
                cases[f"poles:{make.__name__}:{seed}"] = poles(points)
    return cases


def spheres(points, weights, cells):
    """Return the balls orthogonal to cells, each as exact reduced fractions (centre and height)."""
    exact = checks.ExactSites.of(points, weights)
    p, h = exact.positions, exact.heights
    a = p[cells[:, 0]]
    arms = [p[cells[:, k]] - a for k in (1, 2, 3)]
    lift = [h[cells[:, k]] - h[cells[:, 0]] for k in (1, 2, 3)]  # 2 centre . arm = lift
    bottom = 2 * checks.determinant3(*arms)
    parts = []
    for k in range(3):
        replaced = [arm.copy() for arm in arms]
        for row, value in zip(replaced, lift, strict=True):
            row[:, k] = value
        parts.append(checks.determinant3(*replaced))
    height = h[cells[:, 0]] * bottom - 2 * sum(a[:, k] * parts[k] for k in range(3))
    found = []
    for row in zip(*parts, height, bottom, strict=True):
        divisor = math.gcd(*row) * (1 if row[-1] > 0 else -1)
        found.append(tuple(value // divisor for value in row))
    return found


@pytest.fixture(scope="module")
def oracle(tmp_path_factory):
    pytest.importorskip("CGAL", reason="the oracle needs the cgal wheel")
    folder = tmp_path_factory.mktemp("oracle")
    cases = all_cases()
    arrays = {}
    for name, (points, weights) in cases.items():
        arrays[f"{name}:points"], arrays[f"{name}:weights"] = points, weights
    np.savez(folder / "cases.npz", **arrays)
    command = [sys.executable, "-c", ORACLE, folder / "cases.npz", folder / "cells.npz"]
    subprocess.run(command, check=True)
    with np.load(folder / "cells.npz") as cells:
        return {name: (*case, cells[name]) for name, case in cases.items()}


def compare(name, points, weights, theirs):
    """Return True when the cells are the same, False when only ties part them; else fail."""
    kind = name.split(":")[0]
    ours = delaunay(points) if kind == "delaunay" else regular_triangulation(points, weights)
    theirs = ours.representative[theirs]  # of a position that occurs several times they name any
    if checks.cell_set(ours) == set(map(tuple, np.sort(theirs, axis=1).tolist())):
        return True
    checks.assert_valid(ours)
    our_balls = spheres(points, ours.weights, ours.cells.astype(np.int64))
    their_balls = spheres(points, ours.weights, theirs.astype(np.int64))
    assert set(our_balls) == set(their_balls), f"{name}: other balls"
    hidden = np.flatnonzero(ours.hidden)
    exact = checks.ExactSites.of(points, ours.weights)
    covered = exact.powers(ours.cells[ours.hidden_cell[hidden]].astype(np.int64), hidden)
    ties = len(our_balls) - len(set(our_balls)) + int((covered == 0).sum())
    assert ties > 0, f"{name}: other cells without a tie"
    return False


@pytest.mark.parametrize("kind", ["delaunay", "equal", "moderate", "heavy", "poles"])
def test_balls_are_those_of_cgal(oracle, kind):
    names = [name for name in oracle if name.startswith(f"{kind}:")]
    assert len(names) >= (5 if kind == "poles" else 11 * SEEDS)
    same = {name: compare(name, *oracle[name]) for name in names}
    generic = {f.__name__ for f in (ball, bumpy_surface, clusters)}
    assert all(same[name] for name in names if kind != "poles" and name.split(":")[1] in generic)
    if kind in {"delaunay", "equal"}:
        assert not all(same.values())  # some of the others are full of ties


def test_the_invariant_tells_balls_apart():
    points = np.random.default_rng(1).random((30, 3))
    cells = delaunay(points).cells.astype(np.int64)
    balls = spheres(points, np.zeros(30), cells)
    assert len(set(balls)) == len(cells)
    unit = 2 ** -min(0, checks.unit_of(points))  # the integers count these
    centres = np.array([[x / (row[4] * unit) for x in row[:3]] for row in balls])
    assert np.allclose(centres, circumcentres(delaunay(points)), rtol=1e-9)
