"""Filters: declaration, checks before the run, and the layers they see."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from meshlab_symrecon.errors import GeometryError, ParameterError
from meshlab_symrecon.plugin import Citation, Layer


def test_a_filter_runs_on_the_current_layer_and_reports_progress(grow_filter, cloud, document):
    heard = []
    outcome = grow_filter.apply(document(cloud), {"factor": 3}, lambda *news: heard.append(news))
    np.testing.assert_array_equal(outcome.layers[0].points, 3.0 * cloud.points)
    assert outcome.measures == {"factor": 3.0}
    assert outcome.current == 0
    assert heard == [(0.5, "growing")]


def test_progress_may_be_left_out(grow_filter, cloud, document):
    assert grow_filter.apply(document(cloud), {}).measures == {"factor": 2.0}


def test_names_are_python_name_aliases_and_menu_name(grow_filter):
    assert grow_filter.names == ("generate_grown_points", "grow_points", "Grow Points")


def test_errors_of_parameters_name_the_filter(grow_filter):
    with pytest.raises(ParameterError, match=r"^generate_grown_points: unknown parameter 'facto'"):
        grow_filter.bind({"facto": 1.0})
    with pytest.raises(ParameterError, match=r"^generate_grown_points: parameter 'factor' must be"):
        grow_filter.bind({"factor": -1.0})


def test_the_check_across_parameters_runs(grow_filter):
    grow_filter.bind({"factor": 0.0})
    with pytest.raises(ParameterError, match=r"^generate_grown_points: a factor of 0 about"):
        grow_filter.bind({"factor": 0.0, "about": "centre"})


@pytest.mark.parametrize("name", ["GrowPoints", "grow points", "2grow", "grow-points", ""])
@pytest.mark.parametrize("field", ["python_name", "aliases"])
def test_a_python_name_is_a_lower_case_identifier(grow_filter, field, name):
    with pytest.raises(ParameterError, match="must be a lower-case identifier"):
        replace(grow_filter, **{field: name if field == "python_name" else (name,)})


@pytest.mark.parametrize("name", ["", " Grow", "Grow ", "Grow  Points", "Grow\nPoints"])
def test_a_menu_name_has_single_spaces(grow_filter, name):
    with pytest.raises(ParameterError, match="a menu name must be words with single spaces"):
        replace(grow_filter, menu_name=name)


def test_requirements_come_from_a_list(grow_filter):
    with pytest.raises(ParameterError, match=r"requires must be of .*; got \['hair'\]"):
        replace(grow_filter, requires=("hair",))


PRESENT = {
    "points": {},
    "faces": {"faces": np.array([[0, 1, 0]])},
    "normals": {"normals": np.ones((2, 3))},
    "colours": {"colours": np.ones((2, 4))},
    "quality": {"quality": np.ones(2)},
}


@pytest.mark.parametrize("need", PRESENT)
def test_what_the_current_layer_lacks_is_named(grow_filter, cloud, document, need):
    needy = replace(grow_filter, requires=(need,))
    needy.apply(document(replace(cloud, **PRESENT[need])), {})
    bare = cloud if need != "points" else replace(cloud, points=np.zeros((0, 3)))
    with pytest.raises(GeometryError, match=f"'Grow Points' needs {need}; layer 'scan' has none"):
        needy.apply(document(bare), {})


def test_an_empty_document_is_refused(grow_filter, document):
    with pytest.raises(GeometryError, match="got an empty document"):
        grow_filter.apply(document(), {})


def test_a_filter_that_needs_nothing_runs_on_an_empty_document(grow_filter, document):
    from_nothing = replace(
        grow_filter, requires=(), run=lambda layers, parameters, progress: list(layers)
    )
    assert from_nothing.apply(document(), {}) == []


def test_layers_are_found_by_number(cloud, document):
    layers = document(cloud, replace(cloud, label="planes", identifier=7))
    assert layers.get(4) is cloud
    assert list(layers) == [4, 7]
    assert layers.current.label == "planes"


@pytest.mark.parametrize("known", ["4 'scan'", "none"])
def test_a_layer_that_is_not_there_is_refused(cloud, document, known):
    layers = document(*([] if known == "none" else [cloud]))
    with pytest.raises(
        ParameterError, match=rf"^no layer has the number 9; the document has {known}$"
    ):
        layers.get(9)


def test_the_newest_layer_of_a_label(cloud, document):
    names = {1: "planes", 2: "planes(1)", 3: "planes of mine", 5: "scan"}
    layers = document(*(replace(cloud, label=n, identifier=i) for i, n in names.items()))
    assert layers.newest("planes").identifier == 2
    assert layers.newest("scan").identifier == 5
    assert layers.newest("crust") is None


@pytest.mark.parametrize(
    "label", ["planes.ply", "Planes", " planes ", "planes(1).ply", "PLANES.PLY"]
)
def test_a_layer_of_a_label_from_a_file_or_written_by_hand(cloud, document, label):
    assert document(replace(cloud, label=label, identifier=4)).newest("planes").identifier == 4


@pytest.mark.parametrize("label", ["my planes", "planes of mine", "planes2", "planes.", ""])
def test_a_layer_of_another_label(cloud, document, label):
    assert document(replace(cloud, label=label, identifier=4)).newest("planes") is None


def test_a_layer_beside_the_current_one_is_the_named_or_the_newest(cloud, document):
    names = {1: "planes", 2: "planes(1)", 3: "mine", 5: "scan"}
    layers = document(*(replace(cloud, label=n, identifier=i) for i, n in names.items()))
    assert layers.beside_current(-1, "planes").identifier == 2
    assert layers.beside_current(1, "planes").identifier == 1
    assert layers.beside_current(3, "planes").identifier == 3
    assert layers.beside_current(-1, "crust") is None
    with pytest.raises(ParameterError, match="no layer has the number 9"):
        layers.beside_current(9, "planes")
    for named in (5, -1):
        with pytest.raises(GeometryError, match="got layer 5 'scan', which it reads beside"):
            layers.beside_current(named, "scan")


def test_a_required_selection_is_that_of_vertices_or_of_faces(cloud):
    first = np.array([True, False])
    assert np.array_equal(replace(cloud, selected=first).required_selection(), first)
    faces = np.array([[0, 0, 0], [1, 1, 1]])
    by_face = replace(cloud, faces=faces, face_selected=first)
    assert np.array_equal(by_face.required_selection(), first)
    for nothing in (None, np.zeros(2, dtype=bool)):
        with pytest.raises(GeometryError, match="onlyselected needs a selection; layer 'scan' has"):
            replace(cloud, selected=nothing).required_selection()


def test_citations_as_text():
    paper = Citation("A. Author", "On growth", "Journal", 2001, "10.1/2")
    assert str(paper) == "A. Author (2001). On growth. Journal. doi:10.1/2"
    assert str(replace(paper, identifier="")) == "A. Author (2001). On growth. Journal."


@pytest.mark.parametrize(
    ("selected", "face_selected", "expected"),
    [
        (None, None, None),
        ([0], None, [0]),
        (None, [1], [1, 2, 3]),
        (None, [0, 1], [0, 1, 2, 3]),
        ([4], [1], [4]),
    ],
)
def test_selected_vertices_count_or_else_the_corners_of_selected_faces(
    selected, face_selected, expected
):
    def flags(count, chosen):
        return None if chosen is None else np.isin(np.arange(count), chosen)

    faces = np.array([[0, 1, 2], [3, 2, 1]])
    layer = Layer(
        np.zeros((5, 3)), faces, selected=flags(5, selected), face_selected=flags(2, face_selected)
    )
    found = layer.selection
    assert (None if found is None else np.flatnonzero(found).tolist()) == expected
