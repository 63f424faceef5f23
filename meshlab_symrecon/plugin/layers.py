"""What filters read and make: layers of a document, and the outcome of a run."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from meshlab_symrecon.arrays import Booleans, Faces, Floats, Points
from meshlab_symrecon.errors import GeometryError, ParameterError

__all__ = ["Layer", "Layers", "Outcome", "VertexScalars"]


@dataclass(frozen=True, slots=True, eq=False)
class Layer:
    """One layer of a document, in world coordinates (its transform matrix already applied).

    Attributes
    ----------
    points : (n, 3) float
    faces : (m, 3) int
        Triangles; shape (0, 3) for a cloud.
    normals : (n, 3) float or None
    colours : (n, 4) float or None
        Red, green, blue, alpha in 0..1, one a vertex.
    quality : (n,) float or None
        MeshLab's vertex scalar.
    face_quality : (m,) float or None
    face_colours : (m, 4) float or None
    selected : (n,) bool or None
        MeshLab's vertex selection.
    face_selected : (m,) bool or None
        MeshLab's face selection.
    attributes : mapping of str to (n,) float
        Custom scalars of the vertices.
    label : str
        The layer's name.
    identifier : int
        The document's number of the layer; -1 for one that is not in a document yet.
    """

    points: Points
    faces: Faces
    label: str = ""
    normals: Points | None = None
    colours: Floats | None = None
    quality: Floats | None = None
    face_quality: Floats | None = None
    face_colours: Floats | None = None
    selected: Booleans | None = None
    face_selected: Booleans | None = None
    attributes: Mapping[str, Floats] = field(default_factory=dict)
    identifier: int = -1

    @property
    def selection(self) -> Booleans | None:
        """The selected vertices, or else the corners of the selected faces; None for neither."""
        if self.selected is not None:
            return self.selected
        if self.face_selected is None:
            return None
        corners = np.zeros(len(self.points), dtype=np.bool_)
        corners[self.faces[self.face_selected]] = True
        return corners

    def required_selection(self) -> Booleans:
        """Return the selection, for a filter whose parameter ``onlyselected`` is set.

        Raises
        ------
        GeometryError
            Nothing is selected.
        """
        chosen = self.selection
        if chosen is None or not chosen.any():
            message = (
                f"onlyselected needs a selection; layer '{self.label}' has none; "
                "select what the filter shall look at, or set onlyselected to false"
            )
            raise GeometryError(message)
        return chosen


@dataclass(frozen=True, slots=True)
class Layers:
    """The layers of a document as a filter sees them; a layer is read when it is asked for.

    Attributes
    ----------
    labels : mapping of int to str
        Every layer's identifier and label, in the document's order.
    current_identifier : int
        The current layer; -1 when the document is empty.
    read : callable
        Returns the layer with a given identifier.
    """

    labels: Mapping[int, str]
    current_identifier: int
    read: Callable[[int], Layer]

    def __iter__(self) -> Iterator[int]:
        return iter(self.labels)

    @property
    def current(self) -> Layer:
        """The current layer.

        Raises
        ------
        GeometryError
            The document is empty.
        """
        if self.current_identifier not in self.labels:
            raise GeometryError("this filter needs a layer; got an empty document; load one first")
        return self.read(self.current_identifier)

    def get(self, identifier: int) -> Layer:
        """Return the layer with that identifier.

        Raises
        ------
        ParameterError
            No layer has it.
        """
        if identifier not in self.labels:
            known = ", ".join(f"{number} '{label}'" for number, label in self.labels.items())
            message = f"no layer has the number {identifier}; the document has {known or 'none'}"
            raise ParameterError(message)
        return self.read(identifier)

    def newest(self, label: str) -> Layer | None:
        """Return the newest layer of a label, in any case.

        What MeshLab appends does not count: ``(1)`` to a label that is taken, and the extension of
        the file when a layer was loaded from one.
        """
        same = re.compile(rf"\s*{re.escape(label)}(\(.*|\.\w+)?\s*", re.IGNORECASE)
        for identifier, name in sorted(self.labels.items(), reverse=True):
            if same.fullmatch(name):
                return self.read(identifier)
        return None

    def beside_current(self, identifier: int, label: str) -> Layer | None:
        """Return the layer that a parameter names, or the newest of a label for -1.

        Raises
        ------
        ParameterError
            No layer has that number.
        GeometryError
            It is the current layer itself.
        """
        found = self.get(identifier) if identifier >= 0 else self.newest(label)
        if found is not None and found.identifier == self.current_identifier:
            message = (
                f"this filter needs the scan as the current layer; got layer {found.identifier} "
                f"'{found.label}', which it reads beside the scan; make the scan current first"
            )
            raise GeometryError(message)
        return found


@dataclass(frozen=True, slots=True, eq=False)
class VertexScalars:
    """New scalars for the vertices of a layer that is in the document; all else of it stays.

    Attributes
    ----------
    identifier : int
        The layer's number.
    quality : (n,) float
        Takes the place of its vertex quality.
    name : str
        Of the custom attribute in which the same numbers are kept.
    attributes : mapping of str to (n,) float
        More custom attributes. A document cannot overwrite one: where a name is taken already, a
        number is appended to it.
    """

    identifier: int
    quality: Floats
    name: str
    attributes: Mapping[str, Floats] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """What a filter made.

    Attributes
    ----------
    layers : tuple of Layer
        New layers, added to the document in this order.
    current : int or None
        Which of the new layers becomes the current one; None leaves the current layer.
    measures : mapping
        What the Python method returns: numbers, booleans, texts and arrays by name.
    warnings : tuple of str
        Sentences the user should read.
    scalars : tuple of VertexScalars
        What is written into layers that were there.
    """

    layers: tuple[Layer, ...] = ()
    current: int | None = 0
    measures: Mapping[str, Any] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    scalars: tuple[VertexScalars, ...] = ()
