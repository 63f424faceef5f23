"""What a filter is: one declaration from which everything else derives.

A filter file has four parts in this order: its ``Parameters``, checks across parameters,
``run(layers, parameters, progress) -> Outcome``, and ``FILTER = Filter(...)``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

from meshlab_symrecon.errors import GeometryError, ParameterError
from meshlab_symrecon.plugin.layers import Layer, Layers, Outcome
from meshlab_symrecon.plugin.parameter_sets import ParameterSet
from meshlab_symrecon.plugin.parameters import Parameter

__all__ = [
    "Citation",
    "Filter",
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
    citations : tuple of Citation
        The publications that it follows.

    Raises
    ------
    ParameterError
        A Python name that is no lower-case identifier, a menu name with odd spaces, or an unknown
        requirement.
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

    def find(self, name: str) -> Parameter:
        """Return the declaration of a parameter, by its name in any case.

        Raises
        ------
        ParameterError
            The filter has no such parameter.
        """
        return self.parameters.find(name, self.menu_name)

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
