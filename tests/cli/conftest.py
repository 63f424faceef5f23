"""Scans with a known mirror plane, or none, and ways to run the command line."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from meshlab_symrecon.cli.main import main
from meshlab_symrecon.host.files import new_document, save_current
from meshlab_symrecon.host.meshset import add_layer
from meshlab_symrecon.plugin import Layer

NORMAL = np.array([2.0, -1.0, 2.0]) / 3.0
OFFSET = -4.0
PLANE = np.append(NORMAL, OFFSET)  # the mirror plane of the statue


def directions(count: int, seed: int) -> np.ndarray:
    drawn = np.random.default_rng(seed).normal(size=(count, 3))
    return drawn / np.linalg.norm(drawn, axis=1, keepdims=True)


def statue_points(count: int = 4000, seed: int = 0) -> np.ndarray:
    """Return a bust-like cloud that is symmetric across ``PLANE``, with a part missing."""
    x, y, z = directions(count, seed).T
    radius = 1.0 + 0.35 * z + 0.3 * y * z - 0.25 * y**3 + 0.4 * np.exp(-8 * ((abs(x) - 0.6) ** 2
        + (y - 0.3) ** 2)) + 0.3 * z * x**2  # fmt: skip
    points = radius[:, np.newaxis] * np.column_stack([x, y, z])
    kept = points[~((points[:, 0] > 0.6) & (points[:, 1] > 0.0))]
    frame, _ = np.linalg.qr(np.column_stack([NORMAL, [1.0, 0, 0], [0, 1.0, 0]]))
    return kept @ frame.T - OFFSET * NORMAL


def lopsided_points(count: int = 3000, seed: int = 1) -> np.ndarray:
    """Return a closed cloud without any mirror plane."""
    x, y, z = directions(count, seed).T
    radius = 1.0 + 0.5 * x + 0.3 * x * y + 0.35 * y * z**2 + 0.45 * x**2 * z - 0.4 * x * y * z
    radius += 0.3 * np.sin(3 * x + 1.0) * y - 0.35 * np.cos(2 * y + z) * x
    return radius[:, np.newaxis] * np.column_stack([x, y * 1.2, z * 0.7])


def write_cloud(path: Path, points: np.ndarray) -> Path:
    mesh_set = new_document()
    faces = np.zeros((0, 3), dtype=np.int64)
    add_layer(mesh_set, Layer(points, faces, "cloud"), current=True)
    save_current(mesh_set, path)
    return path


@pytest.fixture
def plane():
    """The statue's mirror plane, (4,)."""
    return PLANE


@pytest.fixture(scope="session")
def scans(tmp_path_factory):
    """A folder with 'statue 1.ply' and 'lopsided.ply'."""
    folder = tmp_path_factory.mktemp("scans größe")
    write_cloud(folder / "statue 1.ply", statue_points())
    write_cloud(folder / "lopsided.ply", lopsided_points())
    return folder


@pytest.fixture
def statue(scans):
    return scans / "statue 1.ply"


@pytest.fixture
def lopsided(scans):
    return scans / "lopsided.ply"


@pytest.fixture
def run():
    """Return a function that runs a command line in this process."""

    def call(*words):
        result = CliRunner().invoke(main, [str(word) for word in words])
        assert result.exception is None or isinstance(result.exception, SystemExit)
        return result

    return call


@pytest.fixture
def shell():
    """Return a function that runs a command line in a process of its own."""

    def call(*words, **options):
        command = [sys.executable, "-m", "meshlab_symrecon.cli.main", *map(str, words)]
        return subprocess.run(command, capture_output=True, text=True, check=False, **options)

    return call
