"""Every flag of -m in every format: in the file when it is given, and not when it is not."""

from __future__ import annotations

import itertools
import re
import zipfile
from pathlib import Path

import numpy as np
import pymeshlab
import pytest

from meshlab_symrecon.cli.server_job import FLAGS
from meshlab_symrecon.errors import FileError, SymReconWarning
from meshlab_symrecon.host.export import export_layer
from meshlab_symrecon.host.files import load, new_document
from meshlab_symrecon.host.mask import SAVED, held_flags, passed_over, save_options

ATTRIBUTES = tuple(flag for flag in FLAGS if flag != "sa")
# What a file shows of a layer that has everything that a layer can have. MeshLab's writers take a
# few more flags (SAVED), of which nothing comes: wedge colours and normals are in no layer.
SHOWN = {
    "ply": {"vc", "vf", "vq", "vn", "vt", "vr", "fc", "ff", "fq", "wt"},
    "obj": {"vc", "vn", "vt", "fc", "wt", "mp"},
    "off": {"vc", "vn", "vt", "fc", "mp"},
    "stl": {"fc"},
    "xyz": {"vn"},
    "3ds": {"fc", "wt"},
    "3mf": set(),
    "ctm": {"vc", "vq"},
    "dae": {"vc", "vn", "wt"},
    "dxf": set(),
    "e57": {"vc", "vq", "vn"},
    "idtf": {"vc", "fc", "wt"},
    "json": {"vc", "vn", "vt"},
    "wrl": {"vc", "wt"},
    "x3d": {"vc", "vn", "vt", "fc", "fn", "wt"},
}
RADII = (
    "ply\nformat ascii 1.0\nelement vertex 8\nproperty double x\nproperty double y\n"
    "property double z\nproperty double radius\nelement face 6\n"
    "property list uchar int vertex_indices\nend_header\n"
)
QUADS = ("0 2 3 1", "4 5 7 6", "0 1 5 4", "2 6 7 3", "0 4 6 2", "1 3 7 5")


@pytest.fixture(scope="module")
def full(tmp_path_factory):
    """A document with one box that has every attribute."""
    corners = [f"{z} {y} {x} {1 + x + 2 * y}" for x, y, z in itertools.product((0, 1), repeat=3)]
    path = tmp_path_factory.mktemp("box") / "box.ply"
    faces = "".join(f"4 {corners}\n" for corners in QUADS)
    path.write_text(RADII + "\n".join(corners) + "\n" + faces)
    mesh_set = load(path)
    mesh_set.compute_color_by_function_per_vertex(x="x*100+9", y="y*80+20", z="z*200+5")
    mesh_set.compute_color_by_function_per_face(r="x0*200+3", g="30", b="77")
    mesh_set.compute_scalar_by_function_per_vertex(q="x-0.25")
    mesh_set.compute_scalar_by_function_per_face(q="x0+0.125")
    mesh_set.compute_texcoord_parametrization_triangle_trivial_per_wedge(sidedim=0, textdim=64)
    mesh_set.compute_texmap_from_color(textname="colours.png")
    mesh_set.compute_texcoord_transfer_wedge_to_vertex()  # cuts along every edge
    mesh_set.meshing_merge_close_vertices()
    mesh_set.meshing_tri_to_quad_dominant()
    mesh_set.compute_selection_by_condition_per_vertex(condselect="x>0.3")
    return mesh_set


def written(mesh_set, folder, extension, flags):
    """Return the file of a layer with some flags."""
    place = folder / ("-".join(sorted(flags)) or "none")
    place.mkdir(exist_ok=True)
    path = place / f"box.{extension}"  # always that name: some formats hold it
    export_layer(mesh_set, 0, path, save_options(extension, flags))
    return path


def content(path):
    """Return what is in a file apart from times and random numbers."""
    if path.suffix == ".dae":
        return re.sub(rb"<(created|modified)>.*?</", b"", path.read_bytes())
    if path.suffix == ".3mf":
        return re.sub(rb'UUID="[^"]*"', b"", zipfile.ZipFile(path).read("3D/3dmodel.model"))
    if path.suffix == ".3ds":  # some of its bytes are left to chance
        return path.read_bytes().count(b"Material")
    if path.suffix == ".e57":
        document = new_document()
        document.load_new_mesh(str(path))
        mesh = document.current_mesh()
        colours = mesh.vertex_color_matrix()[:, :3].any()  # black when there are none
        return colours, mesh.has_vertex_scalar(), mesh.vertex_normal_matrix().any()
    return path.read_bytes()


@pytest.mark.filterwarnings("ignore::meshlab_symrecon.errors.SymReconWarning")
@pytest.mark.parametrize("extension", SAVED)
def test_every_flag_is_in_the_file_or_not(full, tmp_path, extension):
    plain = content(written(full, tmp_path, extension, set()))
    files = {flag: written(full, tmp_path, extension, {flag}) for flag in ATTRIBUTES}
    assert {flag for flag, file in files.items() if content(file) != plain} == SHOWN[extension]


def header(path):
    text = path.read_bytes().partition(b"end_header")[0].decode()
    vertex, _, face = text.partition("element face")
    return re.findall(r"property .*?(\w+)\n", vertex), re.findall(r"property .*?(\w+)\n", face)


PLY = {
    "vc": (["red", "green", "blue", "alpha"], []),
    "vf": (["flags"], []),
    "vq": (["quality"], []),
    "vn": (["nx", "ny", "nz"], []),
    "vt": (["texture_u", "texture_v"], []),
    "vr": (["radius"], []),
    "fc": ([], ["red", "green", "blue", "alpha"]),
    "ff": ([], ["flags"]),
    "fq": ([], ["quality"]),
    "fn": ([], []),
    "wc": ([], []),
    "wn": ([], []),
    "wt": ([], ["texcoord"]),
    "mp": ([], []),
}


@pytest.mark.parametrize("flag", PLY)
def test_ply_has_coordinates_faces_and_the_flag_alone(full, tmp_path, flag):
    path = written(full, tmp_path, "ply", {flag})
    vertex, face = header(path)
    extra_vertex, extra_face = PLY[flag]
    assert vertex == ["x", "y", "z", *extra_vertex]
    assert face == ["vertex_indices", *extra_face]


READ_BACK = {
    ("ply", "vc"): "vertex_color_matrix",
    ("ply", "vq"): "vertex_scalar_array",
    ("ply", "vn"): "vertex_normal_matrix",
    ("ply", "fc"): "face_color_matrix",
    ("ply", "fq"): "face_scalar_array",
    ("ply", "wt"): "wedge_tex_coord_matrix",
    ("obj", "vc"): "vertex_color_matrix",
    ("obj", "vn"): "vertex_normal_matrix",
    ("obj", "wt"): "wedge_tex_coord_matrix",
    ("off", "vc"): "vertex_color_matrix",
    ("wrl", "vc"): "vertex_color_matrix",
    ("stl", "fc"): "face_color_matrix",
    ("dae", "wt"): "wedge_tex_coord_matrix",
}
HAS = {
    "vertex_color_matrix": "has_vertex_color",
    "vertex_scalar_array": "has_vertex_scalar",
    "face_color_matrix": "has_face_color",
    "face_scalar_array": "has_face_scalar",
    "wedge_tex_coord_matrix": "has_wedge_tex_coord",
}


@pytest.mark.filterwarnings("ignore:.* MeshLab does not read textures")
@pytest.mark.parametrize(("extension", "flag"), READ_BACK)
def test_what_was_asked_for_comes_back_and_nothing_else(full, tmp_path, extension, flag):
    method = READ_BACK[extension, flag]
    document = load(written(full, tmp_path, extension, {flag}))
    mesh = document.current_mesh()
    source = full.mesh(0)
    steps = {"ply": 1e6, "stl": 31}.get(extension, 255)  # five bits a channel in STL
    if extension != "stl":  # welds vertices
        assert mesh.vertex_number() == source.vertex_number()
    values, expected = getattr(mesh, method)(), getattr(source, method)()
    assert values.shape == expected.shape
    if flag == "vn":
        values, expected = (rows / np.linalg.norm(rows, axis=1)[:, None]
                            for rows in (values, expected))  # fmt: skip
    np.testing.assert_allclose(values, expected, atol=1.001 / steps)
    for other, has in HAS.items():
        materials = extension == "obj" and flag == "wt" and has == "has_face_color"
        assert getattr(mesh, has)() == (other == method or materials), has


def test_text_or_bytes(full, tmp_path):
    for extension, start in (("ply", b"format ascii"), ("stl", b"facet normal")):
        path = written(full, tmp_path, extension, {"sa"})
        assert start in path.read_bytes()
        path = written(full, tmp_path, extension, set())
        assert start not in path.read_bytes()
    assert "binary" not in save_options("obj", {"sa"})


def test_without_mp_polygons_become_triangles(full, tmp_path):
    for flags, corners in ((set(), 3), ({"mp"}, 4)):
        path = written(full, tmp_path, "obj", flags)
        faces = re.findall(r"^f (.*)$", path.read_text(), re.MULTILINE)
        assert {len(face.split()) for face in faces} == {corners}


def test_texture_coordinates_come_before_polygons_in_obj(full, tmp_path):
    path = written(full, tmp_path, "obj", {"wt", "mp"})
    assert passed_over("obj", {"wt", "mp"}) == ("mp",)
    assert "map_Kd colours.png" in path.with_name("box.obj.mtl").read_text()
    document = load(path)
    mesh = document.current_mesh()
    assert mesh.has_wedge_tex_coord()
    assert list(mesh.textures()) == ["colours.png"]


@pytest.mark.parametrize("extension", SAVED)
def test_what_a_format_cannot_take_is_named(extension):
    every = passed_over(extension, FLAGS)
    assert set(every) == set(FLAGS) - {
        *SAVED[extension], *(["sa"] if extension in ("ply", "stl") else [])
    } | ({"mp"} if extension == "obj" else set())  # fmt: skip
    assert list(every) == sorted(every)
    assert passed_over(extension, ()) == ()
    assert not any(value for name, value in save_options(extension, ()).items() if name != "binary")


def test_quality_that_stops_the_writer_of_e57_is_not_held(full, tmp_path):
    mesh_set = new_document()
    mesh_set.create_cube()
    for quality, held in (("x-0.25", True), ("x-2", False), ("x+1", False)):
        mesh_set.compute_scalar_by_function_per_vertex(q=quality)
        flags = held_flags("e57", mesh_set.mesh(0))
        assert ("vq" in flags) == held
        with pytest.warns(SymReconWarning, match="points only"):
            export_layer(mesh_set, 0, tmp_path / "a.e57", save_options("e57", flags))
    with pytest.raises(FileError, match="E57"), pytest.warns(SymReconWarning, match="points only"):
        export_layer(mesh_set, 0, tmp_path / "b.e57", save_options("e57", {"vq"}))
    assert not (tmp_path / "b.e57").exists()


def test_held_flags_are_those_of_the_layer(full):
    ply = {"vc", "vf", "vq", "vn", "vt", "vr", "fc", "ff", "fq", "wc", "wn", "wt"}
    assert held_flags("ply", full.mesh(0)) == ply
    bare = new_document()
    bare.create_cube()
    assert held_flags("ply", bare.mesh(0)) == {"vf", "vn", "vr", "ff", "wc", "wn"}
    assert held_flags("obj", bare.mesh(0)) == {"vn", "wn", "mp"}
    assert held_flags("obj", full.mesh(0)) == {"vc", "vn", "vt", "fc", "wn", "wt"}


def test_the_table_has_every_format_that_pymeshlab_writes_here(full, tmp_path):
    """Left out: U3D, which only leaves a file for TeX; NXS and NXZ, which read freed memory."""
    tried = (
        "ply obj off stl xyz 3ds 3mf ctm dae dxf e57 idtf json wrl x3d u3d glb gltf gts "
        "vmi bre qobj pts asc apts ptx fbx txt pdb vrml x3dv tri es"
    )
    able = set()
    for extension in tried.split():
        path = tmp_path / f"a.{extension}"
        try:
            full.save_current_mesh(str(path))
        except pymeshlab.PyMeshLabException:
            continue
        if path.exists():
            able.add(extension)
    assert able == set(SAVED)


def test_the_page_on_meshlabserver_has_this_table():
    page = Path(__file__).parents[2] / "docs" / "meshlabserver.md"
    told = {flag: set() for flag in FLAGS}
    for row in re.findall(r"^\| (`\w\w`[^|]*)\|[^|]*\|([^|:]*)", page.read_text(), re.MULTILINE):
        for flag in re.findall(r"`(\w\w)`", row[0]):
            told[flag] |= set(row[1].split()) - {"none"}
    shown = {flag: {name for name in SHOWN if flag in SHOWN[name]} for flag in ATTRIBUTES}
    assert told == shown | {"sa": {"ply", "stl"}}
