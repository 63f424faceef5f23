"""Layers written as they are: matrices baked or left out, textures, what cannot be written."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pymeshlab
import pytest

from meshlab_symrecon.errors import FileError, HostError, SymReconWarning
from meshlab_symrecon.host import formats
from meshlab_symrecon.host.atomic import replacing
from meshlab_symrecon.host.baking import bake_layer
from meshlab_symrecon.host.export import export_layer, write_all
from meshlab_symrecon.host.files import load, new_document
from meshlab_symrecon.host.mask import SAVED, TEXT, save_options
from meshlab_symrecon.host.meshset import read_layer

SHEARED = np.array([[2, 0.3, 0, 1], [0, 1, 0.1, -2], [0, 0, 0.5, 3e-7], [0, 0, 0, 1]])
MIRRORED = SHEARED @ np.diag([-1.0, 1, 1, 1])


def ball(cloud=False):
    mesh_set = new_document()
    mesh_set.create_sphere(subdiv=2)
    if cloud:
        mesh = mesh_set.current_mesh()
        points, normals = mesh.vertex_matrix(), mesh.vertex_normal_matrix()
        mesh_set = new_document()
        mesh_set.add_mesh(pymeshlab.Mesh(vertex_matrix=points, v_normals_matrix=normals))
    return mesh_set


def moved(mesh_set, matrix):
    mesh_set.set_matrix(transformmatrix=matrix, freeze=False)
    return mesh_set


@pytest.mark.parametrize("cloud", [False, True])
@pytest.mark.parametrize("matrix", [SHEARED, MIRRORED], ids=["sheared", "mirrored"])
def test_baking_is_what_reading_the_layer_gives(cloud, matrix):
    mesh_set = moved(ball(cloud), matrix)
    expected = read_layer(mesh_set, 0)
    bake_layer(mesh_set, 0)
    mesh = mesh_set.mesh(0)
    assert np.array_equal(mesh.transform_matrix(), np.eye(4))
    np.testing.assert_allclose(mesh.vertex_matrix(), expected.points, rtol=0, atol=1e-14)
    normals = mesh.vertex_normal_matrix()
    if cloud or matrix is SHEARED:
        np.testing.assert_allclose(normals, expected.normals, rtol=0, atol=1e-12)
    else:  # made anew from faces
        assert np.einsum("ij,ij->i", normals, expected.normals).min() > 0.98
    faces = mesh.face_matrix()
    assert np.array_equal(np.sort(faces, axis=1), np.sort(expected.faces, axis=1))
    if not cloud:
        corners = mesh.vertex_matrix()[faces]
        assert np.linalg.det(corners - mesh.vertex_matrix().mean(axis=0)).min() > 0  # outward


def test_baking_leaves_other_layers_and_the_current_one():
    mesh_set = moved(ball(), SHEARED)
    mesh_set.create_cube()
    moved(mesh_set, MIRRORED)
    bake_layer(mesh_set, 0)
    assert mesh_set.current_mesh_id() == 1
    assert np.array_equal(mesh_set.mesh(1).transform_matrix(), MIRRORED)
    before = mesh_set.mesh(0).vertex_matrix()
    bake_layer(mesh_set, 0)
    assert np.array_equal(mesh_set.mesh(0).vertex_matrix(), before)


def test_a_cloud_without_normals_is_baked_without_making_some_up():
    mesh_set = new_document()
    mesh_set.add_mesh(pymeshlab.Mesh(vertex_matrix=np.eye(3)))
    bake_layer(moved(mesh_set, SHEARED), 0)
    assert not mesh_set.mesh(0).vertex_normal_matrix().any()


@pytest.mark.parametrize("scale", [0.0, np.nan])
def test_a_flattening_matrix_is_not_baked(scale):
    mesh_set = moved(ball(), np.diag([1.0, 1.0, scale, 1.0]))
    with pytest.raises(HostError, match="flattens"):
        bake_layer(mesh_set, 0)


@pytest.mark.parametrize("extension", ["ply", "obj", "off"])
def test_matrices_are_left_out(tmp_path, extension):
    mesh_set = moved(ball(), SHEARED)
    path = tmp_path / f"größe 1.{extension}"
    export_layer(mesh_set, 0, path, save_options(extension, ()))
    again = load(path)
    np.testing.assert_allclose(
        again.mesh(0).vertex_matrix(), mesh_set.mesh(0).vertex_matrix(), atol=1e-6
    )
    assert np.array_equal(again.mesh(0).face_matrix(), mesh_set.mesh(0).face_matrix())
    assert [file.name for file in tmp_path.iterdir()] == [path.name]


@pytest.mark.parametrize("extension", SAVED)
def test_an_empty_layer_is_written_or_refused(tmp_path, extension):
    mesh_set = ball()
    mesh_set.set_selection_all()
    mesh_set.meshing_remove_selected_vertices()
    path = tmp_path / f"a.{extension}"
    if extension in formats.NEEDS_POINTS:
        with pytest.raises(FileError, match="has no points"):
            export_layer(mesh_set, 0, path, save_options(extension, ()))
    else:
        export_layer(mesh_set, 0, path, save_options(extension, ()))
    assert path.exists() == (extension not in formats.NEEDS_POINTS)


def test_clouds_are_no_stl_and_loose_points_are_told(tmp_path):
    cloud = ball(cloud=True)
    with pytest.raises(FileError, match=r"162 points belong to no face; write \.ply"):
        export_layer(cloud, 0, tmp_path / "a.stl", save_options("stl", ()))
    mesh_set = new_document()
    points = np.vstack([np.eye(3), np.zeros((1, 3))])
    mesh_set.add_mesh(pymeshlab.Mesh(vertex_matrix=points, face_matrix=[[0, 1, 2]]))
    with pytest.warns(SymReconWarning, match="1 points belong to no face"):
        export_layer(mesh_set, 0, tmp_path / "b.stl", save_options("stl", ()))
    with pytest.warns(SymReconWarning, match="1 faces were left out"):
        export_layer(mesh_set, 0, tmp_path / "b.xyz", save_options("xyz", ()))
    assert sorted(file.name for file in tmp_path.iterdir()) == ["b.stl", "b.xyz"]


# The writer of 3DS tells by itself; the reader of CTM crashes too easily to be asked.
CHECKED = [name for name in SAVED if name not in ("3ds", "ctm")]


@pytest.mark.parametrize(
    ("extension", "cut"),
    [*((extension, cut) for extension in CHECKED for cut in (0.5, 0.999)), ("ply", 0), ("xyz", 0)],
)
@pytest.mark.filterwarnings("ignore::meshlab_symrecon.errors.SymReconWarning")
def test_a_writer_that_does_not_finish_leaves_what_was_there(tmp_path, monkeypatch, extension, cut):
    path = tmp_path / f"a.{extension}"
    path.write_text("old")
    before = Path.cwd()
    mesh_set = ball()

    class Unfinished:
        def __getattr__(self, name):
            return getattr(mesh_set, name)

        def save_current_mesh(self, file, **options):
            mesh_set.save_current_mesh(file, **options)
            with Path(file).open("r+b") as written:
                written.truncate(int(written.seek(0, 2) * cut))

    with pytest.raises(FileError, match="check free space"):
        export_layer(Unfinished(), 0, path, save_options(extension, ()))
    if extension in ("ply", "stl"):
        with pytest.raises(FileError, match="check free space"):
            export_layer(Unfinished(), 0, path, save_options(extension, {TEXT}))
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]
    assert Path.cwd() == before


def everything(mesh_set, path, text=False):
    with replacing(path) as staged:
        write_all(mesh_set, 0, path, staged, text)
    return path


def test_everything_is_custom_attributes_too_and_no_matrix(tmp_path):
    mesh_set = moved(ball(), SHEARED)
    mesh_set.compute_new_custom_scalar_attribute_per_vertex(name="height", expr="z")
    mesh_set.compute_scalar_by_function_per_vertex(q="x")
    path = everything(mesh_set, tmp_path / "a.ply")
    assert b"property double height" in path.read_bytes()
    again = load(path)
    for method in ("vertex_matrix", "vertex_scalar_array", "face_matrix"):
        old, new = (getattr(document.mesh(0), method)() for document in (mesh_set, again))
        assert np.array_equal(old, new), method
    export_layer(mesh_set, 0, tmp_path / "b.ply", save_options("ply", ()))
    assert b"height" not in (tmp_path / "b.ply").read_bytes()
    text = everything(mesh_set, tmp_path / "c.ply", text=True).read_text()
    assert "format ascii" in text
    assert "quality" in text


@pytest.mark.filterwarnings("ignore::meshlab_symrecon.errors.SymReconWarning")
@pytest.mark.parametrize("extension", SAVED)
def test_everything_is_written_in_every_format(tmp_path, extension):
    mesh_set = ball()
    mesh_set.compute_color_by_function_per_vertex(x="x*99+100", y="y*99+100", z="z*99+100")
    path = everything(mesh_set, tmp_path / f"a.{extension}")
    plain = tmp_path / f"b.{extension}"
    export_layer(mesh_set, 0, plain, save_options(extension, ()))
    larger = {"3mf", "dxf", "stl", "3ds", "e57"}  # hold no colours, or as many bytes
    if extension not in larger:
        assert path.stat().st_size > plain.stat().st_size


@pytest.fixture
def textured(tmp_path):
    """A file 'in/ball.obj' with the texture 'in/NAME'; return a function of the name."""

    def make(name):
        folder = tmp_path / "in"
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        mesh_set = ball()
        mesh_set.compute_color_by_function_per_vertex(x="x*99+100", y="y*99+100", z="z*99+100")
        mesh_set.compute_texcoord_parametrization_triangle_trivial_per_wedge(textdim=128)
        mesh_set.compute_texmap_from_color(textname="a.png", textw=128, texth=128)
        mesh_set.save_current_mesh(str(folder / "ball.obj"))
        material = folder / "ball.obj.mtl"
        material.write_text(material.read_text().replace("a.png", name))
        if name != "a.png":
            mesh_set.mesh(0).texture("a.png").save(str(folder / name))
            (folder / "a.png").unlink()
        return folder / "ball.obj"

    return make


@pytest.mark.parametrize("name", ["a.png", "maps/more/a.bmp"])
@pytest.mark.parametrize("extension", ["ply", "obj", "dae"])
def test_textures_go_along_byte_for_byte(textured, tmp_path, name, extension):
    path = textured(name)
    mesh_set = load(path)
    assert list(mesh_set.mesh(0).textures()) == [name]
    out = tmp_path / "out"
    out.mkdir()
    target = out / f"b.{extension}"
    export_layer(mesh_set, 0, target, save_options(extension, {"wt"}))
    assert (out / name).read_bytes() == (path.parent / name).read_bytes()
    again = load(target)
    assert list(again.mesh(0).textures()) == [name]
    assert again.mesh(0).has_wedge_tex_coord()


def test_textures_without_a_file_are_written_and_without_coordinates_not(textured, tmp_path):
    mesh_set = load(textured("maps/a.png"))
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
    export_layer(mesh_set, 0, tmp_path / "a" / "x.ply", save_options("ply", {"wt"}))
    again = load(tmp_path / "a" / "x.ply")
    image = again.mesh(0).texture("maps/a.png")
    assert (image.width(), image.height()) == (128, 128)
    export_layer(mesh_set, 0, tmp_path / "b" / "x.ply", save_options("ply", {"vn"}))
    assert [file.name for file in (tmp_path / "b").iterdir()] == ["x.ply"]


def test_in_place_the_texture_is_not_touched(textured):
    path = textured("a.png")
    before = (path.parent / "a.png").read_bytes()
    mesh_set = load(path)
    export_layer(mesh_set, 0, path, save_options("obj", {"wt"}))
    assert (path.parent / "a.png").read_bytes() == before
    again = load(path)
    assert list(again.mesh(0).textures()) == ["a.png"]


def test_textures_elsewhere_are_copied_beside_the_file(textured, tmp_path):
    path = textured("../maps/a.png")
    mesh_set = load(path)
    assert list(mesh_set.mesh(0).textures()) == ["../maps/a.png"]
    out = tmp_path / "deep" / "out"
    out.mkdir(parents=True)
    export_layer(mesh_set, 0, out / "b.obj", save_options("obj", {"wt"}))
    assert sorted(file.name for file in out.iterdir()) == ["a.png", "b.obj", "b.obj.mtl"]
    assert (out / "a.png").read_bytes() == (tmp_path / "maps" / "a.png").read_bytes()
    assert "map_Kd a.png" in (out / "b.obj.mtl").read_text()
    assert [file.name for file in out.parent.iterdir()] == ["out"]


@pytest.mark.filterwarnings("ignore::meshlab_symrecon.errors.SymReconWarning")
def test_an_image_that_meshlab_cannot_read_goes_along(textured, tmp_path):
    path = textured("a.png")
    (path.parent / "a.png").unlink()
    (path.parent / "a.jpg").write_bytes(b"\xff\xd8\xff\xe0 no reader looks inside")
    material = path.with_name("ball.obj.mtl")
    material.write_text(material.read_text().replace("a.png", "a.jpg"))
    (tmp_path / "out").mkdir()
    export_layer(load(path), 0, tmp_path / "out" / "b.obj", save_options("obj", {"wt"}))
    copied = tmp_path / "out" / "a.jpg"
    assert copied.read_bytes() == (path.parent / "a.jpg").read_bytes()
    assert "map_Kd a.jpg" in (tmp_path / "out" / "b.obj.mtl").read_text()
