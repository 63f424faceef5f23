"""Files that are damaged, hostile, or of kinds that MeshLab misreads."""

from __future__ import annotations

import json
import os
import struct
import warnings
from base64 import b64encode

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from meshlab_symrecon.cli.main import main
from meshlab_symrecon.errors import FileError, ScriptError, SymReconWarning
from meshlab_symrecon.host import inspection_obj, inspection_trial, number_lines
from meshlab_symrecon.host.files import check_input, load, new_document, save_current
from meshlab_symrecon.host.inspection import inspect
from meshlab_symrecon.host.mlx import read_script
from meshlab_symrecon.host.project_files import read_project
from meshlab_symrecon.host.reconstruction import whole_method

WORDS = {
    "i1": "char", "u1": "uchar", "i2": "short", "u2": "ushort", "i4": "int", "u4": "uint",
    "f4": "float", "f8": "double",
}  # fmt: skip
FORMS = ("ascii", "binary_little_endian", "binary_big_endian")
POINTS = np.array([[0.1, 0.2, 0.3], [1.5, 0, 0], [0, 1.25, 0], [0, 0, 2.5]])
FACES = [[0, 1, 2], [0, 2, 1, 3]]
TRIANGLES = 3


def ply(
    form="binary_little_endian", kind="f8", counter="u1", index="i4", points=POINTS, faces=FACES
):
    order = ">" if form == "binary_big_endian" else "<"
    lines = ["ply", f"format {form} 1.0", f"element vertex {len(points)}"]
    lines += [f"property {WORDS[kind]} {axis}" for axis in "xyz"]
    lines += [f"element face {len(faces)}"]
    lines += [f"property list {WORDS[counter]} {WORDS[index]} vertex_indices", "end_header", ""]
    head = "\n".join(lines).encode()
    if form == "ascii":
        rows = [" ".join(map(repr, row)) for row in np.asarray(points, kind).tolist()]
        rows += [" ".join(map(str, [len(face), *face])) for face in faces]
        return head + "".join(row + "\n" for row in rows).encode()
    data = np.asarray(points, order + kind).tobytes()
    for face in faces:
        data += np.array(len(face), order + counter).tobytes()
        data += np.array(face, order + index).tobytes()
    return head + data


def obj(points=POINTS, faces=FACES):
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in np.asarray(points, float).tolist()]
    lines += ["f " + " ".join(str(corner + 1) for corner in face) for face in faces]
    return "".join(line + "\n" for line in lines).encode()


def off(points=POINTS, faces=FACES, keyword="OFF", more=""):
    rows = [" ".join(map(repr, row)) + more for row in np.asarray(points, float).tolist()]
    rows += [" ".join(map(str, [len(face), *face])) for face in faces]
    return "\n".join([keyword, f"{len(points)} {len(faces)} 0", *rows, ""]).encode()


def xyz(points=POINTS):
    rows = np.asarray(points, float).tolist()
    return "".join(" ".join(map(repr, row)) + "\n" for row in rows).encode()


def stl(corners, announced=None):
    count = len(corners) if announced is None else announced
    table = np.zeros(len(corners), [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("a", "<u2")])
    table["corners"] = corners
    return b"by hand".ljust(80) + struct.pack("<I", count) + table.tobytes()


def text_stl(corners):
    lines = ["solid a"]
    for corner in np.asarray(corners, float).tolist():
        lines += ["facet normal 0 0 1", "outer loop"]
        lines += [f"vertex {x!r} {y!r} {z!r}" for x, y, z in corner]
        lines += ["endloop", "endfacet"]
    return "".join(line + "\n" for line in [*lines, "endsolid a"]).encode()


CORNERS = POINTS[[[0, 1, 2], [0, 2, 3]]].astype("<f4")
ROWS = b"0 0 0\n1 0 0\n0 1 0\n"
V = b"v 0 0 0\nv 1 0 0\nv 0 1 0\n"
FACET = text_stl(CORNERS[:1])
LONG = [list(range(300))]


def header(*lines):
    return ("\n".join(["ply", "format ascii 1.0", *lines, "end_header", ""])).encode()


XYZ = ("property float x", "property float y", "property float z")
REFUSED = {
    "one axis twice.ply": (
        header("element vertex 3", "property float x", *XYZ) + ROWS, "'x' of 'vertex' twice"
    ),
    "vertex twice.ply": (
        header("element vertex 3", *XYZ, "element vertex 3", *XYZ) + ROWS, "'vertex' twice"
    ),
    "bare.ply": (
        header("element vertex 3", *XYZ, "element thing 2000000000") + ROWS,
        "announces 2000000000 of 'thing' without properties",
    ),
    "axis list.ply": (
        header("element vertex 1", "property list uchar float x", *XYZ[1:]) + b"1 0 0 0\n",
        "no vertices with x, y and z",
    ),
    "word.ply": (ply("ascii").replace(b"1.25", b"a"), "line 12 has 'a' instead of a number"),
    "comment.ply": (ply("ascii").replace(b"0.1 ", b"#\n0.1 "), "a comment among its numbers"),
    "long.ply": (ply(points=np.eye(300)[:, :3], faces=LONG, counter="i4"), "of 300 numbers"),
    "two corners.ply": (ply(faces=[[0, 1]]), "face 1 has 2 corners"),
    "corner.ply": (ply(faces=[[0, 1, 2], [0, 1, 4]]), "face 2 names vertex 4, and there are 4"),
    "negative.ply": (ply(faces=[[0, 1, -(2**31)]]), "names vertex -2.14748e+09"),
    "half.ply": (ply("ascii", faces=[[0, 1, 1.5]]), "names vertex 1.5"),
    "length.ply": (ply(faces=[[0, 1, 2]], counter="i4")[:-16] + struct.pack("<i", -1) + b"\0" * 12,
                   "a list of -1 numbers, which cannot be"),
    "fraction.ply": (ply("ascii", faces=[[0, 1, 2], [0, 1, 2, 3]]).replace(b"\n4 0", b"\n3.5 0"),
                     "a list of 3.5 numbers"),
    "middle.ply": (ply()[:-1], "ends in the middle of face 2 of 2"),
    "inf.ply": (ply("ascii", kind="f4").replace(b"1.25", b"1e300"), "has the coordinate inf"),
    "nan.ply": (ply(points=np.full((3, 3), np.nan), faces=[]), "holds no points"),
    "marked.obj": (b"\xef\xbb\xbf" + V, "begins with a byte order mark"),
    "wide.obj": (V.decode().encode("utf-16"), "is UTF-16 text"),
    "gzip.xyz": (b"\x1f\x8b\x08\0", "is compressed by gzip"),
    "old.obj": (V.replace(b"\n", b"\r"), "a carriage return alone"),
    "blank.obj": (b" " + V, "line 1 has a blank before 'v'"),
    "word.obj": (V + b"vt a b\n", "line 4 has 'a' instead of a number"),
    "short.obj": (V + b"v 1 2\n", "line 4 has 2 numbers, and 'v' needs 3"),
    "inf.obj": (V + b"v 1 2 inf\n", "line 4 has the coordinate inf"),
    "nan.obj": (b"v 1 2 nan\n", "holds no points"),
    "edge.obj": (V + b"f 1 2\n", "the face in line 4 has 2 corners"),
    "many.obj": (V + b"f" + b" 1 2 3" * 4000 + b"\n", "has 12000 corners"),
    "zero.obj": (V + b"\0\n", "line 4 has a byte of zero"),
    "device.obj": (b"mtllib /dev/zero\n" + V, "line 1 names /dev/zero"),
    "counted.obj": (b"# Vertices: 9\n" + V, "announces 9 vertices, and 3 follow"),
    "inf.off": (off([[0, 0, np.inf]], []), "point 1 has the coordinate inf"),
    "large.off": (off([[0, 0, 1e300]], []), "point 1 has the coordinate 1e+300"),
    "nan.off": (off([[0, 0, np.nan]], []), "holds no points"),
    "none.off": (off(POINTS[:0], []), "holds no points"),
    "counts.off": (b"OFF\n3 x 0\n" + ROWS, "line 2 must have the numbers of points, faces"),
    "negative.off": (b"OFF\n-3 1 0\n" + ROWS, "line 2 must have"),
    "binary.off": (b"OFF BINARY\n\0\0\0\3", "is a binary OFF file"),
    "huge.off": (b"OFF\n2147483647 0 0\n" + ROWS, "announces 2147483647 points, and 3 follow"),
    "faces.off": (b"OFF\n3 2 0\n" + ROWS + b"3 0 1 2\n", "announces 2 faces, and 1 follow"),
    "short.off": (b"OFF\n3 0 0\n0 0\n" + ROWS, "line 3 has 2 numbers, and a point has 3"),
    "over.off": (b"OFF\n3 0 0\n0 0 0 1 2 3\n0 0 0 1 2 3\n", "line 4 goes on behind"),
    "corners.off": (off(faces=[[0, 1, 2]])[:-2] + b"\n", "3 corners, and 2 numbers follow"),
    "endless.off": (off(faces=[[0, 1, 2]]).replace(b"\n3 0", b"\n1000000000 0"), "1e+09 corners"),
    "corner.off": (off(faces=[[0, 1, 99999999999]]), "names vertex 1e+11, and there are 4"),
    "columns.xyz": (b"1 2 3 4\n", "line 1 has 4 numbers"),
    "row.xyz": (ROWS + b"1 2\n", "line 4 has 2 numbers"),
    "comma.xyz": (b"1,2,3\n", "line 1 has '1,2,3' instead of a number"),
    "count.xyz": (b"4\n" + ROWS, "its first line announces 4 points, and 3 follow"),
    "large.xyz": (ROWS + b"0 -1e300 0\n", "point 4 has the coordinate -1e+300"),
    "more.stl": (stl(CORNERS, announced=1), "announces 1 triangles, and 50 bytes more follow"),
    "none.stl": (stl(CORNERS[:0]), "holds no points"),
    "inf.stl": (stl(np.full((1, 3, 3), np.inf)), "has the coordinate inf"),
    "nan.stl": (stl(np.full((1, 3, 3), np.nan)), "holds no facet with whole coordinates"),
    "open.stl": (FACET.replace(b"endsolid a\n", b""), "no 'endsolid' follows its 1 facets"),
    "half.stl": (FACET.replace(b"endloop\n", b""), "its facet 1 is not whole"),
    "word.stl": (FACET.replace(b"1.5", b"a"), "its facet 1 has 'a' instead of a number"),
    "four.stl": (FACET.replace(b"endloop", b"vertex 1 1 1\nendloop"), "'vertex' where 'endloop'"),
    "line.stl": (FACET.replace(b"\n", b" "), "facets in the line of 'solid'"),
    "lines.stl": (b"solid a\n" + FACET[8:-11].replace(b"\n", b" ") + b"\nendsolid a\n", "1 facets"),
    "empty.stl": (b"solid a\nendsolid a\n", "holds no points"),
    "cut.3ds": (b"MM\xff\0\0\0" + b"\0" * 50, "announces 255 bytes, and has 56"),
    "begin.glb": (b"glTX" + b"\0" * 20, "does not begin as .glb files do"),
    "crash.gltf": (
        b'{"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],'
        b'"meshes":[{"primitives":[{"attributes":{"POSITION":99}}]}]}',
        "MeshLab's reader crashes on it",
    ),
    "none.asc": (b"nothing\n", "cannot be read"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_damaged_files_are_refused_in_one_sentence(tmp_path, name):
    content, words = REFUSED[name]
    path = tmp_path / name
    path.write_bytes(content)
    mesh_set = new_document()
    mesh_set.create_cube()
    with pytest.raises(FileError) as caught:
        load(path, mesh_set)
    message = str(caught.value)
    assert words in message
    assert message.startswith(str(path))
    assert "\n" not in message
    assert mesh_set.mesh_number() == 1
    assert path.read_bytes() == content


CUTTABLE = {
    "binary.ply": ply(),
    "big.ply": ply("binary_big_endian"),
    "text.ply": ply("ascii"),
    "a.off": off(),
    "binary.stl": stl(CORNERS),
    "text.stl": text_stl(CORNERS),
}


@pytest.mark.parametrize("name", CUTTABLE)
def test_no_cut_of_a_counted_file_passes_in_silence(tmp_path, name):
    """What is not refused holds every point and face, but for the end of a number."""
    path = tmp_path / name
    content = CUTTABLE[name].rstrip() if name in ("text.ply", "a.off") else CUTTABLE[name]
    path.write_bytes(content)
    whole = inspect(path, path.suffix[1:])
    for length in range(1, len(content), 3):
        path.write_bytes(content[:length])
        try:
            held = inspect(path, path.suffix[1:])
        except FileError:
            continue
        assert (held.points, held.triangles) == (whole.points, whole.triangles), length
        assert name.startswith("text.") or name == "a.off"


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("kind", ["f4", "f8"])
@pytest.mark.parametrize("counter", ["i1", "u1", "i2", "u2", "i4", "u4"])
def test_ply_of_every_type_is_read_to_the_last_bit(tmp_path, form, kind, counter):
    for index in ("i1", "u1", "i2", "u2", "i4", "u4"):
        path = tmp_path / f"{index}.ply"
        path.write_bytes(ply(form, kind, counter, index))
        mesh_set = load(path)
        mesh = mesh_set.current_mesh()
        assert np.array_equal(mesh.vertex_matrix(), POINTS.astype(kind).astype(float))
        assert mesh.face_number() == TRIANGLES
        assert mesh.label() == path.name


def test_whole_coordinates_and_other_properties_survive_the_copy(tmp_path):
    lines = ["element vertex 3", *(line.replace("float", "short") for line in XYZ)]
    lines += ["property uchar red", "property uchar green", "property uchar blue"]
    path = tmp_path / "a.ply"
    path.write_bytes(header(*lines) + b"0 0 0 255 0 0\n1 0 0 255 0 0\n-7 300 0 0 0 255\n")
    mesh_set = load(path)
    mesh = mesh_set.current_mesh()
    assert np.array_equal(mesh.vertex_matrix(), [[0, 0, 0], [1, 0, 0], [-7, 300, 0]])
    assert np.array_equal(mesh.vertex_color_matrix()[2], [0, 0, 1, 1])


coordinates = arrays(
    np.float64,
    st.tuples(st.integers(1, 12), st.just(3)),
    elements=st.floats(-1e99, 1e99, allow_nan=False, allow_infinity=False),
)


@pytest.mark.parametrize("name", ["ascii.ply", "little.ply", "big.ply", "a.xyz", "a.off", "a.obj"])
def test_points_come_back_to_the_last_bit(tmp_path_factory, name):
    write = {
        "ascii.ply": lambda points: ply("ascii", points=points, faces=[]),
        "little.ply": lambda points: ply(points=points, faces=[]),
        "big.ply": lambda points: ply("binary_big_endian", points=points, faces=[]),
        "a.xyz": xyz,
        "a.off": lambda points: off(points, []),
        "a.obj": lambda points: obj(points, []),
    }[name]
    path = tmp_path_factory.mktemp("round") / name

    @settings(max_examples=25, derandomize=True, deadline=None)
    @given(coordinates)
    def back(points):
        path.write_bytes(write(points))
        mesh_set = load(path)
        assert np.array_equal(mesh_set.current_mesh().vertex_matrix(), points)

    back()


BROKEN = np.vstack([POINTS, [[np.nan, 0, 0]]])
USES = [[0, 1, 2], [0, 1, 4], [0, 2, 3]]


@pytest.mark.parametrize(
    ("name", "content", "points", "faces"),
    [
        ("little.ply", ply(points=BROKEN, faces=USES), 4, 2),
        ("uneven.ply", ply(points=BROKEN, faces=[*USES, [0, 1, 2, 4]]), 4, 3),
        ("ascii.ply", ply("ascii", points=BROKEN, faces=USES), 4, 2),
        ("big.ply", ply("binary_big_endian", points=BROKEN, faces=USES), 4, 2),
        ("a.obj", obj(BROKEN, USES), 4, 2),
        ("back.obj", obj(BROKEN, []) + b"f -5 -4 -3\nf -5 -4 -1\nf 1 3 4\n", 4, 2),
        ("a.off", off(BROKEN, USES), 4, 2),
        ("a.xyz", xyz(BROKEN), 4, 0),
        ("a.pts", xyz(BROKEN), 4, 0),
    ],
)
def test_points_that_are_not_numbers_are_told_with_their_faces(
    tmp_path, name, content, points, faces
):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.warns(SymReconWarning, match=r"1 of 5 points have .* not numbers") as told:
        mesh_set = load(path)
    mesh = mesh_set.current_mesh()
    lost = 2 if name == "uneven.ply" else 1
    assert faces == 0 or f"with {lost} faces that use them" in str(told[0].message)
    assert (mesh.vertex_number(), mesh.face_number()) == (points, faces)
    assert np.array_equal(mesh.vertex_matrix(), POINTS)


@pytest.mark.parametrize("write", [stl, text_stl])
def test_facets_that_are_not_numbers_are_told(tmp_path, write):
    corners = np.concatenate([CORNERS, CORNERS[:1]])
    corners[2, 1, 1] = np.nan
    path = tmp_path / "a.stl"
    path.write_bytes(write(corners))
    with pytest.warns(SymReconWarning, match=r"1 of 9 points .* with 1 faces that use them"):
        mesh_set = load(path)
    assert mesh_set.current_mesh().face_number() == 2


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("more.ply", ply() + b"more!", "has 5 bytes behind what its header announces"),
        ("more.off", off() + b"3 0 1 2\n", "has 1 lines behind the faces"),
        ("edge.off", off(faces=[[0, 1], [0, 1, 2]]), "has 1 faces of two corners"),
        ("cut.xyz", ROWS.rstrip(), "its last line has no end"),
        ("cut.obj", V.rstrip(), "its last line has no end"),
        (
            "twice.obj",
            V + b"f 1 2 3\nf 1 1 2\n",
            "made 1 triangles of faces that can be cut into 2",
        ),
    ],
)
def test_what_is_left_out_is_told(tmp_path, name, content, words):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.warns(SymReconWarning) as told:
        load(path)
    assert [words in str(one.message) for one in told] == [True]


@pytest.mark.parametrize(
    ("name", "content", "points", "faces"),
    [
        ("coff.off", off(keyword="COFF", more=" 255 0 0 255"), 4, 3),
        ("noff.off", off(keyword="NOFF", more=" 0 0 1"), 4, 3),
        ("stoff.off", off(keyword="STOFF", more=" 0.5 0.5"), 4, 3),
        ("row.off", b"OFF\n# a\n3 1 0\n# b\n0 0 0 1 0 0 0 1 0\n3 0 1 2\n", 3, 1),
        ("marked.off", b"\xef\xbb\xbfOFF 3 1 0\r\n" + ROWS + b"3 0 1 2\r\n", 3, 1),
        ("normals.xyz", b"1 2 3 0 0 1\n\n# a\n\t4 5 6 0 0 1\r\n", 2, 0),
        ("counted.pts", b"3\n" + ROWS, 3, 0),
        ("solid.stl", b"solid facet normal".ljust(80) + stl(CORNERS)[80:], 4, 2),
        ("upper.stl", text_stl(CORNERS).upper(), 4, 2),
        (
            "colours.obj",
            b"\xef\xbb\xbf# a\nv 0 0 0 1 0 0\nv 1 0 0 1 0 0 # b\nv 0 1 0 1 0 0\n",
            3,
            0,
        ),
        ("meshlab.obj", b"# Vertices: 3\n# Faces: 1\n" + V + b"f 1 2 3\n# End of File", 3, 1),
    ],
)
def test_unusual_files_are_read_without_a_word(tmp_path, name, content, points, faces):
    path = tmp_path / name
    path.write_bytes(content)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        mesh_set = load(path)
        mesh = mesh_set.current_mesh()
    assert (mesh.vertex_number(), mesh.face_number()) == (points, faces)


def test_text_is_the_same_in_blocks_of_any_size(tmp_path, monkeypatch):
    path = tmp_path / "a.off"
    path.write_bytes(off(BROKEN, USES))
    whole = inspect(path, "off")
    path.with_suffix(".stl").write_bytes(text_stl(CORNERS))
    facets = inspect(path.with_suffix(".stl"), "stl")
    for size in range(1, 40, 3):
        monkeypatch.setattr(number_lines, "CHUNK", size)
        monkeypatch.setattr("meshlab_symrecon.host.inspection_stl.CHUNK", size)
        assert inspect(path, "off") == whole
        assert inspect(path.with_suffix(".stl"), "stl") == facets


def test_lines_without_an_end_are_refused_before_memory_is(tmp_path, monkeypatch):
    monkeypatch.setattr(number_lines, "CHUNK", 64)
    monkeypatch.setattr(number_lines, "LONGEST", 1 << 20)
    monkeypatch.setattr(inspection_obj, "MOST_BYTES", 1 << 20)
    for name, content in (
        ("a.xyz", b"1" * (1 << 21)),
        ("a.obj", b"#" * (1 << 21)),
        ("b.obj", b"\\\n".join([b"v" * (1 << 19)] * 4)),
    ):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(FileError, match="more than 1 MB"):
            load(tmp_path / name)


def stopped(tmp_path, monkeypatch, source):
    """Try a file in a child process that runs ``source`` instead of MeshLab's reader."""
    path = tmp_path / "a.dae"
    path.write_bytes(b"x")
    program = "import sys\nfrom meshlab_symrecon.host import inspection_trial as trial\n"
    program += f"def points(file, shown):\n    {source}\n"
    program += "trial._points = points\ntrial.main()\n"
    monkeypatch.setattr(inspection_trial, "CHILD", program)
    inspection_trial.try_in_child(path)


def test_a_reader_that_hangs_is_stopped(tmp_path, monkeypatch):
    monkeypatch.setattr(inspection_trial, "SECONDS", 1)
    monkeypatch.setattr(inspection_trial, "WAITING", 60)  # the machine may be busy
    with pytest.raises(FileError, match="took longer than 1 s"):
        stopped(tmp_path, monkeypatch, "while True: pass")


def test_a_reader_that_waits_is_stopped(tmp_path, monkeypatch):
    monkeypatch.setattr(inspection_trial, "SECONDS", 1)
    with pytest.raises(FileError, match="took longer than 4 s"):
        stopped(tmp_path, monkeypatch, "import time; time.sleep(60)")


def test_a_reader_that_wants_gigabytes_is_stopped(tmp_path, monkeypatch):
    with pytest.raises(FileError, match="takes more than 1024 MB of memory"):
        stopped(tmp_path, monkeypatch, "return len(bytearray(1 << 32))")


def test_a_device_is_no_project(tmp_path):
    os.mkfifo(tmp_path / "a.mlp")
    with pytest.raises(FileError, match="is not an ordinary file"):
        read_project(tmp_path / "a.mlp")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="Windows has no such pipes")
@pytest.mark.parametrize("extension", ["ply", "xyz", "glb", "stl"])
def test_the_method_and_apply_do_not_wait_for_a_pipe(tmp_path, extension):
    path, output = tmp_path / f"a.{extension}", tmp_path / "out.ply"
    os.mkfifo(path)
    with pytest.raises(FileError, match="is not an ordinary file"):
        whole_method(path, {}, lambda fraction, message: None)
    words = ["apply", "generate_reflection_planes", str(path), "-o", str(output)]
    said = CliRunner().invoke(main, words)
    assert said.exit_code == 1
    assert "is not an ordinary file" in said.output
    assert not output.exists()


@pytest.mark.parametrize(
    ("content", "words"),
    [(None, "no such file"), (b"", "is empty"), (b"x", "")],
)
def test_inputs_are_looked_at_first(tmp_path, content, words):
    path = tmp_path / "a.ply"
    if content is not None:
        path.write_bytes(content)
    if words:
        with pytest.raises(FileError, match=words):
            check_input(path)
    else:
        assert check_input(path) is None


def test_an_input_with_an_impossible_name(tmp_path):
    with pytest.raises(FileError, match="name too long"):
        check_input(tmp_path / ("a" * 300))


def test_a_script_without_an_end(monkeypatch):
    monkeypatch.setattr("meshlab_symrecon.host.mlx.LARGEST", 1 << 20)
    with pytest.raises(ScriptError, match="/dev/zero:1: a filter script has at most 1 MB"):
        read_script("/dev/zero")


def test_absurd_coordinates_of_rare_formats(tmp_path):
    mesh_set = new_document()
    mesh_set.create_sphere(subdiv=1)
    path = tmp_path / "a.x3d"
    save_current(mesh_set, path)
    content = path.read_bytes()
    before, after = content.split(b'point="', 1)
    kept = after.split(b" ", 2)[2]
    for word in (b"1e300", b"nan", b"-inf"):
        path.write_bytes(before + b'point="0.5 ' + word + b" " + kept)
        with pytest.raises(FileError, match=f"has the coordinate {word.decode()}, with which"):
            load(path)
    path.write_bytes(before + b'point="0.5 1e30 ' + kept)
    loaded = load(path)
    assert loaded.current_mesh().vertex_number() == mesh_set.current_mesh().vertex_number()


@pytest.mark.parametrize("faces", [FACES, USES[:1], []])
def test_plain_obj_files_hold_the_same_by_blocks_and_by_lines(tmp_path, monkeypatch, faces):
    path = tmp_path / "a.obj"
    path.write_bytes(b"# a\no b\n" + obj(faces=faces).replace(b"\n", b"\r\n") + b"vt 0 1\ng c\n")
    quick = inspection_obj.plain_obj(path)
    monkeypatch.setattr(inspection_obj, "plain_obj", lambda path: None)
    assert quick is not None
    assert quick == inspection_obj.check_obj(path)


@pytest.mark.parametrize("last", [b"f 1 2 9\n", b"f 0 1 2\n", b"f -1 1 2\n", b"f 1 2\n", b"v 1\n",
    b"f 1/1 2 3\n", b"f 1 2 3.5\n", b"v 1 2 nan\n", b"v 1 2 inf\n", b"v 1 2 3 #\n", b" v 1 2 3\n",
    b"v\t1 2 3\n", b"f\t1 2 3\n", b"f 1 2 \\\n3\n", b"mtllib a\n", b"\0\n", b"v 1 2 3", b"v\n",
    b"# Vertices: 9\n"])  # fmt: skip
def test_what_is_unusual_in_an_obj_file_is_looked_at_by_lines(tmp_path, last):
    path = tmp_path / "a.obj"
    path.write_bytes(V + last)
    assert inspection_obj.plain_obj(path) is None


def chunk(kind, content):
    return struct.pack("<HI", kind, 6 + len(content)) + content


def three_ds(faces, points=4, textured=None, materials=(0,), before=b""):
    rows = (np.arange(3 * points, dtype="<f4") ** 2).tobytes()
    corners = np.array([[*face, 7] for face in faces], "<u2").tobytes()
    group = b"stone\0" + struct.pack("<H", len(materials)) + np.array(materials, "<u2").tobytes()
    parts = chunk(0x4110, struct.pack("<H", points) + rows)
    if textured is not None:
        parts += chunk(0x4140, struct.pack("<H", textured) + b"\0" * 8 * textured)
    parts += chunk(0x4120, struct.pack("<H", len(faces)) + corners + chunk(0x4130, group))
    thing = chunk(0x4000, b"thing\0" + chunk(0x4100, parts))
    material = chunk(0xAFFF, chunk(0xA000, b"stone\0"))
    return chunk(0x4D4D, chunk(2, b"\3\0\0\0") + chunk(0x3D3D, material + before + thing))


@pytest.mark.parametrize("textured", [None, 4, 5])
def test_a_good_3ds_file_is_read(tmp_path, textured):
    path = tmp_path / "a.3ds"
    path.write_bytes(three_ds([(0, 1, 2), (0, 3, 2)], textured=textured, materials=(0, 1)))
    mesh_set = load(path)
    mesh = mesh_set.current_mesh()
    assert mesh.face_number() == 2
    assert set(map(tuple, mesh.vertex_matrix())) == {
        (0, 1, 4), (9, 16, 25), (36, 49, 64), (81, 100, 121)
    }  # fmt: skip


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (three_ds([(0, 1, 4)]), "a face names point 4 of a mesh with 4 points"),
        (three_ds([(0, 1, 2), (65535, 1, 2)]), "a face names point 65535"),
        (three_ds([(0, 1, 3)], textured=3), "point 3 of a mesh with 3 texture coordinates"),
        (three_ds([(0, 1, 2)], materials=(0, 1)), "a material names face 1 of a mesh with 1 faces"),
        (three_ds([(0, 1, 9)], before=chunk(0x4000, b"lamp\0")), "a face names point 9"),
    ],
)
def test_numbers_that_lead_out_of_a_3ds_mesh(tmp_path, content, words):
    path = tmp_path / "a.3ds"
    path.write_bytes(content)
    with pytest.raises(FileError, match=words):
        load(path)


def gltf(corners, kind=5123, where="inside", count=None, shift=0, cut=0):
    points = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], "<f4")
    numbers = np.array(corners, {5121: "<u1", 5123: "<u2", 5125: "<u4"}[kind])
    data = points.tobytes() + numbers.tobytes()
    data = data[: len(data) - cut]
    views = [
        {"buffer": 0, "byteOffset": 0, "byteLength": 48},
        {"buffer": 0, "byteOffset": 48 - shift, "byteLength": numbers.nbytes},
    ]
    accessors = [
        {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0],
         "max": [1, 1, 1]},
        {"bufferView": 1, "componentType": kind, "type": "SCALAR", "byteOffset": shift,
         "count": numbers.size if count is None else count},
    ]  # fmt: skip
    uri = {"inside": "data:application/octet-stream;base64," + b64encode(data).decode(),
           "beside": "a%20b.bin"}.get(where)  # fmt: skip
    buffer = {"byteLength": len(data)} | ({} if uri is None else {"uri": uri})
    primitive = {"attributes": {"POSITION": 0}, "indices": 1}
    text = json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}], "meshes": [{"primitives": [primitive]}], "buffers": [buffer],
        "bufferViews": views, "accessors": accessors,
    }).encode()  # fmt: skip
    if uri is not None:
        return text, data
    text += b" " * (-len(text) % 4)
    data += b"\0" * (-len(data) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    chunks += struct.pack("<I4s", len(data), b"BIN\0") + data
    return b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks, b""


def loaded_gltf(folder, where, corners, **more):
    content, beside = gltf(corners, where=where, **more)
    path = folder / ("a.glb" if where == "binary" else "a.gltf")
    path.write_bytes(content)
    (folder / "a b.bin").write_bytes(beside)
    return load(path)


PLACES = pytest.mark.parametrize("where", ["inside", "beside", "binary"])


@PLACES
@pytest.mark.parametrize("kind", [5121, 5123, 5125])
@pytest.mark.parametrize("shift", [0, 8])
def test_a_good_gltf_file_is_read(tmp_path, where, kind, shift):
    corners = [0, 1, 2, 0, 3, 1, 1, 3, 2]
    mesh_set = loaded_gltf(tmp_path, where, corners, kind=kind, shift=shift)
    assert mesh_set.current_mesh().face_number() == 3
    assert mesh_set.current_mesh().vertex_number() == 4


@PLACES
@pytest.mark.parametrize("kind", [5121, 5123, 5125])
def test_numbers_that_lead_out_of_a_gltf_mesh(tmp_path, where, kind):
    with pytest.raises(FileError, match="a face names point 4 of a mesh with 4 points"):
        loaded_gltf(tmp_path, where, [0, 1, 2, 0, 1, 4], kind=kind)
    with pytest.raises(FileError, match=r"its indices reach beyond the \d+ bytes"):
        loaded_gltf(tmp_path, where, [0, 1, 2], kind=kind, count=300)


def test_a_gltf_buffer_that_is_cut(tmp_path):
    with pytest.raises(FileError, match="its indices reach beyond the 52 bytes"):
        loaded_gltf(tmp_path, "beside", [0, 1, 2], cut=2)
    with pytest.raises(FileError, match="its POSITION reach beyond the 40 bytes"):
        loaded_gltf(tmp_path, "beside", [0, 1, 2], cut=14)


def sphere(folder, extension):
    mesh_set = new_document()
    mesh_set.create_sphere(subdiv=1)
    path = folder / f"a.{extension}"
    mesh_set.save_current_mesh(str(path))
    return path


@pytest.mark.parametrize("number", [42, 60, 200, 30_000, 2**31 - 1, -1])
def test_numbers_that_lead_out_of_a_collada_mesh(tmp_path, number):
    path = sphere(tmp_path, "dae")
    before, after = path.read_text().split("<p>", 1)
    path.write_text(f"{before}<p>{number} {after.split(None, 1)[1]}")
    with pytest.raises(FileError, match=f"a face names VERTEX {number} of a mesh with 42 points"):
        load(path)


def test_a_normal_that_a_collada_mesh_does_not_have(tmp_path):
    path = sphere(tmp_path, "dae")
    before, after = path.read_text().split("<p>", 1)
    path.write_text(f"{before}<p>0 80 {after.split(None, 2)[2]}")
    with pytest.raises(FileError, match="names NORMAL 80 of a mesh with 80 entries for it"):
        load(path)


@pytest.mark.parametrize("extension", ["dae", "ctm", "x3d", "wrl", "3mf", "3ds"])
def test_good_files_of_rare_formats_pass_the_trial(tmp_path, extension):
    mesh_set = load(sphere(tmp_path, extension))
    assert mesh_set.current_mesh().vertex_number() == 42
    assert mesh_set.current_mesh().face_number() == 80


@pytest.mark.parametrize("corner", [3, -1])
def test_faces_that_lead_out_of_what_a_reader_made(tmp_path, corner):
    class Made:
        def face_matrix(self):
            return np.array([[0, 1, corner]])

        def vertex_number(self):
            return 3

    with pytest.raises(FileError, match="a face names a point that is none of its 3 points"):
        inspection_trial._check_corners(tmp_path, Made())
