"""A complete filter of one's own: move the current layer's points along an axis.

In the package's pyproject.toml:

    [project.entry-points."meshlab_symrecon.filters"]
    shift = "shift_filter:FILTER"
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from meshlab_symrecon.plugin import (
    Filter,
    Layers,
    Outcome,
    ParameterSet,
    Progress,
    choice,
    diagonal_fraction,
)


class Parameters(ParameterSet):
    """How far, and where to."""

    axis: str = choice("x", ("x", "y", "z"), "Axis", "Direction of the shift.")
    length: float = diagonal_fraction(0.1, "Length", "How far to shift.")


def run(layers: Layers, parameters: Parameters, progress: Progress) -> Outcome:
    """Return a shifted copy of the current layer."""
    source = layers.current
    diagonal = np.linalg.norm(np.ptp(source.points, axis=0))
    step = np.zeros(3)
    step["xyz".index(parameters.axis)] = parameters.length * diagonal
    moved = replace(source, points=source.points + step, label="shifted", identifier=-1)
    return Outcome((moved,), measures={"step": step})


FILTER = Filter(
    menu_name="Shift Points",
    python_name="generate_shifted_points",
    summary="Copy a layer, moved along an axis.",
    description="Adds the layer `shifted`.",
    parameters=Parameters,
    run=run,
    meshlab_class="Layer",
    category="Creation/Sampling",
    creates=("shifted",),
)
