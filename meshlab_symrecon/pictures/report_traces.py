"""The layers of a reconstruction as traces of plotly."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np

from meshlab_symrecon.arrays import Faces, Floats
from meshlab_symrecon.errors import SymReconError
from meshlab_symrecon.pictures.deviation_colours import STOPS
from meshlab_symrecon.pictures.report_drawing import DIMMEST, Levels, Singles
from meshlab_symrecon.pictures.scene import INVENTED, MEASURED, PLANE

__all__ = [
    "Colour",
    "cloud_trace",
    "deviation_trace",
    "figure_text",
    "plotly_script",
    "sheet_traces",
    "surface_trace",
]

Colour: TypeAlias = tuple[int, int, int]

DARKEST = 0.42  # of a colour is left where the least light falls
LIGHTING = {
    "ambient": 0.44, "diffuse": 0.68, "specular": 0.06, "roughness": 0.8, "fresnel": 0.05,
    "facenormalsepsilon": 0.0, "vertexnormalsepsilon": 0.0,
}  # fmt: skip
SUN = {"x": -4e4, "y": -6e4, "z": 9e4}  # far away, above the viewer's left shoulder
COVERING = 700.0  # pixels: points of this size / sqrt(count) look like a surface
SIZES = (2.2, 7.0)  # pixels: the smallest and the largest point


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


def figure_text(traces: Sequence[Any], layout: Mapping[str, Any]) -> str:
    """Return a figure as JSON in which no angle bracket can end a script."""
    text: str = _plotly()[0].Figure(list(traces), layout).to_json()
    return text.replace("<", "\\u003c").replace(">", "\\u003e")


def _css(colour: Sequence[float]) -> str:
    return "rgb({:.0f},{:.0f},{:.0f})".format(*colour)


def _scale(colours: Sequence[Sequence[float]]) -> list[tuple[float, str]]:
    """Return evenly spaced colours as a scale."""
    places = np.linspace(0.0, 1.0, len(colours)).tolist()
    return [(place, _css(colour)) for place, colour in zip(places, colours, strict=True)]


def surface_trace(placed: Singles, faces: Faces, share: Floats) -> Any:
    """Return a surface, coloured by the share invented of its vertices."""
    x, y, z = placed.T
    i, j, k = faces.T.astype(np.int32)
    levels = np.round(255.0 * np.clip(share, 0.0, 1.0)).astype(np.uint8)
    return _plotly()[0].Mesh3d(
        x=x, y=y, z=z, i=i, j=j, k=k, intensity=levels, cmin=0, cmax=255, showscale=False,
        colorscale=_scale((MEASURED, INVENTED)), hoverinfo="skip", lighting=LIGHTING,
        lightposition=SUN,
    )  # fmt: skip


def sheet_traces(corners: Singles) -> tuple[Any, Any]:
    """Return a translucent sheet and its border."""
    objects = _plotly()[0]
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


def cloud_trace(placed: Singles, light: Levels, colour: Colour) -> Any:
    """Return points in one colour under the light that falls on them."""
    dark = [DARKEST * channel for channel in colour]
    marker = {
        "size": _size(len(placed)), "color": light, "cmin": DIMMEST, "cmax": 255,
        "colorscale": _scale((dark, colour)), "line": {"width": 0},
    }  # fmt: skip
    return _points(placed, marker, hoverinfo="skip")


def deviation_trace(placed: Singles, deviation: Floats, limit: float) -> Any:
    """Return points coloured by their deviation, from ``-limit`` to ``limit``."""
    marker = {
        "size": _size(len(placed)) + 0.6,  # over the same points of the scan
        "color": deviation.astype(np.float32), "cmin": -limit, "cmax": limit,
        "colorscale": [((place + 1.0) / 2.0, _css(colour)) for place, colour in STOPS],
        "line": {"width": 0},
    }  # fmt: skip
    return _points(placed, marker, hovertemplate="%{marker.color:.4g}<extra></extra>")


def _points(placed: Singles, marker: Mapping[str, Any], **hover: str) -> Any:
    x, y, z = placed.T
    return _plotly()[0].Scatter3d(x=x, y=y, z=z, mode="markers", marker=marker, **hover)


def _size(count: int) -> float:
    """Return a diameter in pixels at which so many points look like a surface."""
    return float(np.clip(round(COVERING / np.sqrt(max(count, 1)), 1), *SIZES))
