"""Tests run away from the source tree, so that what is installed is what is tested."""

from __future__ import annotations

import os
import signal
import sys
from contextlib import suppress
from pathlib import Path

import pytest

if os.environ.get("LC_ALL") in ("C", "POSIX"):  # MeshLab, when it is loaded, would name files so
    os.environ["LC_ALL"] = "C.UTF-8"


def pytest_configure():
    """Hear signals: in the background of a script Ctrl-C is ignored, under nohup SIGHUP is.

    So it would be by all that is started, too.
    """
    for name, heard in (("SIGINT", signal.default_int_handler), ("SIGHUP", signal.SIG_DFL)):
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) is signal.SIG_IGN:
            signal.signal(number, heard)
    with suppress(ImportError):  # what is released is tested without it
        _make_hypothesis_certain()


def _make_hypothesis_certain():
    """Draw the same examples each time, however slow the machine is."""
    from hypothesis import HealthCheck, settings

    calm = settings(derandomize=True, deadline=None, suppress_health_check=[HealthCheck.too_slow])
    settings.register_profile("certain", calm)
    settings.load_profile("certain")


@pytest.fixture(scope="session", autouse=True)
def _away_from_the_tree(tmp_path_factory):
    before = Path.cwd()
    os.chdir(tmp_path_factory.mktemp("elsewhere"))
    yield
    os.chdir(before)


@pytest.fixture(autouse=True)
def _aftermath_undone():
    """Undo what a filter leaves behind that a test lets fail in pymeshlab itself."""
    yield
    aftermath = sys.modules.get("meshlab_symrecon.host.aftermath")
    if aftermath is not None:
        aftermath.undo_aftermath()
