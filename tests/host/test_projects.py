"""Projects that are read, and saved beside where their layers came from."""

from __future__ import annotations

import base64
import json
import struct
import zlib
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pymeshlab
import pytest

from meshlab_symrecon.errors import FileError, SymReconWarning
from meshlab_symrecon.host.files import load, new_document
from meshlab_symrecon.host.project_copy import copied_files, save_project_copy
from meshlab_symrecon.host.project_files import read_project
from meshlab_symrecon.host.projects import load_layers, load_project, save_project

MOVED = np.array(
    [[0.0, -2, 0, 1.123456789123], [1, 0, 0, -3e-7], [0, 0, 1, 12345.678], [0, 0, 0, 1]]
)
LAYER = (
    '<MLMesh label="{label}" filename="{file}" visible="1" idInFile="{index}">'
    "<MLMatrix44>{matrix}</MLMatrix44></MLMesh>"
)
CAMERA = (
    '<VCGCamera TranslationVector="1 2 3 1" LensDistortion="0 0" ViewportPx="8 8" '
    'PixelSizeMm="0.1 0.1" CenterPx="4 4" FocalMm="5" CameraType="0" BinaryData="0" '
    'RotationMatrix="1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1"/>'
)
RASTER = '<MLRaster label="{file}">' + CAMERA + '<Plane semantic="1" fileName="{file}"/></MLRaster>'


def numbers(matrix):
    return " ".join(repr(float(value)) for value in np.ravel(matrix))


def picture(path):
    """Write a PNG of 8 by 8 grey pixels."""

    def chunk(kind, data):
        body = kind + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))

    size = struct.pack(">IIBBBBB", 8, 8, 8, 0, 0, 0, 0)
    rows = zlib.compress((b"\0" + b"\x7f" * 8) * 8)
    start = b"\x89PNG\r\n\x1a\n"
    path.write_bytes(start + chunk(b"IHDR", size) + chunk(b"IDAT", rows) + chunk(b"IEND", b""))


@pytest.fixture
def folder(tmp_path):
    """A folder with 'cube.ply' and 'in here/sphere.ply'."""
    mesh_set = new_document()
    mesh_set.create_cube()
    mesh_set.save_current_mesh(str(tmp_path / "cube.ply"))
    (tmp_path / "in here").mkdir()
    mesh_set.create_sphere(subdiv=1)
    mesh_set.save_current_mesh(str(tmp_path / "in here" / "sphere.ply"))
    return tmp_path


@pytest.fixture
def write(folder):
    """Return a function that writes a project of given layers and rasters."""

    def project(*layers, rasters="", name="a.mlp", index=-1):
        body = "".join(LAYER.format(label=label, file=file, matrix=matrix, index=index)
                       for label, file, matrix in layers)  # fmt: skip
        path = folder / name
        path.write_text(
            "<!DOCTYPE MeshLabDocument>\n<MeshLabProject><MeshGroup>"
            f"{body}</MeshGroup><RasterGroup>{rasters}</RasterGroup></MeshLabProject>"
        )
        return path

    return project


CUBE = ("the cube", "cube.ply", numbers(MOVED))
SPHERE = ("ball", "in here/sphere.ply", numbers(np.eye(4)))


def shown(mesh_set):
    return [(mesh.label(), mesh.vertex_number()) for mesh in mesh_set]


def test_layers_come_with_labels_and_matrices_to_the_last_bit(write, monkeypatch):
    path = write(CUBE, SPHERE)
    monkeypatch.chdir(path.parent.parent)  # files are named from the project
    mesh_set = load_project(path)
    assert shown(mesh_set) == [("the cube", 8), ("ball", 42)]
    assert np.array_equal(mesh_set.mesh(0).transform_matrix(), MOVED)
    assert np.array_equal(mesh_set.mesh(1).transform_matrix(), np.eye(4))
    assert mesh_set.current_mesh_id() == 1


def test_layers_are_added_behind_those_that_are_there(write):
    mesh_set = new_document()
    mesh_set.create_cone()
    assert load_project(write(CUBE), mesh_set) is mesh_set
    assert [label for label, _ in shown(mesh_set)] == ["Cone", "the cube"]
    origins = load_layers(read_project(write(SPHERE, CUBE)), mesh_set)
    assert {number: path.name for number, path in origins.items()} == {
        2: "sphere.ply", 3: "cube.ply",
    }  # fmt: skip


@pytest.mark.parametrize("extension", ["mlp", "mlb"])
def test_what_pymeshlab_saves_is_read(write, extension):
    mesh_set = load_project(write(CUBE, SPHERE))
    path = write(name="b.mlp").with_suffix(f".{extension}")
    again = pymeshlab.MeshSet(verbose=False)
    again.load_new_mesh(str(path.with_name("cube.ply")))
    again.set_matrix(transformmatrix=MOVED, freeze=False)
    again.save_project(str(path))
    mesh_set = load_project(path)
    tolerance = 0.0 if extension == "mlb" else 1e-5  # MeshLab writes six digits in MLP
    np.testing.assert_allclose(
        mesh_set.mesh(0).transform_matrix(), MOVED, rtol=tolerance, atol=tolerance
    )


def test_lists_of_alignments_are_read(folder):
    rows = "\n".join(" ".join(map(repr, map(float, row))) for row in MOVED)
    unmoved = "\n".join(" ".join(map(repr, row)) for row in np.eye(4).tolist())
    path = folder / "a.ALN"
    path.write_text(f"2\ncube.ply\n#\n{rows}\n\nin here/sphere.ply\n#\n{unmoved}\n0\n")
    mesh_set = load_project(path)
    assert shown(mesh_set) == [("cube.ply", 8), ("sphere.ply", 42)]
    assert np.array_equal(mesh_set.mesh(0).transform_matrix(), MOVED)


def two_triangles(path):
    """Write a glTF file with two meshes, at heights 0 and 1."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1]], "<f4")
    content = base64.b64encode(corners.tobytes()).decode()
    views = [{"buffer": 0, "byteOffset": 36 * number, "byteLength": 36} for number in (0, 1)]
    accessors = [
        {"bufferView": number, "componentType": 5126, "count": 3, "type": "VEC3",
         "min": [0, 0, number], "max": [1, 1, number]}
        for number in (0, 1)
    ]  # fmt: skip
    meshes = [{"primitives": [{"attributes": {"POSITION": number}}]} for number in (0, 1)]
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0}, {"mesh": 1}], "meshes": meshes, "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": 72, "uri": f"data:application/octet-stream;base64,{content}"}],
    }  # fmt: skip
    path.write_text(json.dumps(document))


@pytest.mark.parametrize(("index", "heights"), [(-1, [0, 1]), (0, [0]), (1, [1]), (2, [0, 1])])
def test_one_mesh_of_a_file_with_several(write, folder, index, heights):
    two_triangles(folder / "two.gltf")
    mesh_set = load_project(write(("mine", "two.gltf", numbers(MOVED)), SPHERE, index=index))
    meshes = list(mesh_set)[:-1]
    assert [mesh.vertex_matrix()[:, 2].max() for mesh in meshes] == heights
    assert all(np.array_equal(mesh.transform_matrix(), MOVED) for mesh in meshes)
    assert (meshes[0].label() == "mine") == (len(meshes) == 1)
    assert mesh_set.current_mesh().label() == "ball"


def test_paths_of_windows_are_read(write):
    mesh_set = load_project(write(("ball", "in here\\sphere.ply", numbers(np.eye(4)))))
    assert shown(mesh_set) == [("ball", 42)]


def test_a_layer_without_matrix_or_label_has_the_identity_and_the_name_of_its_file(folder):
    path = folder / "a.mlp"
    path.write_text('<MeshLabProject><MeshGroup><MLMesh filename="cube.ply"/></MeshGroup>'
                    "</MeshLabProject>")  # fmt: skip
    mesh_set = load_project(path)
    assert shown(mesh_set) == [("cube.ply", 8)]
    assert np.array_equal(mesh_set.mesh(0).transform_matrix(), np.eye(4))


def test_every_missing_file_is_named(write):
    path = write(("a", "gone.ply", numbers(np.eye(4))), CUBE, ("b", "lost/b.obj", ""))
    with pytest.raises(FileError, match=r"matrix of 'lost/b\.obj'"):
        load_project(path)
    unit = numbers(np.eye(4))
    path = write(("a", "gone.ply", unit), CUBE, ("b", "lost/b.obj", unit), ("c", "gone.ply", unit))
    with pytest.raises(FileError, match="names 2 mesh files that are not there") as caught:
        load_project(path)
    assert str(path.parent / "gone.ply") in str(caught.value)
    assert str(path.parent / "lost/b.obj") in str(caught.value)


def matrix_of(text):
    return LAYER.format(label="", index=-1, file="cube.ply", matrix=text)


BAD = {
    "words.mlp": ("hello", "it is not XML"),
    "empty.mlp": ("", "it is not XML"),
    "root.mlp": ("<FilterScript/>", "its outermost element is <FilterScript>"),
    "bomb.mlp": ('<!DOCTYPE a [<!ENTITY b "c">]><MeshLabProject>&b;</MeshLabProject>', "entities"),
    "coding.mlp": ('<?xml version="1.0" encoding="no-such"?><MeshLabProject/>', "cannot be read"),
    "nameless.mlp": (
        '<MeshLabProject><MLMesh label="x" filename=""/></MeshLabProject>', "names no file"
    ),
    "short.mlp": (matrix_of("1 0 0"), "16 finite numbers"),
    "word.mlp": (matrix_of("one"), "16 finite numbers"),
    "nan.mlp": (
        matrix_of("nan " * 16), "16 finite numbers"
    ),
    "count.aln": ("cube.ply\n", "first line must be the number"),
    "empty.aln": ("", "first line must be the number"),
    "short.aln": ("2\ncube.ply\n#\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n", "announces 2 meshes"),
    "word.aln": ("1\ncube.ply\n#\na b c d\n0 1 0 0\n0 0 1 0\n0 0 0 1\n", "16 finite numbers"),
    "other.nvm": ("", "known extensions are mlp, mlb, aln"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_bad_projects_are_refused_in_one_sentence(folder, name):
    text, words = BAD[name]
    if text.startswith("<MLMesh"):
        text = f"<MeshLabProject>{text}</MeshLabProject>"
    (folder / name).write_text(text)
    with pytest.raises(FileError, match=words) as caught:
        load_project(folder / name)
    assert str(folder / name) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_missing_project_and_a_damaged_layer(write, folder):
    with pytest.raises(FileError, match=r"none\.mlp cannot be read: No such file"):
        load_project(folder / "none.mlp")
    path = write(CUBE)
    (folder / "cube.ply").write_text("ply\nhello")
    with pytest.raises(FileError, match=r"cube\.ply is damaged"):
        load_project(path)


def test_rasters_come_with_their_cameras(write, folder):
    picture(folder / "in here" / "photo.png")
    mesh_set = load_project(write(CUBE, rasters=RASTER.format(file="in here/photo.png")))
    assert mesh_set.raster_number() == 1
    assert shown(mesh_set) == [("the cube", 8)]
    save_project_copy(mesh_set, folder / "b.mlp", {0: folder / "b.ply"})
    root = ElementTree.parse(folder / "b.mlp").getroot()
    assert [plane.get("fileName") for plane in root.iter("Plane")] == ["in here/photo.png"]
    camera = next(root.iter("VCGCamera"))
    assert [float(word) for word in camera.get("TranslationVector").split()[:3]] == [1, 2, 3]


def test_missing_pictures_are_told_and_not_fatal(write, folder):
    picture(folder / "here.png")
    rasters = RASTER.format(file="here.png") + RASTER.format(file="gone.png")
    with pytest.warns(SymReconWarning, match=r"images are missing: .*gone\.png$"):
        mesh_set = load_project(write(CUBE, rasters=rasters))
    assert mesh_set.raster_number() == 1
    assert shown(mesh_set) == [("the cube", 8)]


def test_names_of_copies():
    project = Path("out/p.mlp")
    labels = {0: "a.ply", 1: "Sampled Mesh", 3: "b", 4: "b!", 5: "scan", 6: "x.stl"}
    origins = {0: Path("in/a.ply"), 5: Path("in/scan.e.fbx")}
    names = copied_files(project, labels, origins, "_out")
    assert {number: path.as_posix() for number, path in names.items()} == {
        0: "in/a_out.ply",
        1: "out/SampledMesh_out.ply",
        3: "out/b_out.ply",
        4: "out/b_out-4.ply",  # never two layers in one file
        5: "in/scan.e_out.ply",  # nothing writes FBX
        6: "out/x_out.ply",
    }
    assert copied_files(project, {0: "a.ply"}, origins, "")[0] == Path("in/a.ply")
    both = copied_files(project, {1: "a", 2: "b"}, dict.fromkeys((1, 2), Path("m.obj")), "")
    assert [path.name for path in both.values()] == ["m.obj", "m-2.obj"]


def test_copies_keep_matrices_attributes_and_labels(write, folder):
    mesh_set = load_project(write(CUBE, SPHERE))
    mesh_set.compute_scalar_by_function_per_vertex(q="x")
    mesh_set.compute_new_custom_scalar_attribute_per_vertex(name="mine", expr="x")
    files = {0: folder / "c.ply", 1: folder / "in here" / "s.ply"}
    save_project_copy(mesh_set, folder / "b.mlp", files)
    again = load_project(folder / "b.mlp")
    assert shown(again) == shown(mesh_set)
    for number in (0, 1):
        before, after = mesh_set.mesh(number), again.mesh(number)
        assert np.array_equal(after.transform_matrix(), before.transform_matrix())
        assert np.array_equal(after.vertex_matrix(), before.vertex_matrix())
        assert np.array_equal(after.face_matrix(), before.face_matrix())
    assert np.array_equal(
        again.mesh(1).vertex_scalar_array(), mesh_set.mesh(1).vertex_scalar_array()
    )
    assert b"property double mine" in files[1].read_bytes()
    native = pymeshlab.MeshSet(verbose=False)
    native.load_project(str(folder / "b.mlp"))
    assert shown(native) == shown(mesh_set)


@pytest.mark.parametrize("word", ["0", "1", "true", "", None])
def test_layers_are_hidden_as_in_pymeshlab(write, folder, word):
    path = write(CUBE, SPHERE)
    written = "" if word is None else f'visible="{word}" '
    path.write_text(path.read_text().replace('visible="1" ', written, 1))
    native = pymeshlab.MeshSet(verbose=False)
    native.load_project(str(path))
    mesh_set = load_project(path)
    seen = [mesh.is_visible() for mesh in native]
    assert seen == [word in ("1", None), True]
    assert [mesh.is_visible() for mesh in mesh_set] == seen
    files = {0: folder / "c.ply", 1: folder / "s.ply"}
    save_project_copy(mesh_set, folder / "b.mlp", files)
    save_project(mesh_set, folder / "d.mlp")
    for name in ("b.mlp", "d.mlp"):
        again = load_project(folder / name)
        assert [mesh.is_visible() for mesh in again] == seen
    mesh_set.generate_by_merging_visible_meshes(deletelayer=False)
    native.generate_by_merging_visible_meshes(deletelayer=False)
    assert mesh_set.current_mesh().vertex_number() == 8 * seen[0] + 42
    assert native.current_mesh().vertex_number() == 8 * seen[0] + 42


def test_a_copy_that_fails_leaves_nothing(write, folder):
    mesh_set = load_project(write(CUBE))
    cloud = pymeshlab.Mesh(vertex_matrix=np.eye(3))
    mesh_set.add_mesh(cloud, "cloud")
    before = sorted(folder.iterdir())
    files = {0: folder / "c.ply", 1: folder / "d.stl"}
    with pytest.raises(FileError, match="holds faces only"):
        save_project_copy(mesh_set, folder / "b.mlp", files)
    assert sorted(folder.iterdir()) == before
    assert load(folder / "cube.ply").mesh_number() == 1
