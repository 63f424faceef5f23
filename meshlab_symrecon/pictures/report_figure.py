"""The interactive view of a reconstruction: its layers as plotly traces."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from meshlab_symrecon.arrays import Booleans, Faces, Floats, Planes, Points
from meshlab_symrecon.errors import SymReconError
from meshlab_symrecon.pictures.projection import Camera
from meshlab_symrecon.pictures.report_drawing import (
    Frame,
    even_subset,
    shading,
    simplified,
    upright_frame,
)
from meshlab_symrecon.pictures.scene import INVENTED, MEASURED, PLANE, plane_sheet
from meshlab_symrecon.pictures.viewpoint import upright, view_of_missing_side

__all__ = ["DEVIATION_COLOURS", "DrawnLayer", "ReportScene", "View", "draw_view", "plotly_script", "sheet_corners"]

Colour: TypeAlias = tuple[int, int, int]

MOST_POINTS = 80_000  # drawn of the scan; of the invented points half as many
MOST_VERTICES = 75_000  # drawn of the surface
DEVIATION_COLOURS: tuple[tuple[float, Colour], ...] = (
    (0.0, (33, 82, 140)), (0.25, (120, 165, 205)), (0.5, (236, 231, 222)),
    (0.75, (222, 150, 94)), (1.0, (158, 62, 18)),
)  # fmt: skip
"""Blue (inside), paper, orange (outside): told apart by those who see no red or no green."""
SPAN = 0.98  # of the deviations lie within the scale; what lies beyond has its end colours
ROOM = 1.01  # half the box of the view / half that of what is in it: plotly cuts what sticks out
ACROSS = 24  # steps in which the view is told how wide the object is
FIELD = np.tan(np.pi / 8.0)  # half of plotly's field of view
DARKEST = 0.42  # of a colour is left where no light falls


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
        Measured and invented points.
    mirrored : (c,) bool
        Which of them were invented.
    surface, faces : (v, 3) float, (m, 3) int
        The reconstructed surface.
    share : (v,) float
        Share invented of every vertex, 0 to 1.
    deviation : (n,) float or None
        Signed distance of every point of the scan from its mirror image, negative inside; NaN
        where there is nothing to compare with.
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

    def camera(self) -> Camera:
        """Return the start view, from the side on which points are missing."""
        return view_of_missing_side(self.completed, self.mirrored, self.planes)

    def invented_area(self) -> tuple[float, float]:
        """Return the area of the surface, and the share of it that is invented."""
        a, b, c = (self.surface[self.faces[:, corner]] for corner in range(3))
        areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2.0
        area = float(areas.sum())
        invented = float(areas @ self.share[self.faces].mean(axis=1)) if len(areas) else 0.0
        return area, invented / area if area > 0.0 else 0.0


@dataclass(frozen=True, slots=True)
class DrawnLayer:
    """One layer of the view: what its switch says, its traces, and whether they begin visible."""

    name: str
    words: str
    colours: tuple[Colour, ...]  # of its swatch, from one end to the other
    traces: tuple[int, ...]
    visible: bool


@dataclass(frozen=True, slots=True)
class View:
    """The view as text for plotly, and what a page says about it."""

    figure: str  # JSON without any angle bracket
    layers: tuple[DrawnLayer, ...]
    start: str  # JSON: where the viewer stands
    frame: Frame
    drawn: tuple[int, int, int]  # points of the scan, invented points, triangles
    deviation_span: float  # at either end of the scale; 0 without deviations


def _plotly() -> tuple[Any, Any]:
    """Import plotly, which is an extra, only when a report is written."""
    try:
        from plotly import graph_objects, offline
    except ImportError as error:
        message = (
            f"a report needs plotly, which cannot be imported ({error}); "
            'install it with: pip install "meshlab-symrecon[report]"'
        )
        raise SymReconError(message) from error
    return graph_objects, offline


def plotly_script() -> str:
    """Return the whole of plotly.js.

    Raises
    ------
    SymReconError
        plotly is missing.
    """
    script: str = _plotly()[1].get_plotlyjs()
    return script


def draw_view(scene: ReportScene) -> View:
    """Return the layers of a reconstruction as an interactive view.

    Raises
    ------
    SymReconError
        plotly is missing.
    """
    objects, _ = _plotly()
    camera = scene.camera()
    up = upright(scene.completed, scene.planes)
    corners = [sheet_corners(plane, scene, up) for plane in scene.planes]
    everything = np.concatenate([scene.scan, scene.completed, scene.surface, *corners])
    frame = upright_frame(everything, up, np.array(camera.direction))
    limit = _span(scene.deviation)
    traces: list[Any] = []
    layers: list[DrawnLayer] = []

    def add(name: str, words: str, colours: Sequence[Colour], drawn: list[Any], on: bool) -> None:
        numbers = tuple(range(len(traces), len(traces) + len(drawn)))
        layers.append(DrawnLayer(name, words, tuple(colours), numbers, on))
        traces.extend(drawn)

    surface, triangles = _surface(objects, scene, frame)
    colours = (MEASURED, INVENTED) if scene.mirrored.any() else (MEASURED,)
    add("surface", "Surface", colours, [surface], on=True)
    sheets = [trace for sheet in corners for trace in _sheet(objects, frame.place(sheet))]
    if sheets:
        several = len(scene.planes) > 1
        add("planes", "Mirror planes" if several else "Mirror plane", [PLANE], sheets, on=True)
    kept = even_subset(scene.scan, MOST_POINTS)
    cloud = _cloud(objects, scene.scan, scene.scan_normals, kept, frame, MEASURED)
    add("scan", "Scan (measured points)", [MEASURED], [cloud], on=False)
    added = np.flatnonzero(scene.mirrored)
    added = added[even_subset(scene.completed[added], MOST_POINTS // 2)]
    if len(added):
        normals = scene.completed_normals
        cloud = _cloud(objects, scene.completed, normals, added, frame, INVENTED)
        add("invented", "Invented points", [INVENTED], [cloud], on=False)
    if scene.deviation is not None and limit > 0.0:
        map_ = _deviations(objects, scene.scan, scene.deviation, kept, frame, limit)
        ends = [colour for _, colour in DEVIATION_COLOURS]
        add("deviation", "Deviation from the mirror image", ends, [map_], on=False)
    for layer in layers:
        for number in layer.traces:
            traces[number].visible = layer.visible
    placed = frame.place(everything)
    figure = objects.Figure(traces, _layout(placed)).to_json()
    start = json.dumps(_start(camera, scene.planes, frame, placed))
    return View(figure, tuple(layers), start, frame, (len(kept), len(added), triangles), limit)


def _css(colour: Sequence[float]) -> str:
    return "rgb({:.0f},{:.0f},{:.0f})".format(*colour)


def _surface(objects: Any, scene: ReportScene, frame: Frame) -> tuple[Any, int]:
    points, faces, share = simplified(scene.surface, scene.faces, scene.share, MOST_VERTICES)
    x, y, z = frame.place(points).T
    i, j, k = np.ascontiguousarray(faces.T, dtype=np.int32)
    levels = np.round(255.0 * np.clip(share, 0.0, 1.0)).astype(np.uint8)
    mesh = objects.Mesh3d(
        x=x, y=y, z=z, i=i, j=j, k=k, intensity=levels, cmin=0, cmax=255, showscale=False,
        colorscale=[[0.0, _css(MEASURED)], [1.0, _css(INVENTED)]], hoverinfo="skip",
        lighting={"ambient": 0.5, "diffuse": 0.62, "specular": 0.06, "roughness": 0.8,
                  "fresnel": 0.05, "facenormalsepsilon": 0.0, "vertexnormalsepsilon": 0.0},
        lightposition={"x": -4e4, "y": -6e4, "z": 9e4},
    )  # fmt: skip
    return mesh, len(faces)


def sheet_corners(plane: Floats, scene: ReportScene, up: Floats) -> Points:
    """Return the corners of the sheet of a plane; one that lies flat has another side up."""
    along = up if abs(plane[:3] @ up) < 0.9 else np.eye(3)[np.argmin(np.abs(plane[:3]))]
    return plane_sheet(plane, scene.completed, along).corners


def _sheet(objects: Any, corners: Any) -> tuple[Any, Any]:
    """Return a translucent sheet and its border."""
    x, y, z = corners.T
    sheet = objects.Mesh3d(
        x=x, y=y, z=z, i=[0, 0], j=[1, 2], k=[2, 3], color=_css(PLANE), opacity=0.22,
        hoverinfo="skip", lighting={"ambient": 1.0, "diffuse": 0.0, "specular": 0.0},
    )  # fmt: skip
    x, y, z = corners[[0, 1, 2, 3, 0]].T
    border = objects.Scatter3d(
        x=x, y=y, z=z, mode="lines", line={"color": _css(PLANE), "width": 4}, hoverinfo="skip"
    )
    return sheet, border


def _cloud(
    objects: Any, points: Points, normals: Points | None, kept: Any, frame: Frame, colour: Colour
) -> Any:
    """Return points in one colour, lit by their normals."""
    light = shading(normals, points, frame)[kept]
    x, y, z = frame.place(points[kept]).T
    dark = [DARKEST * channel for channel in colour]
    marker = {
        "size": _size(len(kept)), "color": light, "cmin": 255 * 0.45, "cmax": 255,
        "colorscale": [[0.0, _css(dark)], [1.0, _css(colour)]], "line": {"width": 0},
    }  # fmt: skip
    return objects.Scatter3d(x=x, y=y, z=z, mode="markers", marker=marker, hoverinfo="skip")


def _size(count: int) -> float:
    """Return a diameter in pixels at which so many points look like a surface."""
    return float(np.clip(round(700.0 / np.sqrt(max(count, 1)), 1), 2.2, 7.0))


def _span(deviation: Floats | None) -> float:
    """Return the deviation, up or down, that all but the largest stay within."""
    if deviation is None:
        return 0.0
    known = np.abs(deviation[np.isfinite(deviation)])
    return float(np.quantile(known, SPAN)) if len(known) else 0.0


def _deviations(  # noqa: PLR0917
    objects: Any, points: Points, deviation: Floats, kept: Any, frame: Frame, limit: float
) -> Any:
    """Return the points that have a deviation, coloured by it."""
    shown = kept[np.isfinite(deviation[kept])]
    x, y, z = frame.place(points[shown]).T
    marker = {
        "size": _size(len(kept)) + 0.4, "color": deviation[shown].astype(np.float32),
        "cmin": -limit, "cmax": limit, "line": {"width": 0},
        "colorscale": [[place, _css(colour)] for place, colour in DEVIATION_COLOURS],
    }  # fmt: skip
    words = "%{marker.color:.4g}<extra></extra>"
    return objects.Scatter3d(
        x=x, y=y, z=z, mode="markers", marker=marker, hovertemplate=words
    )  # fmt: skip


def _layout(placed: Any) -> dict[str, Any]:
    """Return the layout: equal scales, no axes, no legend of plotly's own."""
    low, high = placed.min(axis=0).astype(float), placed.max(axis=0).astype(float)
    middle, half = (low + high) / 2.0, ROOM * np.maximum((high - low) / 2.0, 1e-3)
    scene: dict[str, Any] = {
        f"{axis}axis": {"visible": False, "range": [float(m - h), float(m + h)]}
        for axis, m, h in zip("xyz", middle, half, strict=True)
    }
    ratio = {axis: 2.0 * float(h) for axis, h in zip("xyz", half, strict=True)}
    return {
        "template": "none", "showlegend": False, "uirevision": "kept",
        "paper_bgcolor": "rgba(0,0,0,0)", "margin": {"l": 0, "r": 0, "t": 0, "b": 0},
        "scene": {**scene, "aspectmode": "manual", "aspectratio": ratio, "dragmode": "turntable"},
    }  # fmt: skip


def _start(camera: Camera, planes: Planes, frame: Frame, placed: Any) -> dict[str, Any]:
    """Return the ways to the viewer and to the mirrored one, and how much room they need.

    How far away the width fits depends on the window: the page reckons it from the ``nearest``
    point in every ``step`` to the side.
    """
    axes = frame.turn(camera.axes())
    back = axes[2]
    other = back * [-1.0, -1.0, 1.0]
    if len(planes):
        normal = frame.turn(planes[0, :3])
        other = back - 2.0 * (back @ normal) * normal
    low, high = placed.min(axis=0).astype(float), placed.max(axis=0).astype(float)
    seen = (placed - (low + high) / 2.0) @ axes.T
    aside, above, near = np.abs(seen[:, 0]), np.abs(seen[:, 1]), seen[:, 2]
    step = max(float(aside.max()), 1e-6) / ACROSS
    bins = np.minimum(aside // step, ACROSS - 1).astype(int)
    nearest = np.full(ACROSS, -2.0)
    np.maximum.at(nearest, bins, near)
    return {
        "back": np.round(back, 6).tolist(),
        "other": np.round(other, 6).tolist(),
        "tall": round(float((near + above / FIELD).max()), 6),  # so far away its height fits
        "step": round(step, 6),
        "nearest": np.round(nearest, 6).tolist(),
    }
