"""The picture of docs/completion.md: what exact mirror images miss, and what asymmetry mends.

    SYMRECON_DATA=... python benchmarks/completion_picture.py docs/pictures/completion.png

The Louvre Demosthenes is a photoscan by ryanfb (CC BY 4.0). He leans and turns his head, so that
no plane mirrors one side onto the other.
"""

from __future__ import annotations

import argparse
from dataclasses import replace

import numpy as np
from completion_measures import heights_over
from damage import Damage, remaining, side_plane
from symmetry_models import model

from meshlab_symrecon.pictures.deviation_colours import deviation_colours
from meshlab_symrecon.pictures.deviation_map import colour_bar
from meshlab_symrecon.pictures.figure import Panel, save_panels
from meshlab_symrecon.pictures.projection import fit, open_screen
from meshlab_symrecon.pictures.renderer import render
from meshlab_symrecon.pictures.scene import MEASURED, PointCloud
from meshlab_symrecon.pictures.viewpoint import disc_radius, view_of_missing_side
from meshlab_symrecon.symmetry import detect_reflection_planes, mirror_complete

SIZE = (640, 820)
LIMIT = 0.02  # diagonals: the deepest colours
SAMPLES, SURFACE = 60_000, 200_000


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("path")
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    shape = model("demosthenes", 0)
    low, high = shape.box
    centre, diagonal = (low + high) / 2, float(np.linalg.norm(high - low))
    truth = shape.sample(SURFACE, np.random.default_rng(0))
    rng = np.random.default_rng(given.seed)
    samples, normals = shape.sample(SAMPLES, rng)
    plane = side_plane(shape, centre, rng)
    kept = remaining(samples, normals, plane, Damage(), (shape, centre, diagonal), rng)
    scan = samples[kept]
    planes = detect_reflection_planes(scan).planes
    exact, leaning = (mirror_complete(scan, planes, blend=width) for width in (0.0, 0.25))
    camera = view_of_missing_side(exact.points, exact.mirrored, planes)
    camera = fit(replace(camera, up=shape.up), exact.points, SIZE, margin=0.02)
    panels = []
    for points, mirrored, name in (
        (scan, np.zeros(len(scan), bool), "The scan"),
        (exact.points, exact.mirrored, "Exact mirror images"),
        (leaning.points, leaning.mirrored, "With the statue's asymmetry"),
    ):
        off = heights_over(points[mirrored], *truth) / diagonal
        colours = np.tile(np.array(MEASURED, dtype=np.uint8), (len(points), 1))
        colours[mirrored] = deviation_colours(off, np.ones(len(off), bool), LIMIT)
        radius = disc_radius(open_screen(camera, [points], *SIZE), points)
        image = render([PointCloud(points, colours, radius=radius)], camera, SIZE)
        panels.append(Panel(image, name, (_words(np.abs(100 * off), len(points)),)))
    panels.append(Panel(colour_bar(100 * LIMIT, "%", SIZE[1])))
    save_panels(given.path, panels)


def _words(off, count: int) -> str:
    """Say how far invented points are from the true surface, in % of the diagonal."""
    if len(off) == 0:
        return f"{count} points, a quarter is missing"
    return f"off by {np.median(off):.2f} % (median), {np.quantile(off, 0.95):.1f} % (95 %)"


if __name__ == "__main__":
    main()
