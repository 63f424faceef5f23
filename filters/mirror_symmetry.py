"""Mirror Symmetry Deviation."""

from __future__ import annotations

import numpy as np

from meshlab_symrecon.arrays import Booleans, Floats
from meshlab_symrecon.errors import GeometryError, ParameterError
from meshlab_symrecon.geometry.plane_quads import PLANES_LABEL, planes_of_pieces
from meshlab_symrecon.plugin import (
    Citation,
    Filter,
    Layer,
    Layers,
    Outcome,
    ParameterSet,
    Progress,
    VertexScalars,
    boolean,
    diagonal_fraction,
    integer,
    layer,
)
from meshlab_symrecon.provenance import MIRRORED
from meshlab_symrecon.symmetry.deviation import (
    FARTHEST,
    TOLERANCE,
    MirrorDeviation,
    mirror_deviation,
)

DEVIATION = "mirror_deviation"
COUNTERPART = "has_counterpart"
MIXED = "mixed_quality"  # where some are measured: their distances, and the quality of the others

UNSIGNED = (
    "inside and outside could not be told, so that no distance has a sign; "
    "compute normals that point outwards, or make the faces agree, and measure again"
)


class Parameters(ParameterSet):
    """Parameters of the deviation."""

    planes: int = layer(
        -1,
        "Planes",
        f"The layer whose rectangles are the mirror planes; -1 takes the newest '{PLANES_LABEL}'.",
    )
    plane: int = integer(
        0,
        "Plane",
        "Which plane of that layer is the mirror, counted from 0. Detected planes come best first.",
        low=0,
    )
    tolerance: float = diagonal_fraction(
        TOLERANCE,
        "Tolerance",
        "What still counts as symmetric in the summary: the share of vertices within it is "
        "returned. The distances do not depend on it.",
        low=1e-6,
        high=0.5,
    )
    farthest: float = diagonal_fraction(
        FARTHEST,
        "Farthest counterpart",
        "A surface that is farther from the mirror image belongs to another part, such as the "
        "other arm of a statue in a pose, and is not compared with it.",
        low=1e-6,
        high=0.5,
    )
    onlyselected: bool = boolean(
        False,
        "Only selected vertices",
        "Measure the selected vertices only, against the whole layer; the others keep their "
        "quality. On a mesh without selected vertices, the corners of its selected faces count.",
    )


def run(layers: Layers, parameters: Parameters, progress: Progress) -> Outcome:
    """Measure the current layer against its mirror image; write the distances as its quality."""
    source = layers.current
    plane = _plane(layers, parameters)
    chosen = _chosen(source, parameters.onlyselected)
    found = mirror_deviation(
        source.points,
        plane,
        source.faces,
        None if len(source.faces) else source.normals,
        chosen=chosen,
        tolerance=parameters.tolerance,
        farthest=parameters.farthest,
        progress=progress,
    )
    if not found.has_counterpart.any():
        message = (
            f"the mirror image across plane {parameters.plane} meets nothing that was measured; "
            f"got {np.count_nonzero(chosen)} points of layer '{source.label}' without counterpart; "
            "detect planes on this layer, choose another plane, or raise farthest"
        )
        raise GeometryError(message)
    return Outcome(
        current=None,
        measures=_measures(found, chosen, plane),
        warnings=_warnings(source, found),
        scalars=(_written(source, chosen, found),),
    )


def _plane(layers: Layers, parameters: Parameters) -> Floats:
    sheets = layers.beside_current(parameters.planes, PLANES_LABEL)
    if sheets is None:
        message = (
            f"there is nothing to mirror across: this filter needs a layer '{PLANES_LABEL}'; "
            "detect planes first, or draw one and name its layer"
        )
        raise GeometryError(message)
    planes = planes_of_pieces(sheets.points, sheets.faces)
    if parameters.plane >= len(planes):
        message = (
            f"plane must be one of the {len(planes)} planes of layer '{sheets.label}', counted "
            f"from 0; got {parameters.plane}; take 0 for the best one"
        )
        raise ParameterError(message)
    plane: Floats = planes[parameters.plane]
    return plane


def _chosen(source: Layer, only_selected: bool) -> Booleans:
    if not only_selected:
        return np.ones(len(source.points), dtype=np.bool_)
    return source.required_selection()


def _written(source: Layer, chosen: Booleans, found: MirrorDeviation) -> VertexScalars:
    """Return the distances as quality; what is not chosen keeps its own, but has no deviation."""
    kept = {COUNTERPART: found.has_counterpart.astype(np.float64)}
    if source.quality is None or chosen.all():
        return VertexScalars(source.identifier, found.distances, DEVIATION, kept)
    mixed = np.where(chosen, found.distances, source.quality)
    return VertexScalars(source.identifier, mixed, MIXED, {DEVIATION: found.distances} | kept)


def _measures(found: MirrorDeviation, chosen: Booleans, plane: Floats) -> dict[str, object]:
    return {
        "median": found.median,
        "percentile_95": found.percentile_95,
        "rms": found.rms,
        "within_tolerance": found.share_within,
        "without_counterpart": float(1.0 - found.has_counterpart[chosen].mean()),
        "tolerance": found.tolerance,
        "signed": found.signed,
        "plane": plane,
    }


def _warnings(source: Layer, found: MirrorDeviation) -> tuple[str, ...]:
    warnings = [] if found.signed else [UNSIGNED]
    invented = np.count_nonzero(source.attributes.get(MIRRORED, np.zeros(0)))
    if invented:
        warnings.append(
            f"{invented} points of layer '{source.label}' are mirror images themselves, so that "
            "they and what they were made from agree by construction; measure the scan instead"
        )
    return tuple(warnings)


FILTER = Filter(
    menu_name="Mirror Symmetry Deviation",
    python_name="compute_scalar_by_mirror_symmetry_per_vertex",
    aliases=("mirror_symmetry_deviation",),
    summary="Measure how far every vertex is from the scan's own mirror image.",
    description=(
        f"Takes a plane of the layer `{PLANES_LABEL}` (detected, moved or drawn by hand) and "
        "writes into the vertex quality of the current layer how far each vertex is from the "
        "layer's mirror image, in the units of the scan: positive where it stands out of its "
        "mirror image, negative where it lies under it. Wear, losses and repairs of one side show "
        "up as spots of one sign, with spots of the other sign at the same place of the other "
        "side. A mesh is measured exactly, a cloud against the tangent planes of its points.\n\n"
        "Where the mirror image falls into a hole, beyond a rim, or on nothing that faces the same "
        "way, there is nothing to compare with: quality is 0 there, and the custom attribute "
        f"`{COUNTERPART}` is 0 instead of 1. The numbers are also kept as the custom attribute "
        f"`{DEVIATION}`, 0 where nothing was measured; with `onlyselected`, `{MIXED}` holds them "
        "beside the quality that the other vertices had, if they had one. After a second run the "
        "names end in `_2`, and so on. Nothing else of the layer changes, and colours stay as they "
        "are: colour it with MeshLab's *Colorize by vertex Quality* and `zerosym`.\n\n"
        "Returns, of the vertices with a counterpart, the `median`, the `percentile_95` and the "
        "`rms` of the distances without their signs and the share `within_tolerance`; the share "
        "`without_counterpart`; the `tolerance` in the units of the scan; whether the distances "
        "are `signed`; and the `plane` (A, B, C, D)."
    ),
    parameters=Parameters,
    run=run,
    meshlab_class="Quality",
    category="Attribute/Scalar",
    arity="VARIABLE",
    requires=("points",),
    citations=(
        Citation(
            "J. A. Baerentzen, H. Aanaes",
            "Signed distance computation using the angle weighted pseudonormal",
            "IEEE Transactions on Visualization and Computer Graphics 11",
            2005,
            "10.1109/TVCG.2005.49",
        ),
    ),
)
