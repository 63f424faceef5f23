"""Surface Reconstruction: Power Crust."""

from __future__ import annotations

from typing import Any

import numpy as np

from meshlab_symrecon.arrays import Floats
from meshlab_symrecon.errors import GeometryError
from meshlab_symrecon.plugin import (
    Citation,
    Filter,
    Layer,
    Layers,
    Outcome,
    ParameterSet,
    Progress,
    boolean,
    choice,
    spacing_multiple,
)
from meshlab_symrecon.powercrust.attributes import carry_over
from meshlab_symrecon.powercrust.labelling import METHODS
from meshlab_symrecon.powercrust.recipe import SURFACES, Recipe
from meshlab_symrecon.powercrust.reconstruction import PowerCrust, reconstruct
from meshlab_symrecon.provenance import MIRRORED, paint_by_share

LABEL = "power crust"
AXIS_LABEL = "medial axis"
CLOSED = 0.9  # share of the time for the surface itself
AUTOMATIC = -1.0
HULL_WARNING = (
    "the points are too few or too flat to tell inside from outside, "
    "so the surface is their convex hull"
)


class Parameters(ParameterSet):
    """Parameters of the Power Crust."""

    surface: str = choice(
        SURFACES[0],
        SURFACES,
        "Surface",
        "'power crust': the walls between inner and outer balls, about four triangles a point, "
        "which noise tangles least. 'interpolating': triangles between the "
        "measured points themselves, two a point, so that every vertex is a point of the scan.",
    )
    labelling: str = choice(
        METHODS[0],
        METHODS,
        "Labelling",
        "How inner balls are told from outer ones. 'min cut' weighs all evidence and bears noise "
        "and holes; 'propagation' is the queue of the original program.",
    )
    smallestball: float = spacing_multiple(
        AUTOMATIC,
        "Smallest ball",
        "Smaller polar balls are dropped, which smooths noise and blunts thin parts. 0 keeps all; "
        "-1 chooses by the noise of the points.",
        low=AUTOMATIC,
    )
    keepoutliers: bool = boolean(
        False,
        "Keep outliers",
        "Use points that are far from all others like any other, instead of leaving them out.",
    )
    widestcap: float = spacing_multiple(
        0.0,
        "Widest cap",
        "Leave holes of the scan open that are wider than this. 0 closes all, so that the surface "
        "bounds a solid.",
    )
    paint: bool = boolean(
        False,
        "Paint",
        "Colour the surface by its share invented, where quality is 0 for measured points and 1 "
        "for mirrored ones, instead of the colours of the points.",
    )
    medialaxis: bool = boolean(
        False,
        "Medial axis",
        "Also add the medial axis as a layer, with the radius of its balls as quality.",
    )
    axisnoise: float = spacing_multiple(
        0.0,
        "Noise of the axis",
        "Leave out parts of the medial axis with smaller balls, which come from noise.",
    )
    axisredundancy: float = spacing_multiple(
        0.0,
        "Redundancy of the axis",
        "Leave out balls of the medial axis that stick out of a larger one next to them by less.",
    )
    outeraxis: bool = boolean(
        False,
        "Outer axis",
        "Also add the medial axis of the space round the surface.",
    )


def run(layers: Layers, parameters: Parameters, progress: Progress) -> Outcome:
    """Reconstruct the current layer's points."""
    source = layers.current
    crust = reconstruct(
        source.points,
        _recipe(parameters),
        progress=lambda share, stage: progress(CLOSED * share, stage),
    )
    added = [_surface(source, crust, progress, paint=parameters.paint)]
    if parameters.medialaxis or parameters.outeraxis:
        axis = crust.axis
        added.append(Layer(axis.points, axis.faces, label=AXIS_LABEL, quality=axis.radii))
    progress(1.0, "done")
    warnings = (HULL_WARNING,) if crust.hull else ()
    return Outcome(tuple(added), current=0, measures=_measures(crust), warnings=warnings)


def _recipe(parameters: Parameters) -> Recipe:
    automatic = parameters.smallestball < 0.0
    return Recipe(
        surface=parameters.surface,
        labelling=parameters.labelling,
        smallest_ball=None if automatic else parameters.smallestball,
        keep_outliers=parameters.keepoutliers,
        widest_cap=parameters.widestcap,
        with_axis=parameters.medialaxis or parameters.outeraxis,
        with_outer_axis=parameters.outeraxis,
        axis_noise=parameters.axisnoise,
        axis_redundancy=parameters.axisredundancy,
    )


def _measures(crust: PowerCrust) -> dict[str, Any]:
    shape = crust.topology
    return {
        "closed": shape.closed,
        "edge_manifold": shape.edge_manifold,
        "vertex_manifold": shape.vertex_manifold,
        "components": shape.components,
        "genus": shape.genus,
        "vertices": len(crust.points),
        "faces": len(crust.faces),
        "largest_cap": crust.largest_cap,
        "opened_caps": crust.opened,
        "outliers": crust.outliers,
        "poles": crust.poles,
        "dropped_poles": crust.dropped_poles,
        "unlabelled_poles": crust.unreached_poles,
        "flipped_poles": crust.flipped_poles,
        "seconds": dict(crust.seconds),
    }


def _surface(source: Layer, crust: PowerCrust, progress: Progress, *, paint: bool) -> Layer:
    def carried(values: Floats | None, low: float) -> Floats | None:
        if values is None:
            return None
        share = (1.0 - CLOSED) / 3
        return carry_over(
            source.points,
            values,
            crust.points,
            progress=lambda done: progress(low + share * done, "carrying over attributes"),
        )

    quality = carried(source.quality, CLOSED)
    colours = carried(source.colours, (1.0 + 2.0 * CLOSED) / 3)
    if paint:
        colours = paint_by_share(np.asarray(carried(_shares(source), (2.0 + CLOSED) / 3)))
    return Layer(crust.points, crust.faces, label=LABEL, colours=colours, quality=quality)


def _shares(source: Layer) -> Floats:
    """Return which points were invented: as a completion has marked them, or else by quality.

    Raises
    ------
    GeometryError
        Nothing tells, since quality is something else.
    """
    shares = source.attributes.get(MIRRORED, source.quality)
    if shares is None:
        return np.zeros(len(source.points))
    if not ((shares >= 0.0) & (shares <= 1.0)).all():
        message = (
            f"paint needs quality from 0 (measured) to 1 (mirrored) in layer '{source.label}'; got "
            f"{float(shares.min()):.3g} to {float(shares.max()):.3g}; leave paint out, or complete "
            "the scan first"
        )
        raise GeometryError(message)
    return np.asarray(shares, dtype=np.float64)


FILTER = Filter(
    menu_name="Surface Reconstruction: Power Crust",
    python_name="generate_surface_reconstruction_power_crust",
    aliases=("power_crust_reconstruct",),
    summary="Wrap a point cloud in a closed surface, without normals.",
    description=(
        "Finds the poles of the points' Voronoi cells, builds the power diagram of their balls in "
        "exact arithmetic, tells inner balls from outer ones, and returns the walls between them "
        "as triangles. The surface is closed and manifold by construction: holes of the cloud are "
        "capped. Colours, and quality such as the share invented, come from the nearest points. "
        "Points far from all others are left out, and the small balls of noisy clouds are.\n\n"
        "Returns what the surface is (`closed`, `edge_manifold`, `vertex_manifold`, `components`, "
        "`genus`, `vertices`, `faces`), the width of the `largest_cap` over a hole in multiples of "
        "the spacing there, how many caps were opened (`opened_caps`), how many points were left "
        "out as `outliers`, how many `poles` there are, how many of them were dropped for their "
        "size (`dropped_poles`), were reached by no evidence (`unlabelled_poles`) or belonged to "
        "pieces too small to keep (`flipped_poles`), and the `seconds` of each stage."
    ),
    parameters=Parameters,
    run=run,
    meshlab_class="Remeshing",
    category="Creation/Reconstruction",
    requires=("points",),
    creates=(LABEL, AXIS_LABEL),
    citations=(
        Citation(
            "N. Amenta, S. Choi, R. K. Kolluri",
            "The power crust",
            "ACM Symposium on Solid Modeling and Applications",
            2001,
            "10.1145/376957.376986",
        ),
    ),
)
