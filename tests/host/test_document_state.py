"""What is known of a document, without the document."""

from __future__ import annotations

import numpy as np
import pymeshlab
import pytest

from meshlab_symrecon.host.document_state import FACTS, DocumentState, LayerState


def layer(**facts):
    return LayerState(facts)


def test_a_cloud_and_a_mesh_are_seen_as_they_are(cloud_set):
    cloud_set.create_cube()
    cloud_set.set_selection_all()
    state = DocumentState.of(cloud_set)
    cloud, cube = state.layers
    assert set(cloud.facts) == set(cube.facts) == set(FACTS)
    assert (cloud.label, cloud.vertices, cloud.is_cloud) == ("scan", 40, True)
    assert (cube.vertices, cube.is_cloud) == (8, False)
    assert [cube.has(fact) for fact in ("faces", "normals", "face_selection")] == [True] * 3
    assert [cloud.has(fact) for fact in ("faces", "normals", "vertex_selection")] == [False] * 3
    assert (state.current, state.most, state.more, state.rasters) == (1, 2, 0, False)
    assert state.current_layer is cube


def test_positions_count_when_identifiers_have_holes(cloud_set):
    cloud_set.create_cube()
    cloud_set.create_sphere(subdiv=1)
    cloud_set.set_current_mesh(1)
    cloud_set.delete_current_mesh()
    state = DocumentState.of(cloud_set)
    assert [known.vertices for known in state.layers] == [40, 42]
    assert state.current == 1  # its identifier is 2


def test_every_fact_follows_what_a_filter_gives():
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.create_sphere(subdiv=1)
    before = DocumentState.of(mesh_set).current_layer
    mesh_set.compute_color_by_function_per_vertex()
    mesh_set.compute_color_by_function_per_face()
    mesh_set.compute_scalar_by_function_per_vertex(q="x")
    mesh_set.compute_scalar_by_function_per_face(q="x0")
    mesh_set.compute_texcoord_parametrization_triangle_trivial_per_wedge(sidedim=0, textdim=64)
    mesh_set.compute_texcoord_transfer_wedge_to_vertex()
    mesh_set.set_selection_all()
    mesh_set.set_mesh_visibility(0, False)
    after = DocumentState.of(mesh_set).current_layer
    changed = {fact for fact in FACTS if before.has(fact) is not after.has(fact)}
    assert changed == set(FACTS) - {"points", "faces", "edges", "normals", "textures"}
    assert after.has("visible") is False


def test_a_state_is_read_without_changing_the_document(cloud_set, points):
    DocumentState.of(cloud_set)
    np.testing.assert_array_equal(cloud_set.current_mesh().vertex_matrix(), points)
    assert cloud_set.current_mesh().label() == "scan"


def test_an_empty_document_and_one_that_nobody_has_seen():
    empty = DocumentState.of(pymeshlab.MeshSet(verbose=False))
    assert (empty.is_empty, empty.current, empty.most) == (True, None, 0)
    unknown = DocumentState.unknown()
    assert (unknown.is_empty, unknown.most) == (False, None)
    assert {unknown.current_layer.has(fact) for fact in FACTS} == {None}


@pytest.mark.parametrize("fact", [True, False, None])
def test_a_cloud_is_only_one_when_that_is_certain(fact):
    facts = {"points": True} | ({} if fact is None else {"faces": fact})
    assert LayerState(facts).is_cloud is (fact is False)
    assert not LayerState({"faces": False}).is_cloud


def test_what_is_joined_is_known_where_both_agree():
    first = LayerState({"points": True, "faces": True, "edges": False}, "a", 3)
    second = LayerState({"points": True, "faces": False}, "a", 4)
    joined = first.joined(second)
    assert (joined.facts, joined.label, joined.vertices) == ({"points": True}, "a", None)
    assert first.joined(first) == first


def test_joined_documents_have_as_many_layers_as_the_longer_one():
    one = DocumentState((layer(faces=True),), current=0, rasters=False)
    two = DocumentState((layer(faces=True), layer(faces=False)), current=1, rasters=False)
    joined = one.joined(two)
    assert joined == two.joined(one)
    assert (len(joined.layers), joined.most, joined.current) == (1, 2, None)
    assert joined.current_layer.has("faces") is None
    assert joined.rasters is False
    assert one.joined(DocumentState.unknown()).most is None


def test_another_layer_becomes_current():
    two = DocumentState((layer(faces=True), layer(faces=False)), current=1)
    assert two.with_current_at(0).current_layer.has("faces") is True
    assert two.with_current_at(5).current is None
    assert two.with_current_at(5).current_layer.has("faces") is None
