"""A script as a program for pymeshlab."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from pathlib import PurePath
from typing import Any

import numpy as np
import pymeshlab

from meshlab_symrecon.host.cloud_cleaning import EMPTY_CLOUDS
from meshlab_symrecon.host.mlx import Script
from meshlab_symrecon.host.native_filters import NativeFilter, completed
from meshlab_symrecon.host.old_names import CHANGE_LAYER, NOTHING
from meshlab_symrecon.host.resolution import Matching, ResolvedStep
from meshlab_symrecon.host.step_of_today import as_written, written_as
from meshlab_symrecon.host.upgrade import comments_of
from meshlab_symrecon.plugin import Filter

__all__ = ["python_script"]

WIDTH = 100
INDENT = "    "
MAIN = """

def main():
    if len(sys.argv) < 3:
        sys.exit(f"usage: python {sys.argv[0]} IN... OUT")
    ms = pymeshlab.MeshSet()
    for path in sys.argv[1:-1]:
        ms.load_new_mesh(path)
    apply_script(ms)
    ms.apply_matrix_freeze()  # files have no place for a layer's matrix
    ms.save_current_mesh(sys.argv[-1])


if __name__ == "__main__":
    main()
"""


def python_script(script: Script, matching: Matching) -> str:
    """Return a program that does to files what the script does.

    Its function ``apply_script(ms)`` has one call a step, with the parameters that the script
    gives. What was mapped or left out stands in comments above the calls.
    """
    lines: list[str] = []
    for number, resolved in enumerate(matching.steps):
        lines += _comments(script, matching, number)
        if resolved is not None and resolved.filter != NOTHING:
            lines += _call(resolved)
    if all(line.startswith("#") for line in lines):
        lines.append("pass")
    ours = any(step is not None and isinstance(step.filter, Filter) for step in matching.steps)
    load = ["meshlab_symrecon.load_plugins()"] if ours else []
    body = "".join(f"{INDENT}{line}\n" for line in (*load, *lines))
    title = _comment(f"The steps of {PurePath(script.path).name}, for pymeshlab.", 0)
    head = [*title, "", "import sys", "", *_imports(body, ours)]
    return "\n".join(head) + "\n\n\ndef apply_script(ms):\n" + body + MAIN


def _imports(body: str, ours: bool) -> list[str]:
    numpy = ["import numpy as np"] if "np.array(" in body else []
    return [*numpy, "import pymeshlab", *(["", "import meshlab_symrecon"] if ours else [])]


def _comments(script: Script, matching: Matching, number: int) -> list[str]:
    """Return comments on a step: its line and its name, then what was mapped or left out."""
    step = script.steps[number]
    name = step.name.strip()
    said = list(comments_of(matching.findings, number))
    if not any(words.startswith(f"'{name}'") for _, words in said):
        said.insert(0, (step.line, name))
    last = 0
    lines = []
    for line, words in said:
        lines += _comment(f"line {line}: {words}" if line != last else words)
        last = line
    return lines


def _comment(words: str, indent: int = len(INDENT)) -> list[str]:
    plain = "".join(letter if letter.isprintable() else " " for letter in words)
    return textwrap.wrap(
        plain, WIDTH - indent, initial_indent="# ", subsequent_indent="# ", break_on_hyphens=False
    )


def _call(resolved: ResolvedStep) -> list[str]:
    if resolved.filter == CHANGE_LAYER:
        return [f"ms.set_current_mesh({_layer_at(resolved.values['mesh'])})"]
    arguments = [*_arguments(resolved), *_left_out(resolved)]
    call = _laid_out(f"ms.{resolved.python_name}", arguments)
    if resolved.then is not None:
        inside = (f"{INDENT}{line}" for line in _call(resolved.then))
        call += ["if ms.current_mesh().face_number():", *inside]
    if resolved.python_name in EMPTY_CLOUDS:
        return ["# beware: it deletes every point of a cloud without faces", *call]
    if resolved.keeps_current and not isinstance(resolved.filter, Filter):
        return ["before = ms.current_mesh_id()", *call, "ms.set_current_mesh(before)"]
    return call


def _arguments(resolved: ResolvedStep) -> list[tuple[str, list[str]]]:
    written = written_as(resolved)
    arguments = []
    for name, value in resolved.values.items():
        if name in resolved.layers:
            arguments.append((name, [_layer_at(value)]))
        elif isinstance(value, pymeshlab.PureValue):
            length = as_written(value, written.get(name))
            arguments.append((name, [f"pymeshlab.PureValue({length!r})"]))
        else:
            arguments.append((name, _literal(value)))
    return arguments


def _left_out(resolved: ResolvedStep) -> list[tuple[str, list[str]]]:
    """Return what our runner gives by itself: threads, and what MeshLab would remember."""
    if not isinstance(resolved.filter, NativeFilter):
        return []
    given = completed(resolved.filter, resolved.values)
    return [(name, _literal(value)) for name, value in given.items() if name not in resolved.values]


def _layer_at(position: int) -> str:
    """Return an expression for a layer's identifier: scripts count, MeshLab numbers."""
    return f"[mesh.id() for mesh in ms][{position}]"


def _laid_out(function: str, arguments: Sequence[tuple[str, list[str]]]) -> list[str]:
    """Return a call in one line if it fits, else with an argument a line."""
    if all(len(value) == 1 for _, value in arguments):
        inside = ", ".join(f"{name}={value[0]}" for name, value in arguments)
        if len(f"{INDENT}{function}({inside})") <= WIDTH:
            return [f"{function}({inside})"]
    lines = [f"{function}("]
    for name, (first, *rest) in arguments:
        whole = [f"{INDENT}{name}={first}", *(f"{INDENT}{line}" for line in rest)]
        whole[-1] += ","
        lines += whole
    return [*lines, ")"]


def _literal(value: Any) -> list[str]:
    """Return a value as an expression, in as many lines as it needs."""
    if isinstance(value, pymeshlab.PercentageValue):
        return [f"pymeshlab.PercentageValue({value.value()!r})"]
    if isinstance(value, pymeshlab.Color):
        channels = (value.red(), value.green(), value.blue(), value.alpha())
        return [f"pymeshlab.Color({', '.join(map(str, channels))})"]
    if isinstance(value, np.ndarray):
        return _array(value)
    if isinstance(value, str):
        return _text(value)
    return [repr(value)]


def _array(values: Any) -> list[str]:
    if values.ndim == 1:
        return [f"np.array({values.tolist()!r})"]
    rows = [f"{INDENT * 2}{row!r}," for row in values.tolist()]
    return ["np.array(", f"{INDENT}[", *rows, f"{INDENT}]", ")"]


def _text(value: str) -> list[str]:
    room = 40  # letters; twice as many columns when every one is escaped
    if len(repr(value)) <= room:
        return [_quoted(value)]
    pieces = [_quoted(value[start : start + room]) for start in range(0, len(value), room)]
    return ["(", *(f"{INDENT}{piece}" for piece in pieces), ")"]


def _quoted(text: str) -> str:
    plain = repr(text)
    return plain if '"' in text or plain.startswith('"') else f'"{plain[1:-1]}"'
