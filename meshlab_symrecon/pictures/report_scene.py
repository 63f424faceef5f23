"""What a report shows: the arrays of a reconstruction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshlab_symrecon.arrays import Booleans, Faces, Floats, Planes, Points
from meshlab_symrecon.pictures.projection import Camera
from meshlab_symrecon.pictures.report_drawing import even_subset, simplified
from meshlab_symrecon.pictures.scene import PlaneSheet, plane_sheet
from meshlab_symrecon.pictures.viewpoint import upright, view_of_missing_side

__all__ = ["ReportScene", "thinned"]

MOST_POINTS = 80_000  # of the scan that are drawn; of the invented points half as many
MOST_VERTICES = 75_000  # of a surface that are drawn
LYING = 0.9  # cosine from which a plane lies rather than stands


@dataclass(frozen=True, slots=True, eq=False)
class ReportScene:
    """Everything that can be shown of a reconstruction.

    Attributes
    ----------
    scan, scan_normals : (n, 3) float; the normals may be None
        What was measured.
    planes : (k, 4) float
        Mirror planes, the best one first.
    completed, completed_normals : (c, 3) float; the normals may be None
        The points of the scan, in their order, and invented points.
    mirrored : (c,) bool
        Which of them were invented.
    surface, faces : (v, 3) float, (m, 3) int
        The reconstructed surface.
    share : (v,) float
        Share invented of every vertex, 0 to 1.
    deviation : (n,) float or None
        Signed distance of every point of the scan from its mirror image, negative inside; NaN
        where there is nothing to compare with.
    signed : bool
        False: inside and outside could not be told, and no deviation is negative.
    """

    scan: Points
    planes: Planes
    completed: Points
    mirrored: Booleans
    surface: Points
    faces: Faces
    share: Floats
    scan_normals: Points | None = None
    completed_normals: Points | None = None
    deviation: Floats | None = None
    signed: bool = True

    def camera(self) -> Camera:
        """Return the start view, from the side on which points are missing."""
        return view_of_missing_side(self.completed, self.mirrored, self.planes)

    def up(self) -> Floats:
        """Return the direction, (3,), in which the object stands."""
        return upright(self.completed, self.planes)

    def sheets(self) -> list[PlaneSheet]:
        """Return a sheet for each mirror plane, upright unless the plane lies."""
        up = self.up()
        sheets = []
        for plane in self.planes:
            standing = abs(plane[:3] @ up) < LYING
            along = up if standing else np.eye(3)[np.argmin(np.abs(plane[:3]))]
            sheets.append(plane_sheet(plane, self.completed, along))
        return sheets

    def invented_area(self) -> tuple[float, float]:
        """Return the area of the surface, and the share of it that is invented."""
        a, b, c = (self.surface[self.faces[:, corner]] for corner in range(3))
        areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2.0
        area = float(areas.sum())
        invented = float(areas @ self.share[self.faces].mean(axis=1)) if len(areas) else 0.0
        return area, invented / area if area > 0.0 else 0.0


def thinned(scene: ReportScene) -> ReportScene:
    """Return what is drawn of a scene: everything of a small one.

    The completed cloud keeps the points of the scan that are kept, then invented ones.
    """
    kept = even_subset(scene.scan, MOST_POINTS)
    invented = np.flatnonzero(scene.mirrored)
    invented = invented[even_subset(scene.completed[invented], MOST_POINTS // 2)]
    measured = np.flatnonzero(~scene.mirrored)[kept]
    chosen = np.concatenate([measured, invented])
    surface, faces, share = simplified(scene.surface, scene.faces, scene.share, MOST_VERTICES)
    return ReportScene(
        scan=scene.scan[kept],
        planes=scene.planes,
        completed=scene.completed[chosen],
        mirrored=np.arange(len(chosen)) >= len(measured),
        surface=surface,
        faces=faces,
        share=share,
        scan_normals=None if scene.scan_normals is None else scene.scan_normals[kept],
        completed_normals=(
            None if scene.completed_normals is None else scene.completed_normals[chosen]
        ),
        deviation=None if scene.deviation is None else scene.deviation[kept],
        signed=scene.signed,
    )
