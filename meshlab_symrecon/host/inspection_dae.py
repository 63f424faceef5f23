"""COLLADA files: corners that name points, normals or colours which are not there.

MeshLab's reader takes such a number for a place in its memory: it crashes, or gives a wrong mesh.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from meshlab_symrecon.host.ply_header import damaged

__all__ = ["check_dae"]

PRIMITIVES = ("triangles", "polylist", "polygons", "tristrips", "trifans", "lines")
POINT = "VERTEX"
COORDINATES = 3


def check_dae(path: Path) -> int:
    """Refuse numbers that lead out of the lists of a mesh; return 0.

    What is no such file at all, the reader itself says; coordinates that are no numbers have been
    refused before.

    Raises
    ------
    FileError
    """
    try:
        root = ElementTree.parse(path).getroot()  # noqa: S314  expat bounds what entities grow to
        problem = next(_problems(root), "")
    except (ElementTree.ParseError, ValueError, LookupError, OverflowError):
        return 0
    if problem:
        raise damaged(path, problem)
    return 0


def _problems(root: Element) -> Iterator[str]:
    for mesh in _all(root, "mesh"):
        lengths = {f"#{source.get('id')}": _length(source) for source in _all(mesh, "source")}
        for vertices in _all(mesh, "vertices"):
            named = [one.get("source") for one in _inputs(vertices, "POSITION")]
            lengths[f"#{vertices.get('id')}"] = lengths[named[0] or ""]
        for kind in PRIMITIVES:
            for primitive in _all(mesh, kind):
                yield from _of_primitive(primitive, lengths)


def _of_primitive(primitive: Element, lengths: dict[str, int]) -> Iterator[str]:
    inputs = list(_inputs(primitive))
    step = 1 + max(int(one.get("offset", "0")) for one in inputs)
    for corners in _all(primitive, "p"):
        numbers = np.array((corners.text or "").split(), dtype=np.int64)
        for one in inputs:
            listed = numbers[int(one.get("offset", "0")) :: step]
            length = lengths.get(one.get("source", ""))
            if length is None or not len(listed):
                continue
            lowest = int(listed.min()) if one.get("semantic") == POINT else 0
            wrong = int(listed.max()) if listed.max() >= length else lowest
            if wrong < 0 or wrong >= length:
                what = "points" if one.get("semantic") == POINT else "entries for it"
                yield f"a face names {one.get('semantic')} {wrong} of a mesh with {length} {what}"


def _all(element: Element, name: str) -> Iterator[Element]:
    """Yield the elements of a name below, whatever their namespace."""
    return (one for one in element.iter() if one.tag.rpartition("}")[2] == name)


def _inputs(element: Element, semantic: str = "") -> Iterator[Element]:
    for one in _all(element, "input"):
        if semantic in ("", one.get("semantic")):
            yield one


def _length(source: Element) -> int:
    """Return how many entries a list has by what is there, whatever is announced."""
    step = next((one.get("stride", "1") for one in _all(source, "accessor")), str(COORDINATES))
    return sum(len((one.text or "").split()) for one in _all(source, "float_array")) // int(step)
