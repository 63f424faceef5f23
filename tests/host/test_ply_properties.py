"""Properties of PLY files that MeshLab drops: read in every form of the file, and written again."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pymeshlab
import pytest

from meshlab_symrecon.errors import SymReconWarning
from meshlab_symrecon.host.attributes import attributes_of
from meshlab_symrecon.host.files import load, new_document, save_current
from meshlab_symrecon.host.meshset import read_layer
from meshlab_symrecon.host.ply_header import read_header
from meshlab_symrecon.host.ply_table import read_columns
from meshlab_symrecon.host.ply_writing import extend_ply

FORMS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
CODES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4",
    "float": "f4", "double": "f8", "int8": "i1", "uint16": "u2", "float64": "f8",
}  # fmt: skip
COUNT = 7


def write(path: Path, form: str, *elements: tuple[str, dict[str, list]]) -> Path:
    """Write a PLY; an element's columns are numbers or lists, by declaration."""
    order = FORMS[form]
    lines = ["ply", f"format {form} 1.0"]
    body = b""
    for name, columns in elements:
        count = len(next(iter(columns.values())))
        lines += [f"element {name} {count}", *(f"property {item}" for item in columns)]
        for number in range(count):
            words = []
            for item, values in columns.items():
                kinds = item.split()[:-1]
                value = values[number]
                parts = [(kinds[-1], list(np.atleast_1d(value)))]
                if kinds[0] == "list":
                    parts = [(kinds[1], [len(value)]), (kinds[2], value)]
                for kind, numbers in parts:
                    if order:
                        body += np.array(numbers, dtype=order + CODES[kind]).tobytes()
                    words += [repr(np.dtype(CODES[kind]).type(n).item()) for n in numbers]
            body += b"" if order else (" ".join(words) + "\n").encode()
    path.write_bytes(("\n".join([*lines, "end_header"]) + "\n").encode() + body)
    return path


def corners(count: int = COUNT) -> dict[str, list]:
    points = np.random.default_rng(0).normal(size=(count, 3)).astype(np.float32)
    return {f"float {axis}": points[:, i].tolist() for i, axis in enumerate("xyz")}


def scalar(mesh_set, name: str) -> list:
    return mesh_set.current_mesh().vertex_custom_scalar_attribute_array(name).tolist()


@pytest.mark.parametrize("kind", CODES)
@pytest.mark.parametrize("form", FORMS)
def test_numbers_of_every_type_in_every_form(tmp_path, form, kind):
    numbers = [3, 0, 1, 100, 127, 5, 2]
    columns = {f"{kind} Part_of": numbers, **corners()}
    mesh_set = load(write(tmp_path / "a.ply", form, ("vertex", columns)))
    assert scalar(mesh_set, "Part_of") == numbers
    save_current(mesh_set, tmp_path / "b.ply")
    assert scalar(load(tmp_path / "b.ply"), "Part_of") == numbers


@pytest.mark.parametrize("form", FORMS)
def test_faces_of_many_corners_and_lists_of_many_lengths(tmp_path, form):
    """A number of a polygon goes to each of its triangles; lists of three become points."""
    rings = [[0, 1, 2, 3], [3, 4, 5], [2, 3, 4, 5, 6], [0, 4, 6]]
    columns = {
        "list uchar int vertex_indices": rings,
        "short part": [7, 8, -9, 10],
        "list uchar double axis": [[i, 0.5, -i] for i in range(4)],
    }
    elements = (
        ("vertex", {**corners(), "list uchar float way": [[1, i, 2] for i in range(COUNT)]}),
    )
    mesh_set = load(write(tmp_path / "a.ply", form, *elements, ("face", columns)))
    mesh = mesh_set.current_mesh()
    owners = [0, 0, 1, 2, 2, 2, 3]
    for triangle, owner in zip(mesh.face_matrix().tolist(), owners, strict=True):
        assert set(triangle) <= set(rings[owner])
    parts = mesh.face_custom_scalar_attribute_array("part")
    assert parts.tolist() == [columns["short part"][owner] for owner in owners]
    axes = mesh.face_custom_point_attribute_matrix("axis")
    assert axes.tolist() == [[owner, 0.5, -owner] for owner in owners]
    ways = mesh.vertex_custom_point_attribute_matrix("way")
    assert ways.tolist() == [[1, i, 2] for i in range(COUNT)]


@pytest.mark.parametrize("form", FORMS)
def test_what_follows_elements_of_other_kinds_is_found(tmp_path, form):
    camera = ("camera", {"float view": [1.0], "list uchar int seen": [[1, 2]]})
    odd = ("odd", {"list uchar short of": [[1], [2, 3], [4]]})  # MeshLab fails on empty ones
    columns = {**corners(), "double height": list(np.arange(COUNT) / 7)}
    path = write(tmp_path / "a.ply", form, camera, odd, ("vertex", columns))
    with pytest.warns(SymReconWarning, match="MeshLab does not read camera, odd; they were left"):
        mesh_set = load(path)
    assert scalar(mesh_set, "height") == columns["double height"]


def test_points_and_faces_that_meshlab_drops_take_their_numbers_along(tmp_path):
    columns = corners()
    columns["float y"][2] = float("nan")
    columns["int id"] = list(range(10, 10 + COUNT))
    faces = {
        "list uchar int vertex_indices": [[0, 1, 3], [1, 2, 3], [4, 4, 5], [4, 5, 6]],
        "int part": [1, 2, 3, 4],
    }
    path = write(tmp_path / "a.ply", "binary_big_endian", ("vertex", columns), ("face", faces))
    with pytest.warns(SymReconWarning, match="1 of 7 points have coordinates"):
        mesh_set = load(path)
    assert scalar(mesh_set, "id") == [10, 11, 13, 14, 15, 16]
    mesh = mesh_set.current_mesh()
    assert mesh.face_number() == 2
    assert mesh.face_custom_scalar_attribute_array("part").tolist() == [1, 4]


@pytest.mark.parametrize("kind", ["float", "double", "uchar", "int"])
def test_a_confidence_is_the_quality(tmp_path, kind):
    """MeshLab takes the bytes of a float confidence for a double."""
    numbers = [3, 0, 1, 100, 127, 5, 2]
    columns = {**corners(), f"{kind} confidence": numbers}
    mesh_set = load(write(tmp_path / "a.ply", "ascii", ("vertex", columns)))
    assert mesh_set.current_mesh().vertex_scalar_array().tolist() == numbers
    assert scalar(mesh_set, "confidence") == numbers


@pytest.mark.parametrize("kind", ["float", "uchar"])
def test_a_quality_wins_over_a_confidence(tmp_path, kind):
    numbers = [3, 0, 1, 100, 127, 5, 2]
    columns = {**corners(), "float confidence": [9.0] * COUNT, f"{kind} quality": numbers}
    mesh_set = load(write(tmp_path / "a.ply", "ascii", ("vertex", columns)))
    assert mesh_set.current_mesh().vertex_scalar_array().tolist() == numbers
    save_current(mesh_set, tmp_path / "b.ply")
    assert scalar(load(tmp_path / "b.ply"), "confidence") == [9.0] * COUNT


def test_what_cannot_be_kept_is_named(tmp_path):
    columns = {
        **corners(),
        "list uchar int pair": [[1, 2]] * COUNT,
        "int Part": [1] * COUNT,
        "int PART": [2] * COUNT,
    }
    path = write(tmp_path / "a.ply", "ascii", ("vertex", columns))
    with pytest.warns(SymReconWarning, match="pair, PART of each vertex cannot be kept"):
        mesh_set = load(path)
    assert scalar(mesh_set, "Part") == [1] * COUNT


def test_edges_keep_their_ends_only(tmp_path):
    edges = {"int vertex1": [0, 1], "int vertex2": [1, 2], "float width": [0.5, 0.5]}
    path = write(tmp_path / "a.ply", "ascii", ("vertex", corners()), ("edge", edges))
    with pytest.warns(SymReconWarning, match="MeshLab does not read edge width"):
        mesh_set = load(path)
    assert mesh_set.current_mesh().edge_matrix().tolist() == [[0, 1], [1, 2]]


def test_a_file_that_meshlab_reads_otherwise_loses_its_numbers_with_a_warning(
    tmp_path, monkeypatch
):
    columns = {**corners(), "int id": list(range(COUNT))}
    path = write(tmp_path / "a.ply", "ascii", ("vertex", columns))
    shifted = write(tmp_path / "b.ply", "ascii", ("vertex", {**columns, "float x": [0.0] * COUNT}))
    monkeypatch.setattr(
        "meshlab_symrecon.host.ply_properties.read_columns",
        lambda _, header, name, wanted: read_columns(shifted, header, name, wanted),
    )
    with pytest.warns(SymReconWarning, match="id were left out: MeshLab read other points"):
        mesh_set = load(path)
    assert attributes_of(mesh_set, 0) == ()


def test_faces_that_meshlab_reads_otherwise(tmp_path, monkeypatch):
    faces = {"list uchar int vertex_indices": [[0, 1, 2]], "int part": [1]}
    path = write(tmp_path / "a.ply", "ascii", ("vertex", corners()), ("face", faces))
    faces["list uchar int vertex_indices"] = [[0, 1, 3]]
    other = write(tmp_path / "b.ply", "ascii", ("vertex", corners()), ("face", faces))
    monkeypatch.setattr(
        "meshlab_symrecon.host.ply_properties.read_columns",
        lambda _, header, name, wanted: read_columns(other, header, name, wanted),
    )
    with pytest.warns(SymReconWarning, match="part were left out: MeshLab read other faces"):
        load(path)


@pytest.mark.parametrize("form", FORMS)
def test_a_cut_file_is_an_error_of_the_reader(tmp_path, form):
    odd = ("odd", {"list uchar double of": [[1.0], [2.0, 3.0], []]})
    path = write(tmp_path / "a.ply", form, odd)
    header = read_header(path)
    whole = path.read_bytes()
    assert read_columns(path, header, "odd", ["of"])["of"].values.tolist() == [1.0, 2.0, 3.0]
    assert read_columns(path, header, "none", ["of"]) == {}
    for length in (header.start + 1, len(whole) - 6):
        path.write_bytes(whole[:length])
        with pytest.raises(ValueError, match="it ends too early"):
            read_columns(path, header, "odd", ["of"])


def test_a_word_among_the_numbers_is_an_error_of_the_reader(tmp_path):
    path = write(tmp_path / "a.ply", "ascii", ("vertex", corners()))
    path.write_text(path.read_text() + "word\n")
    with pytest.raises(ValueError, match="a word among its numbers"):
        read_columns(path, read_header(path), "vertex", ["x"])


def test_only_files_of_even_lists_are_extended(tmp_path):
    odd = ("odd", {"list uchar double of": [[1.0], [2.0, 3.0], []]})
    path = write(tmp_path / "a.ply", "binary_little_endian", odd)
    before = path.read_bytes()
    with pytest.raises(ValueError, match="the element 'odd' in lists or not whole"):
        extend_ply(path, edges=np.array([[0, 1]]))
    assert path.read_bytes() == before


@pytest.mark.parametrize("name", ["height", "Height", "HEIGHT", "heightOfIt", "a b", "Class", "if"])
def test_names_that_pymeshlab_does_not_tell_are_found_and_written(tmp_path, name):
    """Also those of a mesh that had them before it was added, which crash pymeshlab's exporter."""
    mesh = pymeshlab.Mesh(np.eye(3), np.array([[0, 1, 2]]))
    mesh.add_vertex_custom_scalar_attribute(np.arange(3.0), name)
    mesh_set = new_document()
    mesh_set.add_mesh(mesh, "solid")
    mesh_set.current_mesh().add_face_custom_scalar_attribute(np.array([0.1]), name)
    save_current(mesh_set, tmp_path / "a.ply")
    written = name.replace(" ", "_")
    back = load(tmp_path / "a.ply")
    assert scalar(back, written) == [0.0, 1.0, 2.0]
    assert back.current_mesh().face_custom_scalar_attribute_array(written).tolist() == [0.1]
    assert read_layer(back, 0).attributes[written].tolist() == [0.0, 1.0, 2.0]


def test_a_name_that_nothing_finds_is_told(tmp_path):
    mesh_set = new_document()
    mesh_set.create_cube()
    count = mesh_set.current_mesh().vertex_number()
    name = "Ω(distance) Of a VERY long name"
    mesh_set.current_mesh().add_vertex_custom_scalar_attribute(np.ones(count), name)
    with pytest.warns(SymReconWarning, match="cannot keep custom attributes"):
        save_current(mesh_set, tmp_path / "a.ply")


def test_a_name_that_the_file_uses_for_something_else_is_told(tmp_path):
    mesh_set = new_document()
    mesh_set.create_cube()
    count = mesh_set.current_mesh().vertex_number()
    mesh_set.current_mesh().add_vertex_custom_scalar_attribute(np.ones(count), "nx")
    with pytest.warns(SymReconWarning, match=r"custom attributes \(nx\) were left out: a PLY file"):
        save_current(mesh_set, tmp_path / "a.ply")


def test_saving_twice_gives_the_same_file(tmp_path):
    columns = {**corners(), "double Height": list(np.arange(COUNT) / 7), "int id": [1] * COUNT}
    edges = {"int vertex1": [0, 1], "int vertex2": [1, 2]}
    write(tmp_path / "0.ply", "ascii", ("vertex", columns), ("edge", edges))
    for number in range(3):
        save_current(load(tmp_path / f"{number}.ply"), tmp_path / f"{number + 1}.ply")
    contents = [(tmp_path / f"{number}.ply").read_bytes() for number in range(1, 4)]
    assert all(first == second for first, second in pairwise(contents))
