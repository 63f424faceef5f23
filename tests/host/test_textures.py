"""Images of textures: found, copied byte for byte, never put over what is there."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
import survival_inputs as inputs

from meshlab_symrecon.errors import FileError, SymReconWarning
from meshlab_symrecon.host.atomic import replacing
from meshlab_symrecon.host.files import load, save_current
from meshlab_symrecon.host.projects import save_project
from meshlab_symrecon.host.textures import plain_texture_name

TRIANGLE = """mtllib in.mtl
v 0 0 0
v 1 0 0
v 1 1 0
vt 0 0
vt 1 0
vt 1 1
usemtl stone
f 1/1 2/2 3/3
"""


def textured(folder: Path, name: str, image: str | None = None, seed: int = 0) -> Path:
    """Write an OBJ whose material names an image; the image is at ``image``, or at its name."""
    folder.mkdir(parents=True, exist_ok=True)
    inputs.png(folder / (image or name), seed)
    (folder / "in.mtl").write_text(f"newmtl stone\nmap_Kd {name}\n")
    (folder / "in.obj").write_text(TRIANGLE)
    return folder / "in.obj"


def named_in(obj: Path) -> str:
    materials = obj.with_name(f"{obj.name}.mtl").read_text()
    return next(line for line in materials.splitlines() if line.startswith("map_Kd "))[7:]


@pytest.mark.parametrize(
    ("name", "image", "written"),
    [
        ("a.png", None, "a.png"),
        ("./a.png", None, "a.png"),
        ("paint/a.png", None, "paint/a.png"),
        ("paint\\a.png", "paint/a.png", "paint/a.png"),
        ("../a.png", None, "a.png"),
        ("-s 1 1 1 a.png", "a.png", "a.png"),
        ("my paint.png", None, "my_paint.png"),
    ],
)
def test_an_image_is_copied_byte_for_byte_to_a_place_beside_the_output(
    tmp_path, name, image, written
):
    source = textured(tmp_path / "a" / "in", name, image)
    (tmp_path / "out").mkdir()
    target = tmp_path / "out" / "new.obj"
    save_current(load(source), target)
    assert named_in(target) == written
    original = source.parent / (image or name)
    assert (target.parent / written).read_bytes() == original.read_bytes()
    files = {path.name for path in tmp_path.rglob("*") if path.is_file()}
    assert files == {
        "in.obj",
        "in.mtl",
        original.name,
        "new.obj",
        "new.obj.mtl",
        Path(written).name,
    }
    back = load(target)
    assert list(back.current_mesh().textures()) == [written]


def test_an_absolute_name_becomes_a_plain_one(tmp_path):
    inputs.png(tmp_path / "far" / "a.png")
    source = textured(tmp_path / "in", str(tmp_path / "far" / "a.png"))
    (tmp_path / "out").mkdir()
    save_current(load(source), tmp_path / "out" / "new.ply")
    assert b"TextureFile a.png\n" in (tmp_path / "out" / "new.ply").read_bytes()
    assert (tmp_path / "out" / "a.png").is_file()


def test_in_the_input_s_folder_its_image_is_used(tmp_path):
    source = textured(tmp_path, "a.png")
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    save_current(load(source), tmp_path / "new.obj")
    assert named_in(tmp_path / "new.obj") == "a.png"
    assert {path: path.read_bytes() for path in before} == before
    assert len(list(tmp_path.iterdir())) == len(before) + 2


def test_another_image_of_that_name_stays(tmp_path):
    source = textured(tmp_path / "in", "paint/a.png")
    inputs.png(tmp_path / "paint" / "a.png", seed=7)
    other = (tmp_path / "paint" / "a.png").read_bytes()
    target = tmp_path / "new.obj"
    for _ in range(2):  # the second time replaces the output's own image
        save_current(load(source), target)
        assert named_in(target) == "new-a.png"
        assert (tmp_path / "paint" / "a.png").read_bytes() == other
        assert (tmp_path / "new-a.png").read_bytes() == (source.parent / "paint/a.png").read_bytes()
    assert len([path for path in tmp_path.iterdir() if path.suffix == ".png"]) == 1


def test_no_image_of_an_input_is_replaced(tmp_path):
    """The name that another image leaves is that of an input's image, too."""
    source = textured(tmp_path / "in", "a.png")
    other = textured(tmp_path, "a.png", seed=7)
    inputs.png(tmp_path / "new-a.png", seed=8)
    (tmp_path / "in.mtl").write_text("newmtl stone\nmap_Kd a.png\nmap_Bump new-a.png\n")
    before = {path: path.read_bytes() for path in tmp_path.glob("*.*")}
    mesh_set = load(other)
    load(source, mesh_set)
    save_current(mesh_set, tmp_path / "new.obj")
    assert named_in(tmp_path / "new.obj") == "new-a-2.png"
    assert {path: path.read_bytes() for path in before} == before


def test_materials_of_an_input_are_not_replaced(tmp_path):
    source = textured(tmp_path, "a.png")
    (tmp_path / "in.mtl").rename(tmp_path / "new.obj.mtl")
    source.write_text(TRIANGLE.replace("in.mtl", "new.obj.mtl"))
    before = (tmp_path / "new.obj.mtl").read_bytes()
    save_current(load(source), tmp_path / "new.obj")
    assert (tmp_path / "new.obj.mtl").read_bytes() == before
    assert "mtllib ./new.obj-2.mtl\n" in (tmp_path / "new.obj").read_text()
    back = load(tmp_path / "new.obj")
    assert list(back.current_mesh().textures()) == ["a.png"]


def test_a_changed_image_is_written_from_memory(tmp_path):
    source = textured(tmp_path / "in", "a.png")
    mesh_set = load(source)
    mesh_set.compute_color_by_function_per_vertex(x="255", y="0", z="0")
    mesh_set.compute_texmap_from_color(textname="a.png", textw=16, texth=16, overwrite=True)
    save_current(mesh_set, tmp_path / "new.obj")
    written = tmp_path / named_in(tmp_path / "new.obj")
    assert written.read_bytes() != (tmp_path / "in" / "a.png").read_bytes()
    back = load(tmp_path / "new.obj")
    back.compute_color_from_texture_per_vertex()
    colours = back.current_mesh().vertex_color_matrix()
    assert np.abs(colours[:, :3] - [1.0, 0.0, 0.0]).max() < 0.02


def test_an_image_that_is_gone_since_is_written_from_memory(tmp_path):
    source = textured(tmp_path / "in", "a.png")
    mesh_set = load(source)
    (tmp_path / "in" / "a.png").unlink()
    save_current(mesh_set, tmp_path / "new.obj")
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")


def test_an_image_that_cannot_be_written_is_told_and_the_mesh_is_written(tmp_path, monkeypatch):
    mesh_set = load(textured(tmp_path / "in", "a.png"))

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("meshlab_symrecon.host.textures._make", full)
    with pytest.warns(SymReconWarning, match="the texture a.png was left out: .*No space left"):
        save_current(mesh_set, tmp_path / "new.obj")
    assert {path.name for path in tmp_path.glob("*.*")} == {"new.obj", "new.obj.mtl"}


def test_materials_without_permission(tmp_path, monkeypatch):
    source = textured(tmp_path, "a.png")

    def refused(*_):
        raise PermissionError(13, "Permission denied", str(tmp_path / "in.mtl"))

    monkeypatch.setattr("meshlab_symrecon.host.importing._named_images", refused)
    with pytest.raises(FileError, match=r"in\.mtl cannot be read: Permission denied"):
        load(source)


def test_of_a_missing_image_the_name_is_kept_and_nothing_invented(tmp_path):
    source = textured(tmp_path, "paint/a.png")
    (tmp_path / "paint" / "a.png").unlink()
    with pytest.warns(
        SymReconWarning, match="paint/a.png only the name is kept, since there is no"
    ):
        mesh_set = load(source)
    with pytest.warns(SymReconWarning, match="the texture paint/a.png was missing"):
        save_current(mesh_set, tmp_path / "new.obj")
    assert named_in(tmp_path / "new.obj") == "paint/a.png"
    assert list(tmp_path.rglob("*.png")) == []


@pytest.mark.parametrize("links", [True, False])
def test_images_of_names_that_meshlab_does_not_read_stay_with_their_faces(
    tmp_path, monkeypatch, links
):
    """MeshLab would take one stand-in for all of them."""

    def refused(*_):
        raise OSError("no links here")

    if not links:
        monkeypatch.setattr(Path, "symlink_to", refused)
    names = ["a 1.png", "../b 2.png", "c.png"]
    maps = ["map_Kd a 1.png", "map_Kd -s 1 1 1 ../b 2.png", "map_Kd c.png"]
    (tmp_path / "in").mkdir()
    for number, name in enumerate(names):
        inputs.png(tmp_path / "in" / name, seed=number)
    materials = [f"newmtl m{i}\n{line}\n" for i, line in enumerate(maps)]
    (tmp_path / "in" / "in.mtl").write_text("".join(materials))
    faces = "".join(f"usemtl m{i}\nf 1/1 2/2 {i + 3}/3\n" for i in (1, 0, 2))
    vertices = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 1 1\n"
    (tmp_path / "in" / "in.obj").write_text(f"mtllib in.mtl\n{vertices}{faces}")
    save_current(load(tmp_path / "in" / "in.obj"), tmp_path / "out.obj")
    written = [tmp_path / plain for plain in ("a_1.png", "b_2.png", "c.png")]
    for name, file in zip(names, written, strict=True):
        assert file.read_bytes() == (tmp_path / "in" / name).read_bytes()
    uses: dict[str, str] = {}
    material = ""
    for line in (tmp_path / "out.obj").read_text().splitlines():
        material = line if line.startswith("usemtl") else material
        if line.startswith("f "):
            uses[line.split()[3].partition("/")[0]] = material.split()[1]
    images = {}
    for line in (tmp_path / "out.obj.mtl").read_text().splitlines():
        if line.startswith("newmtl"):
            material = line.split()[1]
        elif line.startswith("map_Kd"):
            images[material] = line.split()[1]
    assert {corner: images[use] for corner, use in uses.items()} == {
        "3": "a_1.png",
        "4": "b_2.png",
        "5": "c.png",
    }


@pytest.mark.parametrize("extension", ["x3d", "wrl"])
def test_textures_that_meshlab_does_not_read_are_told(tmp_path, extension):
    target = tmp_path / f"new.{extension}"
    save_current(load(textured(tmp_path / "in", "a.png")), target)
    with pytest.warns(SymReconWarning, match=r"does not read textures \(a.png\) of such files"):
        load(target)


def test_layers_of_a_project_keep_images_of_one_name(tmp_path):
    mesh_set = load(textured(tmp_path / "one", "a.png", seed=1))
    load(textured(tmp_path / "two", "a.png", seed=2), mesh_set)
    (tmp_path / "out").mkdir()
    save_project(mesh_set, tmp_path / "out" / "p.mlp")
    images = set()
    for layer in (tmp_path / "out").glob("*.ply"):
        back = load(layer)
        (name,) = back.current_mesh().textures()
        images.add((tmp_path / "out" / name).read_bytes())
    assert images == {(tmp_path / which / "a.png").read_bytes() for which in ("one", "two")}
    assert len(images) == 2


def test_a_failed_write_leaves_no_image(tmp_path):
    def fail() -> None:
        with replacing(tmp_path / "a.obj") as staged:
            (staged.parent / "paint").mkdir()
            (staged.parent / "paint" / "a.png").write_text("image")
            staged.write_text("mesh")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fail()
    assert list(tmp_path.iterdir()) == []


def test_further_files_are_refused_before_any_is_moved(tmp_path):
    (tmp_path / "b.png").mkdir()

    def place() -> None:
        with replacing(tmp_path / "a.obj") as staged:
            (staged.parent / "a.png").write_text("image")
            (staged.parent / "b.png").write_text("image")
            staged.write_text("mesh")

    with pytest.raises(FileError, match="is not an ordinary file"):
        place()
    assert os.listdir(tmp_path) == ["b.png"]  # noqa: PTH208


@pytest.mark.parametrize(
    ("name", "plain"),
    [
        ("a.png", "a.png"),
        ("x/y/a.png", "x/y/a.png"),
        ("./x/./a.png", "x/a.png"),
        ("../../a.png", "a.png"),
        ("/etc/a.png", "a.png"),
        ("C:\\scan\\a b.png", "a_b.png"),
        ("..", "texture"),
        ('a"b?.png', "a_b_.png"),
    ],
)
def test_names_stay_beneath_the_output(name, plain):
    assert plain_texture_name(name) == plain
