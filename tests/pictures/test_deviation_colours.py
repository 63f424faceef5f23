"""The colours of a map of deviation."""

from __future__ import annotations

import numpy as np
import pytest

from meshlab_symrecon.errors import GeometryError, ParameterError
from meshlab_symrecon.pictures.deviation_colours import (
    STOPS,
    UNKNOWN,
    colour_limit,
    deviation_colours,
)

KNOWN = np.ones(5, dtype=bool)


def test_the_stops_are_met_and_beyond_them_nothing_changes():
    places = np.array([place for place, _ in STOPS])
    known = np.ones(len(places), dtype=bool)
    colours = [colour for _, colour in STOPS]
    assert deviation_colours(3.0 * places, known, 3.0).tolist() == [list(c) for c in colours]
    far = deviation_colours([-1e9, 1e9], [True, True], 1e-3)
    assert far.tolist() == [list(colours[0]), list(colours[-1])]


def test_inside_is_blue_outside_is_red_and_both_darken_alike():
    values = np.linspace(-1.0, 1.0, 401)
    colours = deviation_colours(values, np.ones(401, dtype=bool), 1.0).astype(float)
    red, blue = colours[:, 0], colours[:, 2]
    assert (blue[values < -0.02] > red[values < -0.02]).all()
    assert (red[values > 0.02] > blue[values > 0.02]).all()
    light = colours @ [0.2126, 0.7152, 0.0722]
    assert (np.diff(light[:201]) >= -1.0).all()  # but for rounding to bytes
    assert (np.diff(light[200:]) <= 1.0).all()
    assert np.abs(light - light[::-1]).max() < 30.0


def test_what_has_no_counterpart_is_grey():
    colours = deviation_colours([0.0, 9.0], [False, True], 1.0)
    assert tuple(colours[0]) == UNKNOWN
    assert max(UNKNOWN) - min(UNKNOWN) < 8
    pale = np.array(dict(STOPS)[0.0])
    assert np.abs(pale - UNKNOWN).min() > 80  # cannot be taken for no deviation


@pytest.mark.parametrize(
    ("values", "limit"),
    [
        ([0.0, 0.0, 0.0, 0.0, 0.0], 1.0),
        ([-3.0, 3.0, 3.0, -3.0, 3.0], 3.0),
        ([3.1, 3.1, 3.1, -3.1, 3.1], 4.0),
        ([0.0, 0.0, 0.0, 0.0, 8.9e-5], 1e-4),
        ([9.0e20] * 5, 1e21),
        ([0.15] * 5, 0.15),
    ],
)
def test_the_limit_is_a_round_number_just_above_most_distances(values, limit):
    assert colour_limit(values, KNOWN) == limit


def test_a_few_large_distances_and_unknown_ones_do_not_stretch_the_limit():
    values = np.concatenate([np.linspace(-1.0, 1.0, 990), np.full(10, 50.0), np.full(500, 7.0)])
    known = np.arange(1500) < 1000
    assert colour_limit(values, known) == 1.0
    assert colour_limit(values, np.zeros(1500, dtype=bool)) == 1.0


def test_bad_input_gives_one_sentence():
    with pytest.raises(ParameterError, match="limit of the colours must be positive"):
        deviation_colours([1.0], [True], 0.0)
    with pytest.raises(GeometryError, match="must be finite"):
        deviation_colours([np.nan], [True], 1.0)
    for known in ([True, False], [1.0]):
        with pytest.raises(GeometryError, match="has_counterpart must be 1 booleans"):
            deviation_colours([1.0], known, 1.0)
