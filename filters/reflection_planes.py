"""Detect Reflection Planes (AP)."""

from __future__ import annotations

import numpy as np

from meshlab_symrecon.geometry.plane_quads import PLANES_LABEL, planes_as_quads
from meshlab_symrecon.plugin import (
    Citation,
    Filter,
    Layer,
    Layers,
    Outcome,
    ParameterSet,
    Progress,
    integer,
    number,
)
from meshlab_symrecon.symmetry.detection import (
    LIMITS,
    DetectionOptions,
    ReflectionPlanes,
    detect_reflection_planes,
)

NONE_FOUND = "no reflection plane was found: the points show no mirror symmetry that can be trusted"
DEFAULTS = DetectionOptions()


class Parameters(ParameterSet):
    """Parameters of the detection."""

    maxplanes: int = integer(
        DEFAULTS.max_planes,
        "Most planes",
        "How many planes to return at most.",
        low=LIMITS["max_planes"][0],
        high=LIMITS["max_planes"][1],
    )
    minconfidence: float = number(
        DEFAULTS.min_confidence,
        "Least confidence",
        "Planes less certain than this are not reported; lower it to see weak candidates.",
        low=LIMITS["min_confidence"][0],
        high=LIMITS["min_confidence"][1],
    )
    samples: int = integer(
        DEFAULTS.sample_count,
        "Samples",
        "Even samples of the cloud whose pairs vote for planes.",
        low=LIMITS["sample_count"][0],
        high=LIMITS["sample_count"][1],
    )
    randomseed: int = integer(
        0, "Random seed", "Equal seeds give equal planes.", low=0, high=2**31 - 1
    )


def run(layers: Layers, parameters: Parameters, progress: Progress) -> Outcome:
    """Detect the planes of the current layer's points, and show them as a layer."""
    source = layers.current
    # Normals of a surface tell inside from outside; those of a cloud may have guessed it.
    normals = source.normals if len(source.faces) else None
    found = detect_reflection_planes(
        source.points,
        normals,
        options=DetectionOptions(
            max_planes=parameters.maxplanes,
            min_confidence=parameters.minconfidence,
            sample_count=parameters.samples,
        ),
        rng=np.random.default_rng(parameters.randomseed),
        progress=progress,
    )
    measures = {
        "planes": found.planes,
        "support": found.support,
        "residual": found.residual,
        "confidence": found.confidence,
        "converged": found.converged,
    }
    if not len(found.planes):
        return Outcome((), current=None, measures=measures, warnings=(NONE_FOUND,))
    return Outcome((_sheets(source, found),), current=None, measures=measures)


def _sheets(source: Layer, found: ReflectionPlanes) -> Layer:
    corners, faces = planes_as_quads(found.planes, source.points)
    return Layer(corners, faces, label=PLANES_LABEL, face_quality=np.repeat(found.confidence, 2))


FILTER = Filter(
    menu_name="Detect Reflection Planes (AP)",
    python_name="generate_reflection_planes",
    aliases=("detect_reflection_planes",),
    summary="Find the planes across which an incomplete scan is its own mirror image.",
    description=(
        "Pairs of even samples vote for the planes that map one onto the other; affinity "
        "propagation clusters the votes; every exemplar is refined on the dense cloud and "
        "verified, with holes told from contradictions. The planes are added as the layer "
        f"`{PLANES_LABEL}`: one rectangle a plane, best first, face quality = confidence. Move or "
        "redraw them by hand if you like; *Mirror-Complete Points* reads what is there. When no "
        "plane can be trusted there is no layer, and `planes` has the shape (0, 4). The current "
        "layer stays the scan.\n\n"
        "Returns `planes` (k, 4), rows (A, B, C, D) with unit normal and Ax + By + Cz + D = 0; "
        "`support`, the share of points with a mirror partner; `residual`, the RMS distance of "
        "partners in box diagonals; `confidence`, 0 to 1; `converged`."
    ),
    parameters=Parameters,
    run=run,
    meshlab_class="PointSet",
    category="Measurement/Geometric",
    requires=("points",),
    creates=(PLANES_LABEL,),
    citations=(
        Citation(
            "B. J. Frey, D. Dueck",
            "Clustering by passing messages between data points",
            "Science 315",
            2007,
            "10.1126/science.1136800",
        ),
    ),
)
