"""Models with known planes: those made here, and those of the folders in SYMRECON_DATA.

Each folder (several, with os.pathsep between them) has ``planes.json`` and the meshes that it
names.
"""

from __future__ import annotations

import json
import os
from functools import lru_cache
from pathlib import Path

import numpy as np
from models import load
from shape_surfaces import Shape
from shapes import SHAPES, made

KINDS = ("statue", "posed", "vessel", "several", "round", "scan", "asymmetric", "scan without")


@lru_cache(maxsize=1)
def entries() -> dict[str, tuple[Path, dict]]:
    """What the folders hold: file and entry of each model; of equal names the first."""
    found: dict[str, tuple[Path, dict]] = {}
    for folder in os.environ.get("SYMRECON_DATA", "").split(os.pathsep):
        listing = Path(folder, "planes.json")
        if not folder or not listing.exists():
            continue
        for name, entry in json.loads(listing.read_text())["models"].items():
            path = Path(folder, "meshes", f"{name}.ply")
            if path.exists() and name not in found and name not in SHAPES:
                found[name] = path, entry
    return found


def names() -> list[str]:
    return [*SHAPES, *entries()]


@lru_cache(maxsize=4)
def scanned(name: str) -> Shape:
    """A model of a file."""
    path, entry = entries()[name]
    mesh = load(path)
    planes = np.array([[*plane["normal"], -plane["offset"]] for plane in entry["planes"]])
    planes = planes.reshape(-1, 4)
    planes = planes / np.linalg.norm(planes[:, :3], axis=1, keepdims=True)
    up = np.array(entry.get("up") or [0.0, 1.0, 0.0], dtype=float)
    turning = entry.get("revolution")  # every plane through the axis is true
    axis = np.array([turning["point"], turning["direction"]], dtype=float) if turning else None
    kind = "scan" if len(planes) or turning else "scan without"
    return Shape(name, kind, mesh.points[mesh.faces], planes, axis, up=up / np.linalg.norm(up))


def model(name: str, seed: int) -> Shape:
    """A model by its name; ``seed`` chooses among the made ones of a name."""
    return made(name, seed) if name in SHAPES else scanned(name)
