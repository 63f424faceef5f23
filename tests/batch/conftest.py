"""Small scans, and a filter that is awkward on some of them, installed for child processes too."""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

import pytest
from batch_inputs import SCRIPT

PLUGIN = Path(__file__).with_name("awkward_filter.py")


@pytest.fixture(scope="session", autouse=True)
def awkward(tmp_path_factory):
    """Install the plugin for this process and those that it starts."""
    from meshlab_symrecon.host.registration import registry

    folder = tmp_path_factory.mktemp("site")
    information = folder / "awkward-1.0.dist-info"
    information.mkdir()
    shutil.copy(PLUGIN, folder)
    (information / "METADATA").write_text("Metadata-Version: 2.1\nName: awkward\nVersion: 1.0\n")
    (information / "entry_points.txt").write_text(
        "[meshlab_symrecon.filters]\nawkward = awkward_filter:FILTER\n"
    )
    before = os.environ.get("PYTHONPATH")
    os.environ["PYTHONPATH"] = str(folder)
    sys.path.insert(0, str(folder))
    registry(refresh=True)
    yield
    sys.path.remove(str(folder))
    if before is None:
        del os.environ["PYTHONPATH"]
    else:
        os.environ["PYTHONPATH"] = before
    registry(refresh=True)


@pytest.fixture
def script(tmp_path):
    path = tmp_path / "halve.mlx"
    path.write_text(SCRIPT)
    return path
