"""The border of the package: what arrays must be, and what is handed on."""

from __future__ import annotations

import numpy as np
import pytest

from meshlab_symrecon.arrays import as_faces, as_normals, as_planes, as_points, as_scalars
from meshlab_symrecon.errors import GeometryError

TRIANGLE = [[0, 1, 2]]


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: as_points("abc"), "points must be numbers in an array of shape (n, 3); got 'abc'"),
        (lambda: as_points([[1, 2, 3], [1, 2]]), "points must be numbers in an array"),
        (lambda: as_points([1.0, 2.0, 3.0]), "must have shape (n, 3); got (3,)"),
        (lambda: as_points([[1.0, 2.0]]), "must have shape (n, 3); got (1, 2)"),
        (
            lambda: as_points([[0, 0, 0], [0, np.nan, 0], [np.inf, 0, 0]]),
            "got 2 rows with NaN or infinity, the first at index 1",
        ),
        (lambda: as_points(np.eye(3), minimum=4), "at least 4 points are needed; got 3"),
        (lambda: as_normals(np.eye(3), 4), "4 normals are needed, one a point; got 3"),
        (
            lambda: as_scalars("ab", 2, "weights"),
            "weights must be numbers in an array of shape (2,)",
        ),
        (lambda: as_scalars([1.0], 2, "weights"), "shape (2,), one a point; got (1,)"),
        (lambda: as_scalars([1, np.inf], 2, "weights"), "got 1 values with NaN or infinity"),
        (lambda: as_planes([[0, 0, 1, 2], [0, 0, 0, 1]]), "a normal (A, B, C) that is not zero"),
        (lambda: as_planes([[0, 0, 1]]), "planes must have shape (n, 4); got (1, 3)"),
        (lambda: as_faces([[0, 1, 1.5]], 3), "whole vertex indices; got fractions"),
        (lambda: as_faces(TRIANGLE, 2), "must lie in 0 .. 1; got 0 .. 2"),
        (lambda: as_faces([[0, 1, -1]], 3), "must lie in 0 .. 2; got -1 .. 1"),
    ],
)
def test_bad_arrays_are_refused_in_one_sentence(call, words):
    with pytest.raises(GeometryError) as caught:
        call()
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("convert", "given"),
    [
        (as_points, np.arange(12.0).reshape(4, 3)),
        (as_planes, np.array([[0.0, 0.0, 1.0, 2.0]])),
        (lambda values: as_normals(values, 3), np.eye(3)),
        (lambda values: as_scalars(values, 3, "weights"), np.arange(3.0)),
        (lambda values: as_faces(values, 3), np.array(TRIANGLE)),
    ],
)
def test_what_is_handed_on_is_an_equal_copy_that_nobody_can_change(convert, given):
    converted = convert(given)
    assert np.array_equal(converted, given)
    assert not np.shares_memory(converted, given)
    assert given.flags.writeable
    assert not converted.flags.writeable


def test_types_and_shapes():
    assert as_points([]).shape == (0, 3)
    assert as_planes([]).shape == (0, 4)
    assert as_faces([], 0).shape == (0, 3)
    assert as_points([[1, 2, 3]]).dtype == np.float64
    assert as_faces(np.array(TRIANGLE, dtype=np.int32), 3).dtype == np.int64


def test_planes_are_scaled_to_unit_normals_and_stay_the_same_planes():
    given = np.array([[0.0, 3.0, 4.0, 10.0], [-2.0, 0.0, 0.0, 1.0]])
    np.testing.assert_allclose(as_planes(given), [[0.0, 0.6, 0.8, 2.0], [-1.0, 0.0, 0.0, 0.5]])


def test_read_only_numbers_are_handed_on_as_they_are_but_not_views_of_what_may_change():
    sealed = np.arange(12.0).reshape(4, 3).copy()
    sealed.setflags(write=False)
    assert as_points(sealed) is sealed
    below = np.arange(12.0).reshape(4, 3).copy()
    view = below[:2]
    view.setflags(write=False)
    converted = as_points(view)
    below[:] = 7.0
    assert np.array_equal(converted, [[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]])
