"""Layers as arrays: exact round trips, world coordinates, and what is honestly absent."""

from __future__ import annotations

import numpy as np
import pymeshlab
import pytest

from meshlab_symrecon.errors import HostError, ParameterError, SymReconWarning
from meshlab_symrecon.host.meshset import add_layer, current_identifier, layers_of, read_layer
from meshlab_symrecon.plugin import Layer

NO_FACES = np.zeros((0, 3), np.int64)
TETRAHEDRON = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
OUTWARD = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])


def volume(points, faces):
    a, b, c = (points[faces[:, corner]] for corner in range(3))
    return np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0


def awkward_numbers(rng, shape):
    """Doubles with every bit in use, over 200 orders of magnitude."""
    return rng.normal(size=shape) * 10.0 ** rng.integers(-100, 100, size=shape)


def test_a_cloud_comes_back_to_the_last_bit():
    rng = np.random.default_rng(0)
    given = Layer(
        points=awkward_numbers(rng, (50, 3)),
        faces=NO_FACES,
        label="scan",
        normals=awkward_numbers(rng, (50, 3)),
        quality=awkward_numbers(rng, 50),
        colours=rng.integers(0, 256, (50, 4)) / 255.0,
        attributes={"mirrored": awkward_numbers(rng, 50), "radius_2": np.arange(50.0)},
    )
    mesh_set = pymeshlab.MeshSet(verbose=False)
    back = read_layer(mesh_set, add_layer(mesh_set, given, current=True))
    for name in ("points", "normals", "quality"):
        np.testing.assert_array_equal(getattr(back, name), getattr(given, name))
    np.testing.assert_array_equal(np.rint(back.colours * 255), np.rint(given.colours * 255))
    assert back.label == "scan"
    assert set(back.attributes) == {"mirrored", "radius_2"}
    for name, values in given.attributes.items():
        np.testing.assert_array_equal(back.attributes[name], values)


def test_a_mesh_comes_back_with_what_its_faces_carry():
    given = Layer(
        points=TETRAHEDRON,
        faces=OUTWARD,
        face_quality=np.array([0.1, 1 / 3, -2.0, 0.0]),
        face_colours=np.array([[0, 1, 2, 255]] * 4) / 255.0,
    )
    mesh_set = pymeshlab.MeshSet(verbose=False)
    back = read_layer(mesh_set, add_layer(mesh_set, given, current=True))
    np.testing.assert_array_equal(back.faces, OUTWARD)
    assert back.faces.dtype == np.int64
    np.testing.assert_array_equal(back.face_quality, given.face_quality)
    np.testing.assert_array_equal(np.rint(back.face_colours * 255), [[0, 1, 2, 255]] * 4)
    assert back.colours is back.quality is back.selected is back.face_selected is None


def test_every_byte_of_colour_survives():
    bytes_ = np.arange(256)
    given = Layer(
        points=np.random.default_rng(0).normal(size=(256, 3)),
        faces=NO_FACES,
        colours=np.repeat(bytes_[:, None], 4, axis=1) / 255.0,
    )
    mesh_set = pymeshlab.MeshSet(verbose=False)
    back = read_layer(mesh_set, add_layer(mesh_set, given, current=True))
    np.testing.assert_array_equal(np.rint(back.colours[:, 0] * 255).astype(int), bytes_)


def test_a_bare_cloud_has_nothing_but_points(cloud_set, points):
    layer = read_layer(cloud_set, 0)
    np.testing.assert_array_equal(layer.points, points)
    assert layer.faces.shape == (0, 3)
    for name in ("normals", "colours", "quality", "face_quality", "face_colours", "selected",
                 "face_selected", "selection"):  # fmt: skip
        assert getattr(layer, name) is None
    assert layer.attributes == {}
    assert (layer.label, layer.identifier) == ("scan", 0)


def test_selection_is_read(cloud_set, points):
    cloud_set.compute_selection_by_condition_per_vertex(condselect="x > 0")
    np.testing.assert_array_equal(read_layer(cloud_set, 0).selected, points[:, 0] > 0)


def test_selected_faces_are_read_after_what_was_deleted_before_them():
    mesh_set = pymeshlab.MeshSet(verbose=False)
    add_layer(mesh_set, Layer(points=TETRAHEDRON, faces=OUTWARD), current=True)
    mesh_set.compute_selection_by_condition_per_face(condselect="fi == 0")
    mesh_set.meshing_remove_selected_faces()
    mesh_set.compute_selection_by_condition_per_face(condselect="fi == 1")
    layer = read_layer(mesh_set, 0)
    np.testing.assert_array_equal(layer.faces[layer.face_selected], [[1, 2, 3]])
    assert layer.selected is None
    np.testing.assert_array_equal(layer.selection, [False, True, True, True])


def test_points_that_are_not_finite_pass():
    points = np.array([[0.0, 0, 0], [np.nan, 1, 2], [np.inf, 0, 0]])
    mesh_set = pymeshlab.MeshSet(verbose=False)
    number = add_layer(mesh_set, Layer(points=points, faces=NO_FACES), current=True)
    np.testing.assert_array_equal(read_layer(mesh_set, number).points, points)


def test_what_is_read_cannot_be_written_to(cloud_set):
    cloud_set.compute_normal_for_point_clouds()
    cloud_set.mesh(0).add_vertex_custom_scalar_attribute(np.ones(40), "a")
    layer = read_layer(cloud_set, 0)
    for array in (layer.points, layer.faces, layer.normals, layer.attributes["a"]):
        assert not array.flags.writeable


def place(mesh_set, linear, shift):
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = linear, shift
    mesh_set.set_matrix(transformmatrix=matrix, freeze=False)
    return mesh_set.current_mesh().transform_matrix()  # MeshLab keeps fewer digits


@pytest.mark.parametrize("mirror", [1.0, -1.0])
def test_a_transform_matrix_is_honoured(mirror):
    mesh_set = pymeshlab.MeshSet(verbose=False)
    given = Layer(points=TETRAHEDRON, faces=OUTWARD)
    number = add_layer(mesh_set, given, current=True)
    at_rest = read_layer(mesh_set, number)
    shear = np.array([[mirror * 2.0, 0.3, 0.0], [0.1, 1.0, -0.4], [0.0, 0.2, 3.0]])
    matrix = place(mesh_set, shear, [5.0, -6.0, 7.0])
    layer = read_layer(mesh_set, number)

    homogeneous = np.column_stack([TETRAHEDRON, np.ones(4)])
    np.testing.assert_allclose(layer.points, (homogeneous @ matrix.T)[:, :3], rtol=1e-14)
    scale = abs(np.linalg.det(matrix[:3, :3]))
    assert volume(layer.points, layer.faces) == pytest.approx(scale / 6.0)  # still outward
    normals = at_rest.normals @ np.linalg.inv(matrix[:3, :3])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    np.testing.assert_allclose(layer.normals, normals, atol=1e-14)
    np.testing.assert_array_equal(mesh_set.mesh(number).vertex_matrix(), TETRAHEDRON)


def test_normals_stay_normal_to_the_moved_surface():
    """A plane's normals under a shear: the inverse transpose, not the matrix."""
    rng = np.random.default_rng(1)
    across = np.column_stack([rng.normal(size=(30, 2)), np.zeros(30)])
    mesh_set = pymeshlab.MeshSet(verbose=False)
    upward = np.tile([0.0, 0.0, 1.0], (30, 1))
    number = add_layer(mesh_set, Layer(points=across, faces=NO_FACES, normals=upward), current=True)
    place(mesh_set, [[1.0, 0.5, 0.7], [0.0, 2.0, 0.3], [0.4, 0.0, 1.0]], [1.0, 2.0, 3.0])
    layer = read_layer(mesh_set, number)
    edges = layer.points - layer.points[0]
    assert np.abs(edges @ layer.normals[0]).max() < 1e-12
    np.testing.assert_allclose(np.linalg.norm(layer.normals, axis=1), 1.0, rtol=1e-14)


def test_a_matrix_that_flattens_is_refused(cloud_set):
    place(cloud_set, np.diag([1.0, 1.0, 0.0]), [0.0, 0.0, 0.0])
    with pytest.raises(HostError, match="layer 0 has a transform matrix that flattens it"):
        read_layer(cloud_set, 0)


@pytest.mark.parametrize("last_row", [[0.0, 0.0, 0.001, 1.0], [0.0, 0.0, 0.0, 2.0]])
def test_a_matrix_of_perspective_is_refused(cloud_set, last_row):
    matrix = np.eye(4)
    matrix[3] = last_row
    cloud_set.set_matrix(transformmatrix=matrix, freeze=False)
    with pytest.raises(HostError, match="layer 0 has a transform matrix with a last row of"):
        read_layer(cloud_set, 0)


def test_a_layer_that_is_not_there_is_refused(cloud_set):
    with pytest.raises(HostError, match="no layer has the number 3"):
        read_layer(cloud_set, 3)


def test_an_empty_layer_cannot_be_added(cloud_set):
    with pytest.raises(HostError, match="layer 'void' cannot be added; got no points"):
        add_layer(
            cloud_set, Layer(points=np.zeros((0, 3)), faces=NO_FACES, label="void"), current=True
        )
    assert cloud_set.mesh_number() == 1


def test_arrays_that_do_not_fit_together_are_refused(cloud_set):
    bad = Layer(points=TETRAHEDRON, faces=np.array([[0, 1, 9]]), label="bad")
    with pytest.raises(HostError, match=r"^adding layer 'bad': "):
        add_layer(cloud_set, bad, current=True)


def test_which_layer_is_current(cloud_set):
    layer = Layer(points=TETRAHEDRON, faces=NO_FACES, label="scan")
    beside = add_layer(cloud_set, layer, current=False)
    assert (beside, current_identifier(cloud_set)) == (1, 0)
    chosen = add_layer(cloud_set, layer, current=True)
    assert current_identifier(cloud_set) == chosen == 2
    assert layers_of(cloud_set).labels == {0: "scan", 1: "scan(1)", 2: "scan(2)"}


def test_in_an_empty_document_a_new_layer_is_current():
    mesh_set = pymeshlab.MeshSet(verbose=False)
    assert current_identifier(mesh_set) == -1
    add_layer(mesh_set, Layer(points=TETRAHEDRON, faces=NO_FACES), current=False)
    assert current_identifier(mesh_set) == 0


def test_layers_are_read_when_asked_for_and_once(cloud_set):
    layers = layers_of(cloud_set)
    assert list(layers) == [0]
    assert layers.current is layers.get(0)
    with pytest.raises(ParameterError, match="no layer has the number 8"):
        layers.get(8)


def test_layers_of_an_empty_document():
    layers = layers_of(pymeshlab.MeshSet(verbose=False))
    assert (dict(layers.labels), layers.current_identifier) == ({}, -1)


def test_numbers_of_layers_have_holes_after_a_deletion(cloud_set):
    layer = Layer(points=TETRAHEDRON, faces=NO_FACES, label="b")
    add_layer(cloud_set, layer, current=True)
    add_layer(cloud_set, layer, current=False)
    cloud_set.delete_current_mesh()
    layers = layers_of(cloud_set)
    assert list(layers) == [0, 2]
    assert layers.get(2).identifier == 2


def test_reading_another_layer_leaves_the_current_one(cloud_set):
    add_layer(cloud_set, Layer(points=TETRAHEDRON, faces=NO_FACES), current=True)
    read_layer(cloud_set, 0)
    assert current_identifier(cloud_set) == 1


def test_attributes_whose_name_pymeshlab_hides_are_left_out_with_a_warning(cloud_set):
    cloud_set.mesh(0).add_vertex_custom_scalar_attribute(np.ones(40), "Height")
    cloud_set.mesh(0).add_vertex_custom_scalar_attribute(np.ones(40), "depth")
    with pytest.warns(SymReconWarning, match="custom attribute 'height' of layer 0 was left out"):
        layer = read_layer(cloud_set, 0)
    assert set(layer.attributes) == {"depth"}


def test_attributes_of_a_new_layer_can_be_saved(tmp_path):
    """Attributes given to a Mesh before it is added crash pymeshlab here."""
    mesh_set = pymeshlab.MeshSet(verbose=False)
    layer = Layer(points=TETRAHEDRON, faces=NO_FACES, attributes={"mirrored": np.arange(4.0)})
    add_layer(mesh_set, layer, current=True)
    path = tmp_path / "out.ply"
    mesh_set.save_current_mesh(str(path), __ca_vs__mirrored=True)
    assert b"property double mirrored" in path.read_bytes()
