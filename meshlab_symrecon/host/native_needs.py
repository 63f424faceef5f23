"""What a filter refuses to work without, as its trials show: what they said, and on what it ran."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any

from meshlab_symrecon.host.document_state import FACTS
from meshlab_symrecon.host.native_trials import Before, Trial

__all__ = ["needs_of"]

PRECONDITION = re.compile(r"Current mesh does not have ([A-Z].*)\.")
MESHLAB_WORDS = {
    "Any Faces": "faces",
    "Vertex Color": "vertex_colour",
    "Face Color": "face_colour",
    "Vertex Quality": "quality",
    "Face Quality": "face_quality",
    "Per Wedge Texture Coords": "wedge_texture",
    "Per Vertex Texture Coords": "vertex_texture",
}
# What filters say in their own words, and which fact they may mean.
OWN_WORDS: tuple[tuple[str, tuple[str, ...]], ...] = (
    ("requires at least one mesh|No mesh layer", ("layer",)),
    ("need a Raster Model|no valid raster", ("raster",)),
    ("[Nn]o selection|no face selection", ("face_selection", "vertex_selection", "selection")),
    ("Vertex Quality", ("quality",)),
    ("Missing Component", ("face_quality",)),
    ("Per Wedge UV|per Wedge Tex|need Texture Coord", ("wedge_texture",)),
    ("per vertex normals", ("normals",)),
    ("no faces|with faces|with some faces|no triangles", ("faces",)),
)
# Filters that work on the current layer, although one of their parameters names a layer.
ON_CURRENT = frozenset({"generate_sampling_poisson_disk"})


def needs_of(trials: list[Trial], before: Before, has_layers: bool) -> list[dict[str, Any]]:
    """Return the facts that a filter needs, and under which values.

    Parameters
    ----------
    trials : list of Trial
        All of one filter.
    before : mapping
        What the documents were.
    has_layers : bool
        As ``behaviour``.
    """
    needs = _preconditions(trials)
    own = _own_needs(trials, before, [need["fact"] for need in needs])
    about_current = not has_layers or trials[0].filter in ON_CURRENT
    return needs + [n for n in own if about_current or n["fact"] in ("layer", "raster")]


def _preconditions(trials: Iterable[Trial]) -> list[dict[str, Any]]:
    """Return what MeshLab itself checks, whatever the parameters are."""
    found = []
    for trial in trials:
        said = PRECONDITION.search(trial.message)
        for words in said[1].split(",") if said else ():
            fact = MESHLAB_WORDS.get(words)
            if fact and fact not in found:
                found.append(fact)
    return [{"fact": fact} for fact in sorted(found)]


def _own_needs(trials: list[Trial], before: Before, known: list[str]) -> list[dict[str, Any]]:
    """Return what the filter itself refuses to work without, and under which values."""
    needs: list[dict[str, Any]] = []
    plain = [trial for trial in trials if not trial.values]
    choices = {str(trial.values): trial.values for trial in trials if trial.values}
    for fact in [fact for _, facts in OWN_WORDS for fact in facts]:
        if fact in known or fact in [need["fact"] for need in needs]:
            continue
        lifted = [
            values
            for values in choices.values()
            if not _is_needed(fact, [t for t in trials if t.values == values], before)
            and _ran_without(fact, [t for t in trials if t.values == values], before)
        ]
        if _is_needed(fact, plain, before):
            needs.append({"fact": fact, "unless": lifted} if lifted else {"fact": fact})
            continue
        for values in choices.values():
            if _is_needed(fact, [t for t in trials if t.values == values], before):
                needs.append({"fact": fact, "when": dict(values)})
    return needs


def _is_needed(fact: str, trials: list[Trial], before: Before) -> bool:
    """Say whether documents without a fact were refused for want of it, and none of them ran."""
    refused = {trial.document for trial in trials if _names(fact, trial.message)}
    without = {trial.document for trial in trials if not _held(fact, trial.document, before)}
    return bool(refused) and refused <= without and not _ran_without(fact, trials, before)


def _ran_without(fact: str, trials: list[Trial], before: Before) -> bool:
    return any(
        trial.ending == "ran" and not _held(fact, trial.document, before) for trial in trials
    )


def _names(fact: str, message: str) -> bool:
    return any(fact in facts and re.search(words, message) for words, facts in OWN_WORDS)


def _held(fact: str, document: str, before: Before) -> bool:
    layers, current = before[document]
    if fact == "layer":
        return bool(layers)
    if fact == "raster" or not layers:
        return False
    facts = dict(zip(FACTS, dict(layers)[current], strict=True))
    if fact == "selection":  # of either kind
        return "y" in (facts["vertex_selection"], facts["face_selection"])
    return facts[fact] == "y"
