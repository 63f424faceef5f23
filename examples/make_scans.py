"""Make the shipped incomplete scans: sample a statue evenly, let a scanner miss one side of it.

    SYMRECON_DATA=/path/to/models python examples/make_scans.py

reads ``meshes/nefertiti.ply`` and ``meshes/demosthenes.ply`` under that folder and writes the PLY
files in ``examples/data``. Everything is seeded: the same meshes give the same bytes.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]

TARGET = Path(__file__).parent / "data"
OVERSAMPLING = 6  # random samples for every one that is kept


@dataclass(frozen=True)
class Scan:
    """How one scan is made; lengths are in units of the source mesh."""

    name: str
    mesh: str
    credit: str
    points: int  # that are left
    missing: float  # share of the surface that the scanner never saw
    centre: tuple[float, float, float]  # of the gap
    radii: tuple[float, float, float]  # of the gap, before it is made ragged
    turn: tuple[float, float, float]  # pose: degrees about y, x, z
    shift: tuple[float, float, float]
    noise: float = 0.0002  # of the box diagonal, along the normal
    seed: int = 1


NEFERTITI = (
    "Bust of Nefertiti, scan by Nora Al-Badri and Jan Nikolai Nelles (The Other Nefertiti), "
    "public domain"
)
DEMOSTHENES = "Demosthenes, Louvre, photoscan by ryanfb, CC BY 4.0, changed: part of it removed"
GAP = ((110.0, 75.0, 10.0), (95.0, 165.0, 140.0))

SCANS = (
    Scan(
        "nefertiti_incomplete", "nefertiti", NEFERTITI, 60_000, 0.27, *GAP,
        turn=(-24.0, 4.0, -3.0), shift=(120.0, 310.0, -85.0), seed=3,
    ),
    Scan(
        "nefertiti_small", "nefertiti", NEFERTITI, 3_000, 0.25, *GAP,
        turn=(-24.0, 4.0, -3.0), shift=(120.0, 310.0, -85.0), seed=3,
    ),
    Scan(
        "demosthenes_incomplete", "demosthenes", DEMOSTHENES, 30_000, 0.25,
        (0.75, 1.25, 0.25), (0.6, 0.95, 0.8),
        turn=(31.0, -3.0, 2.0), shift=(0.4, 1.7, 0.9), seed=3,
    ),
)  # fmt: skip


def read_mesh(path: Path) -> tuple[Array, NDArray[np.int64]]:
    """Read vertices and triangles of a binary little-endian PLY with float positions only."""
    raw = path.read_bytes()
    end = raw.index(b"end_header\n") + len(b"end_header\n")
    counts = {
        line.split()[1]: int(line.split()[2])
        for line in raw[:end].decode().splitlines()
        if line.startswith("element")
    }
    points = np.frombuffer(raw, "<f4", 3 * counts["vertex"], end).reshape(-1, 3)
    triangle = np.dtype([("count", "u1"), ("corners", "<i4", 3)])
    faces = np.frombuffer(raw, triangle, counts["face"], end + points.nbytes)
    return points.astype(float), faces["corners"].astype(np.int64)


def write_cloud(path: Path, points: Array, credit: str) -> None:
    """Write positions as float32, with the credit as a comment in the header."""
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        f"comment {credit}\ncomment made by examples/make_scans.py of meshlab_symrecon\n"
        f"element vertex {len(points)}\n"
        "property float x\nproperty float y\nproperty float z\nend_header\n"
    )
    path.write_bytes(header.encode("ascii") + points.astype("<f4").tobytes())


def sample_evenly(
    points: Array, faces: NDArray[np.int64], count: int, rng: np.random.Generator
) -> tuple[Array, Array]:
    """Sample by area, then keep one sample a cell of a grid that is fine enough for the count."""
    corners = points[faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(across, axis=1)
    chosen = rng.choice(len(faces), OVERSAMPLING * count, p=area / area.sum())
    root, second = np.sqrt(rng.random(len(chosen))), rng.random(len(chosen))
    weights = np.column_stack([1 - root, root * (1 - second), root * second])
    samples = np.einsum("nk,nkc->nc", weights, corners[chosen])
    high = 2.0 * float(np.sqrt(area.sum() / count))
    low = high / 100.0
    kept = np.arange(len(samples))
    for _ in range(30):
        cell = (low + high) / 2
        cells = np.floor((samples - samples.min(axis=0)) / cell).astype(np.int64)
        first = np.unique(np.ravel_multi_index(cells.T, cells.max(axis=0) + 1), return_index=True)[
            1
        ]
        if len(first) >= count:
            low, kept = cell, first
        else:
            high = cell
    kept = rng.permutation(kept)[:count]
    return samples[kept], (across / np.maximum(area, 1e-300)[:, None])[chosen[kept]]


def ripples(points: Array, wavelength: float, rng: np.random.Generator) -> Array:
    """Return a smooth random field over space, of variance about one."""
    waves = rng.normal(size=(40, 3)) * (2.0 * np.pi / wavelength / np.sqrt(3.0))
    phases = rng.uniform(0.0, 2.0 * np.pi, 40)
    field: Array = np.cos(points @ waves.T + phases).sum(axis=1) / np.sqrt(20.0)
    return field


def seen_by_scanner(points: Array, scan: Scan, rng: np.random.Generator) -> NDArray[np.bool_]:
    """Say which points are left round one ragged gap."""
    diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
    depth = np.linalg.norm((points - scan.centre) / scan.radii, axis=1)
    depth += 0.10 * ripples(points, 0.14 * diagonal, rng)
    depth += 0.06 * ripples(points, 0.05 * diagonal, rng)
    depth += 0.03 * ripples(points, 0.02 * diagonal, rng)
    depth += 0.01 * rng.normal(size=len(points))  # the last points before a gap are stray ones
    return depth > np.quantile(depth, scan.missing)


def make(scan: Scan, source: Path) -> Array:
    """Return the points of one scan, in the scanner's pose."""
    rng = np.random.default_rng(scan.seed)
    points, faces = read_mesh(source / "meshes" / f"{scan.mesh}.ply")
    count = int(np.ceil(scan.points / (1.0 - scan.missing))) + 1
    samples, normals = sample_evenly(points, faces, count, rng)
    left = seen_by_scanner(samples, scan, np.random.default_rng([scan.seed, 1]))
    sigma = scan.noise * np.linalg.norm(np.ptp(samples, axis=0))
    noisy = samples + normals * rng.normal(0.0, sigma, len(samples))[:, None]
    posed = Rotation.from_euler("yxz", scan.turn, degrees=True).apply(noisy[left][: scan.points])
    return posed + scan.shift


def main() -> None:
    """Write every shipped scan."""
    source = os.environ.get("SYMRECON_DATA")
    if source is None:
        raise SystemExit("SYMRECON_DATA is not set; let it name the folder that holds meshes/.")
    TARGET.mkdir(parents=True, exist_ok=True)
    for scan in SCANS:
        points = make(scan, Path(source))
        write_cloud(TARGET / f"{scan.name}.ply", points, scan.credit)
        print(f"{scan.name}.ply: {len(points)} points")


if __name__ == "__main__":
    main()
