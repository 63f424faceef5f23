"""What filters need, and what a document is after them, so far as trials and declarations show.

MeshLab's filters were tried once, by ``meshlab_symrecon.host.native_table``; a plugin's filter says
of itself what it needs and which layers it may add.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib.resources import files
from typing import Any

from meshlab_symrecon.host.constant_defaults import constant_defaults
from meshlab_symrecon.host.fates import believed, believed_of_made
from meshlab_symrecon.host.native_filters import NativeFilter, native_filters
from meshlab_symrecon.plugin import Filter

__all__ = ["OF_NAMED_LAYERS", "Expectation", "Need", "Way", "expectation"]

Fates = Mapping[str, str]  # by fact: what it becomes where it did not hold, and where it did
NEW = "new "  # the beginning of a way's ``current``; behind it stands which one, from the last

# What the facts of a plugin's requirements are called in a document.
OF_PLUGINS = {
    "points": "points",
    "faces": "faces",
    "normals": "normals",
    "colours": "vertex_colour",
    "quality": "quality",
}
# What the layers that parameters name must have; whoever reads the table above sees only the
# current one.
OF_NAMED_LAYERS: Mapping[str, Mapping[str, tuple[str, ...]]] = {
    "apply_coord_craters_from_point_cloud": {"target_mesh": ("faces",)},
    "apply_coord_point_cloud_movement_over_mesh": {"target_mesh": ("faces",)},
    "compute_color_by_point_cloud_voronoi_projection": {"coloredmesh": ("faces",)},
    "compute_mls_projection_apss": {"controlmesh": ("points",)},
    "compute_mls_projection_rimls": {"controlmesh": ("points",)},
    "transfer_attributes_per_vertex": {"sourcemesh": ("points",)},
    "transfer_attributes_to_texture_per_vertex": {"targetmesh": ("faces", "wedge_texture")},
    "transfer_texture_to_color_per_vertex": {"sourcemesh": ("faces", "wedge_texture", "textures")},
}
# Needs that MeshLab words as something else: a boundary, which only faces have.
MORE_NEEDS = {
    "compute_texcoord_parametrization_harmonic": "faces",
    "compute_texcoord_parametrization_least_squares_conformal_maps": "faces",
}


@dataclass(frozen=True, slots=True)
class Need:
    """A fact without which a filter refuses to work.

    Attributes
    ----------
    fact : str
        Of the current layer; or ``layer``, ``raster``, or ``selection`` of either kind.
    when : mapping
        Values with which it is needed; empty: always.
    unless : tuple of mappings
        Values with any of which it is not needed.
    """

    fact: str
    when: Mapping[str, Any] = field(default_factory=dict)
    unless: tuple[Mapping[str, Any], ...] = ()

    def applies(self, values: Mapping[str, Any]) -> bool:
        """Say whether the fact is needed with these values."""
        return _given(self.when, values) and not any(_given(it, values) for it in self.unless)


@dataclass(frozen=True, slots=True)
class Way:
    """How the list of layers changes.

    Attributes
    ----------
    added, most : int, int or None
        The least and the most layers that are added, behind the others; None: nobody knows.
    removed : str
        none, current, all, or empty when that is unknown.
    current : str
        Which layer is current afterwards: same, other (the one behind it, or else the first),
        ``new -1`` for the last new one, or empty when that is unknown.
    """

    added: int = 0
    most: int | None = 0
    removed: str = "none"
    current: str = "same"


UNKNOWN_WAY = Way(most=None, current="")


@dataclass(frozen=True, slots=True)
class Expectation:
    """What is expected of a filter.

    Attributes
    ----------
    needs : tuple of Need
    way : Way
        With values that are not among the exceptions.
    exceptions : tuple of (mapping, Way)
        Values that change the way.
    kept, others, made : mapping of str to str, or None
        Fates of facts: of the layer that was current, of those that were not, and of new layers,
        seen from the one that was current. What is absent stays, or is as there; None: all unknown.
    choices : frozenset of str
        Names of the parameters that are told apart in ``exceptions``, which were tried one by one.
    python_name : str
        Of MeshLab's filters, for their defaults.
    """

    needs: tuple[Need, ...] = ()
    way: Way = UNKNOWN_WAY
    exceptions: tuple[tuple[Mapping[str, Any], Way], ...] = ()
    kept: Fates | None = None
    others: Fates | None = None
    made: Fates | None = None
    choices: frozenset[str] = frozenset()
    python_name: str = ""

    def way_with(self, values: Mapping[str, Any]) -> Way:
        """Return how the layers change with these values."""
        found = [(given, way) for given, way in self.exceptions if _given(given, values)]
        if not found:
            return self.way
        given, way = found[0]
        if len(found) == 1 and not self._is_changed({*values} - {*given}, values):
            return way
        ways = (self.way, *(way for _, way in found))  # together, they may do anything of these
        removed = {way.removed for way in ways}
        return Way(most=None, removed=removed.pop() if len(removed) == 1 else "", current="")

    def _is_changed(self, names: set[str], values: Mapping[str, Any]) -> bool:
        """Say whether any of these choices is, or may be, another one than by default."""
        chosen = names & self.choices
        defaults = constant_defaults(self.python_name) if chosen else {}
        return any(name not in defaults or defaults[name] != values[name] for name in chosen)


def _given(wanted: Mapping[str, Any], values: Mapping[str, Any]) -> bool:
    return all(name in values and values[name] == value for name, value in wanted.items())


# Ways that depend on the shape of a layer or on what is visible, so that trials differ.
HAND_MADE = {
    "generate_splitting_by_connected_components": (
        UNKNOWN_WAY,
        (({"delete_source_mesh": True}, Way(most=None, removed="", current="")),),
    ),
    "generate_surface_reconstruction_vcg": (UNKNOWN_WAY, ()),
    "delete_non_visible_meshes": (Way(most=0, removed="", current=""), ()),
}


def expectation(item: Filter | NativeFilter) -> Expectation:
    """Return what is expected of a filter."""
    if isinstance(item, NativeFilter):
        return _of_natives()[item.python_name]
    needs = [Need("layer"), *(Need(OF_PLUGINS[name]) for name in item.requires)]
    # A filter need not declare what it makes: then nobody knows.
    return Expectation(
        needs=tuple(needs) if item.requires else (),
        way=Way(most=len(item.creates) or None, current=""),
        kept={"quality": "??"},  # it may write scalars into any layer
        others={"quality": "??"},
    )


@cache
def _of_natives() -> Mapping[str, Expectation]:
    table = json.loads(files("meshlab_symrecon.host").joinpath("native_filters.json").read_bytes())
    return {name: _read(native_filters()[name], facts) for name, facts in table.items()}


def _read(item: NativeFilter, facts: Mapping[str, Any]) -> Expectation:
    seen = facts["behaviour"]
    if seen is None:  # it was never tried
        return Expectation()
    more = MORE_NEEDS.get(item.python_name)
    needs = tuple(
        Need(
            need["fact"],
            _in_words(item, need.get("when", {})),
            tuple(_in_words(item, values) for values in need.get("unless", ())),
        )
        for need in [*seen["needs"], *([] if more is None else [{"fact": more}])]
    )
    way, exceptions = HAND_MADE.get(item.python_name) or _read_ways(item, seen["layers"])
    name = item.python_name
    return Expectation(
        needs,
        way,
        exceptions,
        kept=believed(name, seen["kept"]),
        others=believed(name, seen["others"]),
        made=believed_of_made(name, seen["made"]),
        choices=frozenset(
            known.name for known in item.parameters if known.rich_type in ("RichBool", "RichEnum")
        ),
        python_name=name,
    )


def _read_ways(
    item: NativeFilter, layers: Mapping[str, Any] | None
) -> tuple[Way, tuple[tuple[Mapping[str, Any], Way], ...]]:
    if layers is None:
        return UNKNOWN_WAY, ()
    exceptions = tuple(
        (_in_words(item, entry["values"]), _read_way(entry["way"]))
        for entry in layers.get("when", ())
    )
    return _read_way(layers), exceptions


def _read_way(facts: Mapping[str, Any] | None) -> Way:
    if facts is None:
        return UNKNOWN_WAY
    return Way(facts["added"], facts["added"], facts["removed"], facts["current"])


def _in_words(item: NativeFilter, values: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return values with the words of enums, by which steps name them, for their numbers."""
    words = {parameter.name: parameter.words for parameter in item.parameters}
    return {name: words[name][value] if words[name] else value for name, value in values.items()}
