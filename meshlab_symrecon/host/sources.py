"""What is remembered of the files that the layers of a document came from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from weakref import WeakKeyDictionary

__all__ = ["Source", "input_files", "remember", "source_of", "texture_file"]


@dataclass(frozen=True, slots=True)
class Source:
    """The file of a layer.

    Attributes
    ----------
    files : tuple of Path
        All that belongs to it: the mesh, its materials, its textures. None may be overwritten.
    textures : mapping of str to Path
        The image behind each name that the layer has for a texture.
    missing : mapping of str to str
        The name in the file of a texture that was not found, by the layer's name of what MeshLab
        put in its place.
    held : frozenset of str
        Kinds of attributes that the file had, as ``host.formats`` calls them.
    attributes : mapping of str to str
        The name of each custom scalar of the vertices, by the name that pymeshlab lists.
    """

    files: tuple[Path, ...] = ()
    textures: Mapping[str, Path] = field(default_factory=dict)
    missing: Mapping[str, str] = field(default_factory=dict)
    held: frozenset[str] = frozenset()
    attributes: Mapping[str, str] = field(default_factory=dict)


_SOURCES: WeakKeyDictionary[Any, dict[int, Source]] = WeakKeyDictionary()


def remember(mesh_set: Any, identifier: int, source: Source) -> None:
    """Keep the source of a layer for as long as its document lives."""
    _SOURCES.setdefault(mesh_set, {})[identifier] = source


def source_of(mesh_set: Any, identifier: int) -> Source:
    """Return what is known of a layer's file; an empty one for a layer that was made here."""
    return _SOURCES.get(mesh_set, {}).get(identifier, Source())


def input_files(mesh_set: Any) -> frozenset[Path]:
    """Return every file that belongs to an input of the document."""
    sources = _SOURCES.get(mesh_set, {}).values()
    return frozenset(file.resolve() for source in sources for file in source.files)


def texture_file(mesh_set: Any, identifier: int, name: str) -> Path | None:
    """Return the image file behind a texture of a layer; copies of a layer share its textures."""
    known = _SOURCES.get(mesh_set, {})
    for source in (source_of(mesh_set, identifier), *known.values()):
        if name in source.textures:
            return source.textures[name]
    return None
