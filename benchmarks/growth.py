"""How time and memory grow with the number of points: detection, completion, crust.

    python benchmarks/growth.py [--points 10000 100000 1000000 10000000] [--crust 1000000]
                                [--statues nefertiti demosthenes] [--rows rows.json]

Scans of two statues (SYMRECON_DATA/meshes): even random points with noise of .05 % of the diagonal
and their normals, 15 % missing on one side.  Each number is that of a process of its own, which
loads the layers it needs from files, as `symrecon apply` does.  Prints a Markdown table: CPU time
of the filter, peak of the whole process, and how much of that a point takes, without imports.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

LIMIT = 3_600.0  # seconds
NOISE, MISSING = 0.0005, 0.15  # of the diagonal, of the surface
BLOCK = 1 << 20  # points made at once
DETECT = "generate_reflection_planes"
COMPLETE = "generate_mirror_completed_points"
CRUST = "generate_surface_reconstruction_power_crust"
HEADER = (
    "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\n"
    "property float z\nproperty float nx\nproperty float ny\nproperty float nz\nend_header\n"
)


# ----------------------------------------------------------------------- in processes of their own


def make(name: str, count: int, path: Path) -> None:
    """Write a scan of a statue."""
    from models import chosen_models

    [model] = chosen_models([name])
    rng = np.random.default_rng(0)
    a, b, c = (model.points[model.faces[:, corner]] for corner in range(3))
    upright = np.cross(b - a, c - a)
    areas = np.linalg.norm(upright, axis=1)
    normals = upright / np.maximum(areas, 1e-300)[:, None]
    gap = model.points[rng.integers(len(model.points))]
    order = np.argsort(np.linalg.norm((a + b + c) / 3.0 - gap, axis=1))
    areas[order[np.cumsum(areas[order]) < MISSING * areas.sum()]] = 0.0
    ends = np.cumsum(areas) / areas.sum()
    with path.open("wb") as file:
        file.write(HEADER.format(count).encode())
        for start in range(0, count, BLOCK):
            size = min(BLOCK, count - start)
            face = np.minimum(np.searchsorted(ends, rng.random(size)), len(ends) - 1)
            across, along = np.sqrt(rng.random((size, 1))), rng.random((size, 1))
            places = a[face] + across * (b[face] - a[face]) + across * along * (c[face] - b[face])
            places += rng.normal(scale=NOISE * model.diagonal, size=(size, 3))
            file.write(np.hstack([places, normals[face]]).astype("<f4").tobytes())


def memory(field: str) -> int:
    lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    return int(next(line.split()[1] for line in lines if line.startswith(field))) * 1024


def work(stage: str, folder: Path) -> dict[str, float]:
    """Run one stage on the files of the stages before it, and say what it took."""
    from meshlab_symrecon.host.files import load, save_current
    from meshlab_symrecon.host.registration import apply_filter

    before = memory("VmRSS")
    mesh_set = None
    if stage == COMPLETE:
        mesh_set = load(folder / "reflection planes.ply")
    mesh_set = load(folder / ("completed.ply" if stage == CRUST else "scan.ply"), mesh_set)
    points = mesh_set.current_mesh().vertex_number()
    started, wall = time.process_time(), time.perf_counter()
    apply_filter(mesh_set, stage)
    run = {"seconds": time.process_time() - started, "wall": time.perf_counter() - wall}
    if stage == DETECT:
        mesh_set.set_current_mesh(max(mesh.id() for mesh in mesh_set))
        save_current(mesh_set, folder / "reflection planes.ply")
    elif stage == COMPLETE:
        save_current(mesh_set, folder / "completed.ply")
    return run | {"points": points, "before": before, "peak": memory("VmHWM")}


# ------------------------------------------------------------------------------- the parent's side


def started(*arguments: object) -> str:
    command = [sys.executable, __file__, *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT, check=False)
    if done.returncode:
        raise SystemExit((done.stderr.strip().splitlines() or [f"killed: {arguments}"])[-1])
    return done.stdout


def grown(name: str, count: int, most_crust: int, runs: int) -> list[dict]:
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        started("--make", name, count, Path(folder, "scan.ply"))
        for stage in (DETECT, COMPLETE, CRUST):
            if stage == CRUST and count > most_crust:
                continue
            tries = [json.loads(started("--work", stage, folder)) for _ in range(runs)]
            best = min(tries, key=lambda run: run["seconds"])
            rows.append({"statue": name, "stage": stage, **best})
            print(line(rows[-1]), flush=True)
    return rows


def line(row: dict) -> str:
    points, more = row["points"], row["peak"] - row["before"]
    return (
        f"| {row['statue']} | {points} | `{row['stage']}` | {row['seconds']:.2f} "
        f"| {1e6 * row['seconds'] / points:.1f} | {row['peak'] / 1e9:.2f} | {more / points:.0f} |"
    )


def main() -> None:
    match sys.argv[1:]:
        case ["--make", name, count, path]:
            return make(name, int(count), Path(path))
        case ["--work", stage, folder]:
            return print(json.dumps(work(stage, Path(folder))))
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    sizes = [10_000, 100_000, 1_000_000, 10_000_000]
    parser.add_argument("--points", type=int, nargs="+", default=sizes)
    parser.add_argument("--crust", type=int, default=1_000_000, help="largest scan it is made of")
    parser.add_argument("--statues", nargs="+", default=["nefertiti", "demosthenes"])
    parser.add_argument("--runs", type=int, default=1, help="the one of least CPU time counts")
    parser.add_argument("--rows", type=Path, help="also write the numbers to this file")
    options = parser.parse_args()
    print("| statue | points | filter | CPU s | µs a point | peak GB | bytes a point |")
    print("| --- | ---: | --- | ---: | ---: | ---: | ---: |")
    rows = []
    for count in options.points:
        for name in options.statues:
            rows += grown(name, count, options.crust, options.runs)
            if options.rows:
                options.rows.write_text(json.dumps(rows, indent=1), encoding="utf-8")
    return None


if __name__ == "__main__":
    main()
