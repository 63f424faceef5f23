"""What a filter is: its declaration, the layers it reads, and the outcome it returns.

A filter file has four parts in this order: its ``Parameters``, checks across parameters,
``run(layers, parameters, progress) -> Outcome``, and ``FILTER = Filter(...)``.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from meshlab_symrecon.arrays import Booleans, Faces, Floats, Points
from meshlab_symrecon.errors import GeometryError, ParameterError
from meshlab_symrecon.plugin.parameters import ParameterSet

__all__ = [
    "Citation",
    "Filter",
    "Layer",
    "Layers",
    "Outcome",
    "Progress",
    "no_check",
    "silent",
]

Progress: TypeAlias = Callable[[float, str], None]

REQUIREMENTS = ("points", "faces", "normals", "colours", "quality")


def silent(fraction: float, message: str) -> None:
    """Report progress to nobody."""


def no_check(parameters: Any) -> None:
    """Accept every combination of parameters."""


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
    attributes: Mapping[str, Floats] = field(default_factory=dict)
    identifier: int = -1


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
    """

    layers: tuple[Layer, ...] = ()
    current: int | None = 0
    measures: Mapping[str, Any] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Citation:
    """A publication, in the fields of CSL-JSON."""

    authors: str
    title: str
    container: str
    year: int
    identifier: str = ""  # DOI

    def __str__(self) -> str:
        tail = f" doi:{self.identifier}" if self.identifier else ""
        return f"{self.authors} ({self.year}). {self.title}. {self.container}.{tail}"


@dataclass(frozen=True, slots=True)
class Filter:
    """A filter, declared once.

    Attributes
    ----------
    menu_name : str
        Name in menus and scripts.
    python_name : str
        Name as a method of ``MeshSet``, by pymeshlab's naming law.
    aliases : tuple of str
        Other Python names, accepted everywhere.
    summary, description : str
        One line; and the whole text in Markdown.
    parameters : type
        The filter's ``ParameterSet``.
    run : callable
        ``run(layers, parameters, progress) -> Outcome``, pure.
    check : callable
        Checks across parameters; raises ParameterError.
    meshlab_class : str
        Menu of MeshLab, such as ``Remeshing``.
    category : str
        Category of MeshLab's coming version, such as ``Creation/Reconstruction``.
    requires : tuple of str
        What the current layer must have, of points, faces, normals, colours, quality.
    creates : tuple of str
        Labels of the layers it adds.
    arity : str
        ``SINGLE_MESH``, or ``VARIABLE`` when it reads other layers too.
    """

    menu_name: str
    python_name: str
    summary: str
    description: str
    parameters: type[ParameterSet]
    run: Callable[[Layers, Any, Progress], Outcome]
    meshlab_class: str
    category: str
    aliases: tuple[str, ...] = ()
    check: Callable[[Any], None] = no_check
    arity: str = "SINGLE_MESH"
    requires: tuple[str, ...] = ("points",)
    creates: tuple[str, ...] = ()
    citations: tuple[Citation, ...] = ()

    def __post_init__(self) -> None:
        for name in (self.python_name, *self.aliases):
            if not (name.isidentifier() and name == name.lower()):
                message = f"a filter's Python name must be a lower-case identifier; got {name!r}"
                raise ParameterError(message)
        if not self.menu_name or self.menu_name != " ".join(self.menu_name.split()):
            message = f"a menu name must be words with single spaces; got {self.menu_name!r}"
            raise ParameterError(message)
        unknown = set(self.requires) - set(REQUIREMENTS)
        if unknown:
            message = f"requires must be of {REQUIREMENTS}; got {sorted(unknown)}"
            raise ParameterError(message)

    @property
    def names(self) -> tuple[str, ...]:
        """Every name of the filter: Python name, aliases, menu name."""
        return (self.python_name, *self.aliases, self.menu_name)

    def bind(self, values: Mapping[str, object]) -> ParameterSet:
        """Return checked parameters.

        Raises
        ------
        ParameterError
            Unknown name, wrong type, out of range, or values that do not go together.
        """
        try:
            parameters = self.parameters.from_values(values)
            self.check(parameters)
        except ParameterError as error:
            raise ParameterError(f"{self.python_name}: {error}") from error
        return parameters

    def apply(
        self, layers: Layers, values: Mapping[str, object], progress: Progress = silent
    ) -> Outcome:
        """Check parameters and input, then run.

        Raises
        ------
        ParameterError
            As ``bind``.
        GeometryError
            The current layer lacks what the filter needs, or cannot be worked on.
        """
        parameters = self.bind(values)
        if self.requires:
            self._check_requirements(layers.current)
        return self.run(layers, parameters, progress)

    def _check_requirements(self, layer: Layer) -> None:
        present = {
            "points": len(layer.points) > 0,
            "faces": len(layer.faces) > 0,
            "normals": layer.normals is not None,
            "colours": layer.colours is not None,
            "quality": layer.quality is not None,
        }
        for need in self.requires:
            if not present[need]:
                message = (
                    f"'{self.menu_name}' needs {need}; layer '{layer.label}' has none; "
                    f"load or compute {need} first"
                )
                raise GeometryError(message)
