"""What must be true of a regular triangulation, in Python's integers, apart from the kernel."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from meshlab_symrecon.geometry.triangulation import Triangulation

FACETS = np.array([[2, 1, 3], [0, 2, 3], [1, 0, 3], [0, 1, 2]])  # facet k, seen from inside


def as_integers(values, unit):
    """Exact multiples of 2**unit as an array of Python integers."""
    scale = Fraction(2) ** -unit
    numbers = [Fraction(float(value)) * scale for value in np.ravel(values)]
    assert all(number.denominator == 1 for number in numbers)
    result = np.empty(len(numbers), dtype=object)
    result[:] = [number.numerator for number in numbers]
    return result.reshape(np.shape(values))


def unit_of(values):
    """Exponent of the last bit used by any of the values."""
    values = np.ravel(values)
    return min(
        (1 - Fraction(float(v)).denominator.bit_length() for v in values if v),
        default=0,
    )


@dataclass(frozen=True, eq=False)
class ExactSites:
    positions: np.ndarray  # (n, 3) object
    heights: np.ndarray  # (n,) object  |p|^2 - w

    @classmethod
    def of(cls, points, weights):
        unit = min(unit_of(points), unit_of(weights) // 2)
        positions = as_integers(points, unit)
        heights = (positions**2).sum(axis=1) - as_integers(weights, 2 * unit)
        return cls(positions, heights)

    def orientations(self, cells):
        a, b, c, d = (self.positions[cells[:, k]] for k in range(4))
        return determinant3(b - a, c - a, d - a)

    def powers(self, cells, others):
        """Sign of the power of ``others`` to the balls of positively oriented cells."""
        p, h = self.positions, self.heights
        a, b, c, d = ((p[cells[:, k]] - p[others]) for k in range(4))
        # lifts relative to the other site: |p - q|^2 - (w_p - w_q) = h_p - h_q - 2 q . (p - q)
        lift = [
            h[cells[:, k]] - h[others] - 2 * (p[others] * row).sum(axis=1)
            for k, row in enumerate((a, b, c, d))
        ]
        return (
            -lift[0] * determinant3(b, c, d)
            + lift[1] * determinant3(a, c, d)
            - lift[2] * determinant3(a, b, d)
            + lift[3] * determinant3(a, b, c)
        )


def determinant3(a, b, c):
    return (
        a[..., 0] * (b[..., 1] * c[..., 2] - b[..., 2] * c[..., 1])
        - a[..., 1] * (b[..., 0] * c[..., 2] - b[..., 2] * c[..., 0])
        + a[..., 2] * (b[..., 0] * c[..., 1] - b[..., 1] * c[..., 0])
    )


def assert_valid(triangulation: Triangulation) -> None:
    """Check every invariant of a regular triangulation, with exact signs."""
    cells = triangulation.cells.astype(np.int64)
    neighbours = triangulation.neighbours.astype(np.int64)
    exact = ExactSites.of(triangulation.sites, triangulation.weights)
    assert len(cells) > 0
    assert (exact.orientations(cells) > 0).all(), "a cell is flat or inverted"
    assert_adjacency(cells, neighbours)
    assert_hull_is_convex(cells, neighbours, exact)
    assert_euler(cells, neighbours)
    assert_regular(cells, neighbours, exact)
    assert_sites_accounted_for(triangulation, exact)


def assert_adjacency(cells, neighbours):
    cell, place = np.nonzero(neighbours >= 0)
    other = neighbours[cell, place]
    back = neighbours[other] == cell[:, None]
    assert (back.sum(axis=1) == 1).all(), "neighbours are not mutual"
    other_place = back.argmax(axis=1)
    here = np.sort(cells[cell[:, None], FACETS[place]], axis=1)
    there = np.sort(cells[other[:, None], FACETS[other_place]], axis=1)
    assert np.array_equal(here, there), "neighbours do not share a facet"
    facets = np.sort(cells[:, FACETS].reshape(-1, 3), axis=1)
    unique, count = np.unique(facets, axis=0, return_counts=True)
    outer = (neighbours < 0).sum()
    assert count.max() <= 2
    assert (count == 1).sum() == outer
    assert 2 * len(unique) == len(facets) + outer


def outer_facets(cells, neighbours):
    cell, place = np.nonzero(neighbours < 0)
    return cells[cell[:, None], FACETS[place]]  # positively oriented with a point inside


def assert_hull_is_convex(cells, neighbours, exact):
    facets = outer_facets(cells, neighbours)
    edges = {}
    for a, b, c in facets.tolist():
        for edge, apex in (((a, b), c), ((b, c), a), ((c, a), b)):
            assert edge not in edges, "two hull facets use one edge in the same direction"
            edges[edge] = apex
    assert all((b, a) in edges for a, b in edges), "the hull is not closed"
    hinges = np.array([(a, b, apex, edges[b, a]) for (a, b), apex in edges.items()])
    assert (exact.orientations(hinges) >= 0).all(), "the hull is not convex"
    vertices = np.unique(facets)
    assert len(vertices) - len(edges) // 2 + len(facets) == 2


def assert_euler(cells, neighbours):
    pairs = np.array(list(itertools.combinations(range(4), 2)))
    edges = np.unique(np.sort(cells[:, pairs].reshape(-1, 2), axis=1), axis=0)
    facet_count = (4 * len(cells) + (neighbours < 0).sum()) // 2
    assert len(np.unique(cells)) - len(edges) + facet_count - len(cells) == 1


def assert_regular(cells, neighbours, exact):
    cell, place = np.nonzero(neighbours >= 0)
    other = neighbours[cell, place]
    once = cell < other
    cell, place, other = cell[once], place[once], other[once]
    other_place = (neighbours[other] == cell[:, None]).argmax(axis=1)
    opposite = cells[other, other_place]
    assert (exact.powers(cells[cell], opposite) >= 0).all(), "a facet is not locally regular"


def assert_sites_accounted_for(triangulation, exact):
    count = len(triangulation.sites)
    used = np.zeros(count, dtype=bool)
    used[triangulation.cells] = True
    duplicate = triangulation.representative != np.arange(count)
    hidden = triangulation.hidden
    assert (used.astype(int) + duplicate + hidden == 1).all(), "a site is lost or counted twice"
    stands_for = triangulation.representative[duplicate]
    assert np.array_equal(triangulation.sites[stands_for], triangulation.sites[duplicate])
    assert (triangulation.weights[stands_for] >= triangulation.weights[duplicate]).all()
    assert not duplicate[stands_for].any()
    assert np.array_equal(hidden, triangulation.hidden_cell >= 0)
    if hidden.any():
        site = np.flatnonzero(hidden)
        cell = triangulation.cells[triangulation.hidden_cell[hidden]].astype(np.int64)
        assert (exact.powers(cell, site) >= 0).all(), "a hidden site belongs into the triangulation"
        for k in range(4):
            replaced = cell.copy()
            replaced[:, k] = site
            assert (exact.orientations(replaced) >= 0).all(), "a hidden site is not in its cell"


def cell_set(triangulation: Triangulation, labels=None) -> set[tuple[int, ...]]:
    """Cells as sorted tuples of site labels (their indices by default)."""
    cells = triangulation.cells if labels is None else np.asarray(labels)[triangulation.cells]
    return set(map(tuple, np.sort(cells, axis=1).tolist()))


def perturbed_power_sign(exact: ExactSites, ranks, cell, other) -> int:
    """Sign of the power of a site to a cell's ball after w_i + epsilon^rank(i), by expansion."""
    cell = np.array([cell])
    power = exact.powers(cell, np.array([other]))[0]
    if power:
        return 1 if power > 0 else -1
    for site in sorted([*cell[0], other], key=lambda i: ranks[i]):
        heavier = ExactSites(exact.positions, exact.heights.copy())
        heavier.heights[site] -= 1  # the power is linear in each weight, and zero without it
        change = heavier.powers(cell, np.array([other]))[0]
        if change:
            return 1 if change > 0 else -1
    raise AssertionError("five sites in one plane")


def brute_force(points, weights) -> set[tuple[int, ...]]:
    """All four-subsets whose perturbed ball has positive power to every other site."""
    exact = ExactSites.of(points, weights)
    ranks = {
        i: rank for rank, i in enumerate(sorted(range(len(points)), key=lambda i: tuple(points[i])))
    }
    found = set()
    for subset in itertools.combinations(range(len(points)), 4):
        sign = exact.orientations(np.array([subset]))[0]
        if sign == 0:
            continue
        cell = subset if sign > 0 else (subset[1], subset[0], *subset[2:])
        others = set(range(len(points))) - set(subset)
        if all(perturbed_power_sign(exact, ranks, cell, other) > 0 for other in others):
            found.add(subset)
    return found
