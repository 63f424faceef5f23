"""Detect Reflection Planes (AP)."""

from __future__ import annotations

import numpy as np

from meshlab_symrecon.arrays import Planes, Points, as_points
from meshlab_symrecon.errors import GeometryError, ParameterError
from meshlab_symrecon.geometry.bounds import is_solid
from meshlab_symrecon.geometry.plane_quads import PLANES_LABEL, planes_as_quads, planes_of_pieces
from meshlab_symrecon.plugin import (
    Citation,
    Filter,
    Layer,
    Layers,
    Outcome,
    ParameterSet,
    Progress,
    boolean,
    integer,
    layer,
    number,
)
from meshlab_symrecon.symmetry.detection import (
    LIMITS,
    DetectionOptions,
    ReflectionPlanes,
    detect_reflection_planes,
    refine_reflection_planes,
)

NONE_FOUND = (
    "no reflection plane was found: the points show no mirror symmetry that can be trusted; lower "
    "minconfidence to see weaker candidates, select the symmetric part and set onlyselected, or "
    "draw a plane by hand"
)
FEWEST = 5  # points that can show a symmetry
DEFAULTS = DetectionOptions()


class Parameters(ParameterSet):
    """Parameters of the detection."""

    maxplanes: int = integer(
        DEFAULTS.max_planes,
        "Most planes",
        "How many planes to report at most, the best first. When refining: how many planes of the "
        "layer to refine, from its first.",
        low=LIMITS["max_planes"][0],
        high=LIMITS["max_planes"][1],
    )
    minconfidence: float = number(
        DEFAULTS.min_confidence,
        "Least confidence",
        "How sure the filter must be of a plane to report it, from 0 (a guess) to 1 (certain). The "
        "default is set so that about 1 in 50 planes reported on statues is wrong; lower it to see "
        "more candidates, more of which are wrong. When refining nothing is left out, but a "
        "warning names the planes that stay below it.",
        low=LIMITS["min_confidence"][0],
        high=LIMITS["min_confidence"][1],
    )
    onlyselected: bool = boolean(
        False,
        "Only selected points",
        "Look at the selected points only: select the part that is symmetric, and leave out the "
        "base, the rock or the arm that is not. On a mesh without selected vertices, the corners "
        "of its selected faces count.",
    )
    refine: bool = boolean(
        False,
        "Refine drawn planes",
        "Do not search: take the planes that you have drawn or moved by hand, and move each to "
        "where the scan fits its mirror image best. A plane should be right to about 10 degrees "
        "and a twentieth of the scan's size. Your layer stays as it is; the refined planes come "
        "as a new one, which the completion then uses.",
    )
    planes: int = layer(
        -1,
        "Planes to refine",
        "The layer whose rectangles are refined, when refining; -1 takes the newest "
        f"'{PLANES_LABEL}'.",
    )
    samples: int = integer(
        DEFAULTS.sample_count,
        "Samples",
        "How many points, spread evenly over the scan, are compared in pairs to find candidates. "
        "More may find a plane that was missed, and take longer. Has no effect when refining.",
        low=LIMITS["sample_count"][0],
        high=LIMITS["sample_count"][1],
    )
    randomseed: int = integer(
        0,
        "Random seed",
        "Chooses what is left to chance; equal seeds give equal planes.",
        low=0,
        high=2**31 - 1,
    )


def check(parameters: Parameters) -> None:
    """Refuse a layer of planes that would not be looked at."""
    if parameters.planes >= 0 and not parameters.refine:
        message = (
            f"planes names the layer to refine, but refine is false; got planes={parameters.planes}"
            "; set refine to true, or leave planes at -1"
        )
        raise ParameterError(message)


def run(layers: Layers, parameters: Parameters, progress: Progress) -> Outcome:
    """Find the planes of the current layer's points, or refine drawn ones; show them as a layer."""
    source = layers.current
    rng = np.random.default_rng(parameters.randomseed)
    if parameters.refine:
        drawn, warnings = _drawn_planes(layers, parameters)
        points, normals = _looked_at(source, parameters.onlyselected)
        found = refine_reflection_planes(points, drawn, normals, rng=rng, progress=progress)
        warnings += _doubts(found, parameters.minconfidence)
    else:
        points, normals = _looked_at(source, parameters.onlyselected)
        options = DetectionOptions(
            max_planes=parameters.maxplanes,
            min_confidence=parameters.minconfidence,
            sample_count=parameters.samples,
        )
        found = detect_reflection_planes(
            points, normals, options=options, rng=rng, progress=progress
        )
        warnings = () if len(found.planes) else (NONE_FOUND,)
    sheets = (_sheets(source, found),) if len(found.planes) else ()
    return Outcome(sheets, current=None, measures=_measures(found), warnings=warnings)


def _looked_at(source: Layer, only_selected: bool) -> tuple[Points, Points | None]:
    """Return the points that count, and their normals."""
    points = as_points(source.points)  # all of them: the rectangles span their box
    normals = source.normals
    if not only_selected:
        return points, normals
    chosen = source.required_selection()
    if not is_solid(points[chosen], FEWEST):
        message = (
            f"detection of reflection planes needs at least {FEWEST} points not in one plane; "
            f"got {np.count_nonzero(chosen)} selected points of {len(points)} in layer "
            f"'{source.label}'; select more of the symmetric part"
        )
        raise GeometryError(message)
    return points[chosen], None if normals is None else normals[chosen]


def _drawn_planes(layers: Layers, parameters: Parameters) -> tuple[Planes, tuple[str, ...]]:
    """Return the planes to refine, and what to tell the user."""
    chosen = layers.beside_current(parameters.planes, PLANES_LABEL)
    if chosen is None:
        message = (
            f"refine needs planes; no layer is called '{PLANES_LABEL}'; draw a rectangle where "
            "the mirror should be and give its layer that name, or name its layer by number"
        )
        raise GeometryError(message)
    planes = planes_of_pieces(chosen.points, chosen.faces)
    most = parameters.maxplanes
    if len(planes) <= most:
        return planes, ()
    left_out = (
        f"layer '{chosen.label}' has {len(planes)} planes, of which the first {most} were refined; "
        "raise maxplanes, or delete planes from the layer"
    )
    return planes[:most], (left_out,)


def _doubts(found: ReflectionPlanes, least: float) -> tuple[str, ...]:
    """Name the refined planes that the points do not bear out."""
    doubtful = np.flatnonzero(found.confidence < least)
    if not len(doubtful):
        return ()
    named = ", ".join(f"{plane} ({found.confidence[plane]:.2f})" for plane in doubtful)
    return (
        f"refined planes that the points do not bear out, with their confidence below {least:g}: "
        f"{named}; look at them before you mirror anything",
    )


def _measures(found: ReflectionPlanes) -> dict[str, object]:
    return {
        "planes": found.planes,
        "support": found.support,
        "residual": found.residual,
        "confidence": found.confidence,
        "converged": found.converged,
    }


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
        "You can help: select the symmetric part and set `onlyselected`; or draw a plane (a flat "
        f"mesh in a layer named `{PLANES_LABEL}`), or move one that was found, and set `refine`: "
        "the planes of that layer are moved to where the scan fits its mirror image best, and come "
        f"as a new layer `{PLANES_LABEL}`, in their order. The layer that you drew stays as it "
        "is.\n\n"
        "Returns `planes` (k, 4), rows (A, B, C, D) with unit normal and Ax + By + Cz + D = 0; "
        "`support`, the share of points with a mirror partner; `residual`, the RMS distance of "
        "partners in box diagonals; `confidence`, 0 to 1; `converged`."
    ),
    parameters=Parameters,
    run=run,
    check=check,
    meshlab_class="PointSet",
    category="Measurement/Geometric",
    arity="VARIABLE",
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
