"""Time and peak memory of detection, by the number of points.

    python benchmarks/detection_growth.py [--points 7000 100000 1000000 5000000] [--model NAME]

A model (`shapes.py`, or of SYMRECON_DATA) with a quarter removed on one side and noise of 0.1 % of
the diagonal, detected in a process of its own, which starts from this small one: a process begins
with the peak of its parent.  CPU seconds are the best of some runs, next to the first one; memory
is the peak of the whole process, and how much of it came on top of imports and points.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

LIMIT = 600.0  # seconds


def peak_megabytes() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def detect(path: str, runs: int) -> None:
    """Detect, in this process, and print what it took."""
    from meshlab_symrecon.symmetry.detection import detect_reflection_planes

    points = np.load(path)
    before = peak_megabytes()
    times, walls = [], []
    for _ in range(runs):
        wall, start = time.perf_counter(), time.process_time()
        found = detect_reflection_planes(points)
        times.append(time.process_time() - start)
        walls.append(time.perf_counter() - wall)
    run = {"seconds": min(times), "first": times[0], "wall": min(walls)}
    run |= {"before": before, "peak": peak_megabytes()}
    run |= {"points": len(points), "planes": len(found.planes)}
    print(json.dumps(run))


def make(path: str, name: str, count: int, seed: int) -> None:
    """Write about ``count`` points that are left of a model."""
    from damage import CONDITIONS, damaged
    from symmetry_models import model

    damage = CONDITIONS["r25"]
    damage = replace(damage, noise=0.1, count=round(count / (1 - damage.share)))
    np.save(path, damaged(model(name, seed), damage, seed).points)


def started(*arguments: object) -> subprocess.CompletedProcess:
    command = [sys.executable, __file__, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=LIMIT)


def main() -> None:
    match sys.argv[1:]:  # the parts that run in processes of their own
        case ["--make", path, name, count, seed]:
            return make(path, name, int(count), int(seed))
        case ["--detect", path, runs]:
            return detect(path, int(runs))
    return compare()


def compare() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--points", nargs="+", type=int, default=[7_000, 100_000, 1_000_000, 5_000_000]
    )
    parser.add_argument("--model", default="bust", help="its name")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    print("| points | CPU s | first run | wall s | peak MB | more than before MB | planes |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for count in options.points:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "points.npy")
            done = started("--make", path, options.model, count, options.seed)
            if done.returncode == 0:
                done = started("--detect", path, options.runs)
        if done.returncode:
            reason = (done.stderr.strip().splitlines() or ["killed"])[-1]
            print(f"| {count} | {reason} | | | | | |", flush=True)
            continue
        run = json.loads(done.stdout)
        print(
            f"| {run['points']} | {run['seconds']:.2f} | {run['first']:.2f} | {run['wall']:.2f} "
            f"| {run['peak']:.0f} | {run['peak'] - run['before']:.0f} | {run['planes']} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
