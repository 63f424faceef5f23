"""Where the lists of a PLY element are when they are of different lengths."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import Any

import numpy as np

from meshlab_symrecon.arrays import Indices
from meshlab_symrecon.host.ply_header import Element

__all__ = ["Places", "lists_in", "places_in"]

CODES = {"i1": "b", "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I", "f4": "f", "f8": "d"}
CUT = "it ends in the middle of {name} {number} of {count}"


@dataclass(frozen=True, slots=True, eq=False)
class Places:
    """The lists of an element.

    Attributes
    ----------
    items : (n,) int
        Where each item begins.
    starts, lengths : (lists, n) int
        Where each list begins, in bytes or in words of an ascii file, and how long it is; a row for
        each property that is a list.
    end : int
        Where the element ends.
    """

    items: Indices
    starts: Indices
    lengths: Indices
    end: int


def places_in(words: Any, start: int, form: str, element: Element) -> Places:
    """Walk through an element, item by item.

    Parameters
    ----------
    words : (n,) uint8, or float of an ascii file
    start : int
    form : str
        The file's format.
    element : Element

    Raises
    ------
    ValueError
        The file ends before the element does, or a list has no length.
    """
    plan, rest = _plan(form, element)
    view = memoryview(words)
    items: list[int] = []
    starts: list[int] = []
    lengths: list[int] = []
    at = start
    number = 0
    try:
        for number in range(element.count):
            items.append(at)
            for before, reader, counter_width, width in plan:
                at += before
                length = reader.unpack_from(view, at)[0] if reader else view[at]
                at += counter_width
                if not 0 <= length <= len(view):
                    raise ValueError(_no_length(element, number, length))
                starts.append(at)
                lengths.append(length)
                at += int(length) * width
            at += rest
    except (IndexError, struct.error):
        at = len(view) + 1
    if at > len(view):
        name, count = element.name, element.count
        raise ValueError(CUT.format(name=name, number=number + 1, count=count))
    found = np.array(lengths)
    if (found != np.floor(found)).any():
        wrong = int(np.argmax(found != np.floor(found)))
        raise ValueError(_no_length(element, wrong // len(plan), found[wrong]))
    shape = (element.count, len(plan))
    return Places(
        np.array(items, dtype=np.int64),
        np.array(starts, dtype=np.int64).reshape(shape).T,
        found.astype(np.int64).reshape(shape).T,
        at,
    )


def _no_length(element: Element, number: int, length: float) -> str:
    return f"{element.name} {number + 1} has a list of {length:g} numbers, which cannot be"


def _plan(
    form: str, element: Element
) -> tuple[list[tuple[int, struct.Struct | None, int, int]], int]:
    """Return what comes before each list, how its length is read and how wide both are.

    A length of one byte or word is read without ``struct``, which is quicker.
    """
    ascii_form = form == "ascii"
    order = ">" if form == "binary_big_endian" else "<"
    plan: list[tuple[int, struct.Struct | None, int, int]] = []
    before = 0
    for item in element.properties:
        width = 1 if ascii_form else int(item.kind[1])
        if not item.length_kind:
            before += width
            continue
        plain = ascii_form or item.length_kind == "u1"
        reader = None if plain else struct.Struct(order + CODES[item.length_kind])
        plan.append((before, reader, 1 if plain else int(item.length_kind[1]), width))
        before = 0
    return plan, before


def lists_in(words: Any, starts: Indices, length: int, kind: np.dtype[Any]) -> Any:
    """Return lists of one length as rows."""
    width = kind.itemsize // int(words.itemsize)
    picked = words[starts[:, None] + np.arange(length * width)]
    return np.ascontiguousarray(picked).view(kind).reshape(len(starts), length)
