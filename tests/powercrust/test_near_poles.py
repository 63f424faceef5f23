"""Poles that crowd at one place, joined."""

from __future__ import annotations

import numpy as np
import pytest

from meshlab_symrecon import _native


@pytest.mark.parametrize("seed", range(5))
def test_each_point_goes_to_the_nearest_one_kept_within_its_reach(seed):
    rng = np.random.default_rng(seed)
    points, reach = rng.random((300, 3)), rng.random(300) * 0.15
    order = rng.permutation(300).astype(np.int32)
    kept = []
    for point in order:
        gaps = np.linalg.norm(points[kept] - points[point], axis=1)
        if not (gaps < reach[point]).any():
            kept.append(int(point))
    keeper = _native.nearest_kept(points, reach, order, 0.15)
    assert np.array_equal(np.flatnonzero(keeper == np.arange(300)), np.sort(kept))
    gaps = np.linalg.norm(points - points[keeper], axis=1)
    assert (gaps <= reach).all()
    assert 0 < len(kept) < 300


@pytest.mark.parametrize("widest", [0.0, -1.0, np.nan])
def test_blocks_without_width_are_refused(widest):
    points = np.random.default_rng(0).random((5, 3))
    with pytest.raises(ValueError, match="positive width"):
        _native.nearest_kept(points, np.ones(5), np.arange(5, dtype=np.int32), widest)
