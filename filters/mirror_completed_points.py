"""Mirror-Complete Points."""

from __future__ import annotations

import numpy as np

from meshlab_symrecon.arrays import Booleans, Floats, Planes
from meshlab_symrecon.errors import GeometryError
from meshlab_symrecon.geometry.plane_quads import PLANES_LABEL, planes_of_pieces
from meshlab_symrecon.plugin import (
    Filter,
    Layer,
    Layers,
    Outcome,
    ParameterSet,
    Progress,
    diagonal_fraction,
    integer,
    layer,
    spacing_multiple,
)
from meshlab_symrecon.symmetry.completion import GAP, mirror_complete

LABEL = "completed points"
MIRRORED = "mirrored"

NO_PLANES = (
    f"there is no layer '{PLANES_LABEL}', so nothing was mirrored; "
    "detect planes first, or draw one and name its layer"
)


class Parameters(ParameterSet):
    """Parameters of the completion."""

    planes: int = layer(
        -1,
        "Planes",
        f"The layer whose rectangles are the mirror planes; -1 takes the newest '{PLANES_LABEL}'.",
    )
    maxplanes: int = integer(
        64,
        "Most planes",
        "How many planes of that layer to use, from the first: each completes what the ones "
        "before it have left.",
        low=1,
        high=64,
    )
    gap: float = spacing_multiple(
        GAP,
        "Gap",
        "A mirrored point is added where no point is nearer than this.",
        low=0.1,
        high=100.0,
    )
    blend: float = diagonal_fraction(
        0.0,
        "Blend",
        "Width of the seam over which mirrored points lean towards the measured surface; "
        "0 keeps exact mirror images. Measured points never move.",
        high=0.5,
    )


def run(layers: Layers, parameters: Parameters, progress: Progress) -> Outcome:
    """Complete the current layer's points across the planes of the planes layer."""
    source = layers.current
    planes, warnings = _planes(layers, parameters)
    planes = planes[: parameters.maxplanes]
    completed = mirror_complete(
        source.points,
        planes,
        normals=source.normals,
        colours=source.colours,
        gap=parameters.gap,
        blend=parameters.blend,
        progress=progress,
    )
    share = _share_invented(source, completed.mirrored)
    added = Layer(
        completed.points,
        np.zeros((0, 3), dtype=np.int64),
        label=LABEL,
        normals=completed.normals,
        colours=completed.colours,
        quality=share,
        attributes={MIRRORED: share},
    )
    mirrored = int(np.count_nonzero(share))
    measures = {"measured": len(share) - mirrored, "mirrored": mirrored}
    return Outcome((added,), current=0, measures=measures, warnings=warnings)


def _share_invented(source: Layer, added: Booleans) -> Floats:
    """Return 1 for every mirrored point, those of an earlier completion included; 0 elsewhere."""
    share: Floats = added.astype(np.float64)
    earlier = source.attributes.get(MIRRORED)
    if earlier is not None:
        share[: len(earlier)] = np.asarray(earlier) != 0.0
    return share


def _planes(layers: Layers, parameters: Parameters) -> tuple[Planes, tuple[str, ...]]:
    """Return the planes to mirror across, and what to tell the user.

    Without a planes layer there are none: a script goes on with what was measured.
    """
    if parameters.planes >= 0:
        chosen: Layer | None = layers.get(parameters.planes)
    else:
        chosen = layers.newest(PLANES_LABEL)
    if chosen is None:
        return np.zeros((0, 4)), (NO_PLANES,)
    planes = planes_of_pieces(chosen.points, chosen.faces)
    if not len(planes):
        message = (
            f"a planes layer needs a rectangle or triangle a plane; layer '{chosen.label}' has "
            "no faces; detect planes first, or draw one"
        )
        raise GeometryError(message)
    return planes, ()


FILTER = Filter(
    menu_name="Mirror-Complete Points",
    python_name="generate_mirror_completed_points",
    aliases=("mirror_complete_points",),
    summary="Fill what a scan lacks with mirror images of what it has.",
    description=(
        f"Reads the planes of the layer `{PLANES_LABEL}` (detected, moved or drawn by hand) and "
        "mirrors the current layer's points across them where nothing was measured. Adds the "
        f"layer `{LABEL}`: the measured points first, in their order, bit for bit, then the "
        "mirrored ones with mirrored normals and copied colours. Vertex quality and the custom "
        "attribute `mirrored` are 0 for measured points and 1 for mirrored ones; what an earlier "
        "completion has mirrored stays 1. Without such a layer nothing is mirrored, and a warning "
        "says so.\n\n"
        "Returns the counts `measured` and `mirrored`."
    ),
    parameters=Parameters,
    run=run,
    meshlab_class="PointSet",
    category="Creation/Sampling",
    arity="VARIABLE",
    requires=("points",),
    creates=(LABEL,),
)
