"""The steps of a script against what is known of a document at each of them, before anything runs.

Only what is certain is an error: a step that would crash, be refused by MeshLab or delete what was
measured. What is unknown is looked at again when the step runs.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from meshlab_symrecon.errors import SymReconError
from meshlab_symrecon.host.cloud_cleaning import empties_clouds
from meshlab_symrecon.host.document_state import DocumentState, LayerState
from meshlab_symrecon.host.expectations import OF_NAMED_LAYERS, Need, expectation
from meshlab_symrecon.host.findings import ERROR, REMARK, SKIP, Finding
from meshlab_symrecon.host.guards import (
    EMPTY_CLOUDS_TOO,
    POISSON,
    WANT_POINTS,
    WORK_ON_EDGES,
    check_sound,
)
from meshlab_symrecon.host.layer_guards import NEED_TWO_LAYERS, WANT_CURRENT
from meshlab_symrecon.host.mlx import Script
from meshlab_symrecon.host.native_filters import NativeFilter
from meshlab_symrecon.host.prediction import after
from meshlab_symrecon.host.resolution import ResolvedStep, matched
from meshlab_symrecon.host.value_limits import check_limits

__all__ = ["check_document", "check_script"]

WORDS = {  # of a fact: what is missing, and what to do
    "points": ("points", "look at what the steps before it delete"),
    "faces": ("faces", "reconstruct a surface first"),
    "edges": ("edges", "make a polyline first"),
    "normals": ("normals", "compute normals for point sets first"),
    "vertex_colour": ("vertex colours", "compute or load colours first"),
    "face_colour": ("face colours", "compute colours of faces first"),
    "quality": ("vertex quality", "compute a scalar of vertices first"),
    "face_quality": ("face quality", "compute a scalar of faces first"),
    "vertex_texture": ("texture coordinates of vertices", "parametrize the layer first"),
    "wedge_texture": ("texture coordinates of wedges", "parametrize the layer first"),
    "textures": ("a texture", "load or compute one first"),
    "vertex_selection": ("selected vertices", "select some first"),
    "face_selection": ("selected faces", "select some first"),
    "selection": ("a selection", "select something first"),
}
# Filters that do nothing, without a word, when none of that is selected.
WORK_ON_SELECTION = {
    "apply_selection_dilatation": "face_selection",
    "apply_selection_erosion": "face_selection",
    "compute_selection_transfer_face_to_vertex": "face_selection",
    "compute_selection_transfer_vertex_to_face": "vertex_selection",
    "generate_from_selected_faces": "face_selection",
    "generate_from_selected_vertices": "vertex_selection",
    "meshing_remove_selected_faces": "face_selection",
    "meshing_remove_selected_vertices": "vertex_selection",
    "meshing_remove_selected_vertices_and_faces": "face_selection",
}


def check_script(script: Script, state: DocumentState) -> tuple[Finding, ...]:
    """Return everything that is found in a script, by itself and on a document.

    Parameters
    ----------
    script : Script
    state : DocumentState
        What is known of the document that it will work on.

    Returns
    -------
    tuple of Finding
        In the order of the steps, and of the lines of each.
    """
    matching = matched(script)
    found = (*matching.findings, *check_document(matching.steps, state, script.path))
    return tuple(sorted(found, key=lambda finding: (finding.step, finding.line)))


def check_document(
    steps: Sequence[ResolvedStep | None], state: DocumentState, path: str | Path = ""
) -> tuple[Finding, ...]:
    """Return what is certainly wrong with the steps of a script on a document.

    Parameters
    ----------
    steps : sequence of ResolvedStep or None
        None stands for a step that is not known, of which findings were made already; what comes
        after it is unknown.
    state : DocumentState
        What is known of the document before the first step.
    path : str or Path
        The script's file, for the findings.

    Returns
    -------
    tuple of Finding
        In the order of the steps. After a step with an error, only that is certain which is so
        whether it is passed over or mended.
    """
    findings: list[Finding] = []
    for number, resolved in enumerate(steps):
        problem = None
        if resolved is not None:
            line = resolved.step.line
            problem = next(_problems(resolved, state), None)
            note = None if problem else _note(resolved, state)
            if problem:
                findings.append(Finding(str(path), line, problem, ERROR, SKIP, number))
            if note:
                findings.append(Finding(str(path), line, note, REMARK, "", number))
        later = _survived(after(state, resolved), resolved)
        if problem is None:
            state = later
        elif resolved is not None and not _would_empty(resolved, state):  # that is never let run
            state = state.joined(later)
    return tuple(findings)


def _survived(state: DocumentState, resolved: ResolvedStep | None) -> DocumentState:
    """Return the state; the rasters of a document are changed by what is not predicted here."""
    if resolved is None or "raster" in resolved.python_name:
        return replace(state, rasters=None)
    return state


def _problems(resolved: ResolvedStep, state: DocumentState) -> Iterator[str]:
    """Yield what is certainly wrong with a step, the gravest first."""
    yield from _wrong_positions(resolved, state)
    if isinstance(resolved.filter, str):
        return
    item = resolved.filter
    for need in expectation(item).needs:
        if need.applies(resolved.values) and _is_missing(need, state):
            yield _missing(item.menu_name, need.fact, state)
    if isinstance(item, NativeFilter):
        yield from _native_problems(item, resolved, state)


def _wrong_positions(resolved: ResolvedStep, state: DocumentState) -> Iterator[str]:
    for name in resolved.layers:
        position = resolved.values.get(name)
        if position is not None and state.most is not None and position >= state.most:
            yield (
                f"parameter '{name}' must be the position of a layer, counted from 0; got "
                f"{position}; the document has {_counted(state)} at this step"
            )


def _counted(state: DocumentState) -> str:
    count = f"{state.most} layer{'' if state.most == 1 else 's'}"
    return f"at most {count}" if state.more else count


def _is_missing(need: Need, state: DocumentState) -> bool:
    if need.fact == "layer":
        return state.is_empty
    if need.fact == "raster":
        return state.rasters is False
    layer = state.current_layer
    if need.fact == "selection":
        return layer.has("vertex_selection") is False and layer.has("face_selection") is False
    return layer.has(need.fact) is False


def _missing(menu_name: str, fact: str, state: DocumentState) -> str:
    if fact == "layer":
        return f"'{menu_name}' needs a layer; the document has none at this step; load one first"
    if fact == "raster":
        return f"'{menu_name}' needs a raster; the document has none; load a project with rasters"
    what, remedy = WORDS[fact]
    return f"'{menu_name}' needs {what}; {_called(state.current_layer)} has none; {remedy}"


def _called(layer: LayerState) -> str:
    return f"layer '{layer.label}'" if layer.label else "the current layer at this step"


def _native_problems(
    item: NativeFilter, resolved: ResolvedStep, state: DocumentState
) -> Iterator[str]:
    if state.is_empty and "empty" in item.fatal:
        yield _missing(item.menu_name, "layer", state)
    layer = state.current_layer
    void = layer.has("points") is False and item.python_name not in WANT_POINTS
    if void and "void" in item.fatal:
        yield _missing(item.menu_name, "points", state)
    by_edges = item.python_name in WORK_ON_EDGES and layer.has("edges") is not False
    if layer.has("faces") is False and _crashes_on_clouds(item) and not by_edges:
        yield _missing(item.menu_name, "faces", state)
    if item.python_name == POISSON and layer.is_cloud and layer.has("normals") is False:
        yield _missing(item.menu_name, "normals", state)
    if _would_empty(resolved, state):
        count = f"{layer.vertices} points" if layer.vertices else "points"
        yield (
            f"'{item.menu_name}' would delete all the {count} of {_called(layer)}, which has no "
            "faces; reconstruct a surface first, or run leniently to pass over the step"
        )
    yield from _poor_named_layers(item, resolved, state)
    yield from _wrong_roles(item, resolved, state)
    try:
        check_sound(item, resolved.values)
        check_limits(item, resolved.values)
    except SymReconError as error:
        yield str(error)


def _would_empty(resolved: ResolvedStep, state: DocumentState) -> bool:
    """Say whether a step would certainly delete every point of a cloud."""
    item = resolved.filter
    cleans = isinstance(item, NativeFilter) and empties_clouds(item, resolved.values)
    return cleans and state.current_layer.is_cloud


def _crashes_on_clouds(item: NativeFilter) -> bool:
    """Say whether a filter that works on the current layer crashes when that has no faces."""
    if item.python_name in EMPTY_CLOUDS_TOO:
        return not EMPTY_CLOUDS_TOO[item.python_name]  # else another layer is meant
    return "cloud" in item.fatal and "mesh" not in item.fatal


def _poor_named_layers(
    item: NativeFilter, resolved: ResolvedStep, state: DocumentState
) -> Iterator[str]:
    """Yield what layers lack that are named by parameters."""
    for parameter, facts in OF_NAMED_LAYERS.get(item.python_name, {}).items():
        position = resolved.values.get(parameter)
        if position is None or position >= len(state.layers):
            continue
        for fact in facts:
            if state.layers[position].has(fact) is False:
                what, remedy = WORDS[fact]
                yield (
                    f"'{item.menu_name}' needs {what} in the layer that '{parameter}' names; "
                    f"layer {position} has none; {remedy}"
                )


def _wrong_roles(item: NativeFilter, resolved: ResolvedStep, state: DocumentState) -> Iterator[str]:
    roles = NEED_TWO_LAYERS.get(item.python_name)
    if roles is None:
        return
    first, second = resolved.values.get(roles[0]), resolved.values.get(roles[1])
    if state.most == 1:
        yield f"'{item.menu_name}' needs two layers; the document has 1 layer at this step"
    elif first is not None and first == second:
        yield (
            f"'{item.menu_name}' needs two layers; got {first} as '{roles[0]}' and as "
            f"'{roles[1]}'; name two different ones"
        )
    wanted = WANT_CURRENT.get(item.python_name)
    position = None if wanted is None else resolved.values.get(wanted)
    if position is not None and state.current is not None and position != state.current:
        yield (
            f"'{item.menu_name}' needs the current layer as '{wanted}'; got {position}; the "
            f"current one is {state.current}; make the other one current first"
        )


def _note(resolved: ResolvedStep, state: DocumentState) -> str:
    fact = WORK_ON_SELECTION.get(resolved.python_name)
    if fact is None or state.current_layer.has(fact) is not False:
        return ""
    return f"it works on {WORDS[fact][0]}, of which there are none at this step: nothing changes"
