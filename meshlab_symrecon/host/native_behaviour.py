"""What trials of a filter show about it: what it makes, and what it leaves behind.

Only what held in every trial is written down. A fact's fate is two letters: what it is afterwards
where it did not hold before, and where it did: ``yy`` is given, ``nn`` is lost, ``ny`` (left out)
stays as it was, and ``?`` stands for what differed or never came up.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from meshlab_symrecon.host.document_state import FACTS
from meshlab_symrecon.host.native_needs import needs_of
from meshlab_symrecon.host.native_trials import Before, Trial

__all__ = ["behaviour"]

# Numbers and expressions may delete or select nothing: that no trial did so shows little.
DELETES = {
    "generate_from_selected": ("points", "faces", "edges", "normals"),
    "meshing_": ("points", "faces", "edges", "normals", "vertex_selection", "face_selection"),
}
MAY_BE_EMPTY = {  # new layers that may come out empty
    "generate_polyline_from_planar_section": ("points", "edges", "normals"),
    "generate_polyline_from_selected_edges": ("points", "edges", "normals"),
    "generate_polyline_from_selection_perimeter": ("points", "edges", "normals"),
}
# Of these, the cleaning steps that leave points behind, if guards let them run.
LEAVES_POINTS = frozenset(
    {
        "meshing_close_holes",
        "meshing_invert_face_orientation",
        "meshing_merge_close_vertices",
        "meshing_poly_to_tri",
        "meshing_re_orient_faces_by_geometry",
        "meshing_re_orient_faces_coherently",
        "meshing_remove_all_faces",
        "meshing_remove_duplicate_faces",
        "meshing_remove_duplicate_vertices",
        "meshing_remove_folded_faces",
        "meshing_remove_null_faces",
        "meshing_remove_selected_faces",
        "meshing_remove_t_vertices",
        "meshing_repair_non_manifold_edges",
        "meshing_snap_mismatched_borders",
    }
)
SELECTS = ("compute_selection", "apply_selection")  # what they select hangs on numbers, too
SELECTIONS = ("vertex_selection", "face_selection")


def behaviour(trials: Iterable[Trial], before: Before, has_layers: bool) -> dict[str, Any]:
    """Return what the trials of one filter show, ready for the table.

    Parameters
    ----------
    trials : iterable of Trial
        All of one filter.
    before : mapping
        What the documents were.
    has_layers : bool
        Whether the filter has parameters that name layers: what it says of faces or selections may
        then be about another layer than the current one.
    """
    tried = list(trials)
    ran = [trial for trial in tried if trial.ending == "ran" and trial.document != "empty"]
    name = tried[0].filter
    kept, others = _kept(ran, before), _others(ran, before)
    if has_layers:  # any of them may be the one that it works on
        kept = others = kept + others
    stays = ("points",) if name in LEAVES_POINTS else ()
    return {
        "needs": needs_of(tried, before, has_layers),
        "layers": _layers(ran, before),
        "kept": _selecting(name, _fates(kept, _deletable(name), kept=stays)),
        "others": _selecting(name, _fates(others)),
        "made": _fates(_made(ran, before), MAY_BE_EMPTY.get(name, ()), new=True),
    }


def _selecting(name: str, fates: dict[str, str] | None) -> dict[str, str] | None:
    """Return the fates with selections unknown, if the filter is one that selects."""
    if fates is None or not name.startswith(SELECTS):
        return fates
    return fates | dict.fromkeys(SELECTIONS, "??")


def _layers(ran: list[Trial], before: Before) -> Any:
    """Return how the list of layers changed: one way, or none when it differed; and exceptions.

    Returns
    -------
    mapping or None
        ``added``; ``removed``: none, current or all; ``current``: same, other (one that was there),
        or new, counted from the last; ``when``: list of values and what they change.
    """
    ways = {
        str(values): (values, _way([trial for trial in ran if trial.values == values], before))
        for values in (trial.values for trial in ran)
    }
    plain = ways.pop("{}", ({}, None))[1]
    if plain is None:
        return None
    differing = [{"values": dict(v), "way": way} for v, way in ways.values() if way != plain]
    return plain | ({"when": differing} if differing else {})


def _way(ran: list[Trial], before: Before) -> dict[str, Any] | None:
    found: set[tuple[int, str, str]] | None = None
    for trial in ran:
        ways = _ways(trial, before)
        found = ways if found is None else found & ways
    if not found:
        return None
    added, removed, current = min(found)
    return {"added": added, "removed": removed, "current": current}


def _ways(trial: Trial, before: Before) -> set[tuple[int, str, str]]:
    """Return every way in which one trial's change of layers can be read."""
    layers, current = before[trial.document]
    earlier = [number for number, _ in layers]
    later = [number for number, _ in trial.layers]
    new = [number for number in later if number not in earlier]
    gone = [number for number in earlier if number not in later]
    removed = {"none"} if not gone else set()
    removed |= {"current"} if gone == [current] else set()
    removed |= {"all"} if gone == earlier else set()
    becomes = "same" if trial.current == current else "other"
    if trial.current in new:
        becomes = f"new {new.index(trial.current) - len(new)}"
    return {(len(new), kind, becomes) for kind in removed}


def _kept(ran: list[Trial], before: Before) -> list[tuple[str, str]]:
    pairs = []
    for trial in ran:
        layers, current = before[trial.document]
        later = dict(trial.layers)
        if current in later:
            pairs.append((dict(layers)[current], later[current]))
    return pairs


def _others(ran: list[Trial], before: Before) -> list[tuple[str, str]]:
    pairs = []
    for trial in ran:
        layers, current = before[trial.document]
        later = dict(trial.layers)
        pairs += [(word, later[n]) for n, word in layers if n != current and n in later]
    return pairs


def _made(ran: list[Trial], before: Before) -> list[tuple[str, str]]:
    """Return pairs of the layer that was current, and each new one."""
    pairs = []
    for trial in ran:
        layers, current = before[trial.document]
        earlier = dict(layers)
        pairs += [(earlier[current], word) for n, word in trial.layers if n not in earlier]
    return pairs


def _deletable(name: str) -> tuple[str, ...]:
    for beginning, facts in DELETES.items():
        if name.startswith(beginning):
            return tuple(fact for fact in facts if fact != "points" or name not in LEAVES_POINTS)
    return ()


def _fates(
    pairs: list[tuple[str, str]],
    deletable: tuple[str, ...] = (),
    *,
    kept: tuple[str, ...] = (),
    new: bool = False,
) -> dict[str, str] | None:
    """Return the fate of each fact that changes; None when nothing was seen."""
    if not pairs:
        return None
    fates = {}
    for place, fact in enumerate(FACTS):
        ends = {was: {late[place] for early, late in pairs if early[place] == was} for was in "ny"}
        fate = "".join(_outcome(was, ends, new) for was in "ny")
        if fact in deletable:
            fate = fate.replace("y", "?")
        if fate != "ny" and fact not in ("visible", *kept):
            fates[fact] = fate
    return fates


def _outcome(was: str, ends: Mapping[str, set[str]], new: bool) -> str:
    """Return what a fact becomes; what never came up is unknown, but a layer keeps what it has."""
    if ends[was]:
        return next(iter(ends[was])) if len(ends[was]) == 1 else "?"
    return "y" if was == "y" and ends["n"] == {"n"} and not new else "?"
