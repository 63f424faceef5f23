"""What the flags of ``-m`` mean to MeshLab's writers, format by format."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import numpy as np

__all__ = ["SAVED", "TEXT", "held_flags", "passed_over", "save_options"]

# Flag: the option of pymeshlab. "coord" is its name for texture coordinates of vertices.
OPTIONS = {
    "vc": "save_vertex_color",
    "vf": "save_vertex_flag",
    "vq": "save_vertex_quality",
    "vn": "save_vertex_normal",
    "vt": "save_vertex_coord",
    "vr": "save_vertex_radius",
    "fc": "save_face_color",
    "ff": "save_face_flag",
    "fq": "save_face_quality",
    "fn": "save_face_normal",
    "wc": "save_wedge_color",
    "wn": "save_wedge_normal",
    "wt": "save_wedge_texcoord",
    "mp": "save_polygonal",
}
# Flag: how a layer tells whether it has that. It has the others always, or never.
QUESTIONS = {
    "vc": "has_vertex_color",
    "vq": "has_vertex_scalar",
    "vt": "has_vertex_tex_coord",
    "fc": "has_face_color",
    "fq": "has_face_scalar",
    "wt": "has_wedge_tex_coord",
}
TEXT = "sa"  # the one flag that is no attribute
TEXT_FORMATS = ("ply", "stl")  # which have two forms, and the option "binary"
# Extension: what MeshLab's writer is able to take. That is asked of it; whether it then writes
# anything depends on the layer. NXS and NXZ are left out: their writers read freed memory, and end
# the process sooner or later. Wedge colours and normals are in no layer of pymeshlab.
SAVED: dict[str, tuple[str, ...]] = {
    "ply": ("vc", "vf", "vq", "vn", "vt", "vr", "fc", "ff", "fq", "wc", "wn", "wt"),
    "obj": ("vc", "vn", "vt", "fc", "wn", "wt", "mp"),
    "off": ("vc", "vn", "vt", "fc", "mp"),
    "stl": ("fc",),
    "xyz": ("vn",),
    "3ds": ("fc", "fn", "wn", "wt"),
    "3mf": (),
    "ctm": ("vc", "vq"),
    "dae": ("vc", "vn", "vt", "wn", "wt"),
    "dxf": (),
    "e57": ("vc", "vq", "vn"),
    "idtf": ("vc", "vn", "fc", "wn", "wt"),
    "json": ("vc", "vn", "vt"),
    "wrl": ("vc", "wc", "wt"),
    "x3d": ("vc", "vn", "vt", "fc", "fn", "wc", "wn", "wt"),
}


def save_options(extension: str, flags: Collection[str]) -> dict[str, bool]:
    """Return every save option of a format: true for a flag that is given, false for the others.

    Parameters
    ----------
    extension : str
        A key of ``SAVED``.
    flags : collection of str
        Those which the format cannot take have no effect; see ``passed_over``.
    """
    given = set(flags) - set(passed_over(extension, flags))
    options = {OPTIONS[flag]: flag in given for flag in SAVED[extension]}
    if extension in TEXT_FORMATS:
        options["binary"] = TEXT not in given
    return options


def passed_over(extension: str, flags: Collection[str]) -> tuple[str, ...]:
    """Return the flags that have no effect in a format, in alphabetical order.

    In OBJ, polygons give way to texture coordinates: MeshLab's writer would lose the texture.
    """
    able = {*SAVED[extension], *((TEXT,) if extension in TEXT_FORMATS else ())}
    if extension == "obj" and "wt" in flags:
        able.discard("mp")
    return tuple(sorted(flag for flag in set(flags) if flag not in able))


def held_flags(extension: str, mesh: Any) -> frozenset[str]:
    """Return the flags of everything that a layer has and a format can hold.

    Quality that is above or below 0 throughout is left out of E57, whose writer refuses it.

    Parameters
    ----------
    extension : str
        A key of ``SAVED``.
    mesh : pymeshlab.Mesh
    """
    absent = {flag for flag, question in QUESTIONS.items() if not getattr(mesh, question)()}
    if extension == "e57" and not _around_zero(mesh.vertex_scalar_array()):
        absent.add("vq")
    wanted = set(SAVED[extension]) - absent
    return frozenset(wanted - set(passed_over(extension, wanted)))


def _around_zero(values: Any) -> bool:
    return bool(np.min(values, initial=np.inf) <= 0.0 <= np.max(values, initial=-np.inf))
