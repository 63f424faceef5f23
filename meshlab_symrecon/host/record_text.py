"""The record of a result as comments in the header of a PLY file, and back."""

from __future__ import annotations

import json
import math
import shutil
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, BinaryIO

from meshlab_symrecon.errors import FileError
from meshlab_symrecon.host.atomic import reason

__all__ = ["Input", "Record", "Step", "put_record", "read_record", "record_text"]

LAYOUT = 1  # of the text; a later one may say more
MARK = b"comment meshlab_symrecon "
LINE = 400  # bytes at most; the least that a reader in use takes is 1024
TEXT_LIMIT = 1 << 16  # bytes
DEPTH = 16  # results that were made one from the other, each with the record of the one before
HEADER_LIMIT = 1 << 20  # bytes
END = "end_header"  # some readers look for it anywhere
HIDDEN_END = "end\\u005fheader"  # the same to JSON


@dataclass(frozen=True, slots=True)
class Step:
    """A filter that ran, by its Python name, with its parameters by theirs."""

    filter: str
    parameters: Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Input:
    """A file that was read: its name without folders, its checksum, and its own record."""

    name: str
    sha256: str
    record: Record | None = None


@dataclass(frozen=True, slots=True)
class Record:
    """How a result came about.

    Attributes
    ----------
    versions : mapping of str to str
        Of this package, and of those whose numbers go into the result.
    inputs : tuple of Input
    parameters : mapping
        The settings of the command, where it had some of its own.
    steps : tuple of Step
        Every filter in order.
    left_out : mapping of str to int
        How many ``steps``, ``inputs``, ``parameters`` and ``records`` of inputs there was no room
        for; the oldest steps go first.
    """

    versions: Mapping[str, str]
    inputs: tuple[Input, ...] = ()
    parameters: Mapping[str, Any] = field(default_factory=dict)
    steps: tuple[Step, ...] = ()
    left_out: Mapping[str, int] = field(default_factory=dict)

    def as_data(self) -> dict[str, Any]:
        """Return it as plain data for JSON."""
        return {
            "layout": LAYOUT,
            "versions": dict(self.versions),
            "inputs": [_input_data(item) for item in self.inputs],
            "parameters": dict(self.parameters),
            "steps": [{"filter": s.filter, "parameters": dict(s.parameters)} for s in self.steps],
            "left_out": dict(self.left_out),
        }


def _input_data(item: Input) -> dict[str, Any]:
    data: dict[str, Any] = {"name": item.name, "sha256": item.sha256}
    return data if item.record is None else data | {"record": item.record.as_data()}


def put_record(file: Path, record: Record) -> None:
    """Put a record into the header of a PLY file, which is replaced; its data stay as they are."""
    changed = file.with_name(f".recorded-{file.name}")
    with file.open("rb") as old, changed.open("wb") as new:
        new.write(old.readline())
        new.write(old.readline())  # the format has to be second
        new.writelines(MARK + piece + b"\n" for piece in _pieces(record_text(record)))
        shutil.copyfileobj(old, new, 1 << 20)
    changed.replace(file)


def record_text(record: Record) -> str:
    """Return a record as one text of printable ASCII without a space, shortened if need be."""
    record = _within(record, DEPTH)
    text = _text(record)
    while len(text) > TEXT_LIMIT:
        record = _shortened(record)
        text = _text(record)
    return text


def _text(record: Record) -> str:
    text = json.dumps(record.as_data(), ensure_ascii=True, allow_nan=False, separators=(",", ":"))
    return text.replace(" ", "\\u0020").replace("\x7f", "\\u007f").replace(END, HIDDEN_END)


def _within(record: Record, depth: int) -> Record:
    """Leave out the records of inputs that are more than so deep in each other."""
    if depth > 1:
        inputs = tuple(
            item if item.record is None else replace(item, record=_within(item.record, depth - 1))
            for item in record.inputs
        )
        return replace(record, inputs=inputs)
    return _without_earlier(record)


def _without_earlier(record: Record) -> Record:
    told = sum(item.record is not None for item in record.inputs)
    if not told:
        return record
    inputs = tuple(replace(item, record=None) for item in record.inputs)
    return replace(record, inputs=inputs, left_out=_more(record, "records", told))


def _more(record: Record, what: str, count: int) -> dict[str, int]:
    return {**record.left_out, what: record.left_out.get(what, 0) + count}


def _shortened(record: Record) -> Record:
    """Leave out the records of inputs, else half of the steps, else of the inputs, else more."""
    shorter = _without_earlier(record)
    if shorter is not record:
        return shorter
    if record.steps:
        lost = (len(record.steps) + 1) // 2
        left_out = _more(record, "steps", lost)
        return replace(record, steps=record.steps[lost:], left_out=left_out)
    if record.inputs:
        kept = len(record.inputs) // 2
        left_out = _more(record, "inputs", len(record.inputs) - kept)
        return replace(record, inputs=record.inputs[:kept], left_out=left_out)
    left_out = _more(record, "parameters", len(record.parameters))
    return replace(record, parameters={}, left_out=left_out)


def _pieces(text: str) -> list[bytes]:
    """Cut a text into lines, at the beginnings of steps and inputs where it can be."""
    room = LINE - len(MARK)
    lines = text.replace('{"filter":', '\n{"filter":').replace('{"name":', '\n{"name":').split("\n")
    return [
        line[start : start + room].encode("ascii")
        for line in lines
        for start in range(0, len(line), room)
    ]


def read_record(path: str | Path) -> Record | None:
    """Return the record in a PLY file; None when it has none, or is of another format.

    Raises
    ------
    FileError
        The file cannot be read, or its record is damaged.
    """
    path = Path(path)
    try:
        with path.open("rb") as file:
            text = b"".join(_marked(file))
    except OSError as error:
        raise FileError(f"{path} cannot be read: {reason(error)}; check its path") from error
    if not text:
        return None
    try:
        data = json.loads(text.decode("ascii"), parse_float=_finite, parse_constant=_finite)
        return _record_of(data, DEPTH)
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
        message = f"{path}: the record in its header is damaged; remove the lines '{MARK.decode()}'"
        raise FileError(message) from error


def _marked(file: BinaryIO) -> list[bytes]:
    if file.readline(8).strip() != b"ply":
        return []
    found = []
    while file.tell() < HEADER_LIMIT:
        line = file.readline(HEADER_LIMIT)
        if not line or line.strip() == END.encode():
            break
        if line.startswith(MARK):
            found.append(line.removeprefix(MARK).strip())
    return found


def _finite(text: str) -> float:
    number = float(text)
    if not math.isfinite(number):
        raise ValueError(f"a finite number was expected; got {text:.60}")
    return number


def _record_of(data: Any, depth: int) -> Record:
    if depth == 0:
        raise ValueError(f"more than {DEPTH} records are in each other")
    return Record(
        versions={name: _text_of(value) for name, value in data["versions"].items()},
        inputs=tuple(_input_of(item, depth) for item in data["inputs"]),
        parameters=dict(data["parameters"].items()),
        steps=tuple(
            Step(_text_of(step["filter"]), dict(step["parameters"].items()))
            for step in data["steps"]
        ),
        left_out={name: int(count) for name, count in data["left_out"].items()},
    )


def _input_of(data: Any, depth: int) -> Input:
    earlier = data.get("record")
    record = None if earlier is None else _record_of(earlier, depth - 1)
    return Input(_text_of(data["name"]), _text_of(data["sha256"]), record)


def _text_of(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError(f"a text was expected; got {value!r:.60}")
    return value
