import numpy as np
import pytest

from meshlab_symrecon.errors import GeometryError
from meshlab_symrecon.geometry.bounds import (
    box_diagonal,
    require_extent,
    require_solid,
    robust_diagonal,
)


def test_diagonal_of_a_box():
    corners = np.array([[0.0, 0.0, 0.0], [3.0, 4.0, 12.0]])
    assert box_diagonal(corners) == 13.0
    assert box_diagonal(np.zeros((0, 3))) == 0.0


def test_robust_diagonal_ignores_a_few_far_points():
    points = np.random.default_rng(0).random((4000, 3))
    far = np.vstack([points, np.full((5, 3), 1e6)])
    assert robust_diagonal(far) == pytest.approx(np.sqrt(3.0), rel=0.02)
    assert box_diagonal(far) > 1e6


FLAT = {
    "that all coincide": np.zeros((30, 3)),
    "on one line": np.outer(np.arange(30.0), [1.0, 2.0, 3.0]),
    "in one plane": np.random.default_rng(1).random((30, 2)) @ [[1.0, 0.0, 2.0], [0.0, 1.0, -1.0]],
}


@pytest.mark.parametrize("shape", FLAT)
@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e6])
@pytest.mark.parametrize("shift", [0.0, 1e3])
def test_flat_clouds_are_refused_at_any_scale_and_place(shape, scale, shift):
    with pytest.raises(GeometryError, match=f"the test needs .* 30 points {shape}"):
        require_solid(scale * (FLAT[shape] + shift), "the test")


@pytest.mark.parametrize("count", range(5))
def test_too_few_points_are_refused(count):
    with pytest.raises(GeometryError, match=f"got {count} points; load"):
        require_solid(np.random.default_rng(2).random((count, 3)), "the test")


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e6])
def test_a_thin_sheet_is_solid(scale):
    sheet = np.random.default_rng(3).random((100, 3)) * [1.0, 1.0, 1e-4]
    require_solid(scale * (sheet + 100.0), "the test")


@pytest.mark.parametrize("require", [require_extent, require_solid])
@pytest.mark.parametrize("scale", [1e-200, 1e-61, 1e61, 1e150, 1e308])
def test_extents_beyond_floats_are_refused(require, scale):
    points = (np.random.default_rng(0).random((30, 3)) * 2.0 - 1.0) * scale
    with (
        np.errstate(all="raise"),
        pytest.raises(GeometryError, match=r"the test needs points that .*; change the units"),
    ):
        require(points, "the test")


@pytest.mark.parametrize("extent", [0.0, 1e-60, 1.0, 1e60])
def test_an_extent_is_enough_without_thickness(extent):
    require_extent(np.outer([0.0, 1.0], [extent, 0.0, 0.0]), "the test")
