"""What a document will be after a step, so far as that is certain."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import reduce

from meshlab_symrecon.host.document_state import (
    FACTS,
    UNKNOWN_LAYER,
    DocumentState,
    LayerState,
)
from meshlab_symrecon.host.expectations import NEW, Expectation, Fates, Way, expectation
from meshlab_symrecon.host.native_filters import NativeFilter
from meshlab_symrecon.host.old_names import CHANGE_LAYER
from meshlab_symrecon.host.resolution import ResolvedStep

__all__ = ["after"]

MERGE = "generate_by_merging_visible_meshes"
OF_MANY = frozenset(  # what is visible goes into the layers that these make
    {
        MERGE,
        "generate_surface_reconstruction_screened_poisson",
        "generate_surface_reconstruction_vcg",
    }
)
LETTERS: Mapping[str, bool] = {"y": True, "n": False}
# Filters that leave the vertices as many as they are begin like this.
KEEP_COUNT = (
    "apply_color", "apply_normal", "apply_scalar", "apply_selection", "compute_color",
    "compute_normal", "compute_scalar", "compute_selection", "get_", "set_",
)  # fmt: skip


def after(state: DocumentState, resolved: ResolvedStep | None) -> DocumentState:
    """Return what is known of a document after a step, None standing for an unknown one."""
    if resolved is None:
        return DocumentState(more=None)
    state = _after_one(state, resolved)
    if resolved.then is None or state.current_layer.has("faces") is False:
        return state
    return _after_one(state, resolved.then)


def _after_one(state: DocumentState, resolved: ResolvedStep) -> DocumentState:
    if isinstance(resolved.filter, str):
        if resolved.filter == CHANGE_LAYER and "mesh" in resolved.values:
            return state.with_current_at(resolved.values["mesh"])
        return state
    expected = expectation(resolved.filter)
    way = expected.way_with(resolved.values)
    if resolved.python_name == MERGE and _may_leave_layers(state, resolved):
        way = replace(way, removed="", current="")
    if resolved.keeps_current and way.removed == "none":
        way = replace(way, current="same")
    return _with_layers(state, expected, way, resolved)


def _may_leave_layers(state: DocumentState, resolved: ResolvedStep) -> bool:
    hidden = any(layer.has("visible") is not True for layer in state.layers) or state.more != 0
    return hidden and resolved.values.get("mergevisible", True) is not False


def _with_layers(
    state: DocumentState, expected: Expectation, way: Way, resolved: ResolvedStep
) -> DocumentState:
    """Return the state with layers removed, changed and added."""
    made = replace(_fated(_source(state, resolved), expected.made), label="", had_faces=False)
    counts_stay = resolved.python_name.startswith(KEEP_COUNT)
    changed = _changed(state, expected, counts_stay)
    left = _without_removed(changed, way)
    if way.most is None or left.more is None or left.more > 0 or way.most > way.added:
        return _added_uncertainly(left, way, made)
    layers = (*left.layers, *[made] * way.added)
    current = left.current
    if way.current.startswith(NEW):
        current = len(layers) + int(way.current.removeprefix(NEW))
    elif not way.current:
        current = None
    return replace(left, layers=layers, current=current, loose=UNKNOWN_LAYER)


def _source(state: DocumentState, resolved: ResolvedStep) -> LayerState:
    """Return what is known of the layer, or of all the layers, that a new one is made of."""
    item = resolved.filter
    parameters = item.parameters if isinstance(item, NativeFilter) else ()
    by_name = any(parameter.rich_type == "RichMesh" for parameter in parameters)
    if not by_name and resolved.python_name not in OF_MANY:
        return state.current_layer
    if state.more != 0:
        return UNKNOWN_LAYER
    return reduce(LayerState.joined, state.layers, state.current_layer)


def _added_uncertainly(state: DocumentState, way: Way, made: LayerState) -> DocumentState:
    """Return the state where nobody knows the position of what is added."""
    more = None if way.most is None or state.more is None else state.more + way.most
    if way.current == "same" and state.current is not None:
        return replace(state, more=more)
    loose = made if way.current.startswith(NEW) else UNKNOWN_LAYER
    loose = state.current_layer if way.current == "same" else loose
    return replace(state, more=more, current=None, loose=loose)


def _changed(state: DocumentState, expected: Expectation, counts_stay: bool) -> DocumentState:
    """Return the state with the fates of all layers fulfilled."""
    current = _fated(state.current_layer, expected.kept)
    if counts_stay:
        current = replace(current, vertices=state.current_layer.vertices)
    if state.current is None:  # then it may be any of them
        layers = tuple(UNKNOWN_LAYER for _ in state.layers)
        return replace(state, layers=layers, loose=current)
    others = [_fated(layer, expected.others) for layer in state.layers]
    others[state.current] = current
    return replace(state, layers=tuple(others))


def _without_removed(state: DocumentState, way: Way) -> DocumentState:
    if way.removed == "none":
        return state
    if way.removed == "all":
        return DocumentState(rasters=state.rasters)
    if way.removed != "current" or state.current is None or state.more != 0:
        return DocumentState(more=state.most, rasters=state.rasters)
    layers = (*state.layers[: state.current], *state.layers[state.current + 1 :])
    position = state.current if state.current < len(layers) else 0
    return replace(state, layers=layers, current=position if layers else None)


def _fated(layer: LayerState, fates: Fates | None) -> LayerState:
    """Return a layer with the fates of its facts fulfilled."""
    if fates is None:
        return UNKNOWN_LAYER
    facts = {}
    for fact in FACTS:
        fate = fates.get(fact, "ny")
        was = layer.has(fact)
        letters = set(fate) if was is None else {fate[was]}
        letter = letters.pop() if len(letters) == 1 else "?"
        if letter in LETTERS:
            facts[fact] = LETTERS[letter]
    if facts.get("normals") is False and facts.get("faces") is not False:
        del facts["normals"]  # MeshLab computes those of faces whenever it likes
    had_faces = layer.had_faces or layer.has("faces") is not False
    return LayerState(facts, layer.label, had_faces=had_faces)
