"""How time and memory of the Power Crust filter grow with the number of samples.

    python benchmarks/crust_growth.py [--samples 10000 100000 1000000] [--surface "power crust"]

Samples of a bumpy torus, each number in a process of its own, through a MeshSet.  Prints CPU time,
memory (growth, and peak of the whole process), the wall time of each stage, and whether ten times
100 000 samples take no more than 12 times the time, and the process no more than 2.5 GB.
"""

from __future__ import annotations

import argparse

import numpy as np
from models import bumpy_torus, scan
from peers import Run, measured

SMALL, LARGE = 100_000, 1_000_000
MOST_TIME = 12.0  # time of LARGE / time of SMALL
MOST_MEMORY = 2.5e9  # bytes, for LARGE samples
LIMIT = 600.0  # seconds


def report(count: int, run: Run) -> None:
    if run.failure:
        print(f"{count:8d} samples: {run.failure}", flush=True)
        return
    stages = ", ".join(f"{name} {seconds:.2f}" for name, seconds in run.stages.items())
    print(
        f"{count:8d} samples: {run.seconds:6.2f} s CPU, {run.megabytes:5.0f} MB more, "
        f"{run.peak_megabytes:5.0f} MB in all, {len(run.faces)} triangles\n          {stages}",
        flush=True,
    )


def verdict(runs: dict[int, Run]) -> None:
    if SMALL in runs and LARGE in runs:
        growth = runs[LARGE].seconds / runs[SMALL].seconds
        print(f"time({LARGE}) / time({SMALL}) = {growth:.1f}, at most {MOST_TIME:g}: ", end="")
        print("kept" if growth <= MOST_TIME else "missed")
    if LARGE in runs:
        peak = runs[LARGE].peak_megabytes * 2**20
        print(f"peak memory {peak / 1e9:.2f} GB, at most {MOST_MEMORY / 1e9:g}: ", end="")
        print("kept" if peak <= MOST_MEMORY else "missed")


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--samples", type=int, nargs="+", default=[10_000, SMALL, LARGE])
    parser.add_argument(
        "--surface", choices=("power crust", "interpolating"), default="power crust"
    )
    options = parser.parse_args()
    model = bumpy_torus()
    runs = {}
    for count in options.samples:
        samples = scan(model, count, noise=0.0, outliers=0.0, seed=0)
        runs[count] = measured(options.surface, np.ascontiguousarray(samples), LIMIT)
        report(count, runs[count])
    verdict(runs)


if __name__ == "__main__":
    main()
