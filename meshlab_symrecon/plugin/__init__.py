"""What a filter author imports. It knows neither algorithms nor pymeshlab."""

from __future__ import annotations

from meshlab_symrecon.plugin.filter import Citation, Filter, Progress
from meshlab_symrecon.plugin.layers import Layer, Layers, Outcome, VertexScalars
from meshlab_symrecon.plugin.parameter_sets import (
    ParameterSet,
    boolean,
    choice,
    diagonal_fraction,
    integer,
    layer,
    number,
    spacing_multiple,
    text,
)

__all__ = [
    "Citation",
    "Filter",
    "Layer",
    "Layers",
    "Outcome",
    "ParameterSet",
    "Progress",
    "VertexScalars",
    "boolean",
    "choice",
    "diagonal_fraction",
    "integer",
    "layer",
    "number",
    "spacing_multiple",
    "text",
]
