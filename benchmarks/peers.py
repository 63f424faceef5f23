"""Ways from points to a surface, each measured in a process of its own.

    python benchmarks/peers.py METHOD SAMPLES.npy RESULT.npz

`measured` starts such a process.  CPU seconds are user and system time; memory is the growth of the
peak of resident memory, without imports and inputs.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

MEGABYTE = 2**20
WARM_UP = 500  # samples
NOTHING = np.zeros((0, 3))


@dataclass(frozen=True)
class Run:
    """What a method did."""

    seconds: float = np.nan
    megabytes: float = np.nan  # more than before
    peak_megabytes: float = np.nan  # of the whole process
    points: np.ndarray = field(default_factory=lambda: NOTHING)
    faces: np.ndarray = field(default_factory=lambda: NOTHING.astype(np.int64))
    failure: str = ""
    stages: dict[str, float] = field(default_factory=dict)  # wall seconds


Work = Callable[[], dict | None]  # what is measured; measures of our filter
Prepared = tuple[Work, Callable[[], tuple[np.ndarray, np.ndarray]]]  # and then the surface

# ----------------------------------------------------------------------------- the child's side


def cloud(samples: np.ndarray):
    import pymeshlab

    import meshlab_symrecon

    meshlab_symrecon.load_plugins()
    mesh_set = pymeshlab.MeshSet()
    mesh_set.add_mesh(pymeshlab.Mesh(samples))

    def surface():
        mesh = mesh_set.current_mesh()
        return mesh.vertex_matrix(), mesh.face_matrix().astype(np.int64)

    return mesh_set, surface


def power_crust(samples: np.ndarray, surface: str = "power crust") -> Prepared:
    mesh_set, result = cloud(samples)
    return lambda: mesh_set.generate_surface_reconstruction_power_crust(surface=surface), result


def interpolating(samples: np.ndarray) -> Prepared:
    return power_crust(samples, "interpolating")


def screened_poisson(samples: np.ndarray) -> Prepared:
    mesh_set, result = cloud(samples)

    def work():
        mesh_set.compute_normal_for_point_clouds(k=16)
        mesh_set.generate_surface_reconstruction_screened_poisson(threads=1)

    return work, result


def ball_pivoting(samples: np.ndarray) -> Prepared:
    mesh_set, result = cloud(samples)

    def work():
        mesh_set.compute_normal_for_point_clouds(k=16)
        mesh_set.generate_surface_reconstruction_ball_pivoting()

    return work, result


def cgal_insertions(samples: np.ndarray) -> Prepared:
    """CGAL's two triangulations, of our samples and of the polar balls our power diagram is of."""
    from CGAL.CGAL_Kernel import Point_3, Weighted_point_3
    from CGAL.CGAL_Triangulation_3 import (
        Delaunay_triangulation_3,
        Regular_triangulation_3,
    )

    from meshlab_symrecon.powercrust.recipe import Recipe
    from meshlab_symrecon.powercrust.stages import Stages
    from meshlab_symrecon.powercrust.usable_poles import usable_poles

    poles = usable_poles(samples, Recipe(keep_outliers=True), Stages()).poles
    points = [Point_3(*site) for site in poles.sites.tolist()]
    balls = [
        Weighted_point_3(Point_3(*centre), weight)
        for centre, weight in zip(poles.centres.tolist(), (poles.radii**2).tolist(), strict=True)
    ]
    kept = []  # both exist at the end, as ours do

    def work():
        kept.append(Delaunay_triangulation_3())
        kept[0].insert(points)
        kept.append(Regular_triangulation_3())
        kept[1].insert(balls)

    return work, lambda: (NOTHING, NOTHING.astype(np.int64))


METHODS: dict[str, Callable[[np.ndarray], Prepared]] = {
    "power crust": power_crust,
    "interpolating": interpolating,
    "CGAL's insertions": cgal_insertions,
    "screened Poisson": screened_poisson,
    "ball pivoting": ball_pivoting,
}


def resident(which: str) -> float:
    """Return VmRSS, or its peak VmHWM, in bytes; NaN where the system does not tell."""
    status = Path("/proc/self/status")
    lines = status.read_text().splitlines() if status.exists() else []
    return next((1024.0 * int(li.split()[1]) for li in lines if li.startswith(which)), np.nan)


def child(method: str, samples: Path, result: Path) -> None:
    cloud_points = np.load(samples)
    METHODS[method](cloud_points[:WARM_UP])[0]()  # so that everything is imported
    work, surface = METHODS[method](cloud_points)
    reset = Path("/proc/self/clear_refs")
    if reset.exists():
        reset.write_text("5")  # the peak starts anew
    before, started = resident("VmRSS"), time.process_time()
    measures = work() or {}
    seconds, peak = time.process_time() - started, resident("VmHWM")
    points, faces = surface()
    stages = measures.get("seconds", {})
    np.savez(
        result,
        cost=[seconds, (peak - before) / MEGABYTE, peak / MEGABYTE],
        points=points,
        faces=faces,
        stages=list(stages),
        stage_seconds=np.array(list(stages.values()), dtype=float),
    )


# ----------------------------------------------------------------------------- the parent's side


def measured(method: str, samples: np.ndarray, limit: float) -> Run:
    """Run a method in a process of its own, for at most `limit` seconds."""
    one_thread = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
    with tempfile.TemporaryDirectory() as folder:
        given, result = Path(folder, "samples.npy"), Path(folder, "result.npz")
        np.save(given, samples)
        try:
            done = subprocess.run(
                [sys.executable, __file__, method, given, result],
                env={**os.environ, **one_thread},
                capture_output=True,
                text=True,
                timeout=limit,
                check=False,
            )
        except subprocess.TimeoutExpired:
            return Run(failure=f"not done after {limit:.0f} s")
        if done.returncode:
            last = done.stderr.strip().splitlines()[-1:]
            return Run(failure=" ".join(last) or f"ended with {done.returncode}")
        with np.load(result) as found:
            stages = dict(zip(found["stages"].tolist(), found["stage_seconds"], strict=True))
            return Run(*found["cost"], found["points"], found["faces"], stages=stages)


if __name__ == "__main__":
    child(sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3]))
