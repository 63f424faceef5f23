"""The page of a report: what it draws, what it says, and that it stays by itself."""

from __future__ import annotations

import base64
import json
import re
import sys
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

from meshlab_symrecon.errors import SymReconError
from meshlab_symrecon.pictures import report_scene, report_stills
from meshlab_symrecon.pictures.deviation_colours import (
    STOPS,
    UNKNOWN,
    UNSIGNED_STOPS,
    colour_limit,
)
from meshlab_symrecon.pictures.report import Listing, ReportWords, Section, Table, report_page
from meshlab_symrecon.pictures.report_drawing import (
    DIMMEST,
    even_subset,
    shading,
    simplified,
    upright_frame,
)
from meshlab_symrecon.pictures.report_scene import ReportScene, thinned
from meshlab_symrecon.pictures.report_stills import draw_stills
from meshlab_symrecon.pictures.report_traces import figure_text
from meshlab_symrecon.pictures.report_view import draw_view
from meshlab_symrecon.pictures.scene import INVENTED, MEASURED, PLANE

WORDS = ReportWords("a scan", ("Found.",), (), (), "Made here.")
EVIL = "</script><script>alert('1')</script><img src=http://a.b/c.png onerror=alert(2)>&amp;\"'"


def globe(rows=40, columns=60):
    """Return a closed surface of two triangles a square, an upright ellipsoid."""
    turn = np.linspace(0.0, 2.0 * np.pi, columns, endpoint=False)
    height = np.linspace(-np.pi / 2, np.pi / 2, rows + 2)[1:-1, None]
    ring = np.stack(
        [np.cos(height) * np.cos(turn), np.cos(height) * np.sin(turn),
         np.sin(height) + 0.0 * turn], axis=-1,
    ).reshape(-1, 3)  # fmt: skip
    points = np.concatenate([ring, [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]]]) * [1.0, 1.1, 2.0]
    low, high, first = rows * columns, rows * columns + 1, np.arange(columns)
    after = (first + 1) % columns
    top = first + (rows - 1) * columns
    faces = [
        np.stack([np.full(columns, low), after, first], axis=1),
        np.stack([np.full(columns, high), top, after + (rows - 1) * columns], axis=1),
    ]
    for row in range(rows - 1):
        a, b = row * columns + first, row * columns + after
        faces += [np.stack([a, b, b + columns], axis=1), np.stack([a, b + columns, a + columns], 1)]
    return points, np.concatenate(faces)


def scene_of(points, faces, planes=((1.0, 0.0, 0.0, 0.0),), **more):
    mirrored = (points[:, 0] > 0.2) & (points[:, 1] < -0.1)
    planes = np.reshape(planes, (-1, 4))
    if not len(planes):
        mirrored[:] = False
    normals = points - points.mean(axis=0)
    return ReportScene(
        points[~mirrored], planes, np.concatenate([points[~mirrored], points[mirrored]]),
        np.arange(len(points)) >= np.count_nonzero(~mirrored), points, faces,
        mirrored.astype(float), normals[~mirrored],
        np.concatenate([normals[~mirrored], normals[mirrored]]), **more,
    )  # fmt: skip


@pytest.fixture(scope="module")
def scene():
    return scene_of(*globe())


@pytest.fixture
def small(monkeypatch):
    """Stills of a tenth of the size."""
    monkeypatch.setattr(report_stills, "HEIGHT", 64)
    monkeypatch.setattr(report_stills, "WIDTHS", (36, 90))


def arrays(trace):
    return {
        name: np.frombuffer(base64.b64decode(value["bdata"]), dtype=np.dtype(value["dtype"]))
        for name, value in [*trace.items(), *trace.get("marker", {}).items()]
        if isinstance(value, dict) and "bdata" in value
    }


def drawn(scene):
    """Return each layer's first trace with its arrays, by the layer's name."""
    view = draw_view(scene)
    traces = json.loads(view.figure)["data"]
    found = {}
    for layer in view.layers:
        trace = traces[layer.traces[0]]
        found[layer.name] = trace | arrays(trace)
        for number in layer.traces:
            assert traces[number]["visible"] is layer.visible
    return found


# What is drawn.


def test_the_frame_is_a_motion_that_stands_upright():
    up, direction = np.array([1.0, 2.0, -0.5]), np.array([0.3, 0.1, 1.0])
    points = np.random.default_rng(0).normal(size=(50, 3))
    frame = upright_frame(points, up, direction)
    np.testing.assert_allclose(frame.axes @ frame.axes.T, np.eye(3), atol=1e-14)
    assert np.linalg.det(frame.axes) == pytest.approx(1.0)
    np.testing.assert_allclose(frame.turn(up), [0.0, 0.0, np.linalg.norm(up)], atol=1e-14)
    assert frame.turn(direction)[0] == pytest.approx(0.0, abs=1e-14)
    assert frame.turn(direction)[1] > 0.0
    assert np.linalg.norm(frame.turn(frame.place(points)), axis=1).max() <= 1.0 + 1e-6


def test_a_single_place_has_a_frame():
    frame = upright_frame(np.ones((3, 3)), np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0]))
    assert not frame.place(np.ones((3, 3))).any()


def test_far_offsets_are_taken_off_before_rounding(scene):
    """Coordinates of a survey: single precision would leave steps of half a metre."""
    shift = np.array([500_000.0, 5_600_000.0, 250.0])
    moved = replace(
        scene, scan=scene.scan + shift, completed=scene.completed + shift,
        surface=scene.surface + shift, planes=scene.planes - [0.0, 0.0, 0.0, shift[0]],
    )  # fmt: skip
    here, there = drawn(scene), drawn(moved)
    assert here.keys() == there.keys()
    for name, trace in here.items():
        for axis in "xyz":
            np.testing.assert_allclose(there[name][axis], trace[axis], atol=2e-6)


def test_an_even_subset_has_one_point_a_cell():
    rng = np.random.default_rng(1)
    dense = rng.normal(size=(6000, 3)) * 0.1
    points = np.concatenate([rng.uniform(-1.0, 1.0, size=(3000, 3)), dense])
    kept = even_subset(points, 500)
    assert 300 <= len(kept) <= 500
    assert (np.diff(kept) > 0).all()
    nearest = np.linalg.norm(points[:, None] - points[kept][None], axis=2).min(axis=1)
    assert nearest.max() < 0.6  # no part is left out, dense or not
    assert np.mean(kept >= 3000) < 0.2  # two thirds of the points, a thousandth of the room
    assert np.array_equal(even_subset(points, len(points)), np.arange(len(points)))
    assert len(even_subset(np.ones((50, 3)), 10)) == 1


def edges(faces):
    return [tuple(edge) for a, b, c in faces.tolist() for edge in ((a, b), (b, c), (c, a))]


@pytest.mark.parametrize("most", [600, 150, 30])
def test_a_simplified_surface_is_near_and_closed(most):
    points, faces = globe()
    fewer, simpler, values = simplified(points, faces, points[:, 2], most)
    assert len(fewer) <= most
    assert len(np.unique(simpler, axis=0)) == len(simpler)
    assert (np.diff(np.sort(simpler, axis=1), axis=1) > 0).all()
    both = edges(simpler)
    assert sorted(both) == sorted((b, a) for a, b in both)  # closed, as the surface was
    step = 4.0 / np.sqrt(most)
    np.testing.assert_allclose(np.linalg.norm(fewer / [1.0, 1.1, 2.0], axis=1), 1.0, atol=step)
    assert np.abs(values - fewer[:, 2]).max() < 2.0 * step  # values go with their places


def test_folds_are_left_out_and_a_small_surface_stays():
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    faces = np.array([[0, 1, 2], [0, 2, 1], [1, 3, 2]])
    same = simplified(points, faces, np.arange(4.0), 4)
    assert np.array_equal(same[0], points)
    assert np.array_equal(same[1], faces)
    doubled = np.repeat(points, 2, axis=0)
    merged = simplified(doubled, 2 * faces, np.arange(8.0), 4)
    (triangle,) = merged[1]
    assert sorted(merged[2][triangle].tolist()) == [2.5, 4.5, 6.5]


def test_light_falls_from_above_whichever_way_normals_point():
    points, _ = globe()
    frame = upright_frame(points, np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0]))
    light = shading(points, points, frame)
    assert np.array_equal(shading(-3.0 * points, points, frame), light)
    assert light.min() >= DIMMEST
    assert light[-1] > light[-2] + 50  # the top pole and the bottom one
    assert (shading(None, points, frame) == 255).all()
    assert len(shading(points[:0], points[:0], frame)) == 0


def test_every_layer_is_drawn_where_it_is(scene):
    layers = drawn(scene)
    assert list(layers) == ["surface", "planes", "scan", "invented"]
    view = draw_view(scene)
    for name, points in (
        ("surface", scene.surface),
        ("scan", scene.scan),
        ("invented", scene.completed[scene.mirrored]),
        ("planes", scene.sheets()[0].corners),
    ):
        placed = np.stack([layers[name][axis] for axis in "xyz"], axis=1)
        back = placed.astype(float) * view.frame.unit @ view.frame.axes + view.frame.origin
        np.testing.assert_allclose(back, points, atol=1e-5)
    faces = np.stack([layers["surface"][corner] for corner in "ijk"], axis=1)
    assert np.array_equal(faces, scene.faces)
    assert np.array_equal(layers["surface"]["intensity"], np.round(255 * scene.share))
    lowest, highest = ([f"rgb{colour}".replace(" ", "")] for colour in (MEASURED, INVENTED))
    assert [stop[1] for stop in layers["surface"]["colorscale"]] == lowest + highest
    assert layers["scan"]["marker"]["colorscale"][-1][1] == lowest[0]
    assert layers["invented"]["marker"]["colorscale"][-1][1] == highest[0]
    assert layers["planes"]["color"] == f"rgb{PLANE}".replace(" ", "")


def test_nothing_sticks_out_of_the_view(scene):
    view = draw_view(scene)
    figure = json.loads(view.figure)
    for axis in "xyz":
        low, high = figure["layout"]["scene"][f"{axis}axis"]["range"]
        for trace in figure["data"]:
            values = arrays(trace)[axis]
            assert low < values.min()
            assert values.max() < high
        ratio = figure["layout"]["scene"]["aspectratio"][axis]
        assert ratio == pytest.approx(high - low)  # equal scales


def test_the_other_side_is_seen_in_the_mirror(scene):
    view = draw_view(scene)
    start = json.loads(view.start)
    back, other = np.array(start["back"]), np.array(start["other"])
    normal = view.frame.turn(scene.planes[0, :3])
    assert back @ normal > 0.3  # from the side with missing parts, where x > 0
    np.testing.assert_allclose(other, back - 2 * (back @ normal) * normal, atol=1e-5)


def test_deviations_are_a_layer_of_their_own(scene):
    deviation = np.linspace(-2.0, 1.0, len(scene.scan))
    deviation[::3] = np.nan
    measured = replace(scene, deviation=deviation)
    layer, alone = drawn(measured)["deviation"], json.loads(draw_view(measured).figure)["data"][-1]
    assert len(arrays(alone)["x"]) == np.count_nonzero(np.isnan(deviation))
    assert alone["marker"]["colorscale"][-1][1] == f"rgb{UNKNOWN}".replace(" ", "")
    known = deviation[np.isfinite(deviation)]
    np.testing.assert_allclose(layer["color"], known, rtol=1e-6)
    limit = colour_limit(known, np.ones(len(known), dtype=bool))
    assert layer["marker"]["cmax"] == -layer["marker"]["cmin"] == limit
    assert layer["visible"] is False
    for (place, colour), stop in zip(STOPS, layer["marker"]["colorscale"], strict=True):
        assert 2.0 * stop[0] - 1.0 == pytest.approx(place)
        assert stop[1] == f"rgb{colour}".replace(" ", "")


@pytest.mark.parametrize("signed", [True, False])
def test_the_legend_tells_inside_from_outside_where_it_is_known(scene, small, signed):
    deviation = np.abs(np.linspace(-2.0, 2.0, len(scene.scan)))
    measured = replace(scene, deviation=deviation, signed=signed)
    page = report_page(measured, WORDS)
    text = " ".join(Reader(page).text)
    assert ("deviation from -2 (inside) to +2 (outside), in the file's unit" in text) is signed
    assert ("deviation from 0 to 2, inside or outside, in the file's unit" in text) is not signed
    (layer,) = [layer for layer in draw_view(measured).layers if layer.name == "deviation"]
    stops = STOPS if signed else UNSIGNED_STOPS
    assert layer.colours == tuple(colour for _, colour in stops)
    deepest_blue = "#{:02x}{:02x}{:02x}".format(*STOPS[0][1])
    assert page.count(deepest_blue) == (2 if signed else 0)  # the switch and the legend
    assert thinned(measured).signed is signed


def test_without_a_counterpart_there_is_no_layer(scene):
    assert "deviation" not in drawn(replace(scene, deviation=np.full(len(scene.scan), np.nan)))


def test_the_share_of_the_area(scene):
    points = np.array([[0.0, 0, 0], [2, 0, 0], [0, 2, 0], [0, 0, 1]])
    faces = np.array([[0, 1, 2], [0, 3, 1]])
    odd = replace(scene, surface=points, faces=faces, share=np.array([0.0, 0.0, 1.0, 0.0]))
    assert odd.invented_area() == pytest.approx((3.0, 2.0 / 9.0))
    assert replace(odd, faces=faces[:0]).invented_area() == (0.0, 0.0)


# The page.


class Reader(HTMLParser):
    """Collects what a browser would see."""

    def __init__(self, page):
        super().__init__()
        self.tags, self.text, self.open = [], [], []
        self.feed(page)

    def handle_starttag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))
        self.open.append(tag)

    def handle_endtag(self, tag):
        while self.open.pop() != tag:
            pass

    def handle_data(self, data):
        if self.open and self.open[-1] not in ("script", "style"):
            self.text.append(data)

    def all(self, tag):
        return [attributes for name, attributes in self.tags if name == tag]


def test_the_page_stands_by_itself(scene, small):
    seen = Reader(report_page(scene, WORDS))
    for tag, attributes in seen.tags:
        for name in ("src", "href", "srcset", "action", "data"):
            assert attributes.get(name, "data:").startswith("data:"), (tag, attributes)
    (policy,) = [item for item in seen.all("meta") if "http-equiv" in item]
    assert policy["content"].startswith("default-src 'none'; ")
    assert "http" not in policy["content"]
    style = report_page(scene, WORDS).split("<style>")[1].split("</style>")[0]
    assert "url(" not in style
    assert "@import" not in style


def test_the_page_can_be_read_by_everybody(scene, small):
    page = report_page(scene, replace(WORDS, warnings=("Careful.",)))
    seen = Reader(page)
    assert page.startswith("<!doctype html>")
    assert seen.all("html") == [{"lang": "en"}]
    assert len(seen.all("title")) == len(seen.all("h1")) == len(seen.all("main")) == 1
    assert len(seen.all("img")) == 3
    assert all(image["alt"] for image in seen.all("img"))
    identifiers = [item["id"] for _, item in seen.tags if "id" in item]
    assert len(set(identifiers)) == len(identifiers)
    assert next(item for item in seen.all("div") if item.get("id") == "view")["aria-label"]
    assert all(item["type"] == "button" for item in seen.all("button"))
    text = " ".join(seen.text)
    for words in ("a scan", "Found.", "Careful.", "Made here.", "mirror plane", "invented"):
        assert words in text


def test_strange_names_are_harmless(scene, small):
    table = Table((EVIL,), ((EVIL, EVIL),))
    evil = ReportWords(EVIL, (EVIL,), (EVIL,), (Section(EVIL, (EVIL, table, Listing(EVIL))),), EVIL)
    plain, strange = (Reader(report_page(scene, words)) for words in (WORDS, evil))
    for tag in ("script", "img", "title", "h1", "meta", "link"):
        assert len(strange.all(tag)) == len(plain.all(tag))
    assert not [item for _, item in strange.tags if "onerror" in item]
    assert strange.text.count(EVIL) >= 9


def test_no_bracket_of_the_figure_ends_its_script():
    text = figure_text([{"type": "scatter3d", "name": EVIL, "x": [0]}], {})
    assert "<" not in text
    assert json.loads(text)["data"][0]["name"] == EVIL


def test_equal_reconstructions_give_equal_pages(scene, small):
    assert report_page(scene, WORDS) == report_page(replace(scene), WORDS)


def test_every_layer_has_a_switch(scene, small):
    deviation = np.linspace(-1.0, 1.0, len(scene.scan))
    full = replace(scene, deviation=deviation)
    boxes = Reader(report_page(full, WORDS)).all("input")
    assert [box["id"] for box in boxes] == [
        f"show-{layer.name}" for layer in draw_view(full).layers
    ]
    numbers = [number for box in boxes for number in json.loads(box["data-traces"])]
    assert numbers == list(range(len(json.loads(draw_view(full).figure)["data"])))
    assert ["checked" in box for box in boxes] == [True, True, False, False, False]


def test_without_a_plane_the_page_shows_what_there_is(small):
    plain = scene_of(*globe(), planes=())
    assert list(drawn(plain)) == ["surface", "scan"]
    text = " ".join(Reader(report_page(plain, WORDS)).text)
    assert "No mirror plane was found, so no point was invented." in text
    assert "invented: mirror images" not in text


def test_several_planes_and_lying_ones_have_sheets():
    planes = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]])
    view = draw_view(scene_of(*globe(), planes=planes))
    (layer,) = [layer for layer in view.layers if layer.name == "planes"]
    assert layer.words == "Mirror planes"
    assert len(layer.traces) == 6


def test_large_clouds_are_thinned_and_the_page_says_so(scene, small, monkeypatch):
    monkeypatch.setattr(report_scene, "MOST_POINTS", 1000)
    monkeypatch.setattr(report_scene, "MOST_VERTICES", 700)
    light = thinned(replace(scene, deviation=scene.scan[:, 0]))
    assert len(light.scan) <= 1000
    assert np.count_nonzero(light.mirrored) <= 500
    assert len(light.faces) < 1500
    assert np.array_equal(light.completed[~light.mirrored], light.scan)
    for points, normals in (
        (light.scan, light.scan_normals),
        (light.completed, light.completed_normals),
    ):
        np.testing.assert_allclose(normals, points - scene.surface.mean(axis=0), atol=1e-12)
    assert np.array_equal(light.deviation, light.scan[:, 0])  # every value stays with its point
    invented = scene.completed[scene.mirrored].tolist()
    assert all(point in invented for point in light.completed[light.mirrored].tolist())
    note = " ".join(Reader(report_page(scene, WORDS)).text)
    for some, all_, what in (
        (len(light.scan), len(scene.scan), "measured points"),
        (np.count_nonzero(light.mirrored), np.count_nonzero(scene.mirrored), "invented points"),
        (len(light.faces), len(scene.faces), "triangles"),
    ):
        assert bool(some < all_) is (f"{some:,} of {all_:,} {what}" in note)
    assert f"{len(light.faces):,} of" in note


def test_a_page_has_a_largest_size():
    points, faces = globe(rows=300, columns=400)
    scene = scene_of(points, faces)
    light = thinned(replace(scene, deviation=scene.scan[:, 0]))
    assert len(draw_view(light).figure) < 8e6
    assert len(light.scan) <= 80_000
    assert len(light.faces) <= 170_000


def test_a_small_scene_is_drawn_whole(scene):
    same = thinned(scene)
    for name in ("scan", "completed", "mirrored", "surface", "faces", "share", "scan_normals"):
        assert np.array_equal(getattr(same, name), getattr(scene, name)), name
    bare = thinned(replace(scene, scan_normals=None, completed_normals=None))
    assert bare.scan_normals is bare.completed_normals is bare.deviation is None


def test_stills_show_three_things_from_one_place(scene, small):
    stills = draw_stills(scene)
    assert len({still.png for still in stills}) == 3
    assert len({still.size for still in stills}) == 1
    for still in stills:
        png = base64.b64decode(still.png)
        assert png.startswith(b"\x89PNG\r\n\x1a\n")
        assert np.frombuffer(png[16:24], dtype=">u4").tolist() == list(still.size)
    assert (
        "The best mirror plane"
        in draw_stills(replace(scene, planes=np.array([[1.0, 0, 0, 0], [0, 1.0, 0, 0]])))[1].caption
    )


@pytest.mark.parametrize("library", ["plotly", "matplotlib.image"])
def test_a_missing_library_is_named(scene, small, monkeypatch, library):
    monkeypatch.setitem(sys.modules, library, None)
    name = library.split(".")[0]
    with pytest.raises(SymReconError, match=f"a report needs {name}.*meshlab-symrecon.report"):
        report_page(scene, WORDS)


def test_colours_can_be_told_apart_without_red_or_green():
    """Luminance alone tells measured from invented, and words from paper."""
    weights = np.array([0.2126, 0.7152, 0.0722])

    def luminance(colour):
        return float(weights @ (np.array(colour) / 255.0) ** 2.2)

    def contrast(first, second):
        low, high = sorted((luminance(first), luminance(second)))
        return (high + 0.05) / (low + 0.05)

    assert contrast(MEASURED, INVENTED) > 2.4
    page_inks = re.findall(r"--(?:ink|faint): #(\w{6})", _style())
    for ink in page_inks:
        assert contrast([int(ink[n : n + 2], 16) for n in (0, 2, 4)], (250, 248, 245)) > 4.5
    assert len(page_inks) == 2


def _style():
    from importlib.resources import files

    folder = files("meshlab_symrecon.pictures")
    return folder.joinpath("report_page.css").read_text(encoding="utf-8")
