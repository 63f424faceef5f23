"""Mirror Symmetry Deviation on documents: in place, honest, repeatable."""

from __future__ import annotations

import re
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab
import pytest
import shapes
from scipy.spatial import ConvexHull

from meshlab_symrecon import apply_filter
from meshlab_symrecon.errors import GeometryError, ParameterError, SymReconWarning
from meshlab_symrecon.geometry.bounds import box_diagonal
from meshlab_symrecon.geometry.plane_quads import PLANES_LABEL, planes_as_quads
from meshlab_symrecon.geometry.surfaces import face_normals
from meshlab_symrecon.host import registration
from meshlab_symrecon.host.history import read_history
from meshlab_symrecon.host.meshset import add_layer, read_layer
from meshlab_symrecon.host.script import run_script
from meshlab_symrecon.plugin import Layer
from meshlab_symrecon.symmetry.deviation import mirror_deviation

DEVIATION = "compute_scalar_by_mirror_symmetry_per_vertex"
MENU_NAME = "Mirror Symmetry Deviation"
NO_FACES = np.zeros((0, 3), dtype=np.int64)
X, Y = np.array([1.0, 0, 0, 0]), np.array([0, 1.0, 0, 0])
PAGE = Path(__file__).parents[1] / "docs" / "deviation.md"
SCRIPT = Path(__file__).parents[1] / "meshlab_scripts" / "deviation.mlx"

SPHERE = shapes.fibonacci_sphere(2000)
HULL = ConvexHull(SPHERE).simplices.astype(np.int64)
OUTWARD = np.einsum("ij,ij->i", face_normals(SPHERE, HULL), SPHERE[HULL[:, 0]]) > 0.0
FACES = np.where(OUTWARD[:, None], HULL, HULL[:, ::-1])
AWAY = ((SPHERE - np.array([0.8, 0.0, 0.6])) ** 2).sum(axis=1)
EAR = np.clip(1.0 - AWAY / 0.3, 0.0, None) ** 3 * 0.1
HEAD = SPHERE * [1.0, 1.2, 1.5] * (1.0 + EAR)[:, None]


def document(points=HEAD, faces=FACES, planes=X, label=PLANES_LABEL, **attributes):
    """A scan as layer 0, which is the current one, and planes as layer 1."""
    mesh_set = pymeshlab.MeshSet(verbose=False)
    add_layer(mesh_set, Layer(points, faces, "scan", **attributes), current=True)
    if planes is not None:
        corners, sheets = planes_as_quads(np.atleast_2d(planes), points)
        add_layer(mesh_set, Layer(corners, sheets, label), current=False)
    return mesh_set


def state(mesh):
    """Everything of a layer but its quality and custom attributes, as bytes."""
    arrays = (
        mesh.vertex_matrix(), mesh.vertex_normal_matrix(), mesh.vertex_color_matrix(),
        mesh.face_matrix(), mesh.transform_matrix(), mesh.vertex_selection_array(),
        mesh.face_selection_array(), mesh.edge_matrix(),
    )  # fmt: skip
    return [np.asarray(array).tobytes() for array in arrays] + [mesh.label(), mesh.id()]


@pytest.mark.parametrize("name", [DEVIATION, "mirror_symmetry_deviation", MENU_NAME])
def test_the_quality_of_the_current_layer_is_written_and_nothing_else(name):
    colours = np.random.default_rng(0).integers(0, 256, (len(HEAD), 4)) / 255.0
    mesh_set = document(colours=colours, quality=np.arange(2000.0))
    mesh_set.compute_selection_by_condition_per_vertex(condselect="z > 0.3")
    mesh_set.compute_selection_by_condition_per_face(condselect="fi < 50")
    before = state(mesh_set.mesh(0)), state(mesh_set.mesh(1))
    measures = apply_filter(mesh_set, name)
    assert (state(mesh_set.mesh(0)), state(mesh_set.mesh(1))) == before
    assert mesh_set.current_mesh_id() == 0
    assert len(mesh_set) == 2
    found = mirror_deviation(HEAD, X, FACES)
    layer = read_layer(mesh_set, 0)
    np.testing.assert_allclose(layer.quality, found.distances, atol=1e-12)
    assert np.array_equal(layer.attributes["mirror_deviation"], layer.quality)
    assert np.array_equal(layer.attributes["has_counterpart"], found.has_counterpart)
    assert set(layer.attributes) == {"mirror_deviation", "has_counterpart"}
    assert measures["median"] == pytest.approx(found.median)
    assert measures["percentile_95"] == pytest.approx(found.percentile_95)
    assert measures["rms"] == pytest.approx(found.rms)
    assert measures["within_tolerance"] == pytest.approx(found.share_within)
    assert measures["without_counterpart"] == 1.0 - found.has_counterpart.mean()
    assert measures["tolerance"] == pytest.approx(found.tolerance)
    assert measures["signed"] is True
    np.testing.assert_allclose(measures["plane"], X, atol=1e-12)


def test_distances_are_in_the_units_of_the_world():
    """A layer's matrix counts, and stays."""
    mesh_set, moved = document(), document(planes=None)
    motion = shapes.MOTIONS[-1]
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = motion.scale * motion.turn, motion.shift
    moved.set_matrix(transformmatrix=matrix, freeze=False)
    corners, sheets = planes_as_quads(motion.planes(X[None]), motion(HEAD))
    add_layer(moved, Layer(corners, sheets, PLANES_LABEL), current=False)
    apply_filter(mesh_set, DEVIATION)
    apply_filter(moved, DEVIATION)
    np.testing.assert_allclose(
        moved.mesh(0).vertex_scalar_array() / motion.scale,
        mesh_set.mesh(0).vertex_scalar_array(),
        atol=1e-9,
    )
    assert np.array_equal(moved.mesh(0).transform_matrix(), matrix)
    assert np.array_equal(moved.mesh(0).vertex_matrix(), HEAD)


def test_the_history_holds_the_step_once_and_replays_it(tmp_path):
    mesh_set = document(planes=np.stack([Y, X]))
    registration.load_plugins()
    try:
        mesh_set.compute_matrix_from_translation(axisx=0.0)
        assert mesh_set.mirror_symmetry_deviation(plane=1, tolerance=0.0123)["signed"]
        names = [step.menu_name for step in read_history(mesh_set)]
        assert names == ["Transform: Translate, Center, set Origin", MENU_NAME]
        expected = mesh_set.mesh(0).vertex_scalar_array()
        path = tmp_path / "steps.mlx"
        mesh_set.save_filter_script(str(path))
        again = document(planes=np.stack([Y, X]))
        again.load_filter_script(str(path))
        again.apply_filter_script()
    finally:
        registration.unload_plugins()
    assert again.mesh(0).vertex_scalar_array().tobytes() == expected.tobytes()
    by_runner = document(planes=np.stack([Y, X]))
    report = run_script(by_runner, path)
    assert [step.status for step in report.steps] == ["ran", "ran"]
    assert by_runner.mesh(0).vertex_scalar_array().tobytes() == expected.tobytes()


def test_a_second_run_overwrites_the_quality_and_keeps_both_attributes():
    mesh_set = document(planes=np.stack([X, Y]))
    apply_filter(mesh_set, DEVIATION)
    first = mesh_set.mesh(0).vertex_scalar_array()
    apply_filter(mesh_set, DEVIATION, plane=1)
    layer = read_layer(mesh_set, 0)
    assert np.array_equal(layer.attributes["mirror_deviation"], first)
    assert np.array_equal(layer.attributes["mirror_deviation_2"], layer.quality)
    assert "has_counterpart_2" in layer.attributes
    assert "has_counterpart_2" in PAGE.read_text(encoding="utf-8")
    assert "has_counterpart_2" in SCRIPT.read_text(encoding="utf-8")
    assert not np.array_equal(first, layer.quality)


def test_only_selected_vertices_are_measured_and_the_others_keep_their_quality():
    whole = document()
    apply_filter(whole, DEVIATION)
    everywhere = whole.mesh(0).vertex_scalar_array()
    mesh_set = document(quality=np.full(len(HEAD), 7.0))
    mesh_set.compute_selection_by_condition_per_vertex(condselect="y > 0.2")
    chosen = mesh_set.mesh(0).vertex_selection_array()
    measures = apply_filter(mesh_set, DEVIATION, onlyselected=True)
    quality = mesh_set.mesh(0).vertex_scalar_array()
    assert np.array_equal(quality[chosen], everywhere[chosen])
    assert (quality[~chosen] == 7.0).all()
    kept = read_layer(mesh_set, 0).attributes
    assert np.array_equal(kept["mirror_deviation"], np.where(chosen, everywhere, 0.0))
    assert np.array_equal(kept["has_counterpart"], chosen)
    assert np.array_equal(kept["mixed_quality"], quality)
    assert len(kept) == 3
    assert measures["without_counterpart"] == 0.0
    assert measures["median"] == np.median(np.abs(everywhere[chosen]))
    bare = document()
    bare.compute_selection_by_condition_per_face(condselect="fi < 30")
    apply_filter(bare, DEVIATION, onlyselected=True)
    layer, corners = read_layer(bare, 0), np.unique(FACES[:30])
    assert np.array_equal(np.flatnonzero(layer.attributes["has_counterpart"]), corners)
    assert set(layer.attributes) == {"mirror_deviation", "has_counterpart"}  # it had no quality
    assert np.array_equal(layer.attributes["mirror_deviation"], layer.quality)
    with pytest.raises(GeometryError, match="layer 'scan' has none; select what the"):
        apply_filter(document(), DEVIATION, onlyselected=True)


def test_the_newest_planes_and_the_first_of_them_are_the_mirror():
    mesh_set = document(planes=Y)
    corners, sheets = planes_as_quads(np.stack([X, Y]), HEAD)
    add_layer(mesh_set, Layer(corners, sheets, PLANES_LABEL), current=False)
    assert abs(apply_filter(mesh_set, DEVIATION)["plane"][0]) == pytest.approx(1.0)
    assert abs(apply_filter(mesh_set, DEVIATION, plane=1)["plane"][1]) == pytest.approx(1.0)
    assert abs(apply_filter(mesh_set, DEVIATION, planes=1)["plane"][1]) == pytest.approx(1.0)
    with pytest.raises(ParameterError, match="plane must be one of the 2 planes"):
        apply_filter(mesh_set, DEVIATION, plane=2)
    with pytest.raises(ParameterError, match="no layer has the number 9"):
        apply_filter(mesh_set, DEVIATION, planes=9)


def test_a_cloud_uses_its_normals_for_their_sides_only():
    crooked = HEAD + 0.3 * np.random.default_rng(0).normal(size=HEAD.shape)
    plain, hinted = document(faces=NO_FACES), document(faces=NO_FACES, normals=crooked)
    for mesh_set in (plain, hinted):
        apply_filter(mesh_set, DEVIATION)
    values = plain.mesh(0).vertex_scalar_array()
    np.testing.assert_allclose(hinted.mesh(0).vertex_scalar_array(), values, atol=1e-12)
    exact = mirror_deviation(HEAD, X, FACES).distances
    assert np.abs(values - exact).max() < 0.003 * box_diagonal(HEAD)


def test_what_cannot_be_measured_is_refused_and_nothing_is_written():
    cases = [
        (document(planes=None), f"this filter needs a layer '{PLANES_LABEL}'"),
        (document(planes=[1.0, 0, 0, -50.0]), "meets nothing that was measured"),
        (document(points=HEAD[:3], faces=NO_FACES), "needs at least"),
    ]
    bare = document(planes=None)
    add_layer(bare, Layer(HEAD[:4], NO_FACES, PLANES_LABEL), current=False)
    cases.append((bare, "has no faces; detect planes first"))
    own = document()
    own.set_current_mesh(1)
    cases.append((own, "got layer 1 'reflection planes', which"))
    for mesh_set, words in cases:
        current = mesh_set.current_mesh_id()
        before = state(mesh_set.mesh(current))
        with pytest.raises(GeometryError, match=words) as caught:
            apply_filter(mesh_set, DEVIATION)
        assert "\n" not in str(caught.value)
        assert state(mesh_set.mesh(current)) == before
        assert read_layer(mesh_set, current).quality is None
        assert read_history(mesh_set) == ()


def test_what_the_user_should_know_is_a_warning():
    flat = np.column_stack([SPHERE[:, :2], 0.05 * np.exp(-8.0 * AWAY)])
    with pytest.warns(SymReconWarning, match="no distance has a sign"):
        measures = apply_filter(document(flat, NO_FACES), DEVIATION)
    assert measures["signed"] is False
    mirrored = (HEAD[:, 0] > 0.0).astype(float)
    with pytest.warns(SymReconWarning, match=f"{int(mirrored.sum())} points of layer 'scan' are"):
        apply_filter(document(attributes={"mirrored": mirrored}), DEVIATION)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        apply_filter(document(attributes={"mirrored": 0.0 * mirrored}), DEVIATION)


def test_the_shipped_script_ends_in_colours_of_either_sign():
    points = shapes.statue(3000, seed=5, missing=0.1)
    mesh_set = document(points, NO_FACES, planes=None)
    report = run_script(mesh_set, SCRIPT)
    assert [step.status for step in report.steps] == ["ran"] * 5
    layer = read_layer(mesh_set, 0)
    assert np.array_equal(layer.points, points)
    most, least = np.argmax(layer.quality), np.argmin(layer.quality)
    assert layer.quality[least] < 0.0 < layer.quality[most]
    red, _, blue, _ = layer.colours.T
    assert (red[most], blue[most]) == (0.0, 1.0)
    assert (red[least], blue[least]) == (1.0, 0.0)
    unknown = layer.attributes["has_counterpart"] == 0.0
    assert 0 < np.count_nonzero(unknown) < len(points)
    assert (np.rint(255.0 * layer.colours[unknown, :3]) == 130.0).all()


def test_the_python_of_the_page_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code = re.search(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert code is not None
    small = PAGE.parents[1] / "examples/data/nefertiti_small.ply"
    Path("scan.ply").write_bytes(small.read_bytes())
    names: dict[str, Any] = {}
    try:
        exec(code[1], names)
    finally:
        registration.unload_plugins()
    assert 0.5 < names["measures"]["within_tolerance"] < 1.0
    saved = pymeshlab.MeshSet(verbose=False)
    saved.load_new_mesh("deviation.ply")
    quality = saved.current_mesh().vertex_scalar_array()
    assert np.array_equal(quality, names["ms"].mesh(0).vertex_scalar_array())
