"""What survives: every cell of the tables in docs/survival.md, observed on a file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import survival_inputs as inputs
from survival import ROWS, WAYS, observe

from meshlab_symrecon.host import inspection
from meshlab_symrecon.host.files import load, new_document
from meshlab_symrecon.host.registration import apply_filter
from meshlab_symrecon.plugin.registry import installed_filters

FILTERS = [item.python_name for item in installed_filters()]

PAGE = Path(__file__).parents[2] / "docs" / "survival.md"


def tables() -> dict[tuple[str, str], str]:
    """Return the word in each cell of the page, by row and way."""
    cells: dict[tuple[str, str], str] = {}
    ways: list[str] = []
    for line in PAGE.read_text(encoding="utf-8").splitlines():
        words = [word.strip() for word in line.strip("|").split("|")]
        if not line.startswith("|") or set(line) <= set("|-: "):
            continue
        if words[0] == "":
            ways = words[1:]
        else:
            cells |= {(words[0], way): word for way, word in zip(ways, words[1:], strict=True)}
    return cells


CELLS = tables()


def test_the_page_has_every_cell():
    assert set(CELLS) == {(row, way) for row in ROWS for way in WAYS}
    assert "lost" not in CELLS.values()


@pytest.mark.parametrize("way", WAYS)
def test_what_a_way_keeps(tmp_path, monkeypatch, way):
    """One test a column, since the cells of a column are quick and many."""
    monkeypatch.setattr(inspection, "try_in_child", lambda path: 0)  # these files are ours
    found = {}
    for number, row in enumerate(ROWS):
        folder = tmp_path / str(number)
        found[row] = observe(folder, row, WAYS[way])
    assert found == {row: CELLS[row, way] for row in ROWS}


def everything(mesh) -> dict[str, object]:
    """Return all that pymeshlab tells of a layer."""
    arrays = {
        name: getattr(mesh, name)().tolist()
        for name in (
            "vertex_matrix", "face_matrix", "edge_matrix", "vertex_normal_matrix",
            "vertex_color_matrix", "vertex_scalar_array", "face_color_matrix", "face_scalar_array",
            "wedge_tex_coord_matrix", "vertex_selection_array", "face_selection_array",
            "transform_matrix",
        )
    }  # fmt: skip
    attributes = {
        "Class": mesh.vertex_custom_scalar_attribute_array("Class").tolist(),
        "flow": mesh.vertex_custom_point_attribute_matrix("flow").tolist(),
        "part": mesh.face_custom_scalar_attribute_array("part").tolist(),
    }
    return arrays | attributes | {"textures": list(mesh.textures()), "label": mesh.label()}


def rich_document(folder: Path):
    """Return a symmetric mesh that has all at once, with a matrix."""
    shape = new_document()
    shape.create_sphere(subdiv=2)
    points = shape.current_mesh().vertex_matrix() * [1.0, 1.5, 0.75]
    faces = shape.current_mesh().face_matrix().tolist()
    count, corners = len(points), len(faces)
    inputs.png(folder / inputs.IMAGE)
    vertex = {
        inputs.COLOURED: inputs.texts(count, "{b} 7 9 255"),
        "double quality": inputs.texts(count, "{q}"),
        "int flags": ["32"] * count,
        "uchar Class": [str(i % 7) for i in range(count)],
        "list uchar float flow": inputs.texts(count, "3 {i} 0 {f}"),
    }
    face = {
        "list uchar float texcoord": inputs.wedge_texts(corners),
        "int flags": ["32"] * corners,
        inputs.COLOURED: inputs.texts(corners, "{b} 7 9 255"),
        "double quality": inputs.texts(corners, "{f}"),
        "int part": inputs.texts(corners, "{i}"),
    }
    inputs.ply(folder / "in.ply", points, faces, vertex, face, [(0, 1)], inputs.IMAGE)
    mesh_set = load(folder / "in.ply")
    mesh_set.set_matrix(transformmatrix=np.diag([2.0, 2.0, 2.0, 1.0]), freeze=False)
    return mesh_set


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", FILTERS)
def test_our_filters_leave_the_layer_that_they_read_as_it_was(tmp_path, name):
    mesh_set = rich_document(tmp_path)
    apply_filter(mesh_set, "generate_reflection_planes")  # which two of them look for
    mesh_set.set_current_mesh(0)
    before = everything(mesh_set.mesh(0))
    assert before["edge_matrix"] == [[0, 1]]
    apply_filter(mesh_set, name)
    after = everything(mesh_set.mesh(0))
    changed = {what for what in before if before[what] != after[what]}
    assert changed == ({"vertex_scalar_array"} if name.startswith("compute_scalar") else set())
