"""What is known of a document, without the document: the model that a script is checked against.

A fact is known to hold, known not to hold, or unknown; only what is known leads to an error.
Facts mean what MeshLab means by them: a layer has vertex colour once it has been given room for
it, whatever the colours are.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from meshlab_symrecon.host.meshset import current_identifier

__all__ = ["FACTS", "UNKNOWN_LAYER", "DocumentState", "LayerState"]

FACTS = (
    "points",
    "faces",
    "edges",
    "normals",
    "vertex_colour",
    "face_colour",
    "quality",
    "face_quality",
    "vertex_texture",
    "wedge_texture",
    "textures",
    "vertex_selection",
    "face_selection",
    "visible",
)


@dataclass(frozen=True, slots=True)
class LayerState:
    """What is known of one layer.

    Attributes
    ----------
    facts : mapping of str to bool
        By the names in ``FACTS``; what is unknown is absent.
    label : str
        Empty when it is unknown.
    vertices : int or None
        Their number, None when it is unknown.
    had_faces : bool
        Whether it had faces at a step before, or may have had: then it is no cloud without them.
    """

    facts: Mapping[str, bool] = field(default_factory=dict)
    label: str = ""
    vertices: int | None = None
    had_faces: bool = False

    def has(self, fact: str) -> bool | None:
        """Say whether the fact holds; None when that is unknown."""
        return self.facts.get(fact)

    @property
    def is_cloud(self) -> bool:
        """Whether it certainly has points, and certainly has and had no faces."""
        return self.has("points") is True and self.has("faces") is False and not self.had_faces

    def joined(self, other: LayerState) -> LayerState:
        """Return what is known when it is this layer or the other."""
        same = {fact: held for fact, held in self.facts.items() if other.has(fact) is held}
        return LayerState(
            same,
            self.label if self.label == other.label else "",
            self.vertices if self.vertices == other.vertices else None,
            self.had_faces or other.had_faces,
        )

    @classmethod
    def of(cls, mesh: Any) -> LayerState:
        """Return what holds for a layer of a MeshSet; it is made compact for that, as by saving."""
        if not mesh.is_compact():
            mesh.compact()
        facts = {
            "points": mesh.vertex_number() > 0,
            "faces": mesh.face_number() > 0,
            "edges": mesh.edge_number() > 0,
            "normals": bool(np.any(mesh.vertex_normal_matrix())),
            "vertex_colour": mesh.has_vertex_color(),
            "face_colour": mesh.has_face_color(),
            "quality": mesh.has_vertex_scalar(),
            "face_quality": mesh.has_face_scalar(),
            "vertex_texture": mesh.has_vertex_tex_coord(),
            "wedge_texture": mesh.has_wedge_tex_coord(),
            "textures": mesh.texture_number() > 0,
            "vertex_selection": mesh.selected_vertex_number() > 0,
            "face_selection": mesh.selected_face_number() > 0,
            "visible": mesh.is_visible(),
        }
        return cls(facts, mesh.label(), int(mesh.vertex_number()))


UNKNOWN_LAYER = LayerState()


@dataclass(frozen=True, slots=True)
class DocumentState:
    """What is known of a document.

    Attributes
    ----------
    layers : tuple of LayerState
        The layers that are certainly there, from position 0 on.
    more : int or None
        How many more there may be behind them: 0 when these are all, None when that is unknown.
    current : int or None
        Position of the current layer; None when it is unknown, or there is none.
    loose : LayerState
        What is known of the current layer when its position is not.
    rasters : bool or None
        Whether it has rasters; None when that is unknown.
    """

    layers: tuple[LayerState, ...] = ()
    more: int | None = 0
    current: int | None = None
    loose: LayerState = UNKNOWN_LAYER
    rasters: bool | None = None

    @property
    def most(self) -> int | None:
        """The largest number of layers there can be; None when that is unknown."""
        return None if self.more is None else len(self.layers) + self.more

    @property
    def is_empty(self) -> bool:
        """Whether there certainly is no layer."""
        return self.most == 0

    @property
    def current_layer(self) -> LayerState:
        """What is known of the current layer."""
        return self.loose if self.current is None else self.layers[self.current]

    def with_current_at(self, position: int) -> DocumentState:
        """Return the same document with another current layer."""
        known = position if position < len(self.layers) else None
        return replace(self, current=known, loose=UNKNOWN_LAYER)

    def joined(self, other: DocumentState) -> DocumentState:
        """Return what is known when it is this document or the other."""
        pairs = zip(self.layers, other.layers, strict=False)  # what one has more, is uncertain
        layers = tuple(layer.joined(its) for layer, its in pairs)
        mosts = (self.most, other.most)
        more = None if None in mosts else max(most or 0 for most in mosts) - len(layers)
        position = self.current if self.current == other.current else None
        return DocumentState(
            layers=layers,
            more=more,
            current=position if position is not None and position < len(layers) else None,
            loose=self.current_layer.joined(other.current_layer),
            rasters=self.rasters if self.rasters == other.rasters else None,
        )

    @classmethod
    def unknown(cls) -> DocumentState:
        """Return what is known of a script's input that nobody has seen: it has a layer."""
        return cls((UNKNOWN_LAYER,), more=None)

    @classmethod
    def of(cls, mesh_set: Any) -> DocumentState:
        """Return what holds for a MeshSet: everything is known."""
        identifiers = [mesh.id() for mesh in mesh_set]
        current = current_identifier(mesh_set)
        return cls(
            layers=tuple(LayerState.of(mesh_set.mesh(number)) for number in identifiers),
            current=identifiers.index(current) if current in identifiers else None,
            rasters=mesh_set.raster_number() > 0,
        )
