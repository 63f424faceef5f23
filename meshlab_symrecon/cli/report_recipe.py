"""How to repeat a reconstruction: its steps with every parameter, as a command, Python and .mlx."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from meshlab_symrecon.host.history import Step, read_history
from meshlab_symrecon.host.native_filters import find_native
from meshlab_symrecon.host.reconstruction import Reconstruction
from meshlab_symrecon.host.registration import registry
from meshlab_symrecon.pictures.report import Listing, Section, Table
from meshlab_symrecon.plugin import Filter
from meshlab_symrecon.plugin.parameters import Value

__all__ = ["python_of", "recipe", "script_of", "steps"]

KEPT = ("type", "name", "value", "x", "y", "z")  # of a parameter in a history, in this order
WIDTH = 100  # characters of a line of Python


def steps(result: Reconstruction, measured: tuple[Step, ...]) -> list[Section]:
    """Return a section for each step that ran, with every parameter as it ran.

    ``measured`` are steps for the report alone.
    """
    parts = [
        Section(f"{number}. {step.menu_name}", _described(step), part=True)
        for number, step in enumerate(read_history(result.mesh_set), start=1)
    ]
    aside = [
        Section(f"For this report: {step.menu_name}", _described(step), part=True)
        for step in measured
    ]
    return [Section("Steps", ()), *parts, *aside]


def _described(step: Step) -> tuple[str | Table, ...]:
    item = _ours(step)
    columns = ("Parameter", "Name", "Value", "Meaning")
    if item is None:
        rows = tuple(
            (given.get("description", ""), given["name"], text, given.get("tooltip", ""))
            for given, text in zip(step.parameters, step.texts.values(), strict=True)
        )
        return ("A filter of MeshLab.", Table(columns, rows))
    values = _values(item, step)
    rows = tuple(
        (parameter.label, parameter.name, _shown(values[parameter.name], parameter.unit),
         parameter.tooltip)
        for parameter in item.parameters.declared()
    )  # fmt: skip
    return (item.summary, Table(columns, rows))


def _ours(step: Step) -> Filter | None:
    return registry().find(step.menu_name) if step.menu_name in registry() else None


def _values(item: Filter, step: Step) -> dict[str, Value]:
    texts = step.texts
    return {
        parameter.name: parameter.parse(texts[parameter.name])
        for parameter in item.parameters.declared()
    }


def _shown(value: Value, unit: str) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value} {unit}".rstrip()


def recipe(result: Reconstruction, scan: Path, command: str) -> list[Section]:
    """Return a section with the command, and the same in Python and as a filter script."""
    passed = read_history(result.mesh_set)
    script = "symrecon run steps.mlx SCAN -o STATUE"
    return [
        Section("Repeat it", ("The same scan, the same versions and this command give the same "
                              "surface, byte for byte.", Listing(command))),
        Section("In Python", (Listing(python_of(passed, scan)),), part=True),
        Section("As a filter script", (f"Saved as steps.mlx, it runs with: {script}",
                                       Listing(script_of(passed))), part=True),
    ]  # fmt: skip


def python_of(passed: tuple[Step, ...], scan: Path) -> str:
    """Return the steps as Python; those of MeshLab ran with its defaults."""
    calls = [_call(step) for step in passed]
    lines = [
        "import pymeshlab, meshlab_symrecon", "", "meshlab_symrecon.load_plugins()",
        "ms = pymeshlab.MeshSet()", f"ms.load_new_mesh({str(scan)!r})", *calls,
        'ms.save_current_mesh("statue.ply")', "",
    ]  # fmt: skip
    return "\n".join(lines)


def _call(step: Step) -> str:
    item = _ours(step)
    if item is None:
        return f"ms.{find_native(step.menu_name).python_name}()"
    arguments = ", ".join(f"{name}={value!r}" for name, value in _values(item, step).items())
    call = f"ms.{item.python_name}({arguments})"
    if len(call) <= WIDTH:
        return call
    body = textwrap.fill(arguments, WIDTH - 4, break_long_words=False, break_on_hyphens=False)
    return f"ms.{item.python_name}(\n{textwrap.indent(body, '    ')},\n)"


def script_of(passed: tuple[Step, ...]) -> str:
    """Return the steps as a filter script, with every parameter."""
    root = ElementTree.Element("FilterScript")
    for step in passed:
        element = ElementTree.SubElement(root, "filter", name=step.menu_name)
        for given in step.parameters:
            attributes: dict[str, Any] = {name: given[name] for name in KEPT if name in given}
            ElementTree.SubElement(element, "Param", attributes)
    ElementTree.indent(root)
    return f"<!DOCTYPE FilterScript>\n{ElementTree.tostring(root, encoding='unicode')}\n"
