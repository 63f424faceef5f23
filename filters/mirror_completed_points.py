"""Mirror-Complete Points."""

from __future__ import annotations

from typing import Any

import numpy as np

from meshlab_symrecon.arrays import Booleans, Floats, Planes
from meshlab_symrecon.errors import ParameterError
from meshlab_symrecon.geometry.plane_quads import PLANES_LABEL, planes_of_pieces
from meshlab_symrecon.plugin import (
    Filter,
    Layer,
    Layers,
    Outcome,
    ParameterSet,
    Progress,
    boolean,
    diagonal_fraction,
    integer,
    layer,
    spacing_multiple,
)
from meshlab_symrecon.provenance import MIRRORED, paint_by_share
from meshlab_symrecon.symmetry.completion import BLEND, GAP, CompletedPoints, mirror_complete

LABEL = "completed points"
SCAN_QUALITY = "scan_quality"

NO_PLANES = (
    f"there is no layer '{PLANES_LABEL}', so nothing was mirrored; "
    "detect planes first, or draw one and name its layer"
)
NO_NORMALS = (
    "the scan has no normals, so the mirrored points have none either, and thin parts may be taken "
    "for both of their sides; run compute_normal_for_point_clouds first"
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
    plane: int = integer(
        -1,
        "Plane",
        "The number of the only plane to use, 0 the first of the layer; -1 uses all.",
        low=-1,
        high=63,
    )
    gap: float = spacing_multiple(
        GAP,
        "Gap",
        "A mirrored point is added where no point is nearer than this.",
        low=0.1,
        high=100.0,
    )
    blend: float = diagonal_fraction(
        BLEND,
        "Blend",
        "How far the difference between the two sides of the statue, seen where both were "
        "measured, is carried into the mirrored part; 0 keeps exact mirror images. Measured points "
        "never move.",
        high=1.0,
    )
    onlyselected: bool = boolean(
        False,
        "Only selected",
        "Mirror the selected points only; the others still count as measured.",
    )
    paint: bool = boolean(
        False,
        "Paint",
        "Colour measured and mirrored points instead of copying the scan's colours.",
    )


def run(layers: Layers, parameters: Parameters, progress: Progress) -> Outcome:
    """Complete the current layer's points across the planes of the planes layer."""
    source = layers.current
    planes, warnings = _planes(layers, parameters)
    completed = mirror_complete(
        source.points,
        planes,
        normals=source.normals,
        colours=source.colours,
        gap=parameters.gap,
        blend=parameters.blend,
        source=source.required_selection() if parameters.onlyselected else None,
        progress=progress,
    )
    share = _share_invented(source, completed.mirrored)
    carried = {name: values[completed.source] for name, values in _scalars(source).items()}
    added = Layer(
        completed.points,
        np.zeros((0, 3), dtype=np.int64),
        label=LABEL,
        normals=completed.normals,
        colours=paint_by_share(share) if parameters.paint else completed.colours,
        quality=share,
        attributes={**carried, MIRRORED: share},
    )
    if source.normals is None and len(planes):
        warnings = (*warnings, NO_NORMALS)
    return Outcome((added,), measures=_measures(completed, share), warnings=warnings)


def _measures(completed: CompletedPoints, share: Floats) -> dict[str, Any]:
    mirrored = int(np.count_nonzero(share))
    return {
        "measured": len(share) - mirrored,
        "mirrored": mirrored,
        "scattered": completed.scattered,
        "plinth": completed.plinth,
        "open_rims": completed.open_rims,
    }


def _scalars(source: Layer) -> dict[str, Floats]:
    """Return the scan's custom scalars, and its quality unless that is provenance."""
    scalars = {name: np.asarray(values) for name, values in source.attributes.items()}
    quality, earlier = source.quality, _earlier_share(source)
    if quality is not None and (earlier is None or not np.array_equal(quality, earlier)):
        scalars.setdefault(SCAN_QUALITY, quality)
    return scalars


def _share_invented(source: Layer, added: Booleans) -> Floats:
    """Return 1 for every mirrored point, those of an earlier completion included; 0 elsewhere."""
    share: Floats = added.astype(np.float64)
    earlier = _earlier_share(source)
    if earlier is not None:
        share[: len(earlier)] = earlier != 0.0
    return share


def _earlier_share(source: Layer) -> Floats | None:
    """Return what an earlier completion has marked; from a file, only quality is left of it."""
    if MIRRORED in source.attributes:
        return np.asarray(source.attributes[MIRRORED])
    quality = source.quality
    if quality is None or quality[0] != 0.0 or not np.isin(quality, (0.0, 1.0)).all():
        return None
    return None if (np.diff(quality) < 0.0).any() else quality


def _planes(layers: Layers, parameters: Parameters) -> tuple[Planes, tuple[str, ...]]:
    """Return the planes to mirror across, and what to tell the user.

    Without a planes layer there are none: a script goes on with what was measured.
    """
    chosen = layers.beside_current(parameters.planes, PLANES_LABEL)
    if chosen is None:
        return np.zeros((0, 4)), (NO_PLANES,)
    planes = planes_of_pieces(chosen.points, chosen.faces)
    if parameters.plane >= len(planes):
        message = (
            f"plane must be the number of a plane of layer '{chosen.label}', 0 to "
            f"{len(planes) - 1}; got {parameters.plane}; use -1 for all"
        )
        raise ParameterError(message)
    only = slice(parameters.plane, parameters.plane + 1)
    return planes[: parameters.maxplanes] if parameters.plane < 0 else planes[only], ()


FILTER = Filter(
    menu_name="Mirror-Complete Points",
    python_name="generate_mirror_completed_points",
    aliases=("mirror_complete_points",),
    summary="Fill what a scan lacks with mirror images of what it has.",
    description=(
        f"Reads the planes of the layer `{PLANES_LABEL}` (detected, moved or drawn by hand) and "
        "mirrors the current layer's points across them where nothing was measured. Adds the "
        f"layer `{LABEL}`: the measured points first, in their order, bit for bit, then the "
        "mirrored ones with mirrored normals, copied colours and copied custom scalars. Vertex "
        "quality and the custom attribute `mirrored` are 0 for measured points and 1 for mirrored "
        "ones; what an earlier completion has mirrored stays 1, and a quality of the scan's own "
        f"goes on as the custom attribute `{SCAN_QUALITY}`. Clutter, and a plinth that is not its "
        "own mirror image, are not mirrored. The fill is no denser than what was measured round "
        "it. Without a planes layer nothing is mirrored, and a warning says so.\n\n"
        "Returns the counts `measured` and `mirrored`, how many measured points were not mirrored "
        "because they lie on no surface (`scattered`) or on such a `plinth`, and `open_rims`: "
        "centre and width of every hole that is missing on both sides, widest first, (k, 4)."
    ),
    parameters=Parameters,
    run=run,
    meshlab_class="PointSet",
    category="Creation/Sampling",
    arity="VARIABLE",
    requires=("points",),
    creates=(LABEL,),
)
