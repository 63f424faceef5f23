"""Surface Reconstruction: Power Crust."""

from __future__ import annotations

from meshlab_symrecon.plugin import (
    Citation,
    Filter,
    Layer,
    Layers,
    Outcome,
    ParameterSet,
    Progress,
    boolean,
)
from meshlab_symrecon.powercrust.attributes import carry_over
from meshlab_symrecon.powercrust.reconstruction import PowerCrust, reconstruct

LABEL = "power crust"
AXIS_LABEL = "medial axis"
HULL_WARNING = (
    "the points are too few or too flat to tell inside from outside, "
    "so the surface is their convex hull"
)


class Parameters(ParameterSet):
    """Parameters of the Power Crust."""

    medialaxis: bool = boolean(
        False,
        "Medial axis",
        "Also add the medial axis as a layer, with the radius of its balls as quality.",
    )


def run(layers: Layers, parameters: Parameters, progress: Progress) -> Outcome:
    """Reconstruct the current layer's points."""
    source = layers.current
    crust = reconstruct(source.points, with_axis=parameters.medialaxis, progress=progress)
    added = [_surface(source, crust)]
    if parameters.medialaxis:
        axis = crust.axis
        added.append(Layer(axis.points, axis.faces, label=AXIS_LABEL, quality=axis.radii))
    shape = crust.topology
    measures = {
        "closed": shape.closed,
        "edge_manifold": shape.edge_manifold,
        "vertex_manifold": shape.vertex_manifold,
        "components": shape.components,
        "genus": shape.genus,
        "vertices": len(crust.points),
        "faces": len(crust.faces),
        "poles": crust.poles,
        "unlabelled_poles": crust.unreached_poles,
    }
    warnings = (HULL_WARNING,) if crust.hull else ()
    return Outcome(tuple(added), current=0, measures=measures, warnings=warnings)


def _surface(source: Layer, crust: PowerCrust) -> Layer:
    quality, colours = (
        None if values is None else carry_over(source.points, values, crust.points)
        for values in (source.quality, source.colours)
    )
    return Layer(crust.points, crust.faces, label=LABEL, colours=colours, quality=quality)


FILTER = Filter(
    menu_name="Surface Reconstruction: Power Crust",
    python_name="generate_surface_reconstruction_power_crust",
    aliases=("power_crust_reconstruct",),
    summary="Wrap a point cloud in a closed surface, without normals.",
    description=(
        "Finds the poles of the samples' Voronoi cells, builds the power diagram of their balls in "
        "exact arithmetic, tells inner balls from outer ones, and returns the faces between them "
        "as triangles. The surface is closed and manifold by construction: holes of the cloud are "
        "capped. Colours, and quality such as the share invented, come from the nearest points."
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
