"""What MeshLab's exporters get wrong, and is put right or told."""

from __future__ import annotations

import os
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pymeshlab
import pytest
import survival_inputs as inputs

from meshlab_symrecon.errors import FileError, SymReconWarning
from meshlab_symrecon.host.files import load, new_document, save_current
from meshlab_symrecon.host.meshset import add_layer, read_layer
from meshlab_symrecon.host.polygons import Polygons, polygons_of
from meshlab_symrecon.host.process_state import process_kept
from meshlab_symrecon.host.projects import save_project
from meshlab_symrecon.plugin import Layer

NO_FACES = np.zeros((0, 3), dtype=np.int64)
MIRROR = np.array([[0.0, -2, 0, 1], [2, 0, 0, 3], [0, 0, -2, -1], [0, 0, 0, 1]])


def box(tmp_path: Path, faces=inputs.QUADS, points=inputs.BENT):
    inputs.ply(tmp_path / "in.ply", points, faces)
    return load(tmp_path / "in.ply")


@pytest.mark.parametrize(
    ("faces", "found"),
    [
        (inputs.TRIANGLES, Polygons.NONE),
        (inputs.QUADS, Polygons.PLAIN),
        ([[0, 1, 3, 7, 5, 4]], Polygons.PLAIN),
        ([[0, 1, 3, 2], [0, 3, 4]], Polygons.TANGLED),  # the cut of one is an edge of another
        ([[0, 1, 2, 3], [1, 4, 5], [1, 4, 5, 2]], Polygons.TANGLED),
        ([[0, 1, 2, 3], [0, 1, 2, 3]], Polygons.TANGLED),
    ],
)
@pytest.mark.parametrize("extension", ["obj", "off", "ply"])
def test_polygons_are_kept_where_the_exporter_can_be_trusted(tmp_path, faces, found, extension):
    """pymeshlab itself ends the process when it writes tangled ones as OBJ or OFF."""
    mesh_set = box(tmp_path, faces)
    assert polygons_of(mesh_set, 0) is found
    target = tmp_path / f"out.{extension}"
    if found is Polygons.TANGLED and extension != "ply":
        with pytest.warns(SymReconWarning, match="cannot keep polygons, which became triangles"):
            save_current(mesh_set, target)
        found = Polygons.NONE
    else:
        save_current(mesh_set, target)
    back = load(target)
    assert polygons_of(back, 0) is found
    assert back.current_mesh().face_number() == mesh_set.current_mesh().face_number()


def test_a_vertex_inside_of_a_polygon_makes_it_tangled(tmp_path):
    """All three inner edges of a fan are marked: there is no way round of all triangles."""
    fan = [[0, 1, 2], [0, 2, 3], [0, 3, 1]]
    inside = 0x40000 | 0x100000  # the first and the last edge of each
    inputs.ply(tmp_path / "in.ply", inputs.BENT, fan, face={"int flags": [str(inside)] * 3})
    assert polygons_of(load(tmp_path / "in.ply"), 0) is Polygons.TANGLED


def test_polygons_of_a_tiny_mesh_are_not_rounded_away(tmp_path):
    """MeshLab's OBJ files of polygons have seven decimals."""
    mesh_set = box(tmp_path, points=inputs.BENT * 1e-5)
    with pytest.warns(SymReconWarning, match="cannot keep polygons"):
        save_current(mesh_set, tmp_path / "out.obj")
    back = load(tmp_path / "out.obj")
    assert np.abs(back.current_mesh().vertex_matrix() - inputs.BENT * 1e-5).max() < 1e-15


@pytest.mark.parametrize(
    ("quality", "kept"), [([0.0, 1.0], True), ([-2.0, 3.0], True), ([1.0, 2.0], False)]
)
def test_a_quality_that_the_e57_exporter_fails_on(tmp_path, quality, kept):
    layer = Layer(np.eye(3)[:2], NO_FACES, quality=np.array(quality))
    mesh_set = new_document()
    add_layer(mesh_set, layer, current=True)
    if not kept:
        with pytest.warns(SymReconWarning, match="e57 cannot keep vertex quality"):
            save_current(mesh_set, tmp_path / "a.e57")
        return
    save_current(mesh_set, tmp_path / "a.e57")
    back = load(tmp_path / "a.e57")
    assert back.current_mesh().vertex_scalar_array().tolist() == quality


def test_colours_of_an_off_file_are_not_taken_for_its_normals(tmp_path):
    layer = Layer(
        np.eye(3),
        NO_FACES,
        normals=np.eye(3),
        colours=np.array([[1.0, 0, 0, 1], [0, 1, 0, 1], [0, 0, 1, 1]]),
    )
    mesh_set = new_document()
    add_layer(mesh_set, layer, current=True)
    with pytest.warns(SymReconWarning, match="off cannot keep vertex normals"):
        save_current(mesh_set, tmp_path / "a.off")
    back = load(tmp_path / "a.off")
    assert back.current_mesh().vertex_color_matrix().tolist() == layer.colours.tolist()


def test_a_matrix_that_mirrors_takes_everything_along(tmp_path):
    inputs.png(tmp_path / "in" / inputs.IMAGE)
    face = {
        "list uchar float texcoord": inputs.wedge_texts(inputs.FACES),
        "int part": inputs.texts(inputs.FACES, "{i}"),
    }
    vertex = {"int flags": ["32"] + ["0"] * 7, "float Height": inputs.texts(8, "{f}")}
    path = tmp_path / "in" / "in.ply"
    inputs.ply(path, inputs.BENT, inputs.TRIANGLES, vertex, face, [(0, 7)], inputs.IMAGE)
    mesh_set = load(path)
    mesh_set.set_matrix(transformmatrix=MIRROR, freeze=False)
    world = read_layer(mesh_set, 0)
    (tmp_path / "out").mkdir()
    save_current(mesh_set, tmp_path / "out" / "out.ply")
    assert (tmp_path / "out" / inputs.IMAGE).read_bytes() == (
        path.parent / inputs.IMAGE
    ).read_bytes()
    back, mesh = load(tmp_path / "out" / "out.ply"), mesh_set.current_mesh()
    moved = back.current_mesh()
    assert np.array_equal(moved.vertex_matrix(), world.points)
    assert np.array_equal(np.sort(moved.face_matrix()), np.sort(world.faces))
    assert np.linalg.det(world.points[moved.face_matrix()[0]]) == pytest.approx(
        np.linalg.det(world.points[world.faces[0]])
    )
    assert moved.edge_matrix().tolist() == [[0, 7]]
    assert moved.vertex_selection_array().tolist() == mesh.vertex_selection_array().tolist()
    for name in ("vertex_custom_scalar_attribute_array", "face_custom_scalar_attribute_array"):
        attribute = "Height" if name.startswith("vertex") else "part"
        before, after = (getattr(one, name)(attribute) for one in (mesh, moved))
        assert np.array_equal(before, after)
    corners = [
        {
            (int(c), *np.round(uv, 5))
            for c, uv in zip(face, one.wedge_tex_coord_matrix()[3 * i : 3 * i + 3], strict=True)
        }
        for one in (mesh, moved)
        for i, face in enumerate(one.face_matrix())
    ]
    assert corners[: inputs.FACES] == corners[inputs.FACES :]
    assert np.array_equal(mesh.transform_matrix(), MIRROR)


def test_a_flat_matrix_cannot_be_baked(tmp_path):
    mesh_set = box(tmp_path)
    mesh_set.set_matrix(transformmatrix=np.diag([1.0, 1, 0, 1]), freeze=False)
    with pytest.raises(FileError, match="reset the matrix first"):
        save_current(mesh_set, tmp_path / "out.ply")
    assert [file.name for file in tmp_path.iterdir()] == ["in.ply"]


def test_a_project_keeps_matrices_and_what_is_hidden(tmp_path):
    mesh_set = box(tmp_path)
    matrix = np.array([[1 / 3, 0, 0, 1e-17], [0, 1e9 + 1 / 3, 0, 2], [0, 0, -1, 0], [0, 0, 0, 1]])
    mesh_set.set_matrix(transformmatrix=matrix, freeze=False)
    kept = mesh_set.current_mesh().transform_matrix()
    mesh_set.set_mesh_visibility(0, False)
    save_project(mesh_set, tmp_path / "p.mlp")
    (layer,) = ElementTree.parse(tmp_path / "p.mlp").getroot().iter("MLMesh")
    assert layer.get("visible") == "0"
    numbers = [float(word) for word in layer.find("MLMatrix44").text.split()]
    assert np.array_equal(np.reshape(numbers, (4, 4)), kept)
    back = pymeshlab.MeshSet(verbose=False)
    back.load_project(str(tmp_path / "p.mlp"))
    assert np.array_equal(back.current_mesh().vertex_matrix(), inputs.BENT)
    rounded = back.current_mesh().transform_matrix()  # MeshLab's reader takes single precision
    assert np.array_equal(rounded, kept.astype(np.float32))


def test_pictures_of_a_project_are_told_as_left_out(tmp_path):
    mesh_set = box(tmp_path)
    inputs.png(tmp_path / "a.png")
    mesh_set.load_new_raster(str(tmp_path / "a.png"))
    with pytest.warns(SymReconWarning, match="1 raster layers were left out"):
        save_project(mesh_set, tmp_path / "p.mlp")


def test_a_file_that_cannot_be_read_leaves_the_current_directory(tmp_path, monkeypatch):
    """MeshLab's readers go to the file's directory, and stay there when they fail."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "deep").mkdir()
    Path("deep/bad.off").write_text("hello\n")
    with pytest.raises(FileError):
        load("deep/bad.off")
    assert Path.cwd() == tmp_path
    with process_kept():
        os.chdir(tmp_path / "deep")
    assert Path.cwd() == tmp_path


def test_normals_that_meshlab_does_not_read_are_told(tmp_path):
    (tmp_path / "a.obj").write_text("vn 0 0 1\nv 0 0 0\nvn 0 0 1\nv 1 0 0\n")
    with pytest.warns(SymReconWarning, match="does not read normals of points without faces"):
        load(tmp_path / "a.obj")


def test_lines_along_many_points_are_told(tmp_path):
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nl 1 2\nl 1 2 3\n")
    with pytest.warns(SymReconWarning, match="of 1 lines along more than two points"):
        mesh_set = load(tmp_path / "a.obj")
    assert mesh_set.current_mesh().edge_number() == 2


def test_attributes_with_capitals_of_a_moved_layer_are_written_and_not_warned_of(tmp_path):
    mesh_set = box(tmp_path)
    numbers = np.arange(8.0)
    mesh_set.current_mesh().add_vertex_custom_scalar_attribute(numbers, "Height")
    mesh_set.set_matrix(transformmatrix=MIRROR, freeze=False)
    save_current(mesh_set, tmp_path / "out.ply")
    back = load(tmp_path / "out.ply")
    read = back.current_mesh().vertex_custom_scalar_attribute_array("Height")
    assert np.array_equal(read, numbers)
    header = (tmp_path / "out.ply").read_bytes().partition(b"end_header")[0]
    assert b"scratch" not in header
