"""What each file format holds, what a layer has, and so what is lost when it is written."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from meshlab_symrecon.arrays import Floats
from meshlab_symrecon.host.attributes import Attribute, attributes_of
from meshlab_symrecon.host.polygons import Polygons, polygons_of
from meshlab_symrecon.host.sources import source_of

__all__ = [
    "FACES_ONLY",
    "NEEDS_POINTS",
    "POINTS_ONLY",
    "TEXTURED",
    "WRITABLE",
    "Contents",
    "contents_of",
    "lost_in",
    "options_for",
]

NEEDS_POINTS = ("obj", "x3d", "3ds", "ctm", "xyz", "e57")  # no file without any
NORMALS = "vertex normals"
COLOURS = "vertex colours"
QUALITY = "vertex quality"
VERTEX_TEXTURE = "vertex texture coordinates"
WEDGES = "wedge texture coordinates"
TEXTURES = "textures"
FACE_COLOURS = "face colours"
FACE_QUALITY = "face quality"
SELECTED = "the vertex selection"
FACE_SELECTED = "the face selection"
EDGES = "edges"
POLYGONS = "polygons, which became triangles"
ATTRIBUTES = "custom attributes"

OPTION = {
    NORMALS: "vertex_normal",
    COLOURS: "vertex_color",
    QUALITY: "vertex_quality",
    VERTEX_TEXTURE: "vertex_coord",
    WEDGES: "wedge_texcoord",
    FACE_COLOURS: "face_color",
    FACE_QUALITY: "face_quality",
    SELECTED: "vertex_flag",
    FACE_SELECTED: "face_flag",
}  # kind: pymeshlab's word for it
WRITABLE: dict[str, tuple[str, ...]] = {
    "ply": tuple(OPTION),
    "obj": (NORMALS, COLOURS, VERTEX_TEXTURE, WEDGES, FACE_COLOURS),
    "off": (NORMALS, COLOURS, FACE_COLOURS),
    "stl": (FACE_COLOURS,),
    "xyz": (NORMALS,),
    "3ds": (),
    "3mf": (),
    "dae": (COLOURS, WEDGES),
    "dxf": (),
    "e57": (NORMALS, COLOURS, QUALITY),
    "wrl": (COLOURS, WEDGES),
    "x3d": (COLOURS, FACE_COLOURS, WEDGES),
}  # extension: what the format can hold beside points and faces, and what MeshLab may leave out
HARMFUL = {
    "off": ("vertex_coord",),
    "3ds": ("wedge_texcoord",),
    "x3d": ("vertex_coord",),
}  # options that MeshLab must not choose itself: it writes garbage, or fails on both coordinates
FACES_ONLY = ("stl", "3ds", "dxf", "wrl")  # points outside faces are lost in these
POINTS_ONLY = ("xyz", "e57")
TEXTURED = ("ply", "obj", "dae", "x3d", "wrl")  # these name the images of textures
WITH_EDGES = ("ply", "obj")
POLYGONAL = ("obj", "off")
WITH_ATTRIBUTES = ("ply",)
DECIMALS = 1e-7  # what MeshLab's OBJ files of polygons keep of a coordinate
FINE_ENOUGH = 1e-6  # box diagonals


@dataclass(frozen=True, slots=True)
class Contents:
    """What a layer has.

    Attributes
    ----------
    points, faces, edges : int
    held : frozenset of str
        The kinds of attributes.
    attributes : tuple of Attribute
        The custom ones.
    polygons : Polygons
    fine : bool
        Whether seven decimals are too few for its coordinates.
    around_zero : bool
        Whether zero is within the range of its quality.
    """

    points: int
    faces: int
    edges: int
    held: frozenset[str]
    attributes: tuple[Attribute, ...]
    polygons: Polygons
    fine: bool
    around_zero: bool


def contents_of(mesh_set: Any, identifier: int) -> Contents:
    """Return what a layer has; what MeshLab gives to every layer counts while it holds something.

    White colours and a quality of zeros count where the layer's file had them.
    """
    mesh = mesh_set.mesh(identifier)
    if not mesh.is_compact():
        mesh.compact()
    in_file = source_of(mesh_set, identifier).held
    faces = mesh.face_number()
    found = {
        NORMALS: bool(np.any(mesh.vertex_normal_matrix())),
        COLOURS: mesh.has_vertex_color()
        and (COLOURS in in_file or not (mesh.vertex_color_matrix() == 1.0).all()),
        QUALITY: mesh.has_vertex_scalar()
        and (QUALITY in in_file or bool(np.any(mesh.vertex_scalar_array()))),
        VERTEX_TEXTURE: mesh.has_vertex_tex_coord(),
        WEDGES: faces > 0 and mesh.has_wedge_tex_coord(),
        TEXTURES: mesh.texture_number() > 0,
        FACE_COLOURS: faces > 0
        and mesh.has_face_color()
        and (FACE_COLOURS in in_file or not (mesh.face_color_matrix() == 1.0).all()),
        FACE_QUALITY: faces > 0 and mesh.has_face_scalar(),
        SELECTED: mesh.selected_vertex_number() > 0,
        FACE_SELECTED: mesh.selected_face_number() > 0,
    }
    polygons = polygons_of(mesh_set, identifier) if faces else Polygons.NONE
    return Contents(
        points=mesh.vertex_number(),
        faces=faces,
        edges=mesh.edge_number(),
        held=frozenset(kind for kind, held in found.items() if held),
        attributes=attributes_of(mesh_set, identifier),
        polygons=polygons,
        around_zero=found[QUALITY] and _around_zero(mesh.vertex_scalar_array()),
        fine=bool(mesh.bounding_box().diagonal() * FINE_ENOUGH < DECIMALS),
    )


def _around_zero(values: Floats) -> bool:
    return values.size > 0 and bool(values.min() <= 0.0 <= values.max())


def _as_polygons(contents: Contents, extension: str) -> bool:
    """Say whether MeshLab's exporter can be trusted with a layer's polygons.

    It ends the process on polygons that share an edge with a third, and its OBJ files of polygons
    have seven decimals and wrong texture coordinates.
    """
    if contents.polygons is not Polygons.PLAIN or extension not in POLYGONAL:
        return False
    textured = contents.held & {WEDGES, VERTEX_TEXTURE}
    return extension != "obj" or not (textured or contents.fine)


def _mishandled(contents: Contents, extension: str) -> frozenset[str]:
    """Return what the format could hold, and MeshLab's exporter does not write well."""
    if extension == "off" and contents.held.issuperset({COLOURS, NORMALS}):
        return frozenset({NORMALS})  # the reader takes colours for normals
    if extension == "e57" and not contents.around_zero:
        return frozenset({QUALITY})  # the exporter fails
    return frozenset()


def options_for(contents: Contents, extension: str) -> Mapping[str, bool]:
    """Return the options of ``save_current_mesh`` that keep all that the format holds."""
    written = contents.held - _mishandled(contents, extension)
    options = {f"save_{OPTION[kind]}": kind in written for kind in WRITABLE[extension]}
    options |= {f"save_{word}": False for word in HARMFUL.get(extension, ())}
    if extension in POLYGONAL:
        options["save_polygonal"] = _as_polygons(contents, extension)
    if extension == "ply" and contents.polygons is not Polygons.NONE:
        options["save_face_flag"] = True  # where MeshLab keeps which edges are inside of a polygon
    return options


def lost_in(contents: Contents, extension: str) -> list[str]:
    """Return what a layer has and the format cannot hold, in words."""
    kept = set(WRITABLE[extension]) - _mishandled(contents, extension)
    if contents.faces:
        kept.add(NORMALS)  # every reader computes them from the faces
    if extension in TEXTURED:
        kept.add(TEXTURES)
    if WEDGES in contents.held & kept:
        kept.add(VERTEX_TEXTURE)  # MeshLab's OBJ reader makes these of the wedges'
    lost = [kind for kind in (*OPTION, TEXTURES) if kind in contents.held - kept]
    if contents.edges and extension not in WITH_EDGES:
        lost.append(f"{contents.edges} {EDGES}")
    polygons = contents.polygons is not Polygons.NONE and extension != "ply"
    if polygons and not _as_polygons(contents, extension):
        lost.append(POLYGONS)
    names = [
        attribute.name
        for attribute in contents.attributes
        if extension not in WITH_ATTRIBUTES or not attribute.known
    ]
    if names:
        lost.append(f"{ATTRIBUTES} ({', '.join(sorted(names))})")
    return lost
