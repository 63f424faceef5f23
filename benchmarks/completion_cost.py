"""CPU time and memory of mirror completion alone, each size in a process of its own.

    python benchmarks/completion_cost.py [--sizes 10000 100000 1000000] [--model bust] [--repeats 3]

The scan lacks a quarter of the model and has normals; the plane is the true one.  Memory is the
growth of the peak of resident memory while the filter runs, MeshLab's own copies included.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from pathlib import Path

from completion_scans import CONDITIONS, case_of
from damage import Damage
from peers import MEGABYTE, resident
from symmetry_models import model

DAMAGE = CONDITIONS["region"]


def child(name: str, size: int) -> dict[str, float]:
    """Complete one scan; return the cost."""
    import pymeshlab

    from meshlab_symrecon import apply_filter
    from meshlab_symrecon.geometry.plane_quads import planes_as_quads

    case = case_of(model(name, 1), Damage(removal=DAMAGE.removal, count=size), 1)
    mesh_set = pymeshlab.MeshSet()
    mesh_set.add_mesh(pymeshlab.Mesh(case.points))
    mesh_set.compute_normal_for_point_clouds()
    quads = planes_as_quads(case.planes[:1], case.points)
    mesh_set.add_mesh(pymeshlab.Mesh(*quads), "reflection planes")
    mesh_set.set_current_mesh(0)
    reset = Path("/proc/self/clear_refs")
    if reset.exists():
        reset.write_text("5")  # the peak starts anew
    before, started = resident("VmRSS"), time.process_time()
    measures = apply_filter(mesh_set, "generate_mirror_completed_points")
    return {
        "seconds": time.process_time() - started,
        "megabytes": (resident("VmHWM") - before) / MEGABYTE,
        "measured": measures["measured"],
        "mirrored": measures["mirrored"],
    }


def measured(name: str, size: int) -> dict[str, float]:
    """Run the child; return what it says."""
    one_thread = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
    done = subprocess.run(
        [sys.executable, __file__, "--model", name, "--child", str(size)],
        env={**os.environ, **one_thread},
        capture_output=True,
        text=True,
        check=True,
    )
    return json.loads(done.stdout.splitlines()[-1])


def main() -> None:
    """Print one line a size."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sizes", nargs="+", type=int, default=[10_000, 100_000, 1_000_000])
    parser.add_argument("--model", default="bust")
    parser.add_argument("--repeats", type=int, default=3, help="the quickest counts")
    parser.add_argument("--child", type=int, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.child:
        print(json.dumps(child(options.model, options.child)))
        return
    print("| samples | measured | mirrored | CPU s | peak MB | bytes a point |")
    print("| --- | --- | --- | --- | --- | --- |")
    for size in options.sizes:
        runs = [measured(options.model, size) for _ in range(options.repeats)]
        best = min(runs, key=lambda run: run["seconds"])
        each = best["megabytes"] * MEGABYTE / (best["measured"] + best["mirrored"])
        print(
            f"| {size} | {best['measured']} | {best['mirrored']} | {best['seconds']:.2f} "
            f"| {best['megabytes']:.0f} | {each:.0f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
