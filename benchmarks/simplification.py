"""Simplified clouds of the same number of points, compared by the surfaces that they give.

    python benchmarks/simplification.py [--samples 20000] [--keep 2000] [--seeds 3] [FOLDER ...]

The models are those of SYMRECON_DATA/meshes and of further folders. From samples of each, as many
points are kept by MeshLab's Poisson-disk sampling (subsampling, exact number), by its clustered
vertex sampling (the size of the cells is searched for the number nearest), and by affinity
propagation. The Power Crust of each is compared with the model: largest distance, in either
direction, and mean of the mean distances, in % of the model's diagonal, averaged over the seeds.
Prints Markdown.
"""

from __future__ import annotations

import argparse
import os
import time
from pathlib import Path

import numpy as np
import pymeshlab
from models import Model, load, scan

from meshlab_symrecon.clustering.simplification import DETAIL, simplify
from meshlab_symrecon.powercrust.recipe import Recipe
from meshlab_symrecon.powercrust.reconstruction import reconstruct

CHECKS = 60_000  # points on either surface
SEARCH = 24  # sizes of the cells tried
METHODS = ("Poisson-disk", "clustered vertex", "ours")


def cloud_set(points: np.ndarray) -> pymeshlab.MeshSet:
    mesh_set = pymeshlab.MeshSet()
    mesh_set.add_mesh(pymeshlab.Mesh(points))
    return mesh_set


def poisson_disk(points: np.ndarray, count: int) -> np.ndarray:
    mesh_set = cloud_set(points)
    mesh_set.generate_sampling_poisson_disk(samplenum=count, subsample=True, exactnumflag=True)
    return mesh_set.current_mesh().vertex_matrix()


def clustered_vertex(points: np.ndarray, count: int) -> np.ndarray:
    """Keep the point nearest to the middle of each cell, in cells that give the number nearest."""
    low, high = 0.02, 20.0  # % of the diagonal
    best = points
    for _ in range(SEARCH):
        size = float(np.sqrt(low * high))
        mesh_set = cloud_set(points)
        mesh_set.generate_sampling_clustered_vertex(
            threshold=pymeshlab.PercentageValue(size), sampling="Closest to center"
        )
        kept = mesh_set.current_mesh().vertex_matrix()
        if abs(len(kept) - count) < abs(len(best) - count):
            best = kept
        low, high = (size, high) if len(kept) > count else (low, size)
    return best


def distances(model: Model, points: np.ndarray) -> tuple[float, float]:
    """Return the largest and the mean distance of a cloud's Power Crust and the model."""
    crust = reconstruct(points, Recipe(with_axis=False))
    mesh_set = pymeshlab.MeshSet()
    mesh_set.add_mesh(pymeshlab.Mesh(crust.points, crust.faces))
    mesh_set.add_mesh(pymeshlab.Mesh(model.points, model.faces))
    largest, means = 0.0, []
    for source, target in ((0, 1), (1, 0)):
        for vertices in (False, True):
            found = mesh_set.get_hausdorff_distance(
                sampledmesh=source,
                targetmesh=target,
                samplevert=vertices,
                sampleface=not vertices,
                samplenum=CHECKS,
                maxdist=pymeshlab.PercentageValue(100),
            )
            largest = max(largest, found["max"])
            means += [] if vertices else [found["mean"]]
    return 100 * largest / model.diagonal, 100 * float(np.mean(means)) / model.diagonal


def compare(model: Model, options: argparse.Namespace) -> tuple[np.ndarray, np.ndarray, float]:
    """Return (3,) largest and mean distances, and the CPU seconds of ours."""
    rows, seconds = [], []
    for seed in range(options.seeds):
        samples = scan(model, options.samples, options.noise, 0.0, seed)
        even = poisson_disk(samples, options.keep)
        count = len(even)  # its exact number is exact to .5 %: the others follow it
        start = time.process_time()
        ours = samples[simplify(samples, count=count, detail=options.detail).chosen]
        seconds.append(time.process_time() - start)
        rows.append([distances(model, c) for c in (even, clustered_vertex(samples, count), ours)])
    means = np.mean(rows, axis=0)
    return means[:, 0], means[:, 1], float(np.mean(seconds))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folders", nargs="*", type=Path)
    parser.add_argument("--samples", type=int, default=20_000)
    parser.add_argument("--keep", type=int, default=2_000)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--noise", type=float, default=0.0, help="%% of the diagonal")
    parser.add_argument("--detail", type=float, default=DETAIL)
    parser.add_argument("--models", nargs="*", default=[])
    options = parser.parse_args()
    data = os.environ.get("SYMRECON_DATA")
    folders = ([Path(data, "meshes")] if data else []) + options.folders
    paths = [path for folder in folders for path in sorted(folder.glob("*.ply"))]
    if options.models:
        paths = [path for path in paths if path.stem in options.models]
    if not paths:
        raise SystemExit("no models: set SYMRECON_DATA, or name folders of PLY files")
    print(f"{options.samples} -> {options.keep} points, {options.seeds} seeds,", end=" ")
    print(f"noise of {options.noise:g} % of the diagonal, detail {options.detail:g}\n")
    heads = [f"{what}, {method}" for what in ("largest", "mean") for method in METHODS]
    print("| model | " + " | ".join(heads) + " | CPU s |\n|" + "---|" * 8)
    ratios, mean_ratios = [], []
    for path in paths:
        largest, mean, seconds = compare(load(path), options)
        cells = [f"{value:.2f}" for value in largest] + [f"{value:.3f}" for value in mean]
        print(f"| {path.stem} | " + " | ".join(cells) + f" | {seconds:.2f} |", flush=True)
        ratios.append(largest[2] / largest[:2])
        mean_ratios.append(mean[2] / mean[:2])
    wins = np.array(ratios) < 1.0
    first, second, both = wins[:, 0].sum(), wins[:, 1].sum(), wins.all(axis=1).sum()
    print(f"\nLargest distance smaller than of {METHODS[0]}: on {first} of {len(paths)} models;")
    print(f"than of {METHODS[1]}: on {second}; than of both: on {both}.")
    for name, values in (("largest", ratios), ("mean", mean_ratios)):
        first, second = np.exp(np.log(values).mean(axis=0))
        print(f"{name} distance / theirs, geometric mean: {first:.2f} and {second:.2f}")


if __name__ == "__main__":
    main()
