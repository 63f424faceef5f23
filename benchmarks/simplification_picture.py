"""The picture of docs/simplification.md: a statue from as many points, spread evenly and by detail.

    SYMRECON_DATA=... python benchmarks/simplification_picture.py docs/pictures/simplification.png

The bust of Nefertiti is in the public domain.
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path

from models import load, scan
from simplification import distances, poisson_disk

from meshlab_symrecon.clustering.simplification import simplify
from meshlab_symrecon.pictures.figure import Panel, save_panels
from meshlab_symrecon.pictures.projection import Camera, fit
from meshlab_symrecon.pictures.renderer import render
from meshlab_symrecon.pictures.scene import INVENTED, PointCloud, TriangleMesh
from meshlab_symrecon.powercrust.recipe import Recipe
from meshlab_symrecon.powercrust.reconstruction import reconstruct

SIZE = (560, 800)
SAMPLES, KEEP = 50_000, 2_500
TOWARDS, UP = (0.55, -0.12, -0.85), (0.0, 1.0, 0.0)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("path")
    model = load(Path(os.environ["SYMRECON_DATA"], "meshes", "nefertiti.ply"))
    samples = scan(model, SAMPLES, 0.0, 0.0, 0)
    even = poisson_disk(samples, KEEP)
    ours = samples[simplify(samples, count=len(even)).chosen]
    camera = fit(Camera(TOWARDS, UP), model.points, SIZE, margin=0.03)
    panels = []
    for name, cloud in (("Poisson-disk", even), ("Simplify Points (AP)", ours)):
        crust = reconstruct(cloud, Recipe(with_axis=False))
        largest, mean = distances(model, cloud)
        kept = [PointCloud(cloud, INVENTED, radius=2.6), TriangleMesh(model.points, model.faces)]
        surface = [TriangleMesh(crust.points, crust.faces)]
        panels += [
            Panel(render(kept, camera, SIZE), name, (f"{len(cloud)} of {SAMPLES} points",)),
            Panel(
                render(surface, camera, SIZE),
                "Its Power Crust",
                (f"off by {mean:.3f} % of the diagonal, {largest:.2f} % at most",),
            ),
        ]
    save_panels(parser.parse_args().path, panels)


if __name__ == "__main__":
    main()
