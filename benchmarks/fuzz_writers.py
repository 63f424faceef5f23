"""Good files of every format that is read, written by hand or by MeshLab, with what they hold."""

from __future__ import annotations

import json
import struct
import tempfile
from base64 import b64encode
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from fuzz_good import Good
from fuzz_scanner_formats import scanner_files
from fuzz_scene_formats import scene_files

__all__ = ["Good", "good_files"]

PLY_TYPES = {"f4": "float", "f8": "double", "u1": "uchar", "i4": "int", "i2": "short"}
BY_MESHLAB = ("3ds", "3mf", "ctm", "dae", "e57", "obj", "off", "ply", "stl", "wrl", "x3d", "xyz")


def _shapes(generator: np.random.Generator) -> dict[str, tuple[np.ndarray, list[list[int]]]]:
    count = int(generator.integers(5, 60))
    points = generator.normal(size=(count, 3)) * 10.0 ** generator.integers(-3, 4)
    triangles = [generator.choice(count, 3, replace=False).tolist() for _ in range(count)]
    mixed = [generator.choice(count, k, replace=False).tolist() for k in (3, 4, 3, 5, 3)]
    return {"cloud": (points, []), "mesh": (points, triangles), "mixed": (points, mixed)}


def good_files(seed: int) -> Iterator[Good]:
    """Yield good files of all kinds."""
    generator = np.random.default_rng(seed)
    for shape, (points, faces) in _shapes(generator).items():
        for good in (
            *_ply(points, faces, generator), *_obj(points, faces, generator),
            *_off(points, faces), *_stl(points, faces), *_texts(points, faces),
            *_gltf(points, faces), *scanner_files(points, faces), *scene_files(points, faces),
        ):  # fmt: skip
            yield replace(good, name=f"{shape}-{good.name}")
    yield from _by_meshlab(generator)


def _cut(faces: list[list[int]]) -> int:
    return sum(len(face) - 2 for face in faces)


def _rows(points: np.ndarray) -> list[str]:
    return [" ".join(map(repr, row)) for row in points.tolist()]


def _ply(points, faces, generator) -> Iterator[Good]:
    for form in ("ascii", "binary_little_endian", "binary_big_endian"):
        for kind in ("f4", "f8"):
            for extra in (False, True):
                yield _one_ply(points, faces, form, kind, extra, generator)


def _one_ply(points, faces, form, kind, extra, generator) -> Good:
    order = ">" if form == "binary_big_endian" else "<"
    fields = [(axis, kind) for axis in "xyz"]
    if extra:
        more = [("red", "u1"), ("green", "u1"), ("blue", "u1"), ("intensity", "f4"), ("ring", "i2")]
        fields = [(more + fields)[at] for at in generator.permutation(len(more) + 3)]
    table = np.zeros(len(points), [(name, order + code) for name, code in fields])
    for number, axis in enumerate("xyz"):
        table[axis] = points[:, number]
    index = "i4" if generator.random() < 0.7 else "u1"
    counter = "u1" if generator.random() < 0.7 else "i4"
    lines = [
        "ply", f"format {form} 1.0", "comment by hand", f"element vertex {len(points)}",
        *(f"property {PLY_TYPES[code]} {name}" for name, code in fields),
    ]  # fmt: skip
    if faces:
        name = "vertex_index" if extra else "vertex_indices"
        lines += [f"element face {len(faces)}"]
        lines += [f"property list {PLY_TYPES[counter]} {PLY_TYPES[index]} {name}"]
        lines += ["property float quality"] if extra else []
    lines += ["obj_info made for tests", "end_header"]
    head = "".join(line + "\n" for line in lines).encode()
    if form == "ascii":
        rows = [" ".join(repr(value) for value in row) for row in table.tolist()]
        rows += [" ".join(map(str, [len(f), *f, *([0.5] if extra else [])])) for f in faces]
        data = "".join(row + "\n" for row in rows).encode()
    else:
        data = table.tobytes()
        for face in faces:
            data += np.array([len(face)], order + counter).tobytes()
            data += np.array(face, order + index).tobytes()
            data += np.array([0.5], order + "f4").tobytes() if extra else b""
    held = points.astype(kind).astype(float)
    name = f"{form}-{kind}{'-extra' if extra else ''}.ply"
    return Good(name, head + data, len(points), _cut(faces), held)


def _obj(points, faces, generator) -> Iterator[Good]:
    rows = ["v " + row for row in _rows(points)]
    count = len(points)
    corners = {
        "plain": lambda i: f"{i + 1}",
        "back": lambda i: f"{i - count}",
        "vt": lambda i: f"{i + 1}/{i % 3 + 1}",
        "vn": lambda i: f"{i + 1}//{i % 2 + 1}",
        "all": lambda i: f"{i + 1}/{i % 3 + 1}/{i % 2 + 1}",
    }
    extra = ["vt 0 0", "vt 1 0", "vt 0 1", "vn 0 0 1", "vn 0 1 0"]
    for name, corner in corners.items():
        lines = ["# by hand", "o thing", *rows, *(extra if faces else []), "s off"]
        lines += ["f " + " ".join(corner(i) for i in face) for face in faces]
        end = "\r\n" if generator.random() < 0.3 else "\n"
        content = "".join(line + end for line in lines).encode()
        yield Good(f"{name}.obj", content, count, _cut(faces), points)


def _off(points, faces) -> Iterator[Good]:
    rows = _rows(points)
    count = len(points)
    last = [" ".join(map(str, [len(face), *face])) for face in faces]
    kinds = {"OFF": "", "COFF": " 255 0 0 255", "NOFF": " 0 0 1", "STOFF": " 0.5 0.5"}
    for keyword, more in kinds.items():
        lines = [keyword, "# by hand", f"{count} {len(faces)} 0", *(row + more for row in rows)]
        content = "".join(line + "\n" for line in lines + last).encode()
        yield Good(f"{keyword}.off", content, count, _cut(faces), points)


def _stl(points, faces) -> Iterator[Good]:
    triangles = [face for face in faces if len(face) == 3]
    if not triangles:
        return
    single = points.astype("<f4")
    used = len(np.unique(single[np.unique(triangles)], axis=0))
    for beginning in (b"by hand", b"solid binary"):
        data = beginning.ljust(80) + struct.pack("<I", len(triangles))
        for face in triangles:
            data += b"\0" * 12 + single[face].tobytes() + b"\0\0"
        yield Good(f"binary-{len(beginning)}.stl", data, used, len(triangles), None)
    lines = ["solid thing"]
    for face in triangles:
        lines += [" facet normal 0 0 1", "  outer loop"]
        lines += [f"   vertex {row}" for row in _rows(single[face].astype(float))]
        lines += ["  endloop", " endfacet"]
    text = "".join(line + "\n" for line in [*lines, "endsolid thing"]).encode()
    yield Good("text.stl", text, used, len(triangles), None)


def _texts(points, faces) -> Iterator[Good]:
    if faces:
        return
    rows = _rows(points)
    for extension in ("xyz", "pts", "asc", "apts"):
        body = "".join(row + "\n" for row in rows)
        exact = 1e-6 if extension == "asc" else 0.0  # MeshLab reads that one in single precision
        yield Good(f"three.{extension}", body.encode(), len(rows), 0, points, exact)
    six = "".join(row + " 0 0 1\n" for row in rows)
    yield Good("six.xyz", six.encode(), len(rows), 0, points)
    crlf = "# by hand\r\n" + "".join(row.replace(" ", "\t") + "\r\n" for row in rows)
    yield Good("tabs.xyz", crlf.encode(), len(rows), 0, points)
    yield Good("counted.pts", f"{len(rows)}\n{body}".encode(), len(rows), 0, points)


def _gltf(points, faces) -> Iterator[Good]:
    triangles = [face for face in faces if len(face) == 3]
    if len(triangles) != len(faces) or not faces:
        return
    single = points.astype("<f4")
    data = single.tobytes() + np.array(triangles, "<u2").tobytes()
    data += b"\0" * (-len(data) % 4)
    low, high = single.min(axis=0).tolist(), single.max(axis=0).tolist()
    views = [{"buffer": 0, "byteOffset": 0, "byteLength": single.nbytes},
             {"buffer": 0, "byteOffset": single.nbytes, "byteLength": 6 * len(faces)}]  # fmt: skip
    accessors = [
        {"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3",
         "min": low, "max": high},
        {"bufferView": 1, "componentType": 5123, "count": 3 * len(faces), "type": "SCALAR"},
    ]  # fmt: skip
    content = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}], "buffers": [{"byteLength": len(data)}], "bufferViews": views,
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": accessors,
    }  # fmt: skip
    base64 = b64encode(data).decode()
    inside = [{"byteLength": len(data), "uri": f"data:application/octet-stream;base64,{base64}"}]
    plain = json.dumps(content | {"buffers": inside}).encode()
    yield Good("hand.gltf", plain, len(points), len(faces), single.astype(float), 1e-6)
    text = json.dumps(content).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    chunks += struct.pack("<I4s", len(data), b"BIN\0") + data
    whole = b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks
    yield Good("hand.glb", whole, len(points), len(faces), single.astype(float), 1e-6)


def _by_meshlab(generator) -> Iterator[Good]:
    import pymeshlab

    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.create_sphere(subdiv=int(generator.integers(1, 3)))
    mesh = mesh_set.current_mesh()
    points, faces = mesh.vertex_number(), mesh.face_number()
    with tempfile.TemporaryDirectory() as folder:
        for extension in BY_MESHLAB:
            path = Path(folder, f"a.{extension}")
            mesh_set.save_current_mesh(str(path))
            held = 0 if extension in ("xyz", "e57") else faces
            yield Good(f"meshlab.{extension}", path.read_bytes(), points, held, None)
