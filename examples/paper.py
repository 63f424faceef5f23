"""The experiments of the paper again: Squirrel and Twirl, incomplete, completed and reconstructed.

    SYMRECON_DATA=... python examples/paper.py figure.png

*Incomplete Surface Reconstruction for Statue Point Cloud based on Symmetry* shows two models in one
figure: the complete cloud, its surface, the incomplete cloud, and the surface of what the method
makes of it. The figure drawn here has the same arrangement, and the paper's counts are printed
beside ours.

The models may not be handed on, so they are not part of this package. `twirl.off` comes with
MeshLab's samples (github.com/cnr-isti-vclab/meshlab, folder `sample`), `squirrel.obj` with
github.com/sgsellan/reach-for-the-spheres (folder `data`). Sample 7000 and 9000 points of them, and
cut a part off so that 5235 and 6711 stay. Four clouds belong into the folder `incomplete` below
SYMRECON_DATA: the incomplete ones as `twirl_7000_5235.ply` and `squirrel_9000_6711.ply`, and all
points of them as `twirl_7000_5235_complete.ply` and `squirrel_9000_6711_complete.ply`.
"""

from __future__ import annotations

import argparse
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pymeshlab
from matplotlib.figure import Figure

import meshlab_symrecon
from meshlab_symrecon.pictures.projection import Camera, fit, open_screen
from meshlab_symrecon.pictures.renderer import render
from meshlab_symrecon.pictures.scene import Item, PointCloud, TriangleMesh, colours_by_share
from meshlab_symrecon.pictures.viewpoint import disc_radius

SIZE = (520, 620)  # pixels of a panel
DPI = 100
INK, FAINT = "#2e2a26", "#857d73"
PAPER = "#faf8f5"
COLUMNS = ("Complete cloud", "Its surface", "Incomplete cloud", "Our surface")
CAPTION = (
    "Limestone is measured, verdigris is invented by reflection. Twirl as published in the public "
    "collections maps onto itself by half a turn\nand has no mirror plane: the method says so, and "
    "our surface there is the Power Crust of what was measured."
)


@dataclass(frozen=True)
class Statue:
    """A model of the paper: its file, its counts there, and from where it is seen."""

    name: str
    file: str
    complete: int
    incomplete: int
    camera: Camera


UP = (0.0, 1.0, 0.0)
STATUES = (
    Statue("Twirl", "twirl_7000_5235", 7000, 5235, Camera((-0.5, -0.25, -0.85), UP)),
    Statue("Squirrel", "squirrel_9000_6711", 9000, 6711, Camera((-0.75, -0.2, -0.6), UP)),
)


@dataclass(frozen=True)
class Result:
    """What the four panels of a row show."""

    complete: np.ndarray
    whole: TriangleMesh
    incomplete: np.ndarray
    surface: TriangleMesh
    planes: int
    mirrored: int


def power_crust(cloud: Path) -> TriangleMesh:
    """Return the surface of a cloud as it is."""
    document = pymeshlab.MeshSet()
    document.load_new_mesh(str(cloud))
    document.generate_surface_reconstruction_power_crust()
    mesh = document.current_mesh()
    return TriangleMesh(mesh.vertex_matrix(), mesh.face_matrix().astype(np.int64))


def repeat(statue: Statue, folder: Path) -> Result:
    """Do to a statue what the paper does: planes, mirror images, surface."""
    document = pymeshlab.MeshSet()
    document.load_new_mesh(str(folder / f"{statue.file}.ply"))
    incomplete = document.current_mesh().vertex_matrix()
    document.compute_normal_for_point_clouds()
    found = document.generate_reflection_planes()
    mirrored = 0
    if len(found["planes"]):
        mirrored = document.generate_mirror_completed_points()["mirrored"]
    document.generate_surface_reconstruction_power_crust()
    made = document.current_mesh()
    share = made.vertex_scalar_array() if mirrored else np.zeros(made.vertex_number())
    surface = TriangleMesh(
        made.vertex_matrix(), made.face_matrix().astype(np.int64), colours_by_share(share)
    )
    complete = folder / f"{statue.file}_complete.ply"
    whole = pymeshlab.MeshSet()
    whole.load_new_mesh(str(complete))
    return Result(
        whole.current_mesh().vertex_matrix(),
        power_crust(complete),
        incomplete,
        surface,
        len(found["planes"]),
        mirrored,
    )


def panels(statue: Statue, result: Result) -> list[np.ndarray]:
    """Draw the row of a statue, all from one place."""
    camera = fit(statue.camera, result.complete, SIZE, margin=0.05)

    def cloud(points: np.ndarray) -> Item:
        screen = open_screen(camera, [points], *SIZE)
        return PointCloud(points, radius=0.55 * disc_radius(screen, points))

    scenes = (cloud(result.complete), result.whole, cloud(result.incomplete), result.surface)
    return [render([item], camera, SIZE) for item in scenes]


def lines(result: Result) -> tuple[str, ...]:
    """Say in numbers what each panel of a row shows."""
    invented = f"{result.mirrored} points invented" if result.planes else "no mirror plane"
    return (
        f"{len(result.complete)} points",
        f"{len(result.whole.faces)} triangles",
        f"{len(result.incomplete)} points",
        f"{len(result.surface.faces)} triangles, {invented}",
    )


def save(rows: list[tuple[Statue, Result]], path: str) -> None:
    """Lay the panels out as in the paper: a row a statue."""
    width, height, head, foot, side = SIZE[0], SIZE[1] + 50, 60, 90, 60
    total = side + width * len(COLUMNS), head + height * len(rows) + foot
    figure = Figure(figsize=(total[0] / DPI, total[1] / DPI), dpi=DPI, facecolor=PAPER)

    def write(x: float, y: float, words: str, size: float, colour: str, turn: float = 0.0) -> None:
        figure.text(
            x / total[0], 1 - y / total[1], words, size=size, color=colour,
            ha="center", va="center", rotation=turn,
        )  # fmt: skip

    for column, heading in enumerate(COLUMNS):
        write(side + (column + 0.5) * width, head / 2, heading, 18, INK)
    for row, (statue, result) in enumerate(rows):
        top = head + row * height
        write(side / 2, top + SIZE[1] / 2, statue.name, 18, INK, 90.0)
        for column, (image, words) in enumerate(
            zip(panels(statue, result), lines(result), strict=True)
        ):
            left = side + column * width
            figure.figimage(image, left, total[1] - top - SIZE[1], origin="upper")
            write(left + width / 2, top + SIZE[1] + 20, words, 13, FAINT)
    write(total[0] / 2, total[1] - foot / 2, CAPTION, 13, FAINT)
    figure.savefig(path, metadata={"Software": None})


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("path", help="the figure, a PNG")
    path = parser.parse_args().path
    data = os.environ.get("SYMRECON_DATA")
    if not data:
        raise SystemExit("SYMRECON_DATA is unset. " + " ".join(__doc__.split("\n\n")[-1].split()))
    meshlab_symrecon.load_plugins()
    rows = []
    for statue in STATUES:
        result = repeat(statue, Path(data, "incomplete"))
        rows.append((statue, result))
        print(f"{statue.name}: complete {statue.complete} points in the paper,", end=" ")
        print(f"{len(result.complete)} here; incomplete {statue.incomplete} in the paper,", end=" ")
        print(f"{len(result.incomplete)} here; mirror planes: {result.planes};", end=" ")
        print(f"{result.mirrored} points invented, {len(result.surface.faces)} triangles")
    save(rows, path)


if __name__ == "__main__":
    main()
