"""Simplify Points (AP) on documents of pymeshlab."""

from __future__ import annotations

import numpy as np
import pymeshlab
import pytest
import shapes

import meshlab_symrecon
from meshlab_symrecon.clustering import simplification
from meshlab_symrecon.clustering.messages import Schedule
from meshlab_symrecon.clustering.simplification import simplify
from meshlab_symrecon.errors import GeometryError, ParameterError, SymReconWarning
from meshlab_symrecon.filters.simplified_points import FILTER, LABEL, UNSETTLED
from meshlab_symrecon.host.meshset import read_layer
from meshlab_symrecon.plugin import Layer, Layers

STATUE = shapes.statue(2000, seed=4)
NO_FACES = np.zeros((0, 3), dtype=np.int64)
RNG = np.random.default_rng(0)
NORMALS = STATUE / np.linalg.norm(STATUE, axis=1, keepdims=True)
COLOURS = np.round(RNG.random((len(STATUE), 4)) * 255) / 255
QUALITY = RNG.random(len(STATUE))
AGE = RNG.random(len(STATUE))


def mesh_set() -> pymeshlab.MeshSet:
    scan = pymeshlab.Mesh(
        STATUE,
        v_normals_matrix=NORMALS,
        v_color_matrix=COLOURS + 0.5 / 255,
        v_scalar_array=QUALITY,
    )
    document = pymeshlab.MeshSet()
    document.add_mesh(scan, "scan")
    document.current_mesh().add_vertex_custom_scalar_attribute(AGE, "age")
    return document


def apply(document: pymeshlab.MeshSet, **values: object) -> dict[str, object]:
    return meshlab_symrecon.apply_filter(document, "generate_simplified_points", **values)


def layer(**values: object) -> Layers:
    scan = Layer(STATUE, NO_FACES, label="scan", identifier=0, **values)
    return Layers({0: "scan"}, 0, lambda _: scan)


def test_the_points_are_those_of_the_scan_with_all_that_they_have():
    document = mesh_set()
    measures = apply(document, count=150)
    made = read_layer(document, document.current_mesh_id())
    assert made.label == LABEL
    assert measures["points"] == len(made.points) == 150
    rows = simplify(STATUE, count=150).chosen
    assert np.array_equal(made.points, STATUE[rows])
    assert np.array_equal(made.normals, NORMALS[rows])
    np.testing.assert_allclose(made.colours, COLOURS[rows], atol=1e-9)
    assert np.array_equal(made.quality, QUALITY[rows])
    assert np.array_equal(made.attributes["age"], AGE[rows])
    before = read_layer(document, 0)
    assert np.array_equal(before.points, STATUE)


def test_the_measures_say_how_far_points_are_from_their_exemplars():
    made = FILTER.apply(layer(), {"count": 150})
    gaps = np.linalg.norm(STATUE[:, None] - made.layers[0].points[None], axis=2).min(axis=1)
    assert made.measures["mean_distance"] == pytest.approx(gaps.mean())
    assert made.measures["largest_distance"] == pytest.approx(gaps.max())
    assert made.measures["converged"] is True
    assert made.measures["preference"] < 0.0


def test_a_percentage_and_a_preference_say_how_many():
    assert len(FILTER.apply(layer(), {}).layers[0].points) == 200
    assert len(FILTER.apply(layer(), {"percentage": 25.0}).layers[0].points) == 500
    assert len(FILTER.apply(layer(), {"percentage": 1e-9}).layers[0].points) == 1
    assert np.array_equal(FILTER.apply(layer(), {"percentage": 100.0}).layers[0].points, STATUE)
    found = FILTER.apply(layer(), {"preference": -16.0})
    assert found.measures["preference"] == -16.0
    rows = simplify(STATUE, preference=-16.0).chosen
    assert np.array_equal(found.layers[0].points, STATUE[rows])


def test_only_selected_points_are_simplified_when_asked():
    left = STATUE[:, 0] < 0.0
    made = FILTER.apply(layer(selected=left), {"onlyselected": True, "count": 80}).layers[0]
    assert np.array_equal(made.points[made.points[:, 0] >= 0.0], STATUE[~left])
    assert np.count_nonzero(made.points[:, 0] < 0.0) == 80
    kept = simplify(STATUE[left], count=80).chosen
    assert np.array_equal(made.points[made.points[:, 0] < 0.0], STATUE[left][kept])
    for nothing in (None, np.zeros(len(STATUE), dtype=bool)):
        with pytest.raises(GeometryError, match="onlyselected needs a selection; layer 'scan'"):
            FILTER.apply(layer(selected=nothing), {"onlyselected": True})


def test_a_selection_in_the_document_counts():
    document = mesh_set()
    document.compute_selection_by_condition_per_vertex(condselect="x > 0")
    apply(document, onlyselected=True, percentage=10.0)
    made = read_layer(document, document.current_mesh_id()).points
    right = STATUE[:, 0] > 0.0
    assert np.count_nonzero(made[:, 0] > 0.0) == round(np.count_nonzero(right) / 10)
    assert np.count_nonzero(made[:, 0] <= 0.0) == np.count_nonzero(~right)


def test_more_points_than_there_are_leave_all_with_a_warning():
    document = mesh_set()
    with pytest.warns(SymReconWarning, match="9999 points were asked for, but there are only 2000"):
        assert apply(document, count=9999)["points"] == len(STATUE)
    assert np.array_equal(document.current_mesh().vertex_matrix(), STATUE)


def test_messages_that_had_not_settled_are_told_and_others_not(monkeypatch):
    settled = FILTER.apply(layer(), {"count": 600})
    assert (settled.measures["converged"], settled.warnings) == (True, ())
    monkeypatch.setattr(simplification, "THOROUGH", Schedule(0.8, 5, 10))
    stopped = FILTER.apply(layer(), {"count": 600})
    assert (stopped.measures["converged"], stopped.warnings) == (False, (UNSETTLED,))
    assert stopped.measures["points"] == 600


def test_two_answers_to_one_question_are_refused():
    with pytest.raises(ParameterError, match="got count=5 and preference=-2; leave one at 0"):
        FILTER.bind({"count": 5, "preference": -2.0})
    with pytest.raises(ParameterError, match="nothing says how many points to keep"):
        FILTER.bind({"percentage": 0.0})
    FILTER.bind({"percentage": 0.0, "count": 5})


def test_the_alias_is_a_method_and_the_step_is_in_the_history(tmp_path):
    meshlab_symrecon.load_plugins()
    try:
        document = mesh_set()
        assert document.simplify_points(count=40)["points"] == 40
        document.save_filter_script(str(tmp_path / "a.mlx"))
        assert "Simplify Points (AP)" in (tmp_path / "a.mlx").read_text(encoding="utf-8")
        again = mesh_set()
        meshlab_symrecon.apply_filter_script(again, str(tmp_path / "a.mlx"))
        assert np.array_equal(
            again.current_mesh().vertex_matrix(), document.current_mesh().vertex_matrix()
        )
    finally:
        meshlab_symrecon.unload_plugins()
