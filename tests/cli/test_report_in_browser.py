"""The page of a real scan in a real browser."""

from __future__ import annotations

import io
import sys
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from meshlab_symrecon.cli.main import main
from meshlab_symrecon.pictures import report_scene, report_stills

ROOT = Path(__file__).parents[2]
SCAN = ROOT / "examples/data/nefertiti_incomplete.ply"

sys.path.insert(0, str(ROOT / "docs"))
try:
    import browser
finally:
    sys.path.remove(str(ROOT / "docs"))

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(bool(browser.missing()), reason=f"missing here: {browser.missing()}"),
]


SIZE = (640, 600)
FRAMES = """
let left = 5;
const done = arguments[0], step = () => left-- ? requestAnimationFrame(step) : done();
step();
"""
VERDIGRIS, LIMESTONE = (58, 134, 148), (222, 203, 174)


@pytest.fixture(scope="module")
def working(tmp_path_factory):
    """Skip where a browser is installed that does not start, or cannot draw."""
    from selenium.common.exceptions import WebDriverException

    blank = tmp_path_factory.mktemp("blank") / "blank.html"
    blank.write_text("<div id=view data-state=ready></div>")
    try:
        with browser.opened(blank, SIZE) as opened:
            asked = "return Boolean(document.createElement('canvas').getContext('webgl'))"
            if not opened.execute_script(asked):
                pytest.skip("the browser here has no WebGL")
    except WebDriverException as error:
        pytest.skip(f"the browser here does not start: {error.msg}")


@pytest.fixture(scope="module")
def page(working, tmp_path_factory):
    folder = tmp_path_factory.mktemp("page größe")
    words = ["reconstruct", SCAN, "-o", folder / "a.ply", "--report", folder / "a page.html"]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(report_scene, "MOST_POINTS", 10_000)  # drawn in software, again and again
        patch.setattr(report_scene, "MOST_VERTICES", 10_000)
        patch.setattr(report_stills, "HEIGHT", 200)
        patch.setattr(report_stills, "WIDTHS", (100, 300))
        ended = CliRunner().invoke(main, [str(word) for word in words])
    assert ended.exit_code == 0, ended.stderr
    return folder / "a page.html"


@pytest.fixture(scope="module")
def shown(page):
    with browser.opened(page, SIZE) as opened:
        yield opened


def pixels(opened, what="#view"):
    """Return the pixels of an element when two pictures of it, frames apart, are the same."""
    from matplotlib.image import imread
    from selenium.webdriver.common.by import By

    element = opened.find_element(By.CSS_SELECTOR, what)
    before = None
    for _ in range(100):
        opened.execute_async_script(FRAMES)
        seen = imread(io.BytesIO(element.screenshot_as_png))[..., :3]
        if before is not None and np.array_equal(seen, before):
            return seen
        before = seen
    raise AssertionError("the view does not come to rest")


def click(opened, what):
    opened.execute_script("document.querySelector(arguments[0]).click()", what)


def near(image, colour, within=0.12):
    """Return the share of the pixels that have nearly this hue, in any light."""
    lit = image / np.maximum(image.max(axis=2, keepdims=True), 1e-6)
    wanted = np.array(colour) / max(colour)
    return float(np.mean(np.abs(lit - wanted).max(axis=2) < within))


def test_it_loads_without_an_error_and_without_a_network(shown, page):
    assert browser.state(shown) == "ready"
    errors = [entry for entry in shown.get_log("browser") if entry["level"] == "SEVERE"]
    assert errors == []
    asked = browser.requests(shown, page)
    assert page.resolve().as_uri() in asked
    assert all(address.startswith(("file:", "data:", "blob:")) for address in asked)
    assert shown.title.startswith(SCAN.name)


def test_the_view_shows_the_surface(shown):
    image = pixels(shown)
    assert len(np.unique(image.reshape(-1, 3), axis=0)) > 1000
    assert near(image, VERDIGRIS) > 0.03  # it is seen from the side that was invented
    assert near(image, LIMESTONE, within=0.06) > 0.02


def test_layers_come_and_go(shown):
    start = pixels(shown)
    click(shown, "#show-surface")
    click(shown, "#show-planes")
    empty = pixels(shown)
    assert len(np.unique(empty[5:-5, 5:-5].reshape(-1, 3), axis=0)) == 1
    click(shown, "#show-scan")
    scan = pixels(shown)
    assert near(scan, VERDIGRIS) < 0.001
    assert np.mean(np.any(scan != empty, axis=2)) > 0.05
    click(shown, "#show-invented")
    completed = pixels(shown)
    assert near(completed, VERDIGRIS) > 0.03
    for layer in ("scan", "invented", "surface", "planes"):
        click(shown, f"#show-{layer}")
    assert np.mean(np.any(pixels(shown) != start, axis=2)) < 0.001


def test_buttons_move_the_viewer(shown):
    start = pixels(shown)
    seen = [start]
    for move in ("left", "right", "closer", "farther", "other"):
        click(shown, f"[data-move={move}]")
        seen.append(pixels(shown))
    left, back, closer, farther, other = (
        float(np.mean(np.abs(image - start).max(axis=2) > 0.02)) for image in seen[1:]
    )
    assert left > 0.03
    assert back < 0.005
    assert closer > 0.03
    assert farther < 0.005
    assert other > 0.03
    assert near(seen[-1], VERDIGRIS) < 0.5 * near(start, VERDIGRIS)  # the side that was measured
    click(shown, "[data-move=start]")
    assert np.mean(np.abs(pixels(shown) - start).max(axis=2) > 0.02) < 0.005


def test_a_phone_needs_no_sideways_scrolling(shown):
    browser.resize(shown, (400, 800))
    image = pixels(shown)
    widths = shown.execute_script("return [document.documentElement.scrollWidth, innerWidth]")
    browser.resize(shown, SIZE)
    assert widths == [400, 400]
    assert image.shape[1] < 400
    assert near(image, VERDIGRIS) > 0.03


def test_paper_shows_the_stills(shown):
    def displayed(what):
        style = "return getComputedStyle(document.querySelector(arguments[0])).display"
        return shown.execute_script(style, what)

    assert (displayed(".stills"), displayed(".live-only")) == ("none", "block")
    shown.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    try:
        assert (displayed(".stills"), displayed(".live-only")) == ("grid", "none")
    finally:
        shown.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})


def test_without_webgl_the_stills_are_shown(page):
    with browser.opened(page, SIZE, webgl=False) as opened:
        assert browser.state(opened) == "still"
        errors = [entry for entry in opened.get_log("browser") if entry["level"] == "SEVERE"]
        assert errors == []
        image = pixels(opened, ".stills")
        assert near(image, VERDIGRIS) > 0.05
        text = opened.execute_script("return document.body.innerText")
        assert "WebGL is missing" in text
        assert "Start view" not in text
