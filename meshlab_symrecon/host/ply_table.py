"""The data of one element of a PLY file as columns: ascii or binary, either order of bytes."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from meshlab_symrecon.arrays import Floats, Indices
from meshlab_symrecon.host.ply_header import Element, Header

__all__ = ["Column", "read_columns", "record_of"]


@dataclass(frozen=True, slots=True, eq=False)
class Column:
    """One property of every item of an element.

    Attributes
    ----------
    values : (n, k) float, or (total,) float where the lists are of different lengths
    lengths : (n,) int
        The length of each item's list; all 1 for a property that is no list.
    """

    values: Floats
    lengths: Indices

    @property
    def even(self) -> bool:
        """Whether all lists are of one length."""
        return self.values.ndim == 2


def read_columns(
    path: Path, header: Header, name: str, wanted: Iterable[str]
) -> Mapping[str, Column]:
    """Read some properties of an element.

    Without lists, or with lists of one length, the whole is one view of the file and only the
    columns that are wanted are copied; otherwise the file is walked item by item.

    Parameters
    ----------
    path : Path
    header : Header
    name : str
        The element's.
    wanted : iterable of str
        Names of properties.

    Raises
    ------
    ValueError
        The file ends too early, or has a word among its numbers.
    """
    words = _words(path, header) if header.form == "ascii" else _raw(path, header)
    start = 0
    for element in header.elements:
        if element.name == name:
            return _columns(words, start, header.form, element, frozenset(wanted))
        start = _end(words, start, header.form, element)
    return {}


def _words(path: Path, header: Header) -> Any:
    """Return every number of an ascii file."""
    with path.open("rb") as file, warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)  # how numpy tells of a word
        file.seek(header.start)
        try:
            return np.fromfile(file, dtype=np.float64, sep=" ")
        except (DeprecationWarning, ValueError) as error:  # by the version of numpy
            raise ValueError("there is a word among its numbers") from error


def _raw(path: Path, header: Header) -> Any:
    return np.memmap(path, dtype=np.uint8, mode="r", offset=header.start)


def record_of(words: Any, start: int, form: str, element: Element) -> np.dtype[Any] | None:
    """Return the layout that all items have when every list is as long as in the first item.

    None when a list is not, or when the file ends before.
    """
    order = ">" if form == "binary_big_endian" else "<"
    fields: list[Any] = []
    position = start
    for number, item in enumerate(element.properties):
        kind = np.dtype(np.float64) if form == "ascii" else np.dtype(order + item.kind)
        length = 1
        if item.length_kind:
            counter = kind if form == "ascii" else np.dtype(order + item.length_kind)
            length = int(_number(words, position, counter))
            fields.append((f"n{number}", counter))
            position += _width(words, counter)
        fields.append((f"v{number}", kind, (length,)))
        position += length * _width(words, kind)
    record = np.dtype(fields)
    if start + element.count * _width(words, record) > len(words):
        return None
    table = _table(words, start, element.count, record)
    for number, item in enumerate(element.properties):
        if item.length_kind and (table[f"n{number}"] != table[f"n{number}"][:1]).any():
            return None
    return record


def _width(words: Any, kind: np.dtype[Any]) -> int:
    """Return how many items of ``words``, bytes or numbers, something takes."""
    return kind.itemsize // int(words.itemsize)


def _number(words: Any, position: int, kind: np.dtype[Any]) -> float:
    held = words[position : position + _width(words, kind)]
    if len(held) < _width(words, kind):
        raise ValueError("it ends too early")
    return float(np.frombuffer(held.tobytes(), kind)[0])


def _table(words: Any, start: int, count: int, record: np.dtype[Any]) -> Any:
    return words[start : start + count * _width(words, record)].view(record)


def _end(words: Any, start: int, form: str, element: Element) -> int:
    if element.count == 0:
        return start
    record = record_of(words, start, form, element)
    if record is not None:
        return start + element.count * _width(words, record)
    return _walk(words, start, form, element, [])[1]


def _columns(
    words: Any, start: int, form: str, element: Element, wanted: frozenset[str]
) -> Mapping[str, Column]:
    chosen = [number for number, item in enumerate(element.properties) if item.name in wanted]
    named = {number: element.properties[number].name for number in chosen}
    if element.count == 0:
        none = np.zeros(0, dtype=np.int64)
        return {named[number]: Column(np.zeros((0, 1)), none) for number in chosen}
    record = record_of(words, start, form, element)
    if record is None:
        walked = _walk(words, start, form, element, chosen)[0]
        return dict(zip(named.values(), walked, strict=True))
    table = _table(words, start, element.count, record)
    columns = {}
    for number in chosen:
        values = np.array(table[f"v{number}"], dtype=np.float64)
        lengths = np.full(element.count, values.shape[1], dtype=np.int64)
        columns[named[number]] = Column(values, lengths)
    return columns


def _walk(
    words: Any, start: int, form: str, element: Element, chosen: list[int]
) -> tuple[list[Column], int]:
    """Go through lists of different lengths; return the chosen columns and where all ends."""
    order = ">" if form == "binary_big_endian" else "<"
    plain = np.dtype(np.float64) if form == "ascii" else None
    kinds = [
        (
            plain or np.dtype(order + item.kind),
            plain or np.dtype(order + (item.length_kind or "u1")),
            bool(item.length_kind),
        )
        for item in element.properties
    ]
    data = words.view(np.uint8)
    unit = int(words.itemsize)
    places: list[list[int]] = [[] for _ in kinds]
    lengths: list[list[int]] = [[] for _ in kinds]
    at = start * unit
    for _ in range(element.count):
        for number, (kind, counter, is_list) in enumerate(kinds):
            length = 1
            if is_list:
                length = int(_number(data, at, counter))
                at += counter.itemsize
            places[number].append(at)
            lengths[number].append(length)
            at += length * kind.itemsize
    if at > len(data):
        raise ValueError("it ends too early")
    columns = [
        _gathered(data, kinds[number][0], np.array(places[number]), np.array(lengths[number]))
        for number in chosen
    ]
    return columns, at // unit


def _gathered(data: Any, kind: np.dtype[Any], starts: Indices, lengths: Indices) -> Column:
    total = int(lengths.sum())
    first = np.repeat(starts, lengths)
    within = np.arange(total) - np.repeat(np.cumsum(lengths) - lengths, lengths)
    places = first + within * kind.itemsize
    picked = data[places[:, None] + np.arange(kind.itemsize)]
    flat = np.ascontiguousarray(picked).view(kind).astype(np.float64)
    if len(lengths) and (lengths == lengths[0]).all():
        return Column(flat.reshape(len(lengths), -1), lengths)
    return Column(flat.reshape(-1), lengths)
