"""Files of scanners and other programs: every point is read, or is told to be left out."""

from __future__ import annotations

import errno
import json
import os
import struct
import warnings
import zlib
from base64 import b64encode

import numpy as np
import pymeshlab
import pytest

from meshlab_symrecon.errors import FileError, SymReconWarning
from meshlab_symrecon.host import point_copies
from meshlab_symrecon.host.files import load, new_document
from meshlab_symrecon.host.inspection import REFUSED
from meshlab_symrecon.host.inspection_fbx import check_fbx
from meshlab_symrecon.host.inspection_txt import txt_rows
from meshlab_symrecon.host.paths import READABLE

NUMBERS = "coordinates that are not numbers; MeshLab left them out"


def quietly(path):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return load(path)


def grid(rows, columns=1, matrix=None):
    """Return a scan of a PTX file from its lines."""
    matrix = np.eye(4) if matrix is None else matrix
    axes = [*matrix[3:, :3], *matrix[:3, :3]]
    numbers = [" ".join(map(repr, row)) for row in [*np.array(axes).tolist(), *matrix.tolist()]]
    return "\n".join([str(columns), str(len(rows) // columns), *numbers, *rows, ""])


def of_points(points, end=" 0.5"):
    return [f"{x!r} {y!r} {z!r}{end}" for x, y, z in points.tolist()]


@pytest.mark.parametrize("share", [0.0, 0.02, 0.5])
def test_all_measured_points_of_all_scans_of_a_ptx_file(tmp_path, share):
    """Where rays met nothing, MeshLab's own reader loses points that were measured."""
    generator = np.random.default_rng(3)
    path = tmp_path / "a.ptx"
    text, expected = "", []
    for _ in range(3):
        matrix = np.eye(4)
        matrix[:3, :3] = np.linalg.qr(generator.normal(size=(3, 3)))[0]
        matrix[3, :3] = generator.normal(size=3) * 1e4
        points = generator.normal(size=(240, 3))
        missing = generator.random(240) < share
        rows = of_points(np.where(missing[:, None], 0.0, points))
        text += grid(rows, 12, matrix)
        expected.append(points[~missing] @ matrix[:3, :3] + matrix[3, :3])
    path.write_text(text)
    mesh_set = quietly(path)
    mesh = mesh_set.current_mesh()
    assert np.array_equal(mesh.vertex_matrix(), np.concatenate(expected))
    assert np.array_equal(mesh.vertex_scalar_array(), np.full(mesh.vertex_number(), 0.5))
    assert mesh.label() == "a.ptx"


def test_scans_with_and_without_colours(tmp_path):
    path = tmp_path / "a.ptx"
    path.write_text(grid(["1 2 3 0.2 255 0 51", "1 2 4 1"]) + grid(["1 2 5 0.6"]))
    mesh_set = quietly(path)
    colours = mesh_set.current_mesh().vertex_color_matrix()[:, :3]
    assert np.allclose(colours, [[1, 0, 0.2], [1, 1, 1], [0.6, 0.6, 0.6]])


def test_a_ptx_file_is_the_same_in_blocks_of_any_size(tmp_path, monkeypatch):
    path = tmp_path / "a.ptx"
    points = np.random.default_rng(0).normal(size=(7, 3))
    path.write_text(grid(of_points(points)) + grid(of_points(points, " 0.5 1 2 3")))
    whole = quietly(path)
    for size in (1, 30, 100):
        monkeypatch.setattr("meshlab_symrecon.host.number_lines.CHUNK", size)
        pieces = quietly(path)
        assert np.array_equal(
            pieces.current_mesh().vertex_matrix(), whole.current_mesh().vertex_matrix()
        )


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        (["0 0 0 0.5", "0 0 0 0.5"], "holds no points"),
        (["nan 0 1 0.5", "0 0 0 0.5"], "holds no points"),
        (["1 2 3 0.5", "inf 0 1 0.5"], "point 2 has the coordinate inf"),
        (["1 2 3 0.5", "1 1e300 1 0.5"], r"point 2 has the coordinate 1e\+300"),
    ],
)
def test_ptx_files_of_which_nothing_can_be_used(tmp_path, rows, words):
    path = tmp_path / "a.ptx"
    path.write_text(grid(rows))
    with pytest.raises(FileError, match=words):
        load(path)


def test_a_ptx_header_without_numbers(tmp_path):
    matrix = np.eye(4)
    matrix[3, 0] = np.nan
    path = tmp_path / "a.ptx"
    path.write_text(grid(["1 2 3 0.5"], matrix=matrix))
    with pytest.raises(FileError, match="header that ends in line 10 has a number that is none"):
        load(path)


TEXT = b"1.5 -2 3e-7\n4 5 6.123456789012345\n"
ROWS = [[1.5, -2.0, 3e-7], [4.0, 5.0, 6.123456789012345]]


@pytest.mark.parametrize(
    "content",
    [
        TEXT,
        TEXT.replace(b" ", b"\t").replace(b"\n", b"\r\n"),
        TEXT.replace(b" ", b","),
        TEXT.replace(b" ", b", "),
        TEXT.replace(b" ", b";"),
        TEXT.replace(b" ", b" ; "),
        b"\xef\xbb\xbf" + TEXT,
        b"X Y Z\n" + TEXT,
        b"// X Y Z\n" + TEXT,
        b"# by hand\n\nx;y;z\n" + TEXT.replace(b" ", b";"),
        b"2\n" + TEXT,
        TEXT.replace(b"\n", b" # a\n"),
    ],
)
def test_a_text_of_points_is_read_whatever_parts_its_numbers(tmp_path, content):
    path = tmp_path / "a.txt"
    path.write_bytes(content)
    mesh_set = quietly(path)
    mesh = mesh_set.current_mesh()
    assert mesh.vertex_matrix().tolist() == ROWS
    assert mesh.label() == "a.txt"
    assert path.read_bytes() == content


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"1,5 2,5 3,5\n", "line 1, '1,5 2,5 3,5', has commas within its numbers"),
        (b"x;y;z\n1,5;2,5;3,5\n", "line 2, '1,5;2,5;3,5', has commas within its numbers"),
        (b"1 2 3\n1,5 2 3\n", "line 2 has '1,5' instead of a number"),
        (b"Notes on the scan\nnone\n", "holds no points"),
        (b"Notes on\n3 scans\n", "line 2 has 'scans' instead of a number"),
        (b"nan 1 2\n", "holds no points"),
        (b"1 2\n3 4\n", "line 1 has 2 numbers, and a point has 3"),
        (b"7\n", "line 1 has 1 numbers, and a point has 3"),
        (b"x y z\n1 2 3\n4 5\n", "line 3 has 2 numbers, and the first point has 3"),
        (b"1 2 3\n4 5 6 7\n", "line 2 has 4 numbers, and the first point has 3"),
        (b"1 2 inf\n", "point 1 has the coordinate inf"),
        (b"PK\x03\x04 1 2 3\n", "is compressed by zip"),
    ],
)
def test_texts_that_are_no_points(tmp_path, content, words):
    path = tmp_path / "a.txt"
    path.write_bytes(content)
    with pytest.raises(FileError, match=words):
        load(path)


def test_lines_of_words_before_the_points_are_told(tmp_path):
    path = tmp_path / "a.txt"
    path.write_bytes(b"hermes\n\nx y z\n" + TEXT)
    with pytest.warns(SymReconWarning, match="2 lines before line 4 hold no point and were passed"):
        mesh_set = load(path)
    assert mesh_set.current_mesh().vertex_matrix().tolist() == ROWS


def test_columns_of_a_text_that_are_left_out_are_told(tmp_path):
    path = tmp_path / "a.txt"
    path.write_bytes(b"1 2 3 255 0 0\n4 5 6 0 0 255\n")
    with pytest.warns(SymReconWarning, match="so the 3 behind x, y and z were left out"):
        mesh_set = load(path)
    assert mesh_set.current_mesh().vertex_matrix().tolist() == [[1, 2, 3], [4, 5, 6]]


@pytest.mark.parametrize(
    ("name", "content"),
    [("a.txt", TEXT), ("a.ptx", grid(["1 2 3 0.5"]).encode())],
)
def test_a_full_folder_for_copies_is_no_fault_of_a_text(tmp_path, monkeypatch, name, content):
    def refuse(*given):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    path = tmp_path / name
    path.write_bytes(content)
    monkeypatch.setattr(point_copies, "_write", refuse)
    with pytest.raises(FileError, match=r"through a copy.*: No space left.*or set TMPDIR$"):
        load(path)


def test_a_text_that_changes_while_it_is_read(tmp_path):
    path = tmp_path / "a.txt"
    path.write_bytes(b"1 2\n")
    made = point_copies.with_points_copied(path, txt_rows)
    with pytest.raises(FileError, match="line 1 has 2 numbers"), made:
        pass


@pytest.mark.parametrize("extension", REFUSED)
def test_formats_that_are_refused_by_name(tmp_path, extension):
    path = tmp_path / f"a.{extension.upper()}"
    path.write_bytes(b"box\n")
    with pytest.raises(FileError, match=r"cannot be read: it is an? .*; write .ply with"):
        load(path)
    assert extension not in READABLE


def test_corners_of_a_qobj_file_are_checked(tmp_path):
    path = tmp_path / "a.qobj"
    places = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
    path.write_bytes(places + b"f 1 2 3 4\n")
    assert quietly(path).current_mesh().face_number() == 2
    path.write_bytes(places + b"f 1 2 3 5\n")
    with pytest.raises(FileError, match="the corner '5', and there are 4"):
        load(path)


def bre(points, columns=4, rows=3, size=256, version=0x101):
    """Return a BRE file of points given by their column and row."""
    header = bytearray(256)
    struct.pack_into("<HH2s", header, 2, version, size, b"BR")
    struct.pack_into("<HH", header, 14, columns, rows)
    return bytes(header) + b"".join(
        struct.pack("<fffBBHHH", *place, 9, 0, *pixel, 0x7FFF) for pixel, place in points.items()
    )


FULL = {(column, row): (column, row, 0.1 * column) for column in range(4) for row in range(3)}


def test_a_breuckmann_scan(tmp_path):
    path = tmp_path / "a.bre"
    path.write_bytes(bre(FULL))
    mesh_set = quietly(path)
    mesh = mesh_set.current_mesh()
    assert mesh.face_number() == 12
    found = {tuple(row) for row in np.round(mesh.vertex_matrix(), 6).tolist()}
    assert found == {tuple(np.round(place, 6)) for place in FULL.values()}


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (bre(FULL)[:-3], "behind its header of 256 bytes are no whole points"),
        (bre(FULL, size=2000), "behind its header of 2000 bytes are no whole points"),
        (bre(FULL, size=6), "behind its header of 6 bytes"),
        (bre(FULL, columns=3), "column 3 and row 0 of a grid of 3 columns and 3 rows"),
        (bre(FULL, rows=2), "column 0 and row 2 of a grid of 4 columns and 2 rows"),
        (bre(FULL | {(0, 0): (np.inf, 0, 0)}), "has the coordinate inf"),
        (bre(FULL)[:200], "does not begin as .bre files do"),
        (b"\0" * 300, "does not begin as .bre files do"),
    ],
)
def test_damaged_breuckmann_scans(tmp_path, content, words):
    path = tmp_path / "a.bre"
    path.write_bytes(content)
    with pytest.raises(FileError, match=words):
        load(path)


def test_points_of_a_breuckmann_scan_without_neighbours_are_told(tmp_path):
    path = tmp_path / "a.bre"
    alone = {pixel: place for pixel, place in FULL.items() if pixel[0] != 2}
    path.write_bytes(bre(alone))
    with pytest.warns(SymReconWarning, match="MeshLab read 6 of the 9 points that it holds"):
        load(path)
    path.write_bytes(bre(FULL | {(3, 2): (np.nan, 0, 0)}))
    with pytest.warns(SymReconWarning, match=f"1 of 12 points have {NUMBERS}"):
        load(path)


ATOM = "ATOM      1  CA  ALA A   1       0.000   1.000  -2.000  1.00 20.00           C  \n"


def test_atoms_of_a_molecule(tmp_path):
    path = tmp_path / "a.pdb"
    path.write_text("HEADER    A\n" + ATOM + "END\n\n")
    ball = quietly(path)
    box = ball.current_mesh().bounding_box()
    assert np.allclose((box.min() + box.max()) / 2, [0, 1, -2], atol=0.1)
    path.write_text(ATOM)
    with pytest.warns(SymReconWarning, match="does not end with the word END"):
        load(path)
    for word in ("nan", "1e999", "x", "", "1 2"):
        path.write_text(ATOM.replace("  -2.000", word.rjust(8)) + "END\n")
        with pytest.raises(FileError, match=r"the atom in line 1 has '.*' instead of a number"):
            load(path)


POINTS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [2, 0, 0], [2, 1, 0]], dtype="<f4")
FACES = [[0, 2, 1], [0, 1, 3], [0, 4, 5]]


def gltf(points, nodes=1, step=12):
    """Return a document whose points lie ``step`` bytes apart."""
    rows = b"".join(row.tobytes().ljust(step, b"\0") for row in points)
    data = rows + np.array(FACES, "<u2").tobytes()
    uri = "data:application/octet-stream;base64," + b64encode(data).decode()
    apart = {} if step == points.itemsize * 3 else {"byteStride": step}
    views = [
        {"buffer": 0, "byteOffset": 0, "byteLength": len(rows)} | apart,
        {"buffer": 0, "byteOffset": len(rows), "byteLength": 2 * 3 * len(FACES)},
    ]
    accessors = [
        {"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3"},
        {"bufferView": 1, "componentType": 5123, "count": 3 * len(FACES), "type": "SCALAR"},
    ]
    primitive = {"attributes": {"POSITION": 0}, "indices": 1}
    return json.dumps(
        {
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(nodes))}],
            "nodes": [{"mesh": 0}] * nodes, "meshes": [{"primitives": [primitive]}],
            "buffers": [{"byteLength": len(data), "uri": uri}], "bufferViews": views,
            "accessors": accessors,
        }
    ).encode()  # fmt: skip


def three_ds(points):
    def chunk(kind, content):
        return struct.pack("<HI", kind, 6 + len(content)) + content

    corners = np.array([[*face, 7] for face in FACES], "<u2").tobytes()
    parts = chunk(0x4110, struct.pack("<H", len(points)) + points.tobytes())
    parts += chunk(0x4120, struct.pack("<H", len(FACES)) + corners)
    thing = chunk(0x4000, b"thing\0" + chunk(0x4100, parts))
    return chunk(0x4D4D, chunk(2, b"\3\0\0\0") + chunk(0x3D3D, thing))


def fbx(points, packed=True):
    """Return a binary FBX file: records that name where they end."""

    def record(place, name, told, inside=b"", count=1):
        end = place + 13 + len(name) + len(told) + len(inside)
        head = struct.pack("<III", end, count, len(told)) + bytes([len(name)])
        return head + name + told + inside

    def array(code, numbers):
        data = zlib.compress(numbers.tobytes()) if packed else numbers.tobytes()
        return code + struct.pack("<III", numbers.size, packed, len(data)) + data

    def string(text):
        return b"S" + struct.pack("<I", len(text)) + text

    def whole(number):
        return b"L" + struct.pack("<q", number)

    def parent(place, name, told, children, count=1):
        start = place + 13 + len(name) + len(told)
        inside = b""
        for child in children:
            inside += child(start + len(inside))
        return record(place, name, told, inside + b"\0" * 13, count)

    corners = np.array([corner for a, b, c in FACES for corner in (a, b, -c - 1)], "<i4")
    arrays = [
        lambda at: record(at, b"Vertices", array(b"d", points.astype("<f8"))),
        lambda at: record(at, b"PolygonVertexIndex", array(b"i", corners)),
    ]
    version = [lambda at: record(at, b"Version", whole(232))]
    shape = whole(10) + string(b"thing\0\1Geometry") + string(b"Mesh")
    model = whole(20) + string(b"thing\0\1Model") + string(b"Mesh")
    objects = [
        lambda at: parent(at, b"Geometry", shape, arrays, 3),
        lambda at: parent(at, b"Model", model, version, 3),
    ]
    pairs = [
        lambda at: record(at, b"C", string(b"OO") + whole(20) + whole(0), count=3),
        lambda at: record(at, b"C", string(b"OO") + whole(10) + whole(20), count=3),
    ]
    content = b"Kaydara FBX Binary  \0\x1a\0" + struct.pack("<I", 7400)
    content += parent(len(content), b"Objects", b"", objects, 0)
    content += parent(len(content), b"Connections", b"", pairs, 0)
    return content + b"\0" * 173


@pytest.mark.parametrize("at", [b"\x08Verticesd", b"\x12PolygonVertexIndexi"])
@pytest.mark.parametrize("packed", [True, False])
def test_arrays_of_an_fbx_file_that_are_not_whole(tmp_path, at, packed):
    """They are passed over: what is wrong with the file, the reader says."""
    points = POINTS.copy()
    points[4] = np.nan
    path = tmp_path / "a.fbx"
    content = fbx(points, packed)
    path.write_bytes(content)
    assert check_fbx(path) == 1
    place = content.index(at) + len(at)
    for end in (place + 5, place + 12, place + 20):
        path.write_bytes(content[:end])
        assert check_fbx(path) == 0
    path.write_bytes(content[:place] + b"\xff\xff\xff\xff" + content[place + 4 :])
    assert check_fbx(path) == 0


def test_an_fbx_file_of_text_with_a_number_that_is_none(tmp_path):
    path = tmp_path / "a.fbx"
    path.write_text("; FBX\nVertices: *3 {\n a: 1.0,nan,2.0\n}\n")
    with pytest.raises(FileError, match="has the coordinate nan, with which nothing"):
        load(path)


WRITERS = {
    "a.fbx": (fbx, 1),
    "plain.fbx": (lambda points: fbx(points, packed=False), 1),
    "a.gltf": (gltf, 1),
    "apart.gltf": (lambda points: gltf(points, step=20), 1),
    "twice.gltf": (lambda points: gltf(points, nodes=2), 2),
    "a.3ds": (three_ds, 1),
}


@pytest.mark.parametrize("name", WRITERS)
def test_points_that_are_no_numbers_are_counted_in_rare_formats(tmp_path, monkeypatch, name):
    monkeypatch.delenv("PYTHONUNBUFFERED", raising=False)  # what readers print comes last then
    write, times = WRITERS[name]
    path = tmp_path / name
    path.write_bytes(write(POINTS))
    assert sum(mesh.vertex_number() for mesh in quietly(path)) == 6 * times
    points = POINTS.copy()
    points[[4, 5], [0, 2]] = np.nan
    path.write_bytes(write(points))
    with pytest.warns(SymReconWarning, match=f"{2 * times} of {6 * times} points have {NUMBERS}"):
        mesh_set = load(path)
    assert sum(mesh.vertex_number() for mesh in mesh_set) == 4 * times
    points[4, 0] = -np.inf
    path.write_bytes(write(points))
    with pytest.raises(FileError, match="point 5 has the coordinate -inf"):
        load(path)


def test_points_left_out_of_an_e57_file_are_told(tmp_path):
    path = tmp_path / "a.e57"
    points = np.random.default_rng(0).normal(size=(50, 3))
    points[[3, 30]] = np.nan
    mesh_set = new_document()
    mesh_set.add_mesh(pymeshlab.Mesh(points))
    mesh_set.save_current_mesh(str(path))
    with pytest.warns(SymReconWarning, match="MeshLab left out 2 of 50 points: those"):
        read = load(path)
    assert read.current_mesh().vertex_number() == 48


def test_counts_that_a_ctm_file_cannot_hold(tmp_path):
    path = tmp_path / "a.ctm"
    mesh_set = new_document()
    mesh_set.create_sphere(subdiv=1)
    mesh_set.save_current_mesh(str(path))
    content = path.read_bytes()
    assert quietly(path).current_mesh().vertex_number() == 42
    for place, what in ((12, "points"), (16, "faces")):
        number = content[place] + (1 << 24)
        path.write_bytes(content[:place] + struct.pack("<I", number) + content[place + 4 :])
        with pytest.raises(FileError, match=f"cannot hold the {number} {what} that it announces"):
            load(path)
    for place in (20, 24):
        path.write_bytes(content[:place] + struct.pack("<I", 9) + content[place + 4 :])
        with pytest.raises(FileError, match="it announces 9 values of a point, and 8 can be"):
            load(path)
    for other in (content[:27], b"X" + content[1:]):
        path.write_bytes(other)
        with pytest.raises(FileError, match=r"does not begin as \.ctm files do"):
            load(path)
