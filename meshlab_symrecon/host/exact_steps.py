"""What a MeshSet's steps ran with, to the last bit, beside pymeshlab's own history of them.

The native history keeps six digits of a number, and layers by identifier, while scripts count
their positions. It also does not know that the user made another layer current between two steps.
So each step is noted here when it runs. The native history says which steps there are; a note is
used for a step that it agrees with.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import numpy as np

from meshlab_symrecon.host.meshset import current_identifier
from meshlab_symrecon.host.mlx import Param, Script, Step
from meshlab_symrecon.host.written_steps import written_step
from meshlab_symrecon.plugin import Filter
from meshlab_symrecon.plugin.parameters import Kind

if TYPE_CHECKING:
    from meshlab_symrecon.host.history import Step as NativeStep
    from meshlab_symrecon.host.native_filters import NativeFilter

__all__ = [
    "Note",
    "Notes",
    "Standing",
    "drop_last",
    "exact_script",
    "in_full",
    "lost_between",
    "note",
    "note_of",
    "notes_of",
    "replace",
    "standing",
]

RECORDED = Path("filter history")  # what messages call steps that were never in a file
LAYER = "RichMesh"
CHANGE_NAME = "Change the current layer"  # a filter of old scripts
SIX_DIGITS = 1e-5  # relative difference that writing six digits makes at most, doubled


@dataclass(frozen=True, slots=True)
class Standing:
    """The position of the current layer, -1 for none, among how many."""

    current: int
    layers: int


@dataclass(frozen=True, slots=True)
class Note:
    """One step twice: as the native history shows it, and as a script says it.

    Attributes
    ----------
    native, written : Step
    before, after : Standing or None
        Of the document round the step; None for a step that has not run.
    """

    native: Step
    written: Step
    before: Standing | None = None
    after: Standing | None = None


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


def standing(mesh_set: Any) -> Standing:
    """Return which layer of a MeshSet is current now."""
    identifiers = [int(mesh.id()) for mesh in mesh_set]
    current = current_identifier(mesh_set)
    position = identifiers.index(current) if current in identifiers else -1
    return Standing(position, len(identifiers))


def note(mesh_set: Any, step: Note) -> None:
    """Add a step that has just run."""
    notes = notes_of(mesh_set)
    ran = dataclasses.replace(step, after=standing(mesh_set))
    replace(mesh_set, Notes(notes.path, (*notes.steps, ran)))


def drop_last(mesh_set: Any, count: int) -> None:
    """Forget the last steps, which were the means of another one."""
    notes = notes_of(mesh_set)
    replace(mesh_set, Notes(notes.path, notes.steps[: max(0, len(notes.steps) - count)]))


def note_of(mesh_set: Any, item: Filter | NativeFilter, values: Mapping[str, Any]) -> Note:
    """Return the note of a step that is about to run, with all its values.

    Layers are identifiers in them.

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
    before = standing(mesh_set)
    return Note(written_step(item, values), written_step(item, placed), before)


def in_full(used: Mapping[str, Any], given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of a native step as they are best written down.

    MeshLab keeps most numbers in single precision, so that .1 comes back from it as
    .10000000149011612. A number that was given is kept as it was, unless MeshLab has cut it down to
    its range; else the shortest number is taken that MeshLab makes the same of. A percentage is
    given as the length that it came to.
    """
    return {name: _in_full(value, given.get(name)) for name, value in used.items()}


def _in_full(used: Any, given: Any) -> Any:
    if not isinstance(used, float):
        return used if given is None else given
    with np.errstate(over="ignore"):
        single = np.float32(used)
        if isinstance(given, (int, float)) and np.float32(given) == single:
            return given
    return float(str(single)) if float(single) == used else used


def exact_script(mesh_set: Any, shown: Sequence[NativeStep]) -> Script:
    """Return the steps that the native history shows as a script, exact where they are noted.

    Where another layer was made current between two steps, a step that does so stands there.
    """
    steps: list[Step] = []
    last: Note | None = None
    for step, noted in _noted(mesh_set, shown):
        if last is not None and noted is not None:
            steps += _change_between(last, noted)
        steps.append(_as_shown(step) if noted is None else noted.written)
        last = noted
    return Script(notes_of(mesh_set).path, tuple(steps))


def lost_between(mesh_set: Any, shown: Sequence[NativeStep]) -> list[str]:
    """Say between which steps layers were loaded, added or deleted by hand."""
    pairs = list(_noted(mesh_set, shown))
    return [
        f"between '{first.written.name}' and '{second.written.name}' layers came or went that no "
        "step made; a script cannot repeat that"
        for (_, first), (_, second) in itertools.pairwise(pairs)
        if first is not None and second is not None and _came_or_went(first, second)
    ]


def _noted(mesh_set: Any, shown: Sequence[NativeStep]) -> list[tuple[NativeStep, Note | None]]:
    """Return each step of the history with its note; the last ones are matched first."""
    notes = notes_of(mesh_set).steps
    pairs: list[tuple[NativeStep, Note | None]] = []
    end = len(notes)
    for step in reversed(shown):
        places = range(end - 1, -1, -1)
        place = next((n for n in places if _agrees(step, notes[n].native)), None)
        pairs.append((step, None if place is None else notes[place]))
        end = end if place is None else place
    return pairs[::-1]


def _change_between(first: Note, second: Note) -> list[Step]:
    if first.after is None or second.before is None or _came_or_went(first, second):
        return []
    position = second.before.current
    if position in (-1, first.after.current):
        return []
    return [Step(CHANGE_NAME, 0, (Param("mesh", 0, LAYER, str(position)),))]


def _came_or_went(first: Note, second: Note) -> bool:
    if first.after is None or second.before is None:
        return False
    return first.after.layers != second.before.layers


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
