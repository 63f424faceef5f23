"""The two ways to label poles, compared through the whole reconstruction.

    SYMRECON_DATA=... python benchmarks/labelling.py [--samples 5000] [--details] [MODEL ...]

Models are those of SYMRECON_DATA/meshes and those of solids.py.  For each condition and method: how
many results have the pieces and handles of the model; wrong labels, in % of the poles in the
model's box whose ball is larger than 1 % of the diagonal (noise may put smaller ones on either
side); the mean distance between the surfaces, in both directions, and the largest one from a result
to its model, in % of the diagonal.  Prints Markdown.
"""

from __future__ import annotations

import argparse
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree
from solids import Model, analytic_models, mesh_model, on_triangles

from meshlab_symrecon.geometry.surfaces import topology
from meshlab_symrecon.geometry.triangulation import Triangulation, regular_triangulation
from meshlab_symrecon.powercrust.crust import crust_faces
from meshlab_symrecon.powercrust.labelling import METHODS, label_poles
from meshlab_symrecon.powercrust.normal_cloud import normalised
from meshlab_symrecon.powercrust.poles import Poles
from meshlab_symrecon.powercrust.recipe import Recipe
from meshlab_symrecon.powercrust.small_balls import NoiseLimits
from meshlab_symrecon.powercrust.stages import Stages
from meshlab_symrecon.powercrust.usable_poles import usable_poles

SMALLEST_BALL = 0.01  # diagonals
HOLE_RADIUS = 0.04  # diagonals
CHECKS = 40_000  # points on either surface
CONDITIONS = {  # noise in % of the diagonal, outliers as a share of the samples, holes
    "clean": (0.0, 0.0, 0),
    "noise .1 %": (0.1, 0.0, 0),
    "noise .2 %": (0.2, 0.0, 0),
    "noise .5 %": (0.5, 0.0, 0),
    "outliers 1 %": (0.0, 0.01, 0),
    "outliers 5 %": (0.0, 0.05, 0),
    "12 holes": (0.0, 0.0, 12),
    "noise .5 %, outliers 5 %": (0.5, 0.05, 0),
}


@dataclass(frozen=True)
class Scan:
    """What the steps before the labelling make of a spoilt sample."""

    poles: Poles
    limits: NoiseLimits
    diagram: Triangulation
    judged: np.ndarray  # of the poles
    truth: np.ndarray  # of those judged, whether they are inside
    surface: cKDTree  # points of the model
    diagonal: float


@dataclass(frozen=True)
class Verdict:
    """How good a result is; distances in % of the diagonal."""

    shape: tuple[int, int] | None
    wrong: float
    mean: float
    largest: float


def spoilt(samples, condition, rng):
    noise, outliers, holes = CONDITIONS[condition]
    low, high = samples.min(axis=0), samples.max(axis=0)
    diagonal = np.linalg.norm(high - low)
    for centre in samples[rng.choice(len(samples), holes, replace=False)]:
        samples = samples[np.linalg.norm(samples - centre, axis=1) > HOLE_RADIUS * diagonal]
    samples = samples + rng.normal(size=samples.shape) * noise / 100 * diagonal
    return np.concatenate([samples, rng.uniform(low, high, (int(outliers * len(samples)), 3))])


def scanned(model, samples, surface, condition, seed):
    """The model as the labelling sees it, in the units of the reconstruction."""
    cloud = normalised(spoilt(samples, condition, np.random.default_rng(seed)))
    usable = usable_poles(cloud.samples, Recipe(), Stages())
    poles = usable.poles
    diagram = regular_triangulation(poles.centres, poles.radii**2)
    low, high = samples.min(axis=0), samples.max(axis=0)
    diagonal = float(np.linalg.norm(high - low))
    centres = cloud.to_input(poles.centres)
    judged = ((centres > low) & (centres < high)).all(axis=1)
    judged &= poles.radii / cloud.scale > SMALLEST_BALL * diagonal
    truth = model.inside(centres[judged])
    points = (surface - cloud.to_input(np.zeros((1, 3)))) * cloud.scale
    tree = cKDTree(points)
    return Scan(poles, usable.limits, diagram, judged, truth, tree, diagonal * cloud.scale)


def judge(scan, method):
    labels = label_poles(
        scan.poles, scan.diagram, method=method, smallest_handle=scan.limits.handle
    )
    wrong = 100 * float(np.mean(labels.inside[scan.judged] != scan.truth))
    if not labels.inside.any():
        return Verdict(None, wrong, 100.0, 100.0)
    found = crust_faces(scan.poles, scan.diagram, labels.inside)
    shape = topology(found.faces)
    rng = np.random.default_rng(0)
    points = on_triangles(found.points, found.faces, CHECKS, rng)
    to_model = scan.surface.query(points)[0]
    to_result = cKDTree(points).query(scan.surface.data)[0]
    unit = 100 / scan.diagonal
    mean = unit * (to_model.mean() + to_result.mean()) / 2
    return Verdict((shape.components, shape.genus), wrong, mean, unit * to_model.max())


def all_models(names):
    models = analytic_models()
    folder = Path(os.environ["SYMRECON_DATA"]) / "meshes"
    models |= {path.stem: mesh_model(path) for path in sorted(folder.glob("*.ply"))}
    return {name: models[name] for name in names or models}


def verdicts(models, count, seed):
    """(model, condition, method) -> verdict."""
    results = {}
    for name, model in models.items():
        samples = model.sample(count, np.random.default_rng(seed))
        surface = model.sample(CHECKS, np.random.default_rng(seed + 2))
        for condition in CONDITIONS:
            scan = scanned(model, samples, surface, condition, seed + 1)
            for method in METHODS:
                results[name, condition, method] = judge(scan, method)
    return results


def print_details(models: dict[str, Model], results) -> None:
    print("Wrong labels in %,", " / ".join(METHODS), "and (pieces, handles) where they are wrong\n")
    print("| model |", " | ".join(CONDITIONS), "|")
    print("|---" * (1 + len(CONDITIONS)) + "|")
    for name, model in models.items():
        cells = []
        for condition in CONDITIONS:
            pair = [results[name, condition, method] for method in METHODS]
            known = (None, model.shape) if model.shape is None else (model.shape,)
            words = [f"{v.wrong:.2f}" + ("" if v.shape in known else f" {v.shape}") for v in pair]
            cells.append(" / ".join(words))
        print(f"| {name} |", " | ".join(cells), "|")
    print()


def print_summary(models: dict[str, Model], results) -> None:
    known = [name for name, model in models.items() if model.shape is not None]
    print(f"Right topology of {len(known)} models; %; % of the diagonal\n")
    print("| condition | labelling | right topology | wrong labels | distance | largest |")
    print("|---|---|---|---|---|---|")
    for condition in CONDITIONS:
        for method in METHODS:
            column = {name: results[name, condition, method] for name in models}
            right = sum(column[name].shape == models[name].shape for name in known)
            wrong, mean = (
                np.mean([getattr(v, what) for v in column.values()]) for what in ("wrong", "mean")
            )
            largest = max(v.largest for v in column.values())
            print(
                f"| {condition} | {method} | {right} | {wrong:.3f} | {mean:.3f} | {largest:.1f} |"
            )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("models", nargs="*")
    parser.add_argument("--samples", type=int, default=5000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--details", action="store_true", help="also a table of all models")
    chosen = parser.parse_args()
    models = all_models(chosen.models)
    results = verdicts(models, chosen.samples, chosen.seed)
    if chosen.details:
        print_details(models, results)
    print_summary(models, results)


if __name__ == "__main__":
    main()
