"""Time, memory and quality of the Power Crust beside its peers, in one run.

    python benchmarks/power_crust.py [--samples 35000 100000] [--noise 0] [--outliers 0] [MODEL ...]

The models are two made here, and those of SYMRECON_DATA/meshes where that variable is set.  Every
method runs in a process of its own, on one thread.  Prints Markdown; the columns are

    CPU s                       user and system time of the whole filter, normals included
    / CGAL                      that time / the time CGAL takes to insert the same samples and poles
    MB, MB/100k                 growth of the peak of resident memory; and that for 100 000 samples
    tri/sample                  triangles a sample
    closed, manifold            no boundary edge; edges and vertices are manifold
    parts, genus                connected components; handles (- unless closed and manifold)
    mean                        mean of the mean distances from result to truth and back
    to truth, from truth        largest distance from result to truth, and back

with distances in % of the model's diagonal, between 100 000 points of either surface (and all
vertices of the result, for the largest) and the other surface.
"""

from __future__ import annotations

import argparse
import itertools

import numpy as np
import pymeshlab
from models import Model, chosen_models, scan
from peers import METHODS, Run, measured

from meshlab_symrecon.geometry.surfaces import topology

CHECKS = 100_000  # points on either surface
INSERTIONS = "CGAL's insertions"
COLUMNS = (
    ("method", 17),
    ("samples", 8),
    ("CPU s", 6),
    ("/ CGAL", 6),
    ("MB", 5),
    ("MB/100k", 7),
    ("tri/sample", 10),
    ("closed", 6),
    ("manifold", 8),
    ("parts", 5),
    ("genus", 5),
    ("mean", 5),
    ("to truth", 8),
    ("from truth", 10),
)


def distances(model: Model, run: Run) -> tuple[float, float, float]:
    """Return mean and largest distances (to the truth, from it) in % of the diagonal."""
    mesh_set = pymeshlab.MeshSet()
    mesh_set.add_mesh(pymeshlab.Mesh(run.points, run.faces))
    mesh_set.add_mesh(pymeshlab.Mesh(model.points, model.faces))

    def one_sided(source: int, target: int, *, vertices: bool) -> dict:
        return mesh_set.get_hausdorff_distance(
            sampledmesh=source,
            targetmesh=target,
            samplevert=vertices,
            sampleface=not vertices,
            samplenum=CHECKS,
            maxdist=pymeshlab.PercentageValue(100),
        )

    there, back = one_sided(0, 1, vertices=False), one_sided(1, 0, vertices=False)
    corners = one_sided(0, 1, vertices=True)
    mean = (there["mean"] + back["mean"]) / 2
    largest = max(there["max"], corners["max"])
    return tuple(100 * value / model.diagonal for value in (mean, largest, back["max"]))


def cells(method: str, count: int, run: Run, reference: float, model: Model) -> list[str]:
    costs = [
        method,
        str(count),
        f"{run.seconds:.2f}",
        f"{run.seconds / reference:.2f}" if np.isfinite(reference) else "",
        f"{run.megabytes:.0f}",
        f"{run.megabytes / count * 100_000:.0f}",
    ]
    if len(run.faces) == 0:
        return costs + [""] * (len(COLUMNS) - len(costs))
    shape = topology(run.faces)
    mean, there, back = distances(model, run)
    return [
        *costs,
        f"{len(run.faces) / count:.1f}",
        "yes" if shape.closed else "no",
        "yes" if shape.edge_manifold and shape.vertex_manifold else "no",
        str(shape.components),
        str(shape.genus) if shape.genus >= 0 else "-",
        f"{mean:.3f}",
        f"{there:.2f}",
        f"{back:.2f}",
    ]


def row(values: list[str]) -> str:
    padded = (
        text.ljust(width) if place == 0 else text.rjust(width)
        for place, (text, (_, width)) in enumerate(zip(values, COLUMNS, strict=True))
    )
    return "| " + " | ".join(padded) + " |"


def compare(model: Model, methods: list[str], options: argparse.Namespace) -> None:
    for noise, outliers in itertools.product(options.noise, options.outliers):
        print(f"\n**{model.name}**, noise {noise:g} %, outliers {100 * outliers:g} %\n")
        print(row([name for name, _ in COLUMNS]))
        print("|" + "|".join("-" * (width + 2) for _, width in COLUMNS) + "|")
        for count in options.samples:
            samples = scan(model, count, noise, outliers, options.seed)
            reference = np.nan
            for method in methods:
                run = measured(method, samples, options.limit)
                if method == INSERTIONS:
                    reference = run.seconds
                if run.failure:
                    print(f"| {method} | {count} | {run.failure} |", flush=True)
                else:
                    print(row(cells(method, count, run, reference, model)), flush=True)


def usable_methods(names: list[str]) -> list[str]:
    """Return the methods asked for, CGAL's first, since the others are compared with it."""
    chosen = sorted(names, key=lambda name: name != INSERTIONS)
    if INSERTIONS not in chosen:
        return chosen
    try:
        import CGAL  # noqa: F401
    except ImportError:
        print("The package cgal is not installed, so there are no ratios to CGAL's insertions.")
        chosen.remove(INSERTIONS)
    return chosen


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("models", nargs="*")
    parser.add_argument("--samples", type=int, nargs="+", default=[35_000, 100_000])
    parser.add_argument("--noise", type=float, nargs="+", default=[0.0], help="%% of the diagonal")
    parser.add_argument("--outliers", type=float, nargs="+", default=[0.0], help="share of samples")
    parser.add_argument("--methods", nargs="+", choices=METHODS, default=list(METHODS))
    parser.add_argument("--limit", type=float, default=60.0, help="seconds for one method")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    methods = usable_methods(options.methods)
    for model in chosen_models(options.models):
        compare(model, methods, options)


if __name__ == "__main__":
    main()
