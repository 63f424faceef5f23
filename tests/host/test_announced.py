"""What files announce, against what MeshLab then reads from them."""

from __future__ import annotations

import json
import os
import struct

import numpy as np
import pymeshlab
import pytest

from meshlab_symrecon.errors import FileError
from meshlab_symrecon.host.announced import Announced, announced_points
from meshlab_symrecon.host.files import load, save_current


@pytest.fixture(scope="module")
def sphere():
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.create_sphere(subdiv=5)
    return mesh_set


def sizes(mesh_set):
    mesh = mesh_set.current_mesh()
    return mesh.vertex_number(), mesh.face_number()


@pytest.mark.parametrize("extension", ["ply", "off"])
def test_headers_tell_exactly(sphere, tmp_path, extension):
    path = tmp_path / f"sphere.{extension}"
    save_current(sphere, path)
    assert announced_points(path) == Announced(*sizes(sphere))


@pytest.mark.parametrize("extension", ["obj", "stl"])
def test_meshes_without_a_header_are_estimated(sphere, tmp_path, extension):
    path = tmp_path / f"sphere.{extension}"
    save_current(sphere, path)
    found = announced_points(path)
    points, faces = sizes(load(path))
    assert not found.exact
    assert found.points == pytest.approx(points, rel=0.02)
    assert found.faces == pytest.approx(faces, rel=0.02)


def test_an_ascii_stl_file_is_sampled(sphere, tmp_path):
    path = tmp_path / "text.stl"
    sphere.save_current_mesh(str(path), binary=False)
    found = announced_points(path)
    assert found.faces == pytest.approx(sphere.current_mesh().face_number(), rel=0.02)


def test_lines_of_points_in_a_large_text_are_estimated(tmp_path):
    rng = np.random.default_rng(0)
    widths = np.where(np.arange(120_000) < 40_000, 3, 9)  # lines get longer
    lines = [
        " ".join(f"{number:.{width}f}" for number in row)
        for row, width in zip(rng.random((120_000, 3)), widths, strict=True)
    ]
    for extension in ("xyz", "asc", "txt", "pts"):
        path = tmp_path / f"cloud.{extension}"
        path.write_text("\n".join(lines), encoding="utf-8")
        assert announced_points(path).points == pytest.approx(120_000, rel=0.02)


def test_a_small_text_is_counted(tmp_path):
    path = tmp_path / "cloud.xyz"
    path.write_text("0 0 1\n\n0 1 0\n1 0 0", encoding="utf-8")
    assert announced_points(path).points == 3


def e57(counts):
    """Return a file as E57 lays it out: checked pages, and XML that starts amid one."""
    xml = b"<e57Root>" + b" " * 3_000
    for count in counts:
        xml += f'<points type="CompressedVector" fileOffset="48" recordCount="{count}">'.encode()
    xml += b"</e57Root>"
    logical = bytes(1_500) + xml
    pages = [logical[at : at + 1_020].ljust(1_020, b"\0") for at in range(0, len(logical), 1_020)]
    body = bytearray(b"".join(page + b"\xff\xff\xff\xff" for page in pages))
    start = 1_500 // 1_020 * 1_024 + 1_500 % 1_020
    body[:48] = b"ASTM-E57" + struct.pack("<IIQQQ", 1, 0, len(body), start, len(xml)) + bytes(8)
    return bytes(body)


def test_the_scans_of_an_e57_file_add_up(tmp_path):
    path = tmp_path / "scans.e57"
    path.write_bytes(e57([12_000, 34]))
    assert announced_points(path) == Announced(12_034)


def gltf():
    primitive = {"attributes": {"POSITION": 0}, "indices": 1}
    accessors = [{"count": 800}, {"count": 4_500}, {"count": 90}]
    single = {"attributes": {"POSITION": 2}}
    return {"accessors": accessors, "meshes": [{"primitives": [primitive, primitive, single]}]}


def test_gltf_tells_in_its_accessors(tmp_path):
    text = json.dumps(gltf()).encode()
    (tmp_path / "a.gltf").write_bytes(text)
    head = struct.pack("<4sIII4s", b"glTF", 2, 20 + len(text), len(text), b"JSON")
    (tmp_path / "a.glb").write_bytes(head + text)
    for name in ("a.gltf", "a.glb"):
        assert announced_points(tmp_path / name) == Announced(890, 2 * 1_500 + 30)


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.ply", b"ply\nformat ascii 1.0\nelement vertex many\nend_header\n"),
        ("a.ply", b"ply\nformat ascii 1.0\nend_header\n"),
        ("a.off", b"OFF\n"),
        ("a.off", b"OFF many points"),
        ("a.stl", b"short"),
        ("a.e57", b"ASTM-E57"),
        ("a.e57", b"something else, and longer than a header is in such a file"),
        ("a.glb", b"glTF"),
        ("a.gltf", b"[[[["),
        ("a.gltf", b'{"accessors": 3, "meshes": [{"primitives": [5]}]}'),
        ("a.fbx", b"whatever"),
        ("a", b"whatever"),
    ],
)
def test_what_does_not_tell_is_left_to_the_reader(tmp_path, name, content):
    path = tmp_path / name
    path.write_bytes(content)
    assert announced_points(path) is None


def heads(count):
    """Return files that announce many points, or triangles, and a few bytes of data."""
    properties = "".join(f"property float {axis}\n" for axis in "xyz")
    ply = f"ply\nformat %s 1.0\nelement vertex {count}\n{properties}end_header\n"
    text = json.dumps(
        {
            "accessors": [{"count": count}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        }
    ).encode()
    return {
        "ascii.ply": (ply % "ascii").encode(),
        "binary.ply": (ply % "binary_little_endian").encode(),
        "a.off": f"OFF\n{count} 0 0\n".encode(),
        "a.stl": bytes(80) + struct.pack("<I", count),
        "a.e57": e57([count]),
        "a.glb": struct.pack("<4sIII4s", b"glTF", 2, 20 + len(text), len(text), b"JSON") + text,
    }


@pytest.mark.parametrize("name", heads(0))
def test_nobody_believes_what_the_bytes_cannot_hold(tmp_path, name):
    path = tmp_path / name
    path.write_bytes(heads(99_991_373)[name] + b"0 0 1 " * 3_000)
    assert announced_points(path) is None
    if not name.endswith((".e57", ".glb")):  # the readers of those have other words
        with pytest.raises(FileError, match=r"is damaged: it.* announces .*(follow|hold)"):
            load(path)


@pytest.mark.parametrize(("form", "size"), [("ascii", 2 * 3 * 1000 - 1), ("binary", 12 * 1000)])
def test_the_least_bytes_are_enough(tmp_path, form, size):
    name = f"{form}.ply"
    path = tmp_path / name
    path.write_bytes(heads(1000)[name] + b"0 " * (size // 2) + b"0" * (size % 2))
    assert announced_points(path) == Announced(1000)
    path.write_bytes(path.read_bytes()[:-1])
    assert announced_points(path) is None


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="Windows has no such pipes")
@pytest.mark.parametrize("extension", ["ply", "off", "stl", "obj", "e57", "gltf", "glb", "xyz"])
def test_nobody_waits_for_a_pipe(tmp_path, extension):
    path = tmp_path / f"a.{extension}"
    os.mkfifo(path)
    assert announced_points(path) is None


def test_a_missing_file_announces_nothing(tmp_path):
    assert announced_points(tmp_path / "none.ply") is None
    assert announced_points(tmp_path / "none.xyz") is None


@pytest.mark.parametrize("beginning", ["OFF\n", "OFF ", "# made by hand\nCOFF\n# sizes\n", "NOFF "])
def test_the_words_before_the_sizes_of_an_off_file(tmp_path, beginning):
    path = tmp_path / "a.off"
    path.write_text(beginning + "12 20 0\n" + 12 * "0 0 0\n" + 20 * "3 0 0 0\n", encoding="utf-8")
    assert announced_points(path) == Announced(12, 20)
