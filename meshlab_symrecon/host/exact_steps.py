"""What a MeshSet's steps ran with, to the last bit, beside pymeshlab's own history of them.

The native history keeps six digits of a number, and layers by identifier, while scripts count
their positions. So each step is noted here in both forms when it runs. The native history says
which steps there are; a note is used for a step that it agrees with.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import numpy as np
import pymeshlab

from meshlab_symrecon.host.mlx import Param, Script, Step, step_of
from meshlab_symrecon.host.native_filters import NativeFilter
from meshlab_symrecon.host.written_steps import written_step
from meshlab_symrecon.plugin import Filter
from meshlab_symrecon.plugin.parameters import Kind

if TYPE_CHECKING:
    from meshlab_symrecon.host.history import Step as NativeStep

__all__ = [
    "Note",
    "Notes",
    "drop_last",
    "exact_script",
    "in_full",
    "note",
    "note_of",
    "notes_of",
    "replace",
]

RECORDED = Path("filter history")  # what messages call steps that were never in a file
LAYER = "RichMesh"
SIX_DIGITS = 1e-5  # relative difference that writing six digits makes at most, doubled


@dataclass(frozen=True, slots=True)
class Note:
    """One step twice: as the native history shows it, and as a script says it."""

    native: Step
    written: Step


@dataclass(frozen=True, slots=True)
class Notes:
    """The steps of a MeshSet, and the script that they were loaded from."""

    path: Path = RECORDED
    steps: tuple[Note, ...] = ()


_lock = threading.Lock()
_kept: WeakKeyDictionary[Any, Notes] = WeakKeyDictionary()


def notes_of(mesh_set: Any) -> Notes:
    """Return what is noted of a MeshSet."""
    with _lock:
        return _kept.get(mesh_set, Notes())


def replace(mesh_set: Any, notes: Notes) -> None:
    """Make ``notes`` all that is noted of a MeshSet."""
    with _lock:
        _kept[mesh_set] = notes


def note(mesh_set: Any, step: Note) -> None:
    """Add a step that ran."""
    notes = notes_of(mesh_set)
    replace(mesh_set, Notes(notes.path, (*notes.steps, step)))


def drop_last(mesh_set: Any, count: int) -> None:
    """Forget the last steps, which were the means of another one."""
    notes = notes_of(mesh_set)
    replace(mesh_set, Notes(notes.path, notes.steps[: max(0, len(notes.steps) - count)]))


def note_of(mesh_set: Any, item: Filter | NativeFilter, values: Mapping[str, Any]) -> Note:
    """Return the note of a step with all its values, in which layers are identifiers.

    Raises
    ------
    ParameterError
        A value is of the wrong type.
    """
    positions = {int(mesh.id()): place for place, mesh in enumerate(mesh_set)}
    if isinstance(item, Filter):
        layers = {known.name for known in item.parameters.declared() if known.kind is Kind.LAYER}
    else:
        layers = {known.name for known in item.parameters if known.rich_type == LAYER}
    placed = dict(values)
    for name in layers & values.keys():
        placed[name] = positions.get(values[name], values[name])
    if isinstance(item, Filter):
        return Note(step_of(item, values), step_of(item, placed))
    return Note(written_step(item, values), written_step(item, placed))


def in_full(used: Mapping[str, Any], given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of a native step as they are best written down.

    MeshLab keeps most numbers in single precision, so that .1 comes back from it as
    .10000000149011612. What was given is kept as it was; of defaults, the shortest number is taken
    that MeshLab makes the same of. A percentage is given as the length that it came to.
    """
    return {
        name: _shortest(value)
        if name not in given or isinstance(given[name], pymeshlab.PercentageValue)
        else given[name]
        for name, value in used.items()
    }


def _shortest(value: Any) -> Any:
    if not isinstance(value, float):
        return value
    single = np.float32(value)
    return float(str(single)) if float(single) == value else value


def exact_script(mesh_set: Any, shown: Sequence[NativeStep]) -> Script:
    """Return the steps that the native history shows as a script, exact where they are noted."""
    notes = notes_of(mesh_set)
    steps: list[Step] = []
    end = len(notes.steps)
    for step in reversed(shown):
        places = range(end - 1, -1, -1)
        place = next((n for n in places if _agrees(step, notes.steps[n].native)), None)
        if place is None:
            steps.append(_as_shown(step))
        else:
            steps.append(notes.steps[place].written)
            end = place
    return Script(notes.path, tuple(reversed(steps)))


def _as_shown(step: NativeStep) -> Step:
    return Step(step.menu_name, 0, tuple(_param(attributes) for attributes in step.parameters))


def _param(attributes: Mapping[str, str]) -> Param:
    rest = dict(attributes)
    name, rich_type = rest.pop("name"), rest.pop("type", "")
    return Param(name, 0, rich_type, rest.pop("value", None), rest)


def _agrees(shown: NativeStep, noted: Step) -> bool:
    """Say whether a note is of that step: the same name, the same values to six digits."""
    if shown.menu_name != noted.name:
        return False
    expected = {param.name: param for param in noted.parameters}
    return all(
        _same(given, expected[given["name"]])
        for given in shown.parameters
        if given["name"] in expected
    )


def _same(shown: Mapping[str, str], noted: Param) -> bool:
    if noted.text is not None:
        return _same_text(shown.get("value", ""), noted.text)
    return all(_same_text(shown.get(name, ""), text) for name, text in noted.attributes.items())


def _same_text(shown: str, noted: str) -> bool:
    if shown == noted:
        return True
    try:
        return math.isclose(float(shown), float(noted), rel_tol=SIX_DIGITS)
    except ValueError:
        return False
