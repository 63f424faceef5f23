"""The measures of the benchmark of completion, on clouds whose answer is known."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

PATH = Path(__file__).resolve().parents[1] / "benchmarks" / "completion_measures.py"
SPEC = importlib.util.spec_from_file_location("completion_measures", PATH)
measures = importlib.util.module_from_spec(SPEC)
sys.modules[SPEC.name] = measures
SPEC.loader.exec_module(measures)

RAISED = np.array([0.0, 0.0, 3.0])
ACROSS_X = np.array([1.0, 0.0, 0.0, 0.0])


def lattice(columns, rows, step=1.0):
    """(columns * rows, 3) points of a square lattice, symmetric across x = 0."""
    x = (np.arange(columns) - (columns - 1) / 2) * step
    y = np.arange(rows) * step
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    return np.column_stack([grid, np.zeros(len(grid))])


def sphere(count, seed=0):
    directions = np.random.default_rng(seed).normal(size=(count, 3))
    return directions / np.linalg.norm(directions, axis=1, keepdims=True)


def sheet(count=20_000, seed=0):
    """Random points of the unit square."""
    points = np.random.default_rng(seed).random((count, 3))
    return points * [1.0, 1.0, 0.0]


class TestAgreement:
    def test_of_half_a_surface(self):
        surface = lattice(40, 40)
        half = surface[surface[:, 0] > 0]
        found = measures.agreement(half, surface, 0.5)
        assert (found.precision, found.recall) == (1.0, 0.5)
        assert found.f == pytest.approx(2 / 3)

    def test_points_off_the_surface_cost_precision_only(self):
        surface = lattice(10, 10)
        cloud = np.concatenate([surface, surface + RAISED])
        found = measures.agreement(cloud, surface, 1.0)
        assert (found.precision, found.recall) == (0.5, 1.0)

    def test_what_is_also_there_is_no_part_of_the_recall(self):
        surface, plinth = lattice(10, 10), lattice(10, 10) - [0, 0, 5.0]
        cloud = np.concatenate([surface, plinth])
        found = measures.agreement(cloud, surface, 0.5, also=plinth)
        assert (found.f, found.precision, found.recall) == (1.0, 1.0, 1.0)
        assert measures.agreement(surface, surface, 0.5, also=plinth).recall == 1.0

    def test_nothing_agrees_with_nothing_near(self):
        assert measures.agreement(lattice(4, 4), lattice(4, 4) + 9.0, 1.0).f == 0.0


def test_no_points_are_all_near_and_no_points_are_near_nothing():
    none = np.zeros((0, 3))
    assert measures.share_near(none, lattice(2, 2), 1.0) == 1.0
    assert measures.share_near(lattice(2, 2), none, 1.0) == 0.0


def test_farthest_is_one_sided_and_in_percent():
    points = np.array([[0.0, 0, 0], [0, 0, 3.0]])
    others = np.array([[0.0, 0, 0], [50.0, 0, 0]])
    assert measures.farthest(points, others, 200.0)[0] == pytest.approx(1.5)
    assert measures.farthest(others, points, 200.0)[0] == pytest.approx(25.0)


@pytest.mark.parametrize("shift", [0.05, 0.1])
def test_asymmetry_of_a_sphere_whose_plane_misses_the_centre(shift):
    """The image is moved by twice the shift s: half of it lies within the radial distance s."""
    surface = sphere(100_000)
    median, most = measures.asymmetry(surface, np.append(ACROSS_X[:3], shift), 1.0)
    cosines = np.linspace(-1, 1, 20_001)  # uniform over a sphere
    distances = 100 * np.abs(np.sqrt(1 + 4 * shift * cosines + 4 * shift**2) - 1)
    assert median == pytest.approx(np.median(distances), rel=0.05)
    assert most == pytest.approx(np.quantile(distances, 0.95), rel=0.05)


def test_asymmetry_of_a_symmetric_lattice_is_none():
    assert measures.asymmetry(lattice(20, 20), ACROSS_X, 1.0)[1] == pytest.approx(0.0, abs=1e-9)


def test_the_image_lands_on_the_removed_part_and_nowhere_else():
    clean = lattice(20, 20)
    removed = (clean[:, 0] > 2.0) & (clean[:, 1] > 5.0)
    images, source = measures.landing(clean, removed, ACROSS_X)
    np.testing.assert_allclose(np.unique(images, axis=0), np.unique(clean[removed], axis=0))
    np.testing.assert_allclose(images, clean[source] * [-1, 1, 1])


@pytest.mark.parametrize("angle", [5.0, 40.0])
def test_normal_angles_as_lines_and_as_directions(angle):
    surface = lattice(10, 10)
    up = np.tile([0.0, 0, 1], (100, 1))
    tilted = 7.0 * Rotation.from_euler("x", angle, degrees=True).apply(up)
    assert measures.normal_angles(surface, tilted, surface, up) == pytest.approx((angle, angle))
    turned = measures.normal_angles(surface, -tilted, surface, up)
    assert turned == pytest.approx((angle, 180.0 - angle))


def test_normal_angles_of_no_points():
    none = np.zeros((0, 3))
    assert np.isnan(measures.normal_angles(none, none, lattice(2, 2), lattice(2, 2))).all()


def test_spacing_of_a_lattice():
    assert measures.mean_spacing(lattice(30, 30, 0.25)) == pytest.approx(0.25)


def test_heights_over_a_sphere():
    surface = sphere(200_000)
    points = sphere(100, seed=1) * np.linspace(0.9, 1.1, 100)[:, np.newaxis]
    heights = measures.heights_over(points, surface, surface)
    np.testing.assert_allclose(heights, np.linspace(-0.1, 0.1, 100), atol=1e-4)
    near = measures.heights_over(points, surface, surface, within=0.05)
    assert np.isfinite(near[np.abs(heights) < 0.049]).all()
    assert np.isnan(near[np.abs(heights) > 0.051]).all()


class TestSeam:
    def test_is_three_spacings_wide_on_both_sides(self):
        cloud = lattice(40, 10)
        seam = measures.seam_of(cloud, cloud[:, 0] > 0, 1.0)
        assert set(np.abs(cloud[seam][:, 0])) == {0.5, 1.5}  # the next is 3 from the other side
        assert np.count_nonzero(seam) == 40

    @pytest.mark.parametrize("mirrored", [True, False])
    def test_of_one_kind_is_none(self, mirrored):
        cloud = lattice(10, 10)
        assert not measures.seam_of(cloud, np.full(100, mirrored), 1.0).any()

    def test_of_an_even_lattice_is_as_dense_as_its_surroundings(self):
        cloud = lattice(60, 60)
        seam = np.abs(cloud[:, 0]) < 2
        inner = (cloud[seam][:, 1] > 17) & (cloud[seam][:, 1] < 42)
        ratios = measures.seam_ratios(cloud, seam, 1.0)
        np.testing.assert_allclose(ratios[inner], 1.0, atol=1e-6)

    @pytest.mark.parametrize(("layers", "ratio"), [(2, 0.5**0.5), (4, 0.5)])
    def test_laid_several_times_is_denser(self, layers, ratio):
        """n layers over each other have a spacing smaller by the root of n."""
        cloud = lattice(60, 60, 0.9)
        belt = cloud[np.abs(cloud[:, 0]) < 3.5]  # all that the balls of the seam reach
        laid = np.concatenate([cloud] + [belt] * (layers - 1))
        seam = np.abs(laid[:, 0]) < 0.5
        inner = (laid[seam][:, 1] > 17) & (laid[seam][:, 1] < 36)
        ratios = measures.seam_ratios(laid, seam, 1.0)[inner]
        np.testing.assert_allclose(ratios, ratio, rtol=1e-6)

    def test_with_a_gap_is_thinner(self):
        cloud = sheet()
        spacing = measures.mean_spacing(cloud)
        gaping = cloud[np.abs(cloud[:, 0] - 0.5) > spacing]
        seam = measures.seam_of(gaping, gaping[:, 0] > 0.5, spacing)
        assert np.median(measures.seam_ratios(gaping, seam, spacing)) > 1.1

    def test_without_surroundings_is_unknown(self):
        cloud = lattice(4, 4)
        assert np.isnan(measures.seam_ratios(cloud, np.ones(16, dtype=bool), 1.0)).all()


class TestSeamQuality:
    def quality(self, cloud, heights, turn=None, scale=1.0):
        sampled = sheet()
        turn = np.eye(3) if turn is None else turn
        return measures.seam_quality(
            scale * cloud @ turn.T,
            sampled[:, 0] > 0.5,
            scale * sampled @ turn.T,
            scale * heights,
            np.zeros(len(sampled)),
            scale * 2.0,
        )

    def test_of_the_complete_cloud_itself(self):
        found = self.quality(sheet(), np.zeros(20_000))
        assert found.spacing == 1.0
        assert found.off == found.own_off
        assert (found.step, found.own_step) == (0.0, 0.0)
        assert np.isnan(found.roughness)  # 0 / 0

    def test_a_raised_side_is_a_step(self):
        cloud = sheet()
        heights = np.where(cloud[:, 0] > 0.5, 0.01, 0.0)
        found = self.quality(cloud + heights[:, np.newaxis] * [0, 0, 1], heights)
        assert found.step == pytest.approx(0.5)  # % of a diagonal of 2
        assert found.roughness == pytest.approx(1.0)

    def test_heights_at_the_seam_only_are_rough(self):
        cloud = sheet()
        mirrored = cloud[:, 0] > 0.5
        heights = np.where(mirrored, 0.001 + 0.003 * (cloud[:, 0] < 0.55), 0.0)
        found = self.quality(cloud, heights)
        assert found.roughness == pytest.approx(4.0, rel=0.05)

    def test_does_not_change_with_motion_and_scale(self):
        cloud = sheet()
        heights = np.random.default_rng(1).normal(0.0, 1e-3, len(cloud))
        turn = Rotation.from_rotvec([0.3, -0.5, 0.8]).as_matrix()
        still = self.quality(cloud, heights)
        moved = self.quality(cloud, heights, turn, 1e3)
        for name in ("spacing", "off", "own_off", "step", "roughness"):
            assert getattr(moved, name) == pytest.approx(getattr(still, name), rel=1e-6)

    def test_without_mirrored_points_is_unknown(self):
        cloud = sheet(500)
        none = np.zeros(500, dtype=bool)
        zeros = np.zeros(500)
        found = measures.seam_quality(cloud, none, cloud, zeros, zeros, 1.0)
        assert np.isnan(found.spacing)
        assert np.isnan(found.step)
