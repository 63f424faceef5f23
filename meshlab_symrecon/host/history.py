"""Our steps in pymeshlab's own script history.

The native history keeps filters that it does not know, without loss, when it reads and writes a
script. So a step of ours is recorded by saving the history, appending one element, and loading
it again. Native floats pass through the native writer, which keeps six digits; ours travel as
text and come back to the last bit.
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from defusedxml.ElementTree import parse

from meshlab_symrecon.errors import HostError
from meshlab_symrecon.host.mlx import choice_attributes
from meshlab_symrecon.host.native_values import SPREAD
from meshlab_symrecon.host.translation import translated
from meshlab_symrecon.plugin import Filter, ParameterSet
from meshlab_symrecon.plugin.parameters import Kind, Value

__all__ = ["Step", "read_history", "record", "restore", "step_element"]

DOCTYPE = "<!DOCTYPE FilterScript>\n"
LOWEST_INT, HIGHEST_INT = -(2**31), 2**31 - 1  # a RichInt
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


def record(mesh_set: Any, item: Filter, parameters: ParameterSet, native_steps: int = 0) -> bool:
    """Append a step of ours to the history; return False when the history cannot be rewritten.

    A history that holds a camera cannot be: the native reader would abort. Ours takes the place of
    the last ``native_steps``, which were its own means; those stay where it cannot be rewritten.
    """
    root = _saved(mesh_set)
    if any(element.get("type") == UNREADABLE for element in root.iter("Param")):
        return False
    steps = root.findall("filter")
    for step in steps[len(steps) - native_steps :]:
        root.remove(step)
    root.append(step_element(item, parameters))
    _load(mesh_set, root)
    return True


def read_history(mesh_set: Any) -> tuple[Step, ...]:
    """Return the steps in the order in which they ran."""
    return tuple(
        Step(element.get("name", ""), tuple(dict(child.attrib) for child in element.iter("Param")))
        for element in _saved(mesh_set).iter("filter")
    )


def restore(mesh_set: Any, steps: Sequence[Step]) -> None:
    """Make ``steps`` the whole history.

    Raises
    ------
    HostError
        A step holds a camera, which the native reader cannot read.
    """
    root = ElementTree.Element("FilterScript")
    for step in steps:
        element = ElementTree.SubElement(root, "filter", name=step.menu_name)
        for attributes in step.parameters:
            if attributes.get("type") == UNREADABLE:
                message = (
                    f"step '{step.menu_name}' has a camera, which MeshLab cannot read back from a "
                    "script; run that step by its method"
                )
                raise HostError(message)
            ElementTree.SubElement(element, "Param", dict(attributes))
    _load(mesh_set, root)


def step_element(item: Filter, parameters: ParameterSet) -> ElementTree.Element:
    """Return a ``<filter>`` element with every parameter, as MeshLab's scripts write them.

    Fractions are written as ``RichString``: the native reader takes any text there and keeps it,
    while a ``RichFloat`` would be cut down to six digits. So are whole numbers above 32 bits, which
    the native reader would drop.
    """
    element = ElementTree.Element("filter", name=item.menu_name)
    values = parameters.values()
    for parameter in parameters.declared():
        value = values[parameter.name]
        attributes = {
            "type": _type_that_survives(parameter.kind, value),
            "name": parameter.name,
            "value": parameter.format(value),
        }
        ElementTree.SubElement(element, "Param", attributes | choice_attributes(parameter))
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
            mesh_set.save_filter_script(str(path))
        root: ElementTree.Element = parse(path).getroot()
    return root


def _load(mesh_set: Any, root: ElementTree.Element) -> None:
    with tempfile.TemporaryDirectory(prefix="symrecon-") as folder:
        path = Path(folder, "history.mlx")
        path.write_text(DOCTYPE + ElementTree.tostring(root, encoding="unicode"), encoding="utf-8")
        with translated("writing the filter history"):
            mesh_set.load_filter_script(str(path))
