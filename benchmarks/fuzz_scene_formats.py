"""Good files of drawing programs: FBX, QOBJ, X3DV and WRL, written by hand."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator

import numpy as np
from fuzz_good import Good

__all__ = ["scene_files"]

MAGIC = b"Kaydara FBX Binary  \0\x1a\0" + struct.pack("<I", 7400)
CORNERS = 3
RECORD = 13  # bytes of a record's beginning, and of the empty one behind the last
Record = Callable[[int], bytes]
TEXT = """; FBX 7.4.0 project file
FBXHeaderExtension:  {{
	FBXVersion: 7400
}}
Objects:  {{
	Geometry: 10, "Geometry::thing", "Mesh" {{
		Vertices: *{0} {{
			a: {1}
		}}
		PolygonVertexIndex: *{2} {{
			a: {3}
		}}
	}}
	Model: 20, "Model::thing", "Mesh" {{
		Version: 232
	}}
}}
Connections:  {{
	C: "OO",20,0
	C: "OO",10,20
}}
"""


def scene_files(points: np.ndarray, faces: list[list[int]]) -> Iterator[Good]:
    """Yield files of a mesh; none for a cloud."""
    if not faces:
        return
    yield from _fbx(points, faces)
    yield from _vrml(points, faces)
    yield _qobj(points, faces)


def _cut(faces: list[list[int]]) -> int:
    return sum(len(face) - 2 for face in faces)


def _fbx(points: np.ndarray, faces: list[list[int]]) -> Iterator[Good]:
    """The last corner of a face is told by a number below zero."""
    used = len(np.unique([corner for face in faces for corner in face]))
    corners = [corner for face in faces for corner in (*face[:-1], -face[-1] - 1)]
    geometry = _record("Geometry", 10, b"thing\0\1Geometry", b"Mesh", inside=(
        _record("Vertices", points.ravel()),
        _record("PolygonVertexIndex", np.array(corners)),
    ))  # fmt: skip
    model = _record("Model", 20, b"thing\0\1Model", b"Mesh", inside=(_record("Version", 232),))
    joined = (_record("C", b"OO", 20, 0), _record("C", b"OO", 10, 20))
    content = MAGIC
    for record in (
        _record("FBXHeaderExtension", inside=(_record("FBXVersion", 7400),)),
        _record("Objects", inside=(geometry, model)),
        _record("Connections", inside=joined),
    ):
        content += record(len(content))
    content += b"\0" * (RECORD + 160)
    yield Good("binary.fbx", content, used, _cut(faces), None)
    numbers = ",".join(map(repr, points.ravel().tolist()))
    named = ",".join(map(str, corners))
    text = TEXT.format(points.size, numbers, len(corners), named)
    yield Good("text.fbx", text.encode(), used, _cut(faces), None)


def _record(name: str, *values: object, inside: tuple[Record, ...] = ()) -> Record:
    """Return what writes a record at a place of the file: records name where they end."""

    def at(place: int) -> bytes:
        told = b"".join(map(_value, values))
        start = place + RECORD + len(name) + len(told)
        held = b""
        for record in inside:
            held += record(start + len(held))
        held += b"\0" * RECORD if inside else b""
        head = struct.pack("<III", start + len(held), len(values), len(told))
        return head + bytes([len(name)]) + name.encode() + told + held

    return at


def _value(value: object) -> bytes:
    if isinstance(value, bytes):
        return b"S" + struct.pack("<I", len(value)) + value
    if isinstance(value, np.ndarray):
        code, kind = (b"d", "<f8") if value.dtype.kind == "f" else (b"i", "<i4")
        data = value.astype(kind).tobytes()
        return code + struct.pack("<III", value.size, 0, len(data)) + data
    return b"L" + struct.pack("<q", value)


def _vrml(points: np.ndarray, faces: list[list[int]]) -> Iterator[Good]:
    if any(len(face) != CORNERS for face in faces):
        return  # MeshLab leaves out polygons that are bent, as these are
    places = ", ".join(f"{x!r} {y!r} {z!r}" for x, y, z in points.tolist())
    corners = ", ".join(" ".join(map(str, [*face, -1])) for face in faces)
    shape = f"Shape {{ geometry IndexedFaceSet {{ coord Coordinate {{ point [ {places} ] }}\n"
    shape += f"coordIndex [ {corners} ] }} }}\n"
    beginnings = {"x3dv": "#X3D V3.0 utf8\nPROFILE Interchange\n", "wrl": "#VRML V2.0 utf8\n"}
    for extension, beginning in beginnings.items():
        content = (beginning + shape).encode()
        yield Good(f"hand.{extension}", content, len(points), _cut(faces), None)


def _qobj(points: np.ndarray, faces: list[list[int]]) -> Good:
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in points.tolist()]
    lines += ["f " + " ".join(str(corner + 1) for corner in face) for face in faces]
    content = "".join(line + "\n" for line in lines).encode()
    return Good("hand.qobj", content, len(points), _cut(faces), points)
