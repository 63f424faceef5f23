"""What becomes of an attribute on its way from a file to a file: observed, in one word."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pymeshlab
from survival_inputs import PLY_INPUTS, WRITERS, write_input

from meshlab_symrecon.errors import FileError
from meshlab_symrecon.host.files import load, new_document, save_current
from meshlab_symrecon.host.native_filters import apply_native
from meshlab_symrecon.host.projects import save_project
from meshlab_symrecon.host.registration import apply_filter

ROWS = tuple(PLY_INPUTS)
MATRIX = np.array([[0.0, -2, 0, 1], [2, 0, 0, 3], [0, 0, 2, -1], [0, 0, 0, 1]])
WORDS = {
    "vertex normals of a cloud": "vertex normals",
    "white vertex colours": "vertex colours",
    "quality called confidence": "vertex quality",
    "images of textures": "textures",
    "names of missing images": "textures",
    "vertex selection": "the vertex selection",
    "face selection": "the face selection",
    "custom numbers of vertices": "custom attributes",
    "custom points of vertices": "custom attributes",
    "custom numbers of faces": "custom attributes",
    "custom points of faces": "custom attributes",
    "faces": "faces were left out",
}  # how warnings call a row
CLOUDS = ("vertex normals of a cloud", "edges")  # rows without faces
OF_FACES = ("wedge texture coordinates", "face colours", "face quality", "polygons")
WRITTEN = {
    "vertex normals of a cloud": (b"vn 0.0", b"vn 1.0"),
    "images of textures": (b"paint/stone.png",),
}  # what shows that the file holds it, where MeshLab does not read it back


@dataclass(frozen=True)
class Way:
    """From a file through a step to a file; by_place: vertices are known by where they are."""

    source: str
    target: str
    step: Callable[[pymeshlab.MeshSet], None] | None = None
    by_place: bool = True


def translate(mesh_set):
    apply_native(
        mesh_set,
        "compute_matrix_from_translation",
        {"traslmethod": 0, "axisx": 8.0, "freeze": True},
    )


def smooth(mesh_set):
    apply_native(mesh_set, "apply_coord_taubin_smoothing", {})


def remove_duplicates(mesh_set):
    apply_native(mesh_set, "meshing_remove_duplicate_vertices", {})


def find_planes(mesh_set):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # none are in this box
        apply_filter(mesh_set, "generate_reflection_planes")
    mesh_set.set_current_mesh(0)


WAYS = {
    **{f"ply → {target}": Way("ply", target) for target in (
        "ply", "obj", "off", "stl", "xyz", "3ds", "3mf", "dae", "e57", "wrl", "x3d", "dxf")},
    "obj → obj": Way("obj", "obj"),
    **{f"{source} → ply": Way(source, "ply") for source in (
        "obj", "off", "stl", "xyz", "3mf", "dae", "e57", "wrl", "x3d", "gltf", "ptx")},
    "ply → reflection planes → ply": Way("ply", "ply", find_planes),
    "ply → translate → ply": Way("ply", "ply", translate, by_place=False),
    "ply → smooth → ply": Way("ply", "ply", smooth, by_place=False),
    "ply → remove duplicates → ply": Way("ply", "ply", remove_duplicates),
    "ply → mlp": Way("ply", "mlp"),
}  # fmt: skip


def observe(folder: Path, row: str, way: Way) -> str:
    """Return kept, baked, warned, refused, lost, or n/a where a format cannot bring it in."""
    source = source_file(folder / "in", row, way.source)
    if source is None:
        return "n/a"
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        mesh_set = load(source)
    if row == "transform matrix":
        mesh_set.set_matrix(transformmatrix=MATRIX, freeze=False)
    before = value_of(mesh_set, row, way.by_place, source.parent)
    if before is None:
        return "n/a"
    inputs = {file: file.read_bytes() for file in source.parent.rglob("*") if file.is_file()}
    if not way.by_place and row in ("transform matrix", *CLOUDS):
        return "n/a"
    if way.step is not None:
        way.step(mesh_set)
        if value_of(mesh_set, row, way.by_place, source.parent) != before:
            return "by the step"
    word = saved(mesh_set, folder, row, way, before)
    if word == "lost" and any(WORDS.get(row, row) in str(one.message) for one in caught):
        word = "warned"
    assert {file: file.read_bytes() for file in inputs} == inputs
    return word


def source_file(folder: Path, row: str, extension: str) -> Path | None:
    if extension in WRITERS:
        return WRITERS[extension](folder, row)
    path = write_input(folder, row)
    if extension == "ply":
        return path
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            save_current(load(path), path.with_suffix(f".{extension}"))
    except FileError:
        return None
    path.unlink()
    return path.with_suffix(f".{extension}")


def saved(mesh_set, folder: Path, row: str, way: Way, before: object) -> str:
    out = folder / "out" / f"out.{way.target}"
    out.parent.mkdir()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            save_project(mesh_set, out) if way.target == "mlp" else save_current(mesh_set, out)
        except FileError:
            return "refused"
        said = [str(warning.message) for warning in caught]
    told = any(WORDS.get(row, row) in sentence for sentence in said)
    told |= row in OF_FACES and any("faces were left out" in sentence for sentence in said)
    if way.target == "dxf":  # which MeshLab does not read
        return "warned" if told else "written"
    word = compared(out, row, way, before)
    return "warned" if word == "lost" and told else word


def compared(out: Path, row: str, way: Way, before: object) -> str:
    """Return what became of a value in the file that was written."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        back = reloaded(out)
    after = value_of(back, row, way.by_place, out.parent)
    ways = {
        "kept": lambda: after == before,
        "to 1/255": lambda: "colours" in row and near(before, after, 1 / 255),
        "to 1/31": lambda: "colours" in row and near(before, after, 1 / 31),
        "written": lambda: (
            row in WRITTEN and all(word in out.read_bytes() for word in WRITTEN[row])
        ),
        "baked": lambda: row == "transform matrix" and world(back) == places(*before),
        "as wedges": lambda: (
            row == "vertex texture coordinates"
            and back.current_mesh().has_wedge_tex_coord()
            and wedges_of(back) == corners_of(before, back)
        ),
    }
    return next((word for word, is_so in ways.items() if is_so()), "lost")


def near(before: dict, after: object, step: float) -> bool:
    if not isinstance(after, dict) or before.keys() != after.keys():
        return False
    return all(np.abs(np.subtract(before[key], after[key])).max() < step + 1e-4 for key in before)


def reloaded(out: Path):
    if out.suffix != ".mlp":
        return load(out)
    mesh_set = new_document()
    mesh_set.load_project(str(out))
    load_again = mesh_set.current_mesh().transform_matrix()
    layer = load(next(out.parent.glob("*.ply")))
    layer.set_matrix(transformmatrix=load_again, freeze=False)
    return layer


def places(points: object, matrix: object) -> list:
    rows = np.array(points) @ np.array(matrix)[:3, :3].T + np.array(matrix)[:3, 3]
    return sorted(map(tuple, np.round(rows, 4).tolist()))


def world(mesh_set) -> list:
    mesh = mesh_set.current_mesh()
    assert np.array_equal(mesh.transform_matrix(), np.eye(4))
    return sorted(map(tuple, np.round(mesh.vertex_matrix(), 4).tolist()))


def names_of_vertices(mesh, by_place: bool) -> list:
    if not by_place:
        return list(range(mesh.vertex_number()))
    return list(map(tuple, np.round(mesh.vertex_matrix(), 4).tolist()))


def turned(corners: list) -> tuple:
    """Return a cycle from its least corner on; what is turned over stays different."""
    first = corners.index(min(corners))
    return tuple(corners[first:] + corners[:first])


def wedges_of(mesh_set) -> dict:
    mesh = mesh_set.current_mesh()
    names = names_of_vertices(mesh, True)
    faces = [turned([names[c] for c in face]) for face in mesh.face_matrix().tolist()]
    return wedges_by_name(faces, mesh, names)


def corners_of(by_vertex: dict, mesh_set) -> dict:
    return {corner: by_vertex[corner[1]] for corner in wedges_of(mesh_set)}


class Seen:
    """One layer, seen through the names of its vertices and faces; a method a row."""

    def __init__(self, mesh, by_place: bool, folder: Path) -> None:
        self.mesh, self.folder = mesh, folder
        self.names = names_of_vertices(mesh, by_place)
        self.faces = [turned([self.names[c] for c in face]) for face in mesh.face_matrix().tolist()]

    def of_vertices(self, there: bool, read: str):
        if not there:
            return None
        values = np.asarray(getattr(self.mesh, read)(), dtype=np.float64)
        return dict(zip(self.names, np.round(values, 5).tolist(), strict=True))

    def of_faces(self, there: bool, read: str):
        if not there or not self.faces:
            return None
        values = np.asarray(getattr(self.mesh, read)(), dtype=np.float64)
        return dict(zip(self.faces, np.round(values, 5).tolist(), strict=True))

    def custom(self, kind: str, form: str, *attributes: str):
        names = self.names if kind == "vertex" else self.faces
        try:
            read = [getattr(self.mesh, f"{kind}_custom_{form}")(name) for name in attributes]
        except pymeshlab.PyMeshLabException:
            return None
        return [dict(zip(names, values.tolist(), strict=True)) for values in read]

    def normals(self):
        normals = self.mesh.vertex_normal_matrix()
        there = np.abs(normals).max() > 0.5 and not self.faces
        return self.of_vertices(there, "vertex_normal_matrix")

    def colours(self):
        return self.of_vertices(self.mesh.has_vertex_color(), "vertex_color_matrix")

    def quality(self):
        return self.of_vertices(self.mesh.has_vertex_scalar(), "vertex_scalar_array")

    def vertex_texture(self):
        read = self.of_vertices(self.mesh.has_vertex_tex_coord(), "vertex_tex_coord_matrix")
        return read and {name: tuple(pair) for name, pair in read.items()}

    def wedges(self):
        if not self.mesh.has_wedge_tex_coord():
            return None
        return wedges_by_name(self.faces, self.mesh, self.names)

    def images(self):
        files = [self.folder / name for name in self.mesh.textures()]
        return [file.read_bytes() for file in files if file.is_file()] or None

    def missing(self):
        files = [
            file for file in self.folder.rglob("*") if file.is_file() and file.suffix != ".png"
        ]
        return any(b"gone.png" in file.read_bytes() for file in files) or None

    def face_colours(self):
        return self.of_faces(self.mesh.has_face_color(), "face_color_matrix")

    def face_quality(self):
        return self.of_faces(self.mesh.has_face_scalar(), "face_scalar_array")

    def selected(self):
        return self.of_vertices(self.mesh.selected_vertex_number() > 0, "vertex_selection_array")

    def faces_selected(self):
        return self.of_faces(self.mesh.selected_face_number() > 0, "face_selection_array")

    def polygons(self):
        rings = [turned([self.names[c] for c in ring]) for ring in self.mesh.polygonal_face_list()]
        return sorted(rings) if len(rings) < len(self.faces) else None

    def edges(self):
        ends = self.mesh.edge_matrix().tolist()
        return sorted(tuple(sorted(self.names[c] for c in edge)) for edge in ends) or None

    def matrix(self):
        matrix = self.mesh.transform_matrix()
        if np.array_equal(matrix, np.eye(4)):
            return None
        return self.mesh.vertex_matrix().tolist(), matrix.tolist()


READERS = {
    "faces": lambda seen: sorted(seen.faces) or None,
    "vertex normals of a cloud": Seen.normals,
    "vertex colours": Seen.colours,
    "white vertex colours": Seen.colours,
    "vertex quality": Seen.quality,
    "quality called confidence": Seen.quality,
    "vertex texture coordinates": Seen.vertex_texture,
    "wedge texture coordinates": Seen.wedges,
    "images of textures": Seen.images,
    "names of missing images": Seen.missing,
    "face colours": Seen.face_colours,
    "face quality": Seen.face_quality,
    "vertex selection": Seen.selected,
    "face selection": Seen.faces_selected,
    "polygons": Seen.polygons,
    "edges": Seen.edges,
    "custom numbers of vertices": lambda seen: seen.custom(
        "vertex", "scalar_attribute_array", "Class", "intensity"
    ),
    "custom points of vertices": lambda seen: seen.custom(
        "vertex", "point_attribute_matrix", "flow"
    ),
    "custom numbers of faces": lambda seen: seen.custom("face", "scalar_attribute_array", "part"),
    "custom points of faces": lambda seen: seen.custom("face", "point_attribute_matrix", "axis"),
    "transform matrix": Seen.matrix,
}


def value_of(mesh_set, row: str, by_place: bool, folder: Path) -> object:
    """Return what a layer has of a row, in a form that can be compared; None for nothing."""
    return READERS[row](Seen(mesh_set.current_mesh(), by_place, folder))


def wedges_by_name(faces: list, mesh, names: list) -> dict:
    rows = np.round(mesh.wedge_tex_coord_matrix(), 5).reshape(-1, 3, 2).tolist()
    return {
        (face, names[c]): tuple(uv)
        for face, corners, row in zip(faces, mesh.face_matrix().tolist(), rows, strict=True)
        for c, uv in zip(corners, row, strict=True)
    }
