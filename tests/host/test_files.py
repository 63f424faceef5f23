"""Files that are read and written: the zoo of bad ones, and what comes back of good ones."""

from __future__ import annotations

import errno
import locale
import os
import struct
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pymeshlab
import pytest

from meshlab_symrecon.arrays import as_points
from meshlab_symrecon.errors import FileError, SymReconError, SymReconWarning
from meshlab_symrecon.host.atomic import (
    remove_dead_staging,
    replacing,
    same_file,
    together,
)
from meshlab_symrecon.host.files import load, new_document, save_current
from meshlab_symrecon.host.formats import FACES_ONLY, POINTS_ONLY, WRITABLE
from meshlab_symrecon.host.meshset import add_layer, read_layer
from meshlab_symrecon.host.paths import READABLE
from meshlab_symrecon.host.projects import save_project
from meshlab_symrecon.plugin import Layer

HEADER = """ply
format {form} 1.0
comment made by hand
element vertex {vertices}
property float x
property float y
property float z
element face {faces}
property list uchar int vertex_indices
end_header
"""
THREE = "0 0 0\n1 0 0\n0 1 0\n"
TETRAHEDRON = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])


def ply(form: str = "ascii", vertices: object = 3, faces: object = 0) -> str:
    return HEADER.format(form=form, vertices=vertices, faces=faces)


def cloud(count: int = 40, seed: int = 0) -> Layer:
    """Return a cloud with everything that a cloud can have, numbers of full length."""
    generator = np.random.default_rng(seed)
    directions = generator.normal(size=(count, 3))
    return Layer(
        points=generator.normal(size=(count, 3)) * 1e5,
        faces=np.zeros((0, 3), dtype=np.int64),
        label="cloud",
        normals=directions / np.linalg.norm(directions, axis=1, keepdims=True),
        colours=np.round(generator.random((count, 4)) * 255) / 255,
        quality=generator.normal(size=count),
    )


def solid() -> Layer:
    points = np.random.default_rng(1).normal(size=(4, 3))
    return Layer(points, TETRAHEDRON, "solid", quality=np.arange(4.0), face_quality=np.ones(4))


def bare() -> Layer:
    """Return a mesh that every format of faces holds whole."""
    return Layer(solid().points, TETRAHEDRON, "bare")


def document(*layers: Layer):
    mesh_set = new_document()
    for layer in layers:
        add_layer(mesh_set, layer, current=True)
    return mesh_set


BAD = {
    "empty.ply": (b"", "is empty"),
    "words.ply": (b"hello\n", "does not start with the word 'ply'"),
    "headless.ply": (b"ply\nformat ascii 1.0\nelement vertex 3\n", "its header has no end"),
    "formless.ply": (b"ply\nelement vertex 1\nend_header\n", "names no format"),
    "form.ply": (ply("middle_endian").encode(), "the line 'format middle_endian 1.0'"),
    "count.ply": (ply(vertices="many").encode(), "the line 'element vertex many'"),
    "negative.ply": (ply(vertices=-1).encode(), "the line 'element vertex -1'"),
    "type.ply": (ply().replace("float x", "quad x").encode(), "the line 'property quad x'"),
    "orphan.ply": (b"ply\nformat ascii 1.0\nproperty int x\nend_header\n", "'property int x'"),
    "short.ply": (b"ply\nformat ascii 1.0\nelement\nend_header\n", "the line 'element'"),
    "faces.ply": (b"ply\nformat ascii 1.0\nelement face 0\nend_header\n", "no vertices with x"),
    "plane.ply": (ply().replace("float z", "float w").encode(), "no vertices with x"),
    "none.ply": (ply(vertices=0).encode(), "holds no points"),
    "cut.ply": ((ply(vertices=4) + THREE).encode(), "at least 12 numbers of data, and 9 follow"),
    "cut2.ply": (
        ply("binary_little_endian", 3).encode() + b"\0" * 35,
        "at least 36 bytes of data, and 35 follow",
    ),
    "huge.ply": (ply("binary_big_endian", 10**15).encode(), "bytes of data, and 0 follow"),
    "index.ply": (
        (ply(faces=1) + THREE + "3 0 1 7\n").encode(),
        "Bad vertex index: face 1 names vertex 7",
    ),
    "index.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "the corner '4', and there are 3"),
    "zero.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n", "the corner '0'"),
    "back.obj": (b"v 0 0 0\nv 1 0 0\nf -1 -2 -3\nv 0 1 0\n", "the corner '-3', and there are 2"),
    "normal.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1//9 2//9 3//9\n", "//9', and there are 3"),
    "texture.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/2 2/1 3/1\n", "the corner '1/2'"),
    "slashes.obj": (b"v 0 0 0\nf 1/1/1/1 1 1\n", "the corner '1/1/1/1'"),
    "word.obj": (b"v 0 0 0\nf a b c\n", "a face has the corner"),
    "comment.obj": (b"v 0 0 0\nf 1 1 1 # c\n", "has a comment behind a face"),
    "none.obj": (b"# nothing\n", "holds no points"),
    "cut.stl": (b"\0" * 80 + struct.pack("<I", 2) + b"\0" * 99, "announces 2 triangles"),
    "tiny.stl": (b"abc", "cannot hold"),
    "words.off": (b"hello\n", "begins with 'hello'"),
    "words.xyz": (b"hello\n", "line 1 has 'hello' instead of a number"),
    "crash.fbx": (b"x", "MeshLab's reader crashes on it"),
    "nan.xyz": (b"nan nan nan\n", "holds no points"),
    "scan.jpg": (b"x", "extension '.jpg', which cannot be read; known are ply, obj"),
    "scan": (b"x", "has no extension"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_files_are_refused_in_one_sentence(tmp_path, name):
    content, words = BAD[name]
    path = tmp_path / name
    path.write_bytes(content)
    mesh_set = document(cloud())
    with pytest.raises(FileError) as caught:
        load(path, mesh_set)
    message = str(caught.value)
    assert words in message
    assert message.startswith(str(path))
    assert "\n" not in message
    assert [mesh.label() for mesh in mesh_set] == ["cloud"] or name.startswith(("words", "nan"))


def test_paths_that_are_no_files(tmp_path):
    for path, words in (
        (tmp_path / "none.ply", "no such file"),
        (tmp_path, "is not an ordinary file"),
        (Path("a\0b.ply"), "cannot be read"),
    ):
        with pytest.raises(FileError, match=words):
            load(path)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_a_file_without_permission(tmp_path):
    path = tmp_path / "a.ply"
    path.write_text(ply() + THREE)
    path.chmod(0)
    with pytest.raises(FileError, match="Permission denied"):
        load(path)


@pytest.mark.parametrize("length", range(0, 500, 7))
def test_every_cut_of_a_binary_mesh_is_an_error_and_no_crash(tmp_path, length):
    whole = tmp_path / "whole.ply"
    save_current(document(solid()), whole)
    content = whole.read_bytes()
    assert len(content) > 500
    path = tmp_path / "cut.ply"
    path.write_bytes(content[:length])
    with pytest.raises(FileError):
        load(path)


def test_good_files_of_every_kind_pass(tmp_path):
    contents = {
        "crlf.ply": (ply() + THREE).replace("\n", "\r\n"),
        "one line.ply": ply() + THREE.replace("\n", " "),
        "back.obj": "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf -3//-1 -2//-1 \\\n -1//-1\n# f 9 9 9\n",
        "plain.obj": "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n",
        "a.off": "OFF\n3 1 0\n" + THREE + "3 0 1 2\n",
        "a.xyz": THREE,
        "words.stl": "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
        "vertex 0 1 0\nendloop\nendfacet\nendsolid a\n",
        "größe und\tweite.PLY": ply() + THREE,
    }
    for name, content in contents.items():
        path = tmp_path / name
        path.write_text(content, newline="")
        mesh_set = load(path)
        assert mesh_set.current_mesh().vertex_number() == 3, name


def test_points_that_are_not_numbers_are_reported(tmp_path):
    points = np.random.default_rng(0).normal(size=(20, 3)).astype("<f4")
    points[[3, 17], [0, 2]] = np.nan
    path = tmp_path / "a.ply"
    path.write_bytes(ply("binary_little_endian", 20).encode() + points.tobytes())
    with pytest.warns(SymReconWarning, match=r"2 of 20 points have coordinates"):
        mesh_set = load(path)
    kept = read_layer(mesh_set, mesh_set.current_mesh_id()).points
    assert np.array_equal(as_points(kept), points[np.isfinite(points).all(axis=1)])


def test_files_go_into_a_document_in_order(tmp_path):
    save_current(document(cloud()), tmp_path / "a.ply")
    save_current(document(bare()), tmp_path / "b.obj")
    mesh_set = load(tmp_path / "a.ply")
    assert load(tmp_path / "b.obj", mesh_set) is mesh_set
    assert [mesh.label() for mesh in mesh_set] == ["a.ply", "b.obj"]
    assert mesh_set.current_mesh().face_number() == 4


@pytest.mark.parametrize("layer", [cloud(), solid()], ids=["cloud", "solid"])
def test_a_ply_keeps_everything(tmp_path, layer):
    path = tmp_path / "größe 1.ply"
    save_current(document(layer), path)
    mesh_set = load(path)
    back = read_layer(mesh_set, mesh_set.current_mesh_id())
    assert np.array_equal(back.points, layer.points)
    assert np.array_equal(back.faces, layer.faces)
    for name in ("quality", "face_quality", "colours"):
        before, after = getattr(layer, name), getattr(back, name)
        assert (before is None and after is None) or np.array_equal(before, after), name
    if layer.normals is not None:
        assert np.array_equal(back.normals, layer.normals)


def test_absent_attributes_are_not_written(tmp_path):
    path = tmp_path / "a.ply"
    save_current(document(Layer(cloud().points, np.zeros((0, 3), dtype=np.int64))), path)
    header = path.read_bytes().partition(b"end_header")[0].decode()
    declared = [line.split()[-1] for line in header.splitlines() if line.startswith("property")]
    assert declared == ["x", "y", "z", "vertex_indices"]


@pytest.mark.parametrize("extension", WRITABLE)
def test_every_known_format_is_written_whole(tmp_path, extension):
    path = tmp_path / f"a.{extension}"
    if extension in POINTS_ONLY:
        with pytest.warns(SymReconWarning, match="holds points only, so 4 faces were left out"):
            save_current(document(bare()), path)
    else:
        save_current(document(bare()), path)
    assert path.stat().st_size > 0
    assert [file for file in tmp_path.iterdir() if file.name.startswith(".")] == []
    if extension in READABLE:
        mesh_set = load(path)
        mesh = mesh_set.current_mesh()
        assert mesh.vertex_number() == 4
        assert mesh.face_number() == (0 if extension in POINTS_ONLY else 4)


@pytest.mark.parametrize("extension", sorted(set(WRITABLE) - set(POINTS_ONLY)))
def test_writing_leaves_the_locale_of_the_process_alone(tmp_path, extension):
    before = locale.setlocale(locale.LC_ALL)
    save_current(document(bare()), tmp_path / f"a.{extension}")
    assert locale.setlocale(locale.LC_ALL) == before


@pytest.mark.parametrize("extension", FACES_ONLY)
def test_formats_of_faces_refuse_clouds(tmp_path, extension):
    path = tmp_path / f"a.{extension}"
    with pytest.raises(FileError, match="holds faces only, and 40 points belong to no face"):
        save_current(document(cloud()), path)
    assert list(tmp_path.iterdir()) == []
    loose = Layer(np.vstack([solid().points, [[9.0, 9.0, 9.0]]]), TETRAHEDRON)
    with pytest.warns(SymReconWarning, match="1 points belong to no face, so they were left out"):
        save_current(document(loose), path)


def test_a_transform_is_written_into_the_coordinates(tmp_path):
    mesh_set = document(solid(), cloud())
    matrix = np.array([[0.0, -2, 0, 1e5], [2, 0, 0, 7], [0, 0, 2, -3], [0, 0, 0, 1]])
    mesh_set.set_matrix(transformmatrix=matrix, freeze=False)
    world = read_layer(mesh_set, 1)
    save_current(mesh_set, tmp_path / "a.ply")
    back = load(tmp_path / "a.ply")
    assert np.array_equal(read_layer(back, 0).points, world.points)
    assert np.array_equal(mesh_set.current_mesh().transform_matrix(), matrix)
    assert mesh_set.mesh_number() == 2


def test_saving_leaves_the_document_as_it_was(tmp_path):
    mesh_set = document(cloud(), solid())
    mesh_set.set_current_mesh(0)
    save_current(mesh_set, tmp_path / "a.ply")
    save_project(mesh_set, tmp_path / "p.mlp")
    assert mesh_set.current_mesh_id() == 0
    assert [mesh.label() for mesh in mesh_set] == ["cloud", "solid"]
    assert np.array_equal(read_layer(mesh_set, 0).points, cloud().points)


def test_an_empty_document_cannot_be_saved(tmp_path):
    with pytest.raises(FileError, match="the document is empty"):
        save_current(new_document(), tmp_path / "a.ply")


def test_a_link_is_written_through(tmp_path):
    (tmp_path / "there").mkdir()
    target = tmp_path / "there" / "a.ply"
    target.write_text("old")
    link = tmp_path / "b.ply"
    link.symlink_to(target)
    save_current(document(solid()), link)
    assert link.is_symlink()
    mesh_set = load(target)
    assert mesh_set.current_mesh().face_number() == 4


def interrupted(path: Path, error: BaseException) -> None:
    with replacing(path) as staged:
        staged.write_text("half")
        raise error


def test_an_interrupted_write_leaves_the_old_file(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old")
    full = OSError(28, "No space left on device")
    for error, raised in (
        (KeyboardInterrupt(), KeyboardInterrupt),
        (RuntimeError(), RuntimeError),
        (full, FileError),
    ):
        with pytest.raises(raised):
            interrupted(path, error)
    with pytest.raises(FileError, match="the writer made no file"), replacing(path):
        pass
    assert path.read_text() == "old"
    assert [file.name for file in tmp_path.iterdir()] == ["a.txt"]


def test_files_beside_the_named_one_come_along(tmp_path):
    with replacing(tmp_path / "a.obj") as staged:
        (staged.parent / "a.obj.mtl").write_text("material")
        staged.write_text("mesh")
    assert {file.name: file.read_text() for file in tmp_path.iterdir()} == {
        "a.obj": "mesh",
        "a.obj.mtl": "material",
    }


def child(program, *words):
    """Run a program in a process of its own; return its number once it has ended."""
    ended = subprocess.run(
        [sys.executable, "-c", f"import os; print(os.getpid())\n{program}", *words],
        capture_output=True, text=True,
    )  # fmt: skip
    return int(ended.stdout.split()[0])


KILLED = """
import sys
from pathlib import Path
from meshlab_symrecon.host.atomic import replacing
with replacing(Path(sys.argv[1])) as staged:
    staged.write_text("half")
    sys.stdout.flush()
    os.abort()
"""


def test_what_a_dead_process_left_is_removed_and_nothing_else(tmp_path):
    target = tmp_path / "a.txt"
    dead = child(KILLED, str(target))
    (left,) = tmp_path.iterdir()
    assert left.name.startswith(f".symrecon-{dead}-")
    elsewhere = tmp_path / f".symrecon-{dead}-0000abcd-xyz"  # of another machine
    elsewhere.mkdir()
    foreign = tmp_path / ".symrecon-notes"
    foreign.mkdir()
    with replacing(tmp_path / "b.txt") as ours:
        ours.write_text("b")
        assert not left.exists()
        with replacing(target) as other:  # and does not take ours for one
            other.write_text("a")
        assert ours.exists()
    stay = {elsewhere.name, foreign.name, "a.txt", "b.txt"}
    assert {file.name for file in tmp_path.iterdir()} == stay


def test_another_users_process_is_alive(tmp_path, monkeypatch):
    dead = child(KILLED, str(tmp_path / "a.txt"))
    (left,) = tmp_path.iterdir()

    def refused(process, number):
        assert (process, number) == (dead, 0)
        raise PermissionError

    with monkeypatch.context() as patched:
        patched.setattr("os.kill", refused)
        remove_dead_staging(tmp_path)
        assert left.exists()
        patched.setattr("os.name", "nt")
        patched.setattr("os.kill", None)
        remove_dead_staging(tmp_path)
    assert left.exists()
    remove_dead_staging(tmp_path)
    assert not left.exists()


def test_names_of_one_file_are_recognised(tmp_path):
    here = tmp_path / "a.ply"
    assert same_file(here, tmp_path / "b" / ".." / "a.ply")
    assert not same_file(here, tmp_path / "b.ply")


FULL = """
import resource, sys
from meshlab_symrecon.errors import FileError
from meshlab_symrecon.host.files import load, save_current
mesh_set = load(sys.argv[1])
resource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000))
try:
    save_current(mesh_set, sys.argv[2])
except FileError as error:
    sys.stdout.write(str(error))
"""


SURVIVED = [name for name in WRITABLE if name not in ("3mf", "e57")]  # these abort the process


@pytest.mark.parametrize("extension", SURVIVED)
def test_a_full_disk_leaves_the_old_file(tmp_path, extension):
    """A limit on the size of files stands in for the disk."""
    mesh_set = new_document()
    mesh_set.create_sphere(subdiv=3)
    save_current(mesh_set, tmp_path / "in.ply")
    target = tmp_path / f"out.{extension}"
    target.write_text("old")
    ended = subprocess.run(
        [sys.executable, "-c", FULL, tmp_path / "in.ply", target], capture_output=True, text=True
    )
    assert ended.returncode == 0, ended.stderr
    assert "cannot be written" in ended.stdout
    assert target.read_text() == "old"
    assert sorted(file.name for file in tmp_path.iterdir()) == ["in.ply", target.name]


@pytest.mark.parametrize("full", ["a.ply", "b.json"])
def test_a_disk_that_is_full_at_the_last_moment_is_told_of_files_together(
    tmp_path, monkeypatch, full
):
    """Some file systems count what was written only when it is flushed."""

    def flush(descriptor):
        if Path(f"/proc/self/fd/{descriptor}").readlink().name == full:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    def work():
        with together():
            for name in ("a.ply", "b.json"):
                with replacing(tmp_path / name) as staged:
                    staged.write_text("new")

    (tmp_path / full).write_text("old")
    monkeypatch.setattr(os, "fsync", flush)
    with pytest.raises(FileError, match=f"{full} cannot be written: No space left.*; free space"):
        work()
    assert [file.name for file in tmp_path.iterdir()] == [full]
    assert (tmp_path / full).read_text() == "old"


def test_a_project_keeps_every_layer(tmp_path):
    other = solid()
    mesh_set = document(cloud(), other)
    mesh_set.mesh(1).set_label("a/b: <c> & größe")
    add_layer(mesh_set, Layer(other.points, other.faces, "A B c größe"), current=True)
    add_layer(mesh_set, Layer(other.points, other.faces, "a b c größe"), current=True)
    path = tmp_path / "the statue.mlp"
    save_project(mesh_set, path, labels={0: "scan"})
    names = [
        element.get("filename") for element in ElementTree.parse(path).getroot().iter("MLMesh")
    ]
    assert len(set(names)) == 4
    assert names[0] == "the statue-scan.ply"
    assert sorted(file.name for file in tmp_path.iterdir()) == sorted([path.name, *names])
    back = pymeshlab.MeshSet(verbose=False)
    back.load_project(str(path))
    assert [mesh.label() for mesh in back] == [
        "scan", "a/b: <c> & größe", "A B c größe", "a b c größe",
    ]  # fmt: skip
    for identifier in range(4):
        before, after = read_layer(mesh_set, identifier), read_layer(back, identifier)
        assert np.array_equal(before.points, after.points)
        assert np.array_equal(before.faces, after.faces)


def test_a_project_spares_the_inputs(tmp_path):
    (tmp_path / "p-cloud.ply").write_text("scan")
    with pytest.raises(FileError, match="would overwrite"):
        save_project(document(cloud()), tmp_path / "p.mlp", inputs=[tmp_path / "p-cloud.ply"])
    assert (tmp_path / "p-cloud.ply").read_text() == "scan"
    with pytest.raises(
        FileError, match=r"extension '.ply', which cannot be written; known are mlp"
    ):
        save_project(document(cloud()), tmp_path / "p.ply")
    assert len(list(tmp_path.iterdir())) == 1


def test_errors_of_files_are_ours():
    assert issubclass(FileError, SymReconError)
    assert issubclass(FileError, OSError)
