"""The Power Crust on sampled models, clean, noisy and with outliers.

    SYMRECON_DATA=... python benchmarks/power_crust.py [--samples 10000] [--seed 0] [MODEL ...]

For each model of SYMRECON_DATA/meshes and each condition: CPU seconds, faces, topology, distances
between the surfaces (mean of both directions; largest from the result, largest from the truth; %
of the diagonal) and the enclosed volume relative to the model's.
"""

from __future__ import annotations

import argparse
import os
import time
from pathlib import Path

import numpy as np
import pymeshlab
from scipy.spatial import cKDTree

from meshlab_symrecon.geometry.surfaces import enclosed_volume, face_normals
from meshlab_symrecon.powercrust.reconstruction import reconstruct

MODELS = ["nefertiti", "squirrel", "skull", "wingnut", "twirl", "falcon", "demosthenes", "column"]
CONDITIONS = [  # noise in % of the diagonal, outliers as a share of the samples
    ("clean", 0.0, 0.0),
    ("noise .2 %", 0.2, 0.0),
    ("noise .5 %", 0.5, 0.0),
    ("outliers 1 %", 0.0, 0.01),
    ("outliers 10 %", 0.0, 0.1),
    ("noise .5 %, outliers 5 %", 0.5, 0.05),
]
CHECKS = 100_000  # points on either surface


def sample(points, faces, count, rng):
    normals = face_normals(points, faces)
    areas = np.linalg.norm(normals, axis=1)
    face = rng.choice(len(faces), count, p=areas / areas.sum())
    u, v = rng.random((2, count))
    flip = u + v > 1
    u[flip], v[flip] = 1 - u[flip], 1 - v[flip]
    a, b, c = (points[faces[face, k]] for k in range(3))
    place = a + u[:, None] * (b - a) + v[:, None] * (c - a)
    return place, normals[face] / areas[face][:, None]


def row(points, faces, count, noise, outliers, rng):
    diagonal = np.linalg.norm(np.ptp(points, axis=0))
    samples, normals = sample(points, faces, count, rng)
    samples += normals * rng.normal(0.0, 1.0, (count, 1)) * noise / 100 * diagonal
    low, high = points.min(axis=0), points.max(axis=0)
    stray = (low + high) / 2 + (rng.random((int(outliers * count), 3)) - 0.5) * (high - low) * 1.25
    started = time.process_time()
    crust = reconstruct(np.concatenate([samples, stray]), with_axis=False)
    seconds = time.process_time() - started
    truth, result = (
        sample(p, f, CHECKS, rng)[0] for p, f in ((points, faces), (crust.points, crust.faces))
    )
    there = cKDTree(truth).query(np.concatenate([result, crust.points]))[0]
    back = cKDTree(result).query(truth)[0]
    floor = cKDTree(truth).query(sample(points, faces, CHECKS, rng)[0])[0].mean()
    mean = there[:CHECKS].mean() + back.mean() - 2 * floor
    shape = crust.topology
    return (
        f"{seconds:5.1f} s {len(crust.faces):8d} faces  closed {shape.closed} manifold "
        f"{shape.vertex_manifold} pieces {shape.components} genus {shape.genus:3d}  mean "
        f"{100 * mean / diagonal:.3f}  largest {100 * there.max() / diagonal:.2f} "
        f"{100 * back.max() / diagonal:.2f}  volume "
        f"{enclosed_volume(crust.points, crust.faces) / enclosed_volume(points, faces):.3f}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("models", nargs="*", default=MODELS)
    parser.add_argument("--samples", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=0)
    chosen = parser.parse_args()
    folder = Path(os.environ["SYMRECON_DATA"]) / "meshes"
    for model in chosen.models:
        mesh_set = pymeshlab.MeshSet()
        mesh_set.load_new_mesh(str(folder / f"{model}.ply"))
        mesh = mesh_set.current_mesh()
        points, faces = mesh.vertex_matrix(), mesh.face_matrix().astype(np.int64)
        for name, noise, outliers in CONDITIONS:
            rng = np.random.default_rng(chosen.seed)
            print(
                f"{model:12s} {name:26s}",
                row(points, faces, chosen.samples, noise, outliers, rng),
                flush=True,
            )


if __name__ == "__main__":
    main()
