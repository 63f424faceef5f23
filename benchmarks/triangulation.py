"""The kernel's triangulations against those of the cgal wheel, in one run.

    python benchmarks/triangulation.py [SAMPLES]

Delaunay triangulation of samples of a bumpy torus, and regular triangulation of their poles: CPU
seconds and cells of both. CGAL's time is that of its insertion alone.
"""

from __future__ import annotations

import sys
import time

import numpy as np
from CGAL.CGAL_Kernel import Point_3, Weighted_point_3
from CGAL.CGAL_Triangulation_3 import Delaunay_triangulation_3, Regular_triangulation_3

from meshlab_symrecon.geometry.triangulation import delaunay, regular_triangulation
from meshlab_symrecon.powercrust.poles import enclose, find_poles


def bumpy_torus(count: int) -> np.ndarray:
    rng = np.random.default_rng(0)
    u, v = rng.random((2, count)) * 2 * np.pi
    tube = 0.35 + 0.05 * np.sin(5 * u) * np.cos(4 * v) + 0.02 * np.sin(13 * u + 3 * v)
    ring = 1 + tube * np.cos(v)
    return np.stack([ring * np.cos(u), ring * np.sin(u), tube * np.sin(v)], axis=1)


def timed(work):
    started = time.process_time()
    result = work()
    return result, time.process_time() - started


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 100_000
    sites = enclose(bumpy_torus(count))
    ours, seconds = timed(lambda: delaunay(sites))
    points = [Point_3(*map(float, site)) for site in sites]
    theirs, their_seconds = timed(lambda: Delaunay_triangulation_3(points))
    report("Delaunay", len(sites), len(ours.cells), seconds, theirs, their_seconds)

    poles = find_poles(ours, count)
    weights = poles.radii**2
    ours, seconds = timed(lambda: regular_triangulation(poles.centres, weights))
    balls = [
        Weighted_point_3(Point_3(*map(float, centre)), float(weight))
        for centre, weight in zip(poles.centres, weights, strict=True)
    ]

    def insert():
        regular = Regular_triangulation_3()
        regular.insert(balls)
        return regular

    theirs, their_seconds = timed(insert)
    report("regular", len(balls), len(ours.cells), seconds, theirs, their_seconds)


def report(name, sites, cells, seconds, theirs, their_seconds) -> None:
    print(
        f"{name:9s} {sites:8d} sites  ours {seconds:.2f} s {cells} cells  "
        f"cgal {their_seconds:.2f} s {theirs.number_of_finite_cells()} cells"
    )


if __name__ == "__main__":
    main()
