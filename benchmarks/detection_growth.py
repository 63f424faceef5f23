"""Time and peak memory of detection, by the number of points.

    python benchmarks/detection_growth.py [--points 7000 100000 1000000 5000000] [--model NAME]

A model (`shapes.py`, or of SYMRECON_DATA) with a quarter removed on one side and noise of 0.1 % of
the diagonal, detected in a process of its own.  CPU seconds are the best of some runs, first the
time of the first one; memory is the peak of the whole process, and how much of it came on top of
imports and points.
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
from damage import CONDITIONS, damaged
from symmetry_models import model, names

LIMIT = 600.0  # seconds


def peak_megabytes() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def child(path: str, runs: int) -> None:
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
    print(
        json.dumps(
            {
                "seconds": min(times), "first": times[0], "wall": min(walls),
                "before": before, "peak": peak_megabytes(), "planes": len(found.planes),
            }
        )
    )  # fmt: skip


def scan(name: str, count: int, seed: int) -> np.ndarray:
    """About ``count`` points that are left of a model."""
    share = CONDITIONS["r25"].share
    sampled = round(count / (1 - share))
    damage = replace(CONDITIONS["r25"], noise=0.1, count=sampled)
    return damaged(model(name, seed), damage, seed).points


def main() -> None:
    if len(sys.argv) == 4 and sys.argv[1] == "--child":
        child(sys.argv[2], int(sys.argv[3]))
        return
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--points", nargs="+", type=int, default=[7_000, 100_000, 1_000_000, 5_000_000]
    )
    parser.add_argument("--model", choices=names(), default="bust", metavar="NAME")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    print("| points | CPU s | first run | wall s | peak MB | more than before MB | planes |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for count in options.points:
        with tempfile.TemporaryDirectory() as folder:
            path = str(Path(folder, "points.npy"))
            points = scan(options.model, count, options.seed)
            np.save(path, points)
            command = [sys.executable, __file__, "--child", path, str(options.runs)]
            done = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT)
        if done.returncode:
            reason = (done.stderr.strip().splitlines() or ["killed"])[-1]
            print(f"| {len(points)} | {reason} | | | | | |", flush=True)
            continue
        run = json.loads(done.stdout)
        print(
            f"| {len(points)} | {run['seconds']:.2f} | {run['first']:.2f} | {run['wall']:.2f} "
            f"| {run['peak']:.0f} | {run['peak'] - run['before']:.0f} | {run['planes']} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
