"""A headless Chromium for pages of ours: to test them, and to take their picture.

python docs/browser.py PAGE PICTURE
"""

from __future__ import annotations

import argparse
import json
import shutil
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")
DRIVER = "chromedriver"
FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--hide-scrollbars", "--disable-dev-shm-usage",
)  # fmt: skip
IN_SOFTWARE = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
WITHOUT_WEBGL = ("--disable-3d-apis",)
PATIENCE = 60.0  # seconds until a view must have been drawn


def missing() -> str:
    """Say what a headless browser lacks here; nothing when it can be opened."""
    lacks = []
    if not any(shutil.which(name) for name in BROWSERS):
        lacks.append("Chromium")
    if shutil.which(DRIVER) is None:
        lacks.append(DRIVER)
    if find_spec("selenium") is None:
        lacks.append("selenium")
    return ", ".join(lacks)


@contextmanager
def opened(page: Path, size: tuple[int, int], *, webgl: bool = True) -> Iterator[Any]:
    """Yield a browser that shows a page of a report, at a size in pixels, when it is drawn.

    Nothing is downloaded: browser and driver are those of the machine.
    """
    from selenium.webdriver import Chrome, ChromeOptions
    from selenium.webdriver.chrome.service import Service

    options = ChromeOptions()
    options.binary_location = next(path for name in BROWSERS if (path := shutil.which(name)))
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    with tempfile.TemporaryDirectory(prefix="browser-", ignore_cleanup_errors=True) as profile:
        given = f"--user-data-dir={profile}", f"--window-size={size[0]},{size[1]}"
        for flag in (*FLAGS, *(IN_SOFTWARE if webgl else WITHOUT_WEBGL), *given):
            options.add_argument(flag)
        browser = Chrome(options=options, service=Service(shutil.which(DRIVER)))
        try:
            resize(browser, size)
            browser.get(page.resolve().as_uri())
            _wait(browser)
            yield browser
        finally:
            browser.quit()


def resize(browser: Any, size: tuple[int, int]) -> None:
    """Set the size of the page itself: windows cannot be as narrow as a phone."""
    metrics = {"width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)


def _wait(browser: Any) -> None:
    deadline = time.monotonic() + PATIENCE
    while not state(browser):
        if time.monotonic() > deadline:
            raise TimeoutError(f"the view was not drawn within {PATIENCE:.0f} seconds")
        time.sleep(0.1)


def state(browser: Any) -> str:
    """Return ``ready``, or ``still`` where there is no WebGL; nothing while the page loads."""
    answer: str = browser.execute_script("return document.getElementById('view').dataset.state")
    return answer


def requests(browser: Any, page: Path) -> list[str]:
    """Return the addresses that the page has asked for."""
    asked = []
    for entry in browser.get_log("performance"):
        message = json.loads(entry["message"])["message"]
        sent = message["params"]
        if message["method"] == "Network.requestWillBeSent" and (
            sent.get("documentURL") == page.resolve().as_uri()
        ):
            asked.append(sent["request"]["url"])
    return asked


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("page", type=Path)
    parser.add_argument("picture", type=Path)
    parser.add_argument("--size", type=int, nargs=2, default=(1100, 1360))
    given = parser.parse_args()
    if missing():
        raise SystemExit(f"missing here: {missing()}")
    with opened(given.page, tuple(given.size)) as browser:
        time.sleep(1.0)  # the last frame
        browser.save_screenshot(str(given.picture))


if __name__ == "__main__":
    main()
