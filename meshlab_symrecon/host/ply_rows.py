"""The items of a PLY element where they are in the file, with lists of any lengths."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from meshlab_symrecon.arrays import Indices
from meshlab_symrecon.host.ply_header import Element
from meshlab_symrecon.host.ply_lists import Places, lists_in, places_in
from meshlab_symrecon.host.ply_table import record_of

__all__ = ["Rows", "rows_of"]

PART = 1 << 16  # items at a time


@dataclass(frozen=True, slots=True, eq=False)
class Rows:
    """An element's items.

    Attributes
    ----------
    element : Element
    words : array
        Of the whole file: bytes, or numbers of an ascii file.
    form : str
        The file's format.
    table : array or None
        The items as records when every list is as long as in the first of them.
    places : Places or None
        Where the lists are, otherwise.
    end : int
        Where the element ends.
    """

    element: Element
    words: Any
    form: str
    table: Any
    places: Places | None
    end: int

    def parts(self) -> Iterator[slice]:
        """Yield ranges of items that are no burden on memory."""
        for first in range(0, self.element.count, PART):
            yield slice(first, min(first + PART, self.element.count))

    def values(self, number: int, part: slice) -> Any:
        """Return the numbers of a property that is no list, (n,), in the type of the file."""
        if self.places is None:
            return self.table[f"v{number}"][part, 0]
        starts = self.places.items[part]
        lists = -1
        for item in self.element.properties[:number]:
            width = self._kind(item.kind).itemsize // int(self.words.itemsize)
            if item.length_kind:
                lists += 1
                starts = self.places.starts[lists][part] + self.places.lengths[lists][part] * width
            else:
                starts = starts + width
        return lists_in(self.words, starts, 1, self._kind(self.element.properties[number].kind))[
            :, 0
        ]

    def lists(self, number: int) -> Iterator[tuple[Indices, Any]]:
        """Yield lists of one property, those of one length together: which items, and rows."""
        if self.places is None:
            for part in self.parts():
                yield np.arange(part.start, part.stop), self.table[f"v{number}"][part]
            return
        before = self.element.properties[:number]
        which = sum(bool(item.length_kind) for item in before)
        starts, lengths = self.places.starts[which], self.places.lengths[which]
        kind = self._kind(self.element.properties[number].kind)
        for length in np.unique(lengths).tolist():
            items = np.flatnonzero(lengths == length)
            step = max(1, PART // max(1, length))
            for first in range(0, len(items), step):
                chosen = items[first : first + step]
                yield chosen, lists_in(self.words, starts[chosen], length, kind)

    def _kind(self, code: str) -> np.dtype[Any]:
        order = ">" if self.form == "binary_big_endian" else "<"
        return np.dtype(np.float64) if self.form == "ascii" else np.dtype(order + code)


def rows_of(words: Any, start: int, form: str, element: Element) -> Rows:
    """Return the items of an element that begins at ``start``.

    Raises
    ------
    ValueError
        The file ends before the element does, or a list has no length.
    """
    if element.count == 0:
        return Rows(element, words, form, None, None, start)
    record = None
    with suppress(ValueError):  # of a first list without a length; the walk tells
        record = record_of(words, start, form, element)
    if record is None:
        places = places_in(words, start, form, element)
        return Rows(element, words, form, None, places, places.end)
    end = start + element.count * (record.itemsize // int(words.itemsize))
    return Rows(element, words, form, words[start:end].view(record), None, end)
