"""Input files for the table of what survives: written by hand, one for each attribute."""

from __future__ import annotations

import base64
import json
import struct
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

QUADS = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
BOX = np.array([[x, y, z] for z in (0, 0.5) for y in (0, 0.75) for x in (0, 1.25)])
TRIANGLES = np.array([(q[0], q[i], q[i + 1]) for q in QUADS for i in (1, 2)])
BENT = BOX + np.arange(8)[:, None] / 64  # no two corners of a coordinate, so places are names
IMAGE = "paint/stone.png"
COUNT, FACES = len(BENT), len(TRIANGLES)


def png(path: Path, seed: int = 0) -> None:
    """Write a picture of noise."""
    path.parent.mkdir(parents=True, exist_ok=True)
    pixels = np.random.default_rng(seed).integers(0, 256, (8, 8, 3), dtype=np.uint8)
    rows = b"".join(b"\0" + row.tobytes() for row in pixels)

    def chunk(kind: bytes, data: bytes) -> bytes:
        return (
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        )

    head = struct.pack(">IIBBBBB", 8, 8, 8, 2, 0, 0, 0)
    parts = chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + parts)


def ply(
    path: Path,
    points: np.ndarray,
    faces: Sequence[Sequence[int]] = (),
    vertex: Mapping[str, Sequence[str]] | None = None,
    face: Mapping[str, Sequence[str]] | None = None,
    edges: Sequence[Sequence[int]] = (),
    image: str = "",
) -> None:
    """Write an ascii PLY file; properties are given by declaration, with a text an item."""
    vertex, face = dict(vertex or {}), dict(face or {})
    lines = ["ply", "format ascii 1.0", *([f"comment TextureFile {image}"] if image else [])]
    lines += [f"element vertex {len(points)}", *(f"property double {axis}" for axis in "xyz")]
    lines += [f"property {name}" for names in vertex for name in names.split(";")]
    if len(faces):
        lines += [f"element face {len(faces)}", "property list uchar int vertex_indices"]
        lines += [f"property {name}" for names in face for name in names.split(";")]
    if len(edges):
        lines += [f"element edge {len(edges)}", "property int vertex1", "property int vertex2"]
    lines.append("end_header")
    for number, point in enumerate(points.tolist()):
        words = [*map(repr, point), *(texts[number] for texts in vertex.values())]
        lines.append(" ".join(words))
    for number, corners in enumerate(faces):
        words = [str(len(corners)), *map(str, corners), *(texts[number] for texts in face.values())]
        lines.append(" ".join(words))
    lines += [f"{first} {second}" for first, second in edges]
    path.write_text("\n".join(lines) + "\n")


def wedge_texts(count: int) -> list[str]:
    """Return texture coordinates for triangles, each of its own."""
    return [f"6 {i / 64} {i / 128} {(i + 1) / 64} 0.25 0.5 {(i + 3) / 64}" for i in range(count)]


def texts(count: int, pattern: str) -> list[str]:
    """Return a text for each of many items; ``{i}`` is its number."""
    return [pattern.format(i=i, f=i / 8 + 0.125, q=i / 8, b=20 * i % 256) for i in range(count)]


V, F = range(COUNT), range(FACES)
COLOURED = "uchar red;uchar green;uchar blue;uchar alpha"
PLY_INPUTS: dict[str, dict[str, object]] = {
    "faces": {"faces": TRIANGLES},
    "vertex normals of a cloud": {
        "vertex": {"double nx;double ny;double nz": texts(COUNT, "0 1 0")[:4] + texts(4, "1 0 0")}
    },
    "vertex colours": {"faces": TRIANGLES, "vertex": {COLOURED: texts(COUNT, "{b} 7 9 255")}},
    "white vertex colours": {
        "faces": TRIANGLES,
        "vertex": {COLOURED: texts(COUNT, "255 255 255 255")},
    },
    "vertex quality": {"faces": TRIANGLES, "vertex": {"double quality": texts(COUNT, "{q}")}},
    "quality called confidence": {
        "faces": TRIANGLES,
        "vertex": {"float confidence": texts(COUNT, "{f}")},
    },
    "vertex texture coordinates": {
        "faces": TRIANGLES,
        "vertex": {"float texture_u;float texture_v": texts(COUNT, "{f} 0.75")},
        "image": IMAGE,
    },
    "wedge texture coordinates": {
        "faces": TRIANGLES,
        "face": {"list uchar float texcoord": wedge_texts(FACES)},
        "image": IMAGE,
    },
    "images of textures": {
        "faces": TRIANGLES,
        "face": {"list uchar float texcoord": wedge_texts(FACES)},
        "image": IMAGE,
    },
    "names of missing images": {
        "faces": TRIANGLES,
        "face": {"list uchar float texcoord": wedge_texts(FACES)},
        "image": "gone.png",
    },
    "face colours": {"faces": TRIANGLES, "face": {COLOURED: texts(FACES, "{b} 7 9 255")}},
    "face quality": {"faces": TRIANGLES, "face": {"double quality": texts(FACES, "{f}")}},
    "vertex selection": {
        "faces": TRIANGLES,
        "vertex": {"int flags": ["32" if i in (1, 5) else "0" for i in V]},
    },
    "face selection": {
        "faces": TRIANGLES,
        "face": {"int flags": ["32" if i in (3, 4) else "0" for i in F]},
    },
    "polygons": {"faces": QUADS},
    "edges": {"edges": [(0, 1), (1, 3), (3, 2), (6, 7)]},
    "custom numbers of vertices": {
        "faces": TRIANGLES,
        "vertex": {"uchar Class": texts(COUNT, "{i}"), "double intensity": texts(COUNT, "{f}")},
    },
    "custom points of vertices": {
        "faces": TRIANGLES,
        "vertex": {"list uchar float flow": texts(COUNT, "3 {i} 0 {f}")},
    },
    "custom numbers of faces": {"faces": TRIANGLES, "face": {"int part": texts(FACES, "{i}")}},
    "custom points of faces": {
        "faces": TRIANGLES,
        "face": {"list int double axis": texts(FACES, "3 {i} 0 {f}")},
    },
    "transform matrix": {"faces": TRIANGLES},
}


def write_input(folder: Path, row: str) -> Path:
    """Write the PLY file that has one attribute, with its image; return its path."""
    folder.mkdir(parents=True, exist_ok=True)
    if row != "names of missing images":
        png(folder / IMAGE)
    ply(folder / "in.ply", BENT, **PLY_INPUTS[row])
    return folder / "in.ply"


def write_obj(folder: Path, row: str) -> Path | None:
    """Write the OBJ file that has one attribute; None when OBJ has no place for it."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "in.obj"
    image = "gone.png" if row == "names of missing images" else IMAGE
    png(folder / IMAGE)
    (folder / "in.mtl").write_text(f"newmtl stone\nKd 1 1 1\nmap_Kd {image}\n")
    colours = {"vertex colours": "{c} 0.25 0.5", "white vertex colours": "1 1 1"}.get(row, "")
    points = [
        f"v {x!r} {y!r} {z!r} {colours.format(c=i / 255)}".rstrip()
        for i, (x, y, z) in enumerate(BENT.tolist())
    ]
    faces = ["f {} {} {}".format(*(row + 1)) for row in TRIANGLES]
    if row in ("faces", "vertex colours", "white vertex colours", "transform matrix"):
        lines = points + faces
    elif row in ("wedge texture coordinates", "images of textures", "names of missing images"):
        coordinates = [f"vt {i / 64} {i / 128}" for i in range(3 * FACES)]
        corners = [
            "f " + " ".join(f"{c + 1}/{3 * i + k + 1}" for k, c in enumerate(row))
            for i, row in enumerate(TRIANGLES.tolist())
        ]
        lines = ["mtllib in.mtl", *points, *coordinates, "usemtl stone", *corners]
    elif row == "vertex normals of a cloud":
        lines = [line for point in points for line in ("vn 0 1 0", point)]
    elif row == "polygons":
        lines = points + ["f " + " ".join(str(c + 1) for c in quad) for quad in QUADS]
    elif row == "edges":
        lines = [*points, "l 1 2", "l 2 4", "l 4 3", "l 7 8"]
    else:
        return None
    path.write_text("\n".join(lines) + "\n")
    return path


def write_gltf(folder: Path, row: str) -> Path | None:
    """Write the glTF file that has one attribute; None when glTF has no place for it."""
    folder.mkdir(parents=True, exist_ok=True)
    png(folder / IMAGE)
    places = BENT[TRIANGLES].reshape(-1, 3).astype("<f4")  # a vertex a corner, as glTF has it
    count = len(places)
    arrays = {"POSITION": ("VEC3", places)}
    if row == "vertex colours":
        colours = np.repeat(np.arange(count) % 8 / 8, 3).reshape(-1, 3)
        arrays["COLOR_0"] = ("VEC3", colours.astype("<f4"))
    elif row in ("wedge texture coordinates", "images of textures"):
        arrays["TEXCOORD_0"] = ("VEC2", (np.arange(2 * count) / 128).reshape(-1, 2).astype("<f4"))
    elif row != "faces":
        return None
    data, views, accessors = b"", [], []
    for kind, values in arrays.values():
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": values.nbytes})
        data += values.tobytes()
        accessor = {"bufferView": len(accessors), "componentType": 5126, "count": count}
        low_high = {"min": values.min(0).tolist(), "max": values.max(0).tolist()}
        accessors.append({**accessor, "type": kind, **low_high})
    corners = np.arange(count, dtype="<u2")
    views.append({"buffer": 0, "byteOffset": len(data), "byteLength": corners.nbytes})
    data += corners.tobytes()
    indices = {"bufferView": len(accessors), "componentType": 5123, "count": count}
    accessors.append({**indices, "type": "SCALAR"})
    primitive = {
        "attributes": {name: number for number, name in enumerate(arrays)},
        "indices": len(arrays),
    }
    content = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "buffers": [
            {
                "byteLength": len(data),
                "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode(),
            }
        ],
        "bufferViews": views,
        "accessors": accessors,
        "meshes": [{"primitives": [primitive]}],
    }
    if "TEXCOORD_0" in arrays:
        primitive["material"] = 0
        content |= {
            "images": [{"uri": IMAGE}],
            "textures": [{"source": 0}],
            "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        }
    (folder / "in.gltf").write_text(json.dumps(content))
    return folder / "in.gltf"


def write_ptx(folder: Path, row: str) -> Path | None:
    """Write the PTX file that has one attribute; None when PTX has no place for it."""
    folder.mkdir(parents=True, exist_ok=True)
    frame = ["0 0 0", "1 0 0", "0 1 0", "0 0 1", "1 0 0 0", "0 1 0 0", "0 0 1 0", "0 0 0 1"]
    patterns = {"vertex colours": "0.5 {b} 7 9", "vertex quality": "{q}", "transform matrix": "0.5"}
    if row not in patterns:
        return None
    lines = [
        f"{x + 1!r} {y!r} {z!r} {text}"
        for (x, y, z), text in zip(BENT.tolist(), texts(COUNT, patterns[row]), strict=True)
    ]
    path = folder / "in.ptx"
    path.write_text("\n".join(["4", "2", *frame, *lines]) + "\n")
    return path


WRITERS = {
    "obj": write_obj,
    "gltf": write_gltf,
    "ptx": write_ptx,
}
