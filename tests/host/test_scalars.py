"""Scalars written into a layer that is in the document: to the last bit, and nothing else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pymeshlab
import pytest

from meshlab_symrecon.errors import HostError, SymReconWarning
from meshlab_symrecon.host.history import read_history
from meshlab_symrecon.host.meshset import add_layer, current_identifier, read_layer
from meshlab_symrecon.host.scalars import write_scalars
from meshlab_symrecon.host.steps import apply_filter
from meshlab_symrecon.plugin import Layer, Outcome, VertexScalars

NO_FACES = np.zeros((0, 3), np.int64)
AWKWARD = np.array([0.0, -0.0, 5e-324, -1e308, np.inf, 0.1 + 0.2, np.pi, 1e-300] * 5)


def state(mesh_set, identifier=0):
    """Everything of a layer but its quality and custom attributes, as bytes."""
    mesh = mesh_set.mesh(identifier)
    arrays = [
        mesh.vertex_matrix(), mesh.vertex_normal_matrix(), mesh.vertex_color_matrix(),
        mesh.face_matrix(), mesh.transform_matrix(), mesh.vertex_selection_array(),
        mesh.face_selection_array(), mesh.edge_matrix(),
    ]  # fmt: skip
    if mesh.has_wedge_tex_coord():
        arrays += [mesh.wedge_tex_coord_matrix(), mesh.face_normal_matrix()]
    return [np.asarray(array).tobytes() for array in arrays] + [mesh.label(), mesh.id()]


def bits(values):
    return np.asarray(values).view(np.int64).tolist()


def scalars(values=AWKWARD, identifier=0, name="made_up", **attributes):
    return VertexScalars(identifier, values, name, attributes)


def test_every_bit_arrives_and_nothing_else_changes(cloud_set):
    cloud_set.compute_selection_by_condition_per_vertex(condselect="x > 0")
    cloud_set.set_matrix(transformmatrix=np.diag([2.0, 2, 2, 1]), freeze=False)
    before = state(cloud_set)
    write_scalars(cloud_set, scalars(mark=np.arange(40.0)))
    mesh = cloud_set.mesh(0)
    assert bits(mesh.vertex_scalar_array()) == bits(AWKWARD)
    assert bits(mesh.vertex_custom_scalar_attribute_array("made_up")) == bits(AWKWARD)
    assert np.array_equal(mesh.vertex_custom_scalar_attribute_array("mark"), np.arange(40.0))
    assert state(cloud_set) == before


def test_a_mesh_with_texture_loose_vertices_and_selected_faces(tmp_path):
    (tmp_path / "a.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 5 5 5\n"
        "vt 0 0\nvt 1 0\nvt .25 .75\nf 1/1 3/3 2/2\nf 1/1 2/2 4/3\n"
    )
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.load_new_mesh(str(tmp_path / "a.obj"))
    mesh_set.compute_selection_by_condition_per_face(condselect="fi == 1")
    before = state(mesh_set)
    values = AWKWARD[: mesh_set.current_mesh().vertex_number()]
    assert len(values) == 5
    write_scalars(mesh_set, scalars(values))
    assert bits(mesh_set.current_mesh().vertex_scalar_array()) == bits(values)
    assert state(mesh_set) == before


def test_deleted_vertices_are_gone_before_the_numbers_are_matched(cloud_set, points):
    cloud_set.compute_selection_by_condition_per_vertex(condselect="vi < 15")
    cloud_set.meshing_remove_selected_vertices()
    write_scalars(cloud_set, scalars(AWKWARD[:25]))
    assert np.array_equal(cloud_set.mesh(0).vertex_matrix(), points[15:])
    assert bits(cloud_set.mesh(0).vertex_scalar_array()) == bits(AWKWARD[:25])


def test_another_layer_than_the_current_one_can_be_written(cloud_set, points):
    second = add_layer(cloud_set, Layer(points[:8], NO_FACES, "second"), current=True)
    before = state(cloud_set), state(cloud_set, second)
    write_scalars(cloud_set, scalars())
    assert current_identifier(cloud_set) == second
    assert (state(cloud_set), state(cloud_set, second)) == before
    assert bits(cloud_set.mesh(0).vertex_scalar_array()) == bits(AWKWARD)
    assert not cloud_set.mesh(second).vertex_scalar_array().any()


def test_names_that_are_taken_get_a_number_all_of_them_the_same(cloud_set):
    mesh = cloud_set.mesh(0)
    mesh.add_vertex_custom_scalar_attribute(np.zeros(40), "mark")
    mesh.add_vertex_custom_point_attribute(np.zeros((40, 3)), "made_up_2")
    for turn in (1.0, 2.0):
        write_scalars(cloud_set, scalars(np.full(40, turn), mark=np.full(40, -turn)))
    assert (mesh.vertex_scalar_array() == 2.0).all()
    layer = read_layer(cloud_set, 0)
    kept = {name: values[0] for name, values in layer.attributes.items()}
    assert kept == {"mark": 0.0, "made_up_3": 1.0, "mark_3": -1.0, "made_up_4": 2.0, "mark_4": -2.0}


def test_what_does_not_fit_is_refused_and_nothing_is_written(cloud_set):
    before = state(cloud_set)
    for wrong, words in (
        (scalars(AWKWARD[:7]), r"needs 40 numbers, one a vertex; got shape \(7,\)"),
        (scalars(mark=np.zeros((40, 1))), r"'mark' of layer 0 needs 40 numbers"),
        (scalars(identifier=9), "layer 9, which is not in the document"),
    ):
        with pytest.raises(HostError, match=words):
            write_scalars(cloud_set, wrong)
    assert state(cloud_set) == before
    assert read_layer(cloud_set, 0).attributes == {}


@pytest.mark.parametrize("name", ["two words", "Capital", "2nd", "", "größe"])
def test_names_that_meshlab_cannot_tell_are_refused(cloud_set, name):
    with pytest.raises(HostError, match="needs a name like 'my_attribute'"):
        write_scalars(cloud_set, scalars(name=name))
    assert read_layer(cloud_set, 0).attributes == {}


@pytest.mark.parametrize("name", ["x", "q", "vi", "nx", "vsel"])
def test_names_of_meshlabs_own_variables_mean_the_attribute(cloud_set, name):
    write_scalars(cloud_set, scalars(name=name))
    assert bits(cloud_set.mesh(0).vertex_scalar_array()) == bits(AWKWARD)


def writer(grow_filter, *made, layers=()):
    def run(document, parameters, progress):
        return Outcome(layers, current=None, measures={"written": len(made)}, scalars=made)

    return replace(grow_filter, run=run)


def test_the_history_shows_the_step_once_and_not_its_means(install, cloud_set, grow_filter):
    install(writer(grow_filter, scalars(), scalars(name="other")))
    cloud_set.compute_normal_for_point_clouds()
    assert apply_filter(cloud_set, "grow_points") == {"written": 2}
    names = [step.menu_name for step in read_history(cloud_set)]
    assert names == ["Compute normals for point sets", "Grow Points"]
    assert {"made_up", "other"} <= set(read_layer(cloud_set, 0).attributes)


def test_with_a_camera_in_the_history_the_step_runs_all_the_same(install, cloud_set, grow_filter):
    install(writer(grow_filter, scalars()))
    cloud_set.set_camera_per_mesh()
    words = "is not in the filter history.*; in its place is 'Per Vertex Quality Function', by"
    with pytest.warns(SymReconWarning, match=words):
        apply_filter(cloud_set, "grow_points")
    assert bits(cloud_set.mesh(0).vertex_scalar_array()) == bits(AWKWARD)
    steps = read_history(cloud_set)
    assert len(steps) == 2
    assert steps[1].menu_name == "Per Vertex Quality Function"
    assert steps[1].texts["q"] == "made_up"


def test_a_step_that_writes_no_scalars_leaves_nothing_beside_a_camera(
    install, cloud_set, grow_filter
):
    install(grow_filter)
    cloud_set.set_camera_per_mesh()
    with pytest.warns(SymReconWarning, match="MeshLab cannot read back$"):
        apply_filter(cloud_set, "grow_points")
    assert len(read_history(cloud_set)) == 1


def test_layers_and_scalars_are_written_all_or_none(install, cloud_set, grow_filter, points):
    good, empty = Layer(points, NO_FACES, "more"), Layer(points[:0], NO_FACES, "empty")
    install(writer(grow_filter, scalars(), layers=(good, empty)))
    with pytest.raises(HostError, match="'empty' cannot be added"):
        apply_filter(cloud_set, "grow_points")
    install(writer(grow_filter, scalars(), scalars(AWKWARD[:3]), layers=(good,)))
    with pytest.raises(HostError, match="needs 40 numbers"):
        apply_filter(cloud_set, "grow_points")
    assert [mesh.label() for mesh in cloud_set] == ["scan"]
    assert read_layer(cloud_set, 0).attributes == {}
    assert read_history(cloud_set) == ()
