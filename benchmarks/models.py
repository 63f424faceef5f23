"""Models whose surface is known, and scans of them: made here, or those of SYMRECON_DATA/meshes."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pymeshlab
from scipy.interpolate import PchipInterpolator

from meshlab_symrecon.geometry.surfaces import face_normals

STRAY_BOX = 1.25  # sides of the box of the outliers / sides of the model's


@dataclass(frozen=True)
class Model:
    """A closed surface of triangles."""

    name: str
    points: np.ndarray  # (v, 3)
    faces: np.ndarray  # (m, 3)

    @property
    def diagonal(self) -> float:
        return float(np.linalg.norm(np.ptp(self.points, axis=0)))


def bumpy_torus(rows: int = 500, columns: int = 1000) -> Model:
    """One handle; bumps of several sizes."""
    u, v = np.meshgrid(
        np.linspace(0.0, 2 * np.pi, columns, endpoint=False),
        np.linspace(0.0, 2 * np.pi, rows, endpoint=False),
    )
    tube = 0.35 + 0.05 * np.sin(5 * u) * np.cos(4 * v) + 0.02 * np.sin(13 * u + 3 * v)
    ring = 1 + tube * np.cos(v)
    points = np.stack([ring * np.cos(u), ring * np.sin(u), tube * np.sin(v)], axis=-1)
    return Model("bumpy torus", points.reshape(-1, 3), _grid_faces(rows, columns, closed=True))


def bust(rows: int = 700, columns: int = 800) -> Model:
    """A statue's kinds of places: a sharp plinth, folds, a hollow neck, a nose and thin ears."""
    radius = np.array([0.0, 0.45, 0.45, 0.30, 0.27, 0.50, 0.42, 0.17, 0.16, 0.25, 0.22, 0.0])
    height = np.array([0.0, 0.0, 0.14, 0.17, 0.30, 0.60, 0.74, 0.82, 0.90, 1.06, 1.20, 1.30])
    along = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(radius), np.diff(height)))])
    rings = np.linspace(0.0, along[-1], rows + 2)[1:-1]
    r, h = (PchipInterpolator(along, values)(rings)[:, None] for values in (radius, height))
    turn = np.linspace(-np.pi, np.pi, columns, endpoint=False)[None, :]
    folds = 0.07 * np.sin(11 * turn + 9 * h) * np.exp(-(((h - 0.5) / 0.12) ** 2))
    nose = 0.30 * np.exp(-((turn / 0.22) ** 2) - ((h - 1.04) / 0.04) ** 2)
    ears = 0.35 * np.exp(-(((np.abs(turn) - 1.6) / 0.09) ** 2) - ((h - 1.06) / 0.05) ** 2)
    r = r * (1.0 + folds + nose + ears)
    body = np.stack([r * np.cos(turn), 0.8 * r * np.sin(turn), h + 0.0 * turn], axis=-1)
    ends = np.array([[0.0, 0.0, height[0]], [0.0, 0.0, height[-1]]])
    low, high = rows * columns, rows * columns + 1
    first = np.arange(columns)
    last, following = first + (rows - 1) * columns, (first + 1) % columns
    caps = [
        np.stack([np.full(columns, low), following, first], axis=1),
        np.stack([np.full(columns, high), last, following + (rows - 1) * columns], axis=1),
    ]
    faces = np.concatenate([_grid_faces(rows, columns, closed=False), *caps])
    return Model("bust", np.concatenate([body.reshape(-1, 3), ends]), faces)


def _grid_faces(rows: int, columns: int, *, closed: bool) -> np.ndarray:
    """Return two triangles a square of a grid whose rows, and columns if closed, are rings."""
    row, column = np.divmod(np.arange((rows if closed else rows - 1) * columns), columns)
    above, beside = (row + 1) % rows, (column + 1) % columns
    a, b = row * columns + column, row * columns + beside
    c, d = above * columns + beside, above * columns + column
    return np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])


def load(path: Path) -> Model:
    mesh_set = pymeshlab.MeshSet()
    mesh_set.load_new_mesh(str(path))
    mesh = mesh_set.current_mesh()
    return Model(path.stem, mesh.vertex_matrix(), mesh.face_matrix().astype(np.int64))


def chosen_models(names: list[str]) -> list[Model]:
    """Return the models of these names, or all: those made here, and those of SYMRECON_DATA."""
    made = [bumpy_torus(), bust()]
    folder = os.environ.get("SYMRECON_DATA")
    paths = sorted(Path(folder, "meshes").glob("*.ply")) if folder else []
    known = [model.name for model in made] + [path.stem for path in paths]
    unknown = set(names) - set(known)
    if unknown:
        raise SystemExit(f"no model {', '.join(sorted(unknown))}; there are: {', '.join(known)}")
    return [model for model in made if not names or model.name in names] + [
        load(path) for path in paths if not names or path.stem in names
    ]


def scan(model: Model, count: int, noise: float, outliers: float, seed: int) -> np.ndarray:
    """Return uniform samples of a model.

    Parameters
    ----------
    model : Model
    count : int
    noise : float
        Standard deviation along the normal, in % of the diagonal.
    outliers : float
        Further points anywhere in a box round the model, as a share of the samples.
    seed : int
    """
    rng = np.random.default_rng(seed)
    normals = face_normals(model.points, model.faces)
    areas = np.linalg.norm(normals, axis=1)
    face = rng.choice(len(areas), count, p=areas / areas.sum())
    u, v = rng.random((2, count))
    flip = u + v > 1.0
    u[flip], v[flip] = 1.0 - u[flip], 1.0 - v[flip]
    a, b, c = (model.points[model.faces[face, corner]] for corner in range(3))
    samples = a + u[:, None] * (b - a) + v[:, None] * (c - a)
    away = rng.normal(0.0, noise / 100 * model.diagonal, (count, 1))
    samples += away * normals[face] / areas[face][:, None]
    low, high = model.points.min(axis=0), model.points.max(axis=0)
    stray = (low + high) / 2 + (rng.random((round(outliers * count), 3)) - 0.5) * (
        STRAY_BOX * (high - low)
    )
    return np.concatenate([samples, stray])
