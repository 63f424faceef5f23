"""Simplify Points (AP)."""

from __future__ import annotations

import numpy as np

from meshlab_symrecon.arrays import Floats, Indices, Points, as_points
from meshlab_symrecon.clustering.simplification import (
    DETAIL,
    LARGEST_DETAIL,
    LARGEST_PREFERENCE,
    SimplifiedPoints,
    simplify,
)
from meshlab_symrecon.errors import ParameterError
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
    number,
)

LABEL = "simplified points"

UNSETTLED = (
    "the messages had not settled when they stopped, so that other points may stand better for the "
    "scan; look at largest_distance, or ask for another number of points"
)


class Parameters(ParameterSet):
    """Parameters of the simplification."""

    count: int = integer(
        0,
        "Number of points",
        "Exactly how many points to keep; 0 goes by the percentage or the preference.",
        low=0,
        high=2**31 - 1,
    )
    percentage: float = number(
        10.0,
        "Percentage of points",
        "How many of the points to keep, where neither their number nor a preference is given.",
        low=0.0,
        high=100.0,
        unit="%",
    )
    preference: float = number(
        0.0,
        "Preference",
        "In place of a number: how much each point wants to be kept, below 0, in squared mean "
        "spacings. On flat parts about one point in 2.5 times the square root of it is kept: -16 "
        "keeps a tenth, -1600 a hundredth, and more where the surface bends. 0 goes by the number "
        "or the percentage.",
        low=-LARGEST_PREFERENCE,
        high=0.0,
    )
    detail: float = number(
        DETAIL,
        "Detail",
        "How much closer points stand where the surface bends or is thin: ears, rims, folds. 0 "
        "spreads them evenly.",
        low=0.0,
        high=LARGEST_DETAIL,
    )
    onlyselected: bool = boolean(
        False,
        "Only selected points",
        "Simplify the selected points only, and keep all others; number and percentage are of the "
        "selected ones. On a mesh without selected vertices, the corners of its selected faces "
        "count.",
    )


def check(parameters: Parameters) -> None:
    """Refuse two answers to one question."""
    if parameters.count and parameters.preference:
        message = (
            "the number of points follows from count or from preference, not from both; got "
            f"count={parameters.count} and preference={parameters.preference:g}; leave one at 0"
        )
        raise ParameterError(message)
    if not (parameters.count or parameters.preference or parameters.percentage):
        message = (
            "nothing says how many points to keep; got count=0, percentage=0 and preference=0; "
            "give one of them"
        )
        raise ParameterError(message)


def run(layers: Layers, parameters: Parameters, progress: Progress) -> Outcome:
    """Choose exemplars of the current layer's points, and add them as a layer."""
    source = layers.current
    points = as_points(source.points)
    simplified = _simplified(source, parameters.onlyselected)
    kept, warnings = _count(len(simplified), parameters)
    found = simplify(
        points[simplified],
        count=kept,
        preference=parameters.preference if kept is None else None,
        detail=parameters.detail,
        progress=progress,
    )
    staying = np.ones(len(points), dtype=np.bool_)
    staying[simplified] = False
    staying[simplified[found.chosen]] = True
    made = _taken(source, np.flatnonzero(staying))
    measures = _measures(points[simplified], found) | {"points": len(made.points)}
    warnings = warnings if found.converged else (*warnings, UNSETTLED)
    return Outcome((made,), current=0, measures=measures, warnings=warnings)


def _simplified(source: Layer, only_selected: bool) -> Indices:
    """Return the points to choose from."""
    if not only_selected:
        return np.arange(len(source.points))
    return np.flatnonzero(source.required_selection())


def _count(points: int, parameters: Parameters) -> tuple[int | None, tuple[str, ...]]:
    """Return how many of the points to keep, None to go by the preference; and a warning."""
    if parameters.preference:
        return None, ()
    if not parameters.count:
        return max(1, round(points * parameters.percentage / 100.0)), ()
    if parameters.count <= points:
        return parameters.count, ()
    too_few = f"{parameters.count} points were asked for, but there are only {points}: all are kept"
    return points, (too_few,)


def _taken(source: Layer, rows: Indices) -> Layer:
    """Return some points of a layer with all that belongs to them."""
    normals, colours, quality = (
        None if values is None else values[rows]
        for values in (source.normals, source.colours, source.quality)
    )
    return Layer(
        source.points[rows],
        np.zeros((0, 3), dtype=np.int64),
        label=LABEL,
        normals=normals,
        colours=colours,
        quality=quality,
        attributes={name: values[rows] for name, values in source.attributes.items()},
    )


def _measures(points: Points, found: SimplifiedPoints) -> dict[str, object]:
    away: Floats = np.linalg.norm(points - points[found.chosen[found.label]], axis=1)
    return {
        "preference": found.preference,
        "mean_distance": float(away.mean()),
        "largest_distance": float(away.max()),
        "converged": found.converged,
    }


FILTER = Filter(
    menu_name="Simplify Points (AP)",
    python_name="generate_simplified_points",
    aliases=("simplify_points",),
    summary="Keep the points that stand best for all others, more of them where there is detail.",
    description=(
        "Affinity propagation chooses exemplars among the points, under the similarity "
        "-|x_i - x_k|². The preference of a point to be one grows with the surface variation of "
        "its neighbourhood, so that ears, rims and folds keep more points than flat parts. The "
        "number of points is exact when `count` or `percentage` gives it.\n\n"
        f"Adds the layer `{LABEL}`: points of the current layer, bit for bit and in their order, "
        "with their normals, colours, quality and custom attributes. The same points are chosen "
        "in whatever order they come.\n\n"
        "Returns the number of `points`; the `preference` of a flat part, in squared mean "
        "spacings; `mean_distance` and `largest_distance` of a point to the one that stands for "
        "it, in the units of the layer; `converged`, whether the messages had settled: "
        "the exemplars, or their net similarity to 0.1 %. A warning says when not."
    ),
    parameters=Parameters,
    run=run,
    check=check,
    meshlab_class="Sampling",
    category="Creation/Sampling",
    requires=("points",),
    creates=(LABEL,),
    citations=(
        Citation(
            "B. J. Frey, D. Dueck",
            "Clustering by passing messages between data points",
            "Science 315",
            2007,
            "10.1126/science.1136800",
        ),
        Citation(
            "M. Pauly, M. Gross, L. P. Kobbelt",
            "Efficient simplification of point-sampled surfaces",
            "IEEE Visualization",
            2002,
            "10.1109/VISUAL.2002.1183771",
        ),
    ),
)
