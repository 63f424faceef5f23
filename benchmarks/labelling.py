"""Labels of poles by a minimum cut and by the paper's propagation, against the truth.

    SYMRECON_DATA=... python benchmarks/labelling.py [--samples 5000] [--seed 0] [MODEL ...]

For each model (those of SYMRECON_DATA/meshes and analytic ones), condition and method: the share of
wrong labels among the poles in the model's box whose ball is larger than 1 % of the diagonal (the
smaller ones noise may put on either side), and whether the crust has the pieces and the genus of
the model.  Prints Markdown.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pymeshlab
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from meshlab_symrecon.geometry.surfaces import face_normals, topology
from meshlab_symrecon.geometry.triangulation import delaunay, regular_triangulation
from meshlab_symrecon.powercrust.crust import crust_faces
from meshlab_symrecon.powercrust.labelling import METHODS, label_poles
from meshlab_symrecon.powercrust.poles import enclose, find_poles

SMALLEST_BALL = 0.01  # diagonals
HOLES, HOLE_RADIUS = 12, 0.04  # diagonals
GRID = 200  # columns a side, in which triangles are looked up
CONDITIONS = {  # noise in % of the diagonal, outliers as a share of the samples, holes
    "clean": (0.0, 0.0, 0),
    "noise .1 %": (0.1, 0.0, 0),
    "noise .2 %": (0.2, 0.0, 0),
    "noise .5 %": (0.5, 0.0, 0),
    "outliers 1 %": (0.0, 0.01, 0),
    "outliers 5 %": (0.0, 0.05, 0),
    "12 holes": (0.0, 0.0, HOLES),
}


@dataclass(frozen=True)
class Model:
    """A solid: points of its surface, a test for its inside, and its topology."""

    sample: Callable[[int, np.random.Generator], np.ndarray]
    inside: Callable[[np.ndarray], np.ndarray]
    shape: tuple[int, int] | None  # pieces and genus, where they are known


# ----------------------------------------------------------------------------- models of triangles


def crossings_above(points, corners):
    """Whether an odd number of triangles lies above each point."""
    low = corners[:, :, :2].min(axis=(0, 1))
    step = (corners[:, :, :2].max(axis=(0, 1)) - low) / GRID
    first = np.floor((corners[:, :, :2].min(axis=1) - low) / step).astype(int)
    last = np.floor((corners[:, :, :2].max(axis=1) - low) / step).astype(int)
    wide, high = (last - first + 1).T
    triangle = np.repeat(np.arange(len(corners)), wide * high)
    place = np.arange(len(triangle)) - np.repeat(np.cumsum(wide * high) - wide * high, wide * high)
    column = first[triangle, 0] + place % wide[triangle]
    row = first[triangle, 1] + place // wide[triangle]
    key = column * (GRID + 1) + row
    order = np.argsort(key, kind="stable")
    key, triangle = key[order], triangle[order]

    cell = np.floor((points[:, :2] - low) / step).astype(int)
    within = ((cell >= 0) & (cell <= GRID)).all(axis=1)
    wanted = np.where(within, cell[:, 0] * (GRID + 1) + cell[:, 1], -1)
    start, end = np.searchsorted(key, wanted), np.searchsorted(key, wanted, side="right")
    point = np.repeat(np.arange(len(points)), end - start)
    place = np.arange(len(point)) - np.repeat(np.cumsum(end - start) - (end - start), end - start)
    a, b, c = corners[triangle[start[point] + place]].transpose(1, 0, 2)
    p = points[point]

    def turn(u, v):
        return (u[:, 0] - p[:, 0]) * (v[:, 1] - p[:, 1]) - (u[:, 1] - p[:, 1]) * (v[:, 0] - p[:, 0])

    weights = np.stack([turn(b, c), turn(c, a), turn(a, b)])
    hit = (weights > 0).all(axis=0) | (weights < 0).all(axis=0)
    area = np.where(hit, weights.sum(axis=0), 1.0)
    height = (weights[0] * a[:, 2] + weights[1] * b[:, 2] + weights[2] * c[:, 2]) / area
    return np.bincount(point[hit & (height > p[:, 2])], minlength=len(points)) % 2 == 1


def mesh_model(path):
    mesh_set = pymeshlab.MeshSet()
    mesh_set.load_new_mesh(str(path))
    mesh = mesh_set.current_mesh()
    points, faces = mesh.vertex_matrix(), mesh.face_matrix().astype(np.int64)
    areas = np.linalg.norm(face_normals(points, faces), axis=1)
    shape = topology(faces)

    def sample(count, rng):
        face = rng.choice(len(faces), count, p=areas / areas.sum())
        u, v = rng.random((2, count))
        flip = u + v > 1
        u[flip], v[flip] = 1 - u[flip], 1 - v[flip]
        a, b, c = (points[faces[face, k]] for k in range(3))
        return a + u[:, None] * (b - a) + v[:, None] * (c - a)

    def inside(queries):
        turns = Rotation.random(3, random_state=0).as_matrix()
        votes = [crossings_above(queries @ t.T, points[faces] @ t.T) for t in turns]
        return np.sum(votes, axis=0) >= 2

    manifold = shape.closed and shape.vertex_manifold
    return Model(sample, inside, (shape.components, shape.genus) if manifold else None)


# -------------------------------------------------------------------------------- analytic models


def implicit_model(field, half_size, genus):
    """The solid field < 0, within a box."""
    half_size = np.asarray(half_size, dtype=float)

    def gradient(points, step=1e-5):
        shifts = step * np.eye(3)
        return np.stack([(field(points + s) - field(points - s)) / (2 * step) for s in shifts], -1)

    def sample(count, rng):
        """Points near the surface, uniform in volume, moved onto it."""
        found = []
        while sum(map(len, found)) < count:
            points = rng.uniform(-1.1, 1.1, (10 * count, 3)) * half_size
            points = points[np.abs(field(points)) < 0.2]
            slope = np.maximum(np.linalg.norm(gradient(points), axis=1), 1e-9)
            points = points[np.abs(field(points)) / slope < 0.01]
            for _ in range(6):
                slopes = gradient(points)
                square = np.maximum((slopes**2).sum(axis=1), 1e-12)
                points = points - (field(points) / square)[:, None] * slopes
            found.append(points[np.abs(field(points)) < 1e-6])
        return np.concatenate(found)[:count]

    return Model(sample, lambda points: field(points) < 0, (1, genus))


def tube(curve, radius):
    """Points nearer to a curve than the radius; it is dense enough to pass for smooth."""
    tree = cKDTree(curve)
    return lambda points: tree.query(points)[0] - radius


def superquadric(sizes, power):
    sizes = np.asarray(sizes)
    return lambda p: (np.abs(p / sizes) ** power).sum(axis=1) ** (1 / power) - 1


def ring(points, centre=0.0):
    return np.hypot(np.hypot(points[:, 0] - centre, points[:, 1]) - 1, points[:, 2])


def bumpy(points):
    length = np.linalg.norm(points, axis=1)
    x, y, z = (points / np.maximum(length, 1e-9)[:, None]).T
    return length - 1 - 0.15 * np.sin(6 * x) * np.sin(7 * y) * np.cos(5 * z)


def bar_across(points):
    """Distance to the diameter of the ring."""
    return np.hypot(np.maximum(np.abs(points[:, 0]) - 1, 0), np.hypot(points[:, 1], points[:, 2]))


def bowl(points):
    shell = np.abs(np.linalg.norm(points, axis=1) - 0.9) - 0.08
    return np.maximum(shell, points[:, 2] - 0.2)


def analytic_models():
    t = np.linspace(0, 2 * np.pi, 3000)
    trefoil = np.stack(
        [np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)], axis=1
    )
    helix = np.stack([np.cos(3 * t), np.sin(3 * t), t / np.pi - 1], axis=1)
    return {
        "torus": implicit_model(lambda p: ring(p) - 0.4, (1.4, 1.4, 0.4), 1),
        "barred ring": implicit_model(
            lambda p: np.minimum(ring(p), bar_across(p)) - 0.2, (1.2, 1.2, 0.2), 2
        ),
        "two rings": implicit_model(
            lambda p: np.minimum(ring(p, -0.6), ring(p, 0.6)) - 0.2, (1.8, 1.2, 0.2), 3
        ),
        "box": implicit_model(superquadric([1, 0.7, 0.5], 8), (1, 0.7, 0.5), 0),
        "pillow": implicit_model(superquadric([1, 1, 0.6], 1.5), (1, 1, 0.6), 0),
        "plate": implicit_model(superquadric([1, 0.8, 0.03], 8), (1, 0.8, 0.03), 0),
        "trefoil": implicit_model(tube(trefoil, 0.4), (3.4, 3.4, 1.4), 1),
        "spring": implicit_model(tube(helix, 0.15), (1.2, 1.2, 1.2), 0),
        "bumpy ball": implicit_model(bumpy, (1.15, 1.15, 1.15), 0),
        "bowl": implicit_model(bowl, (1, 1, 1), 0),
    }


# -------------------------------------------------------------------------------------- the tables


def spoilt(samples, condition, rng):
    noise, outliers, holes = CONDITIONS[condition]
    low, high = samples.min(axis=0), samples.max(axis=0)
    diagonal = np.linalg.norm(high - low)
    for centre in samples[rng.choice(len(samples), holes, replace=False)]:
        samples = samples[np.linalg.norm(samples - centre, axis=1) > HOLE_RADIUS * diagonal]
    samples = samples + rng.normal(size=samples.shape) * noise / 100 * diagonal
    return np.concatenate([samples, rng.uniform(low, high, (int(outliers * len(samples)), 3))])


def judge(model, samples, condition, seed):
    """For each method: the share of wrong labels, the pieces and the genus, and seconds."""
    rng = np.random.default_rng(seed)
    low, high = samples.min(axis=0), samples.max(axis=0)
    scan = spoilt(samples, condition, rng)
    poles = find_poles(delaunay(enclose(scan)), len(scan))
    diagram = regular_triangulation(poles.centres, poles.radii**2)
    judged = ((poles.centres > low) & (poles.centres < high)).all(axis=1)
    judged &= poles.radii > SMALLEST_BALL * np.linalg.norm(high - low)
    truth = model.inside(poles.centres[judged])
    verdicts = []
    for method in METHODS:
        started = time.process_time()
        labels = label_poles(poles, diagram, method=method)
        seconds = time.process_time() - started
        wrong = 100 * float(np.mean(labels.inside[judged] != truth))
        found = None
        if labels.inside.any():
            shape = topology(crust_faces(poles, diagram, labels.inside).faces)
            found = (shape.components, shape.genus)
        verdicts.append((wrong, found, seconds))
    return verdicts


def cell(verdict, shape):
    wrong, found, _ = verdict
    if found is None:
        return f"{wrong:.2f} (none)"
    return f"{wrong:.2f}" + (f" {found}" if shape not in (None, found) else "")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("models", nargs="*")
    parser.add_argument("--samples", type=int, default=5000)
    parser.add_argument("--seed", type=int, default=0)
    chosen = parser.parse_args()
    models = analytic_models()
    folder = Path(os.environ["SYMRECON_DATA"]) / "meshes"
    models |= {path.stem: mesh_model(path) for path in sorted(folder.glob("*.ply"))}
    models = {name: models[name] for name in chosen.models or models}

    print("Wrong labels in %,", " | ".join(METHODS), "; (pieces, genus) where they are wrong\n")
    print("| model |", " | ".join(CONDITIONS), "|")
    print("|---" * (1 + len(CONDITIONS)) + "|")
    results = {}
    for name, model in models.items():
        cells = []
        samples = model.sample(chosen.samples, np.random.default_rng(chosen.seed))
        for condition in CONDITIONS:
            verdicts = judge(model, samples, condition, chosen.seed + 1)
            results[name, condition] = verdicts
            cells.append(" / ".join(cell(verdict, model.shape) for verdict in verdicts))
        print(f"| {name} |", " | ".join(cells), "|", flush=True)

    known = [name for name, model in models.items() if model.shape is not None]
    print("\n| over all models | mean wrong % | largest wrong % | right topology | seconds |")
    print("|---|---|---|---|---|")
    for condition in CONDITIONS:
        for k, method in enumerate(METHODS):
            wrong = [results[name, condition][k][0] for name in models]
            right = sum(results[name, condition][k][1] == models[name].shape for name in known)
            seconds = sum(results[name, condition][k][2] for name in models)
            print(
                f"| {condition}, {method} | {np.mean(wrong):.3f} | {max(wrong):.2f} "
                f"| {right} of {len(known)} | {seconds:.2f} |"
            )


if __name__ == "__main__":
    main()
