"""Our steps in pymeshlab's own script history.

The native history keeps filters that it does not know, without loss, when it reads and writes a
script. So a step of ours is recorded by saving the history, appending one element, and loading
it again. Native floats pass through the native writer, which keeps six digits; ours travel as
text and come back to the last bit. ``exact_steps`` keeps the native ones.
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pymeshlab
from defusedxml.ElementTree import parse

from meshlab_symrecon.errors import HostError
from meshlab_symrecon.host import exact_steps
from meshlab_symrecon.host.mlx import choice_attributes
from meshlab_symrecon.host.native_values import SPREAD
from meshlab_symrecon.host.translation import translated
from meshlab_symrecon.plugin import Filter, ParameterSet
from meshlab_symrecon.plugin.parameters import Kind, Value

__all__ = ["Step", "check_restorable", "plugin_step", "read_history", "record", "restore"]

DOCTYPE = "<!DOCTYPE FilterScript>\n"
LOWEST_INT, HIGHEST_INT = -(2**31), 2**31 - 1  # a RichInt
# As they were before anything could replace them: these read and write the native history itself.
NATIVE_LOAD = pymeshlab.MeshSet.load_filter_script
NATIVE_SAVE = pymeshlab.MeshSet.save_filter_script
UNREADABLE = "RichShotf"  # the native reader destroys a camera, or aborts the process


@dataclass(frozen=True, slots=True)
class Step:
    """One step of a history: the menu name, and each parameter's name and attributes in XML."""

    menu_name: str
    parameters: tuple[Mapping[str, str], ...]

    @property
    def texts(self) -> dict[str, str]:
        """The value of each parameter as one text, by its name in scripts."""
        return {attributes["name"]: _text(attributes) for attributes in self.parameters}


def _text(attributes: Mapping[str, str]) -> str:
    """Join what the native writer spreads over several attributes."""
    if "value" in attributes:
        return attributes["value"]
    spread = SPREAD.get(attributes.get("type", ""), ())
    return " ".join(attributes[part] for part in spread)


def record(
    mesh_set: Any,
    item: Filter,
    parameters: ParameterSet,
    note: exact_steps.Note,
    native_steps: int = 0,
) -> bool:
    """Append a step of ours to the history; return False when the history cannot be rewritten.

    A history that holds a camera cannot be: the native reader would abort. Ours takes the place of
    the last ``native_steps``, which were its own means; those stay where it cannot be rewritten.
    ``note`` was taken before the step ran.
    """
    root = _saved(mesh_set)
    if any(element.get("type") == UNREADABLE for element in root.iter("Param")):
        return False
    steps = root.findall("filter")
    for step in steps[len(steps) - native_steps :]:
        root.remove(step)
    root.append(_element(plugin_step(item, parameters)))
    _load(mesh_set, root)
    exact_steps.drop_last(mesh_set, native_steps)
    exact_steps.note(mesh_set, note)
    return True


def read_history(mesh_set: Any) -> tuple[Step, ...]:
    """Return the steps in the order in which they ran."""
    return tuple(
        Step(element.get("name", ""), tuple(dict(child.attrib) for child in element.iter("Param")))
        for element in _saved(mesh_set).iter("filter")
    )


def check_restorable(steps: Sequence[Step]) -> None:
    """Refuse steps that the native reader cannot read.

    Raises
    ------
    HostError
        A step holds a camera.
    """
    for step in steps:
        if any(attributes.get("type") == UNREADABLE for attributes in step.parameters):
            message = (
                f"step '{step.menu_name}' has a camera, which MeshLab cannot read back from a "
                "script; run that step by its method"
            )
            raise HostError(message)


def restore(mesh_set: Any, steps: Sequence[Step]) -> None:
    """Make ``steps`` the whole history.

    Raises
    ------
    HostError
        As ``check_restorable``.
    """
    check_restorable(steps)
    root = ElementTree.Element("FilterScript")
    root.extend(_element(step) for step in steps)
    _load(mesh_set, root)


def plugin_step(item: Filter, parameters: ParameterSet) -> Step:
    """Return a step of ours with every parameter, as the native history keeps it without loss.

    Fractions are written as ``RichString``: the native reader takes any text there and keeps it,
    while a ``RichFloat`` would be cut down to six digits. So are whole numbers above 32 bits, which
    the native reader would drop.
    """
    values = parameters.values()
    written = []
    for parameter in parameters.declared():
        value = values[parameter.name]
        attributes = {
            "type": _type_that_survives(parameter.kind, value),
            "name": parameter.name,
            "value": parameter.format(value),
        }
        written.append(attributes | choice_attributes(parameter))
    return Step(item.menu_name, tuple(written))


def _element(step: Step) -> ElementTree.Element:
    element = ElementTree.Element("filter", name=step.menu_name)
    for attributes in step.parameters:
        ElementTree.SubElement(element, "Param", dict(attributes))
    return element


def _type_that_survives(kind: Kind, value: Value) -> str:
    if kind.rich_type == "RichFloat":
        return "RichString"
    if kind is Kind.INTEGER and not LOWEST_INT <= int(value) <= HIGHEST_INT:
        return "RichString"
    return kind.rich_type


def _saved(mesh_set: Any) -> ElementTree.Element:
    with tempfile.TemporaryDirectory(prefix="symrecon-") as folder:
        path = Path(folder, "history.mlx")
        with translated("reading the filter history"):
            NATIVE_SAVE(mesh_set, str(path))
        root: ElementTree.Element = parse(path).getroot()
    return root


def _load(mesh_set: Any, root: ElementTree.Element) -> None:
    with tempfile.TemporaryDirectory(prefix="symrecon-") as folder:
        path = Path(folder, "history.mlx")
        path.write_text(DOCTYPE + ElementTree.tostring(root, encoding="unicode"), encoding="utf-8")
        with translated("writing the filter history"):
            NATIVE_LOAD(mesh_set, str(path))
