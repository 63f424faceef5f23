"""The picture of docs/detection.md: three made scans and the planes found in them.

python benchmarks/plane_pictures.py docs/pictures/planes.png
"""

from __future__ import annotations

import argparse
from dataclasses import replace

import numpy as np
from damage import CONDITIONS, damaged
from symmetry_models import model

from meshlab_symrecon.pictures.figure import Panel, save_panels
from meshlab_symrecon.pictures.projection import Camera, open_screen
from meshlab_symrecon.pictures.renderer import render
from meshlab_symrecon.pictures.scene import PointCloud, plane_sheet
from meshlab_symrecon.pictures.viewpoint import disc_radius
from meshlab_symrecon.symmetry import detect_reflection_planes

SIZE = (620, 760)
COUNT = 60_000
SCENES = (  # model, seed, damage, what to say, azimuth and elevation of the view
    ("bust", 4, "r50", "Half a bust\nnothing overlaps: the rim tells", (62.0, 12.0)),
    ("jug", 2, "r25", "A jug\nits body fits all round: the handle tells", (35.0, 18.0)),
    ("star_5", 1, "r25", "A star\nall its planes, each of them once", (30.0, 42.0)),
)


def view(azimuth: float, elevation: float) -> Camera:
    """Look from an azimuth round z, and from above."""
    turn, rise = np.radians([azimuth, elevation])
    towards = np.array([np.cos(turn) * np.cos(rise), np.sin(turn) * np.cos(rise), np.sin(rise)])
    x, y, z = (-towards).tolist()
    return Camera((x, y, z), (0.0, 0.0, 1.0))


def panel(name: str, seed: int, condition: str, caption: str, angles: tuple[float, float]) -> Panel:
    scan = damaged(
        model(name, seed), replace(CONDITIONS[condition], count=COUNT, posed=False), seed
    )
    points = scan.points
    found = detect_reflection_planes(points)
    up = np.array([0.0, 0.0, 1.0])
    sheets = [
        plane_sheet(plane, points, up if abs(plane[2]) < 0.9 else [1.0, 0.0, 0.0])
        for plane in found.planes
    ]
    everything = [points, *(sheet.corners for sheet in sheets)]
    screen = open_screen(view(*angles), everything, *SIZE)
    items = [PointCloud(points, radius=disc_radius(screen, points)), *sheets]
    heading, line = caption.split("\n")
    sure = f"{len(found.planes)} of {max(1, len(scan.planes))} found"
    return Panel(render(items, view(*angles), SIZE), heading, (line, sure))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("path")
    save_panels(parser.parse_args().path, [panel(*scene) for scene in SCENES])


if __name__ == "__main__":
    main()
