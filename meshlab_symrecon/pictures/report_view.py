"""The interactive view of a reconstruction: its layers, and where the viewer stands."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from meshlab_symrecon.arrays import Floats, Planes
from meshlab_symrecon.pictures.deviation_colours import (
    STOPS,
    UNKNOWN,
    UNSIGNED_STOPS,
    colour_limit,
)
from meshlab_symrecon.pictures.projection import Camera
from meshlab_symrecon.pictures.report_drawing import (
    Frame,
    Singles,
    shading,
    upright_frame,
)
from meshlab_symrecon.pictures.report_scene import ReportScene
from meshlab_symrecon.pictures.report_traces import (
    Colour,
    cloud_trace,
    deviation_trace,
    figure_text,
    sheet_traces,
    surface_trace,
)
from meshlab_symrecon.pictures.scene import INVENTED, MEASURED, PLANE

__all__ = ["DrawnLayer", "View", "draw_view"]

ROOM = 1.01  # half the box of the view / half that of what is in it: plotly cuts what sticks out
ACROSS = 24  # steps in which the view is told how wide the object is
FIELD = np.tan(np.pi / 8.0)  # half of plotly's field of view


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
    deviation_span: float  # at either end of the scale; 0 without deviations


def draw_view(scene: ReportScene) -> View:
    """Return the layers of a reconstruction as an interactive view; thin out large ones first.

    Raises
    ------
    SymReconError
        plotly is missing.
    """
    camera, sheets = scene.camera(), [sheet.corners for sheet in scene.sheets()]
    everything = np.concatenate([scene.completed, scene.surface, *sheets])
    frame = upright_frame(everything, scene.up(), np.array(camera.direction))
    limit = _span(scene.deviation)
    stack = Stack()
    stack.add(
        "surface", "Surface", (MEASURED, INVENTED) if scene.mirrored.any() else (MEASURED,),
        surface_trace(frame.place(scene.surface), scene.faces, scene.share), visible=True,
    )  # fmt: skip
    if sheets:
        drawn = [trace for sheet in sheets for trace in sheet_traces(frame.place(sheet))]
        words = "Mirror plane" if len(sheets) == 1 else "Mirror planes"
        stack.add("planes", words, (PLANE,), *drawn, visible=True)
    _add_clouds(stack, scene, frame, limit)
    placed = frame.place(everything)
    return View(
        figure_text(stack.traces, _layout(placed)), tuple(stack.layers),
        json.dumps(_start(camera, scene.planes, frame, placed)), frame, limit,
    )  # fmt: skip


def _add_clouds(stack: Stack, scene: ReportScene, frame: Frame, limit: float) -> None:
    """Add the scan, the invented points, and the map of deviation."""
    placed, light = frame.place(scene.scan), shading(scene.scan_normals, scene.scan, frame)
    stack.add(
        "scan", "Scan (measured points)", (MEASURED,), cloud_trace(placed, light, MEASURED)
    )  # fmt: skip
    if scene.mirrored.any():
        lit = shading(scene.completed_normals, scene.completed, frame)[scene.mirrored]
        cloud = cloud_trace(frame.place(scene.completed[scene.mirrored]), lit, INVENTED)
        stack.add("invented", "Invented points", (INVENTED,), cloud)
    if scene.deviation is not None and limit > 0.0:
        known = np.isfinite(scene.deviation)
        stops = STOPS if scene.signed else UNSIGNED_STOPS
        stack.add(
            "deviation", "Deviation from the mirror image", tuple(colour for _, colour in stops),
            deviation_trace(placed[known], scene.deviation[known], limit),
            cloud_trace(placed[~known], light[~known], UNKNOWN),
        )  # fmt: skip


@dataclass(slots=True)
class Stack:
    """Layers with their traces, while a view is being put together."""

    layers: list[DrawnLayer] = field(default_factory=list)
    traces: list[Any] = field(default_factory=list)

    def add(
        self, name: str, words: str, colours: tuple[Colour, ...], *drawn: Any, visible: bool = False
    ) -> None:
        """Add a layer on top."""
        numbers = range(len(self.traces), len(self.traces) + len(drawn))
        self.layers.append(DrawnLayer(name, words, colours, tuple(numbers), visible))
        for trace in drawn:
            trace.visible = visible
            self.traces.append(trace)


def _span(deviation: Floats | None) -> float:
    """Return the deviation that has the deepest colour; 0 where nothing was compared."""
    if deviation is None or not np.isfinite(deviation).any():
        return 0.0
    known = np.isfinite(deviation)
    return colour_limit(np.where(known, deviation, 0.0), known)


def _layout(placed: Singles) -> dict[str, Any]:
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


def _start(camera: Camera, planes: Planes, frame: Frame, placed: Singles) -> dict[str, Any]:
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
