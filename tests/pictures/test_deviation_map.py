"""The picture of a map of deviation: what is drawn where."""

from __future__ import annotations

import sys

import numpy as np
import pytest
import shapes

from meshlab_symrecon.errors import GeometryError, ParameterError, SymReconError
from meshlab_symrecon.pictures import deviation_map
from meshlab_symrecon.pictures.deviation_colours import STOPS, UNKNOWN
from meshlab_symrecon.pictures.deviation_map import colour_bar, deviation_picture
from meshlab_symrecon.pictures.viewpoint import views_of_both_sides

pytest.importorskip("matplotlib")

X = np.array([1.0, 0.0, 0.0, 0.0])
POINTS, FACES = shapes.torus_mesh(30, 16)
DISTANCES = 0.02 * POINTS[:, 0]
KNOWN = POINTS[:, 1] < 0.5
NO_FACES = np.zeros((0, 3), dtype=np.int64)


def read(path):
    from matplotlib.image import imread

    return np.rint(255.0 * imread(path)[..., :3]).astype(int)


@pytest.mark.parametrize("faces", [FACES, NO_FACES], ids=["mesh", "cloud"])
def test_both_signs_and_the_unknown_are_seen_and_the_bytes_repeat(tmp_path, faces, monkeypatch):
    monkeypatch.setattr(deviation_map, "HEIGHT", 240)
    monkeypatch.setattr(deviation_map, "WIDTHS", (140, 260))
    for name in ("a.png", "b.png"):
        deviation_picture(POINTS, faces, DISTANCES, KNOWN, X, tmp_path / name, unit="mm")
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()
    picture = read(tmp_path / "a.png")
    views = picture[:, : picture.shape[1] - 280]  # the rest is the bar
    red, green, blue = views.reshape(-1, 3).T
    assert np.mean(red > blue + 60) > 0.03
    assert np.mean(blue > red + 60) > 0.03
    grey = (np.abs(red - blue) < 8) & (np.abs(red - green) < 8) & (red < 140) & (red > 60)
    assert grey.mean() > 0.01


def test_the_bar_shows_every_colour_from_out_to_under():
    bar = colour_bar(6.0, "mm")
    column = bar[:, 40].astype(int)
    for place, colour in STOPS:
        row = round(140 + (700 - 140) * (1.0 - place) / 2.0)
        assert np.abs(column[min(row, 699)] - colour).max() <= 4
    assert (column == UNKNOWN).all(axis=1).sum() >= 20
    assert (bar[:, 100:].min(axis=2) < 100).any()  # what is written beside it
    assert colour_bar(6.0, "mm").tobytes() == bar.tobytes()
    assert colour_bar(3.0, "mm").tobytes() != bar.tobytes()
    assert colour_bar(6.0, "mm", height=500).shape == (500, 250, 3)


def test_the_two_views_are_mirror_images_of_each_other():
    points = shapes.statue(2000, seed=1)
    left, right = views_of_both_sides(points, X[None])
    assert np.allclose(np.array(left.direction) * [-1, 1, 1], right.direction)
    assert np.allclose(left.up, right.up)
    assert left.direction[0] != 0.0


def test_bad_input_gives_one_sentence(tmp_path):
    path = tmp_path / "a.png"
    with pytest.raises(ParameterError, match="captions must be two"):
        deviation_picture(POINTS, FACES, DISTANCES, KNOWN, X, path, captions=("one",))
    with pytest.raises(ParameterError, match="limit of the colours must be positive"):
        deviation_picture(POINTS, FACES, DISTANCES, KNOWN, X, path, limit=-1.0)
    with pytest.raises(GeometryError, match="at least 1 points"):
        deviation_picture(POINTS[:0], NO_FACES, DISTANCES[:0], KNOWN[:0], X, path)
    with pytest.raises(ParameterError, match="colours must be one or"):
        deviation_picture(POINTS, FACES, DISTANCES[:5], KNOWN[:5], X, path)
    assert list(tmp_path.iterdir()) == []


def test_a_missing_matplotlib_is_one_clear_sentence(monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(SymReconError, match="needs matplotlib"):
        colour_bar(1.0)
