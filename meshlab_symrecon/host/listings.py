"""What pymeshlab prints of its filters and scripts, printed of plugin filters in the same form.

It is written to Python's standard output, where pymeshlab writes to that of C++.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator

from meshlab_symrecon import _native
from meshlab_symrecon.host.mlx import Param, Script, Step
from meshlab_symrecon.host.resolution import matched
from meshlab_symrecon.host.translation import script_name_in_python
from meshlab_symrecon.plugin import Filter
from meshlab_symrecon.plugin.parameters import Kind, Parameter

__all__ = ["print_found", "print_names", "print_parameters", "print_script"]

PYTHON_TYPES = {
    "RichBool": "bool",
    "RichInt": "int",
    "RichMesh": "int",
    "RichFloat": "float",
    "RichDynamicFloat": "float (bounded)",
    "RichAbsPerc": "PureValue",
    "RichColor": "Color",
    "RichPosition": "numpy.ndarray[numpy.float64[3]]",
    "RichDirection": "numpy.ndarray[numpy.float64[3]]",
    "RichPoint3f": "numpy.ndarray[numpy.float64[3]]",
    "RichMatrix44f": "numpy.ndarray[numpy.float64[4, 4]]",
}
NUMERIC = (Kind.INTEGER, Kind.NUMBER, Kind.DIAGONAL_FRACTION, Kind.SPACING_MULTIPLE)


def print_names(filters: Iterable[Filter]) -> None:
    """Go on with the list that pymeshlab has printed."""
    _write(f"\t{item.python_name}" for item in filters)


def print_parameters(item: Filter) -> None:
    """Print each parameter with its type and default, and the range of a number."""
    _write(
        [
            f"{item.python_name} filter - list of parameter names:",
            *(f"\t{_declared(known)}" for known in item.parameters.declared()),
        ]
    )


def _declared(known: Parameter) -> str:
    shown = type(known.default).__name__
    if known.kind in NUMERIC and known.low is not None and known.high is not None:
        bounds = f"[min: {known.low:.12g}; max: {known.high:.12g}]"
        return f"{known.name} : {shown} (bounded) = {known.default!r} {bounds}"
    return f"{known.name} : {shown} = {known.default!r}"


def print_found(filters: Iterable[Filter], keyword: str) -> None:
    """Print the filters that have a word in a name or in what they do, with what they do."""
    wanted = keyword.lower()
    found = [
        item
        for item in filters
        if any(wanted in text.lower() for text in (*item.names, item.summary))
    ]
    width = max((len(item.python_name) for item in found), default=0)
    _write(f"{item.python_name:{width}} : {item.summary}" for item in found)


def print_script(script: Script) -> None:
    """Print each step under its Python name of today, with every value in full."""
    _write([f"Filter Script Size : {len(script.steps)}", ""])
    resolved = matched(script).steps
    for number, (step, today) in enumerate(zip(script.steps, resolved, strict=True)):
        name = step.name if today is None else today.python_name
        _write([f"{number}: {name}", *_values(step), ""])


def _values(step: Step) -> Iterator[str]:
    for param in step.parameters:
        shown = PYTHON_TYPES.get(param.rich_type, "str")
        yield f"\t{script_name_in_python(param.name)} : {shown} = {_value(param)}"


def _value(param: Param) -> str:
    if param.text is None:
        return f"[{', '.join(param.attributes.values())}]"
    if param.rich_type == "RichEnum":
        return repr(param.attributes.get(f"enum_val{param.text}", param.text))
    if param.rich_type == "RichBool":
        return param.text.capitalize()
    return param.text if param.rich_type in PYTHON_TYPES else repr(param.text)


def _write(lines: Iterable[str]) -> None:
    _native.flush_streams()  # into a pipe or a file, both keep what they have for later
    sys.stdout.write("".join(f"{line}\n" for line in lines))
    sys.stdout.flush()
