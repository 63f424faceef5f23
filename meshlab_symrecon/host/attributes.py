"""Custom attributes of a layer, by their true names.

pymeshlab lists them in lower case only, and ends the process when it is asked to write one that a
mesh had before it was added to a document; so they are looked up by name and written by us.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import islice, product
from typing import Any

import numpy as np
import pymeshlab

from meshlab_symrecon.arrays import Floats
from meshlab_symrecon.host.meshset import (
    FACE_POINT_PREFIX,
    FACE_SCALAR_PREFIX,
    POINT_PREFIX,
    SCALAR_PREFIX,
    current_identifier,
)
from meshlab_symrecon.host.sources import source_of

__all__ = ["SCRATCH", "Attribute", "attributes_of", "read_attribute"]

SCRATCH = "symreconscratch"  # how names begin of attributes that are never written
GETTERS = {
    SCALAR_PREFIX: ("vertex", "vertex_custom_scalar_attribute_array"),
    POINT_PREFIX: ("vertex", "vertex_custom_point_attribute_matrix"),
    FACE_SCALAR_PREFIX: ("face", "face_custom_scalar_attribute_array"),
    FACE_POINT_PREFIX: ("face", "face_custom_point_attribute_matrix"),
}  # prefix of an option of the PLY exporter: what carries the attribute, and how it is read
MOST_SPELLINGS = 1 << 12  # that are tried: 30 ms


@dataclass(frozen=True, slots=True)
class Attribute:
    """A custom attribute.

    Attributes
    ----------
    element : str
        ``vertex`` or ``face``.
    name : str
        As pymeshlab lists it, where the true name is not known.
    getter : str
        The method of a mesh that returns its values.
    known : bool
        Whether the name is the true one.
    """

    element: str
    name: str
    getter: str
    known: bool


def attributes_of(mesh_set: Any, identifier: int) -> tuple[Attribute, ...]:
    """Return the custom attributes of a layer."""
    current = current_identifier(mesh_set)
    mesh_set.set_current_mesh(identifier)
    try:
        options = mesh_set.filter_parameter_values("ply")
    finally:
        if current >= 0:
            mesh_set.set_current_mesh(current)
    mesh, names = mesh_set.mesh(identifier), source_of(mesh_set, identifier).attributes
    found = []
    for option in options:
        prefix, listed = option[: len(SCALAR_PREFIX)], option[len(SCALAR_PREFIX) :]
        if prefix not in GETTERS or listed.startswith(SCRATCH):
            continue
        element, getter = GETTERS[prefix]
        name = _true_name(mesh, getter, listed, names.get(listed))
        found.append(Attribute(element, name or listed, getter, name is not None))
    return tuple(found)


def read_attribute(mesh: Any, attribute: Attribute) -> Floats:
    """Return the values of an attribute whose name is known: (n,), or (n, 3) for points."""
    return np.asarray(getattr(mesh, attribute.getter)(attribute.name), dtype=np.float64)


def _true_name(mesh: Any, getter: str, listed: str, remembered: str | None) -> str | None:
    """Return the name under which pymeshlab finds an attribute, None when none is found."""
    likely = [listed, listed.capitalize(), listed.upper(), listed.title()]
    letters = [(letter, letter.upper()) if letter.isalpha() else (letter,) for letter in listed]
    spellings = ("".join(word) for word in islice(product(*letters), MOST_SPELLINGS))
    blanks = (name.replace("_", " ") for name in likely if "_" in name)
    for name in ([remembered] if remembered else []) + likely + list(blanks):
        if _has(mesh, getter, name):
            return name
    return next((name for name in spellings if _has(mesh, getter, name)), None)


def _has(mesh: Any, getter: str, name: str) -> bool:
    try:
        getattr(mesh, getter)(name)
    except pymeshlab.PyMeshLabException:
        return False
    return True
