"""Our steps in pymeshlab's own script history: in order, exact, and replayed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pymeshlab
import pytest

from meshlab_symrecon.errors import HostError, ParameterError, ScriptError, SymReconWarning
from meshlab_symrecon.host import history, registration
from meshlab_symrecon.host.history import Step, read_history, restore

AWKWARD = {
    "factor": 0.1 + 0.2,
    "randomseed": 2**40 + 1,
    "mode": "plain",
    "keep": False,
    "title": 'é "<&>\n \u3042',
}


def names(mesh_set):
    return [step.menu_name for step in read_history(mesh_set)]


def test_steps_appear_in_order_among_native_ones(plugins, cloud_set):
    cloud_set.compute_normal_for_point_clouds()
    cloud_set.grow_points()
    cloud_set.apply_nothing()
    cloud_set.compute_matrix_from_translation(axisx=1.0)
    cloud_set.apply_filter("Grow Points", factor=0.5)
    assert names(cloud_set) == [
        "Compute normals for point sets",
        "Grow Points",
        "Do Nothing",
        "Transform: Translate, Center, set Origin",
        "Grow Points",
    ]


def test_a_step_that_fails_is_not_recorded(plugins, cloud_set):
    with pytest.raises(ParameterError):
        cloud_set.grow_points(factor=-1.0)
    assert names(cloud_set) == []


def test_every_value_survives_the_native_history_to_the_last_bit(
    plugins, cloud_set, grow_filter, tmp_path
):
    """Through our record, the native save, the native load, and another step on top."""
    cloud_set.grow_points(**AWKWARD)
    path = str(tmp_path / "steps.mlx")
    cloud_set.save_filter_script(path)
    other = pymeshlab.MeshSet(verbose=False)
    other.add_mesh(pymeshlab.Mesh(vertex_matrix=np.eye(3)))
    other.load_filter_script(path)
    other.apply_nothing()
    step = read_history(other)[0]
    declared = grow_filter.parameters
    back = {name: declared.find(name).parse(text) for name, text in step.texts.items()}
    assert back == AWKWARD


@pytest.mark.parametrize("factor", [0.123456789, 1e-300, 5e-324, 1e300, 1 / 3])
def test_a_mixed_script_is_replayed_from_a_file_with_the_same_bits(
    plugins, cloud_set, points, tmp_path, factor
):
    cloud_set.grow_points(factor=factor, title="first")
    cloud_set.compute_selection_by_condition_per_vertex(condselect="x > 0")
    cloud_set.grow_points(factor=1.0, title="second")
    path = str(tmp_path / "steps.mlx")
    cloud_set.save_filter_script(path)

    again = pymeshlab.MeshSet(verbose=False)
    again.add_mesh(pymeshlab.Mesh(vertex_matrix=points), "scan")
    again.load_filter_script(path)
    again.apply_filter_script()
    assert [mesh.label() for mesh in again] == ["scan", "first", "second"]
    np.testing.assert_array_equal(again.mesh(2).vertex_matrix(), cloud_set.mesh(2).vertex_matrix())
    np.testing.assert_array_equal(
        again.mesh(1).vertex_selection_array(), cloud_set.mesh(1).vertex_selection_array()
    )


def test_a_replay_leaves_the_history_as_it_is(plugins, cloud_set):
    cloud_set.grow_points()
    cloud_set.create_cube()
    before = read_history(cloud_set)
    cloud_set.apply_filter_script()
    assert read_history(cloud_set) == before
    assert cloud_set.mesh_number() == 5


def test_a_native_history_is_replayed(plugins, cloud_set):
    cloud_set.create_cube(size=2.0)
    cloud_set.apply_filter_script()
    assert cloud_set.mesh_number() == 3
    assert names(cloud_set) == ["Box/Cube"]


def test_replay_in_an_empty_document_does_not_crash(plugins, tmp_path):
    """The native replay ends the process here."""
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.create_cube()
    path = str(tmp_path / "steps.mlx")
    mesh_set.save_filter_script(path)
    empty = pymeshlab.MeshSet(verbose=False)
    empty.load_filter_script(path)
    empty.apply_filter_script()
    assert empty.mesh_number() == 1


def test_native_parameters_of_every_shape_are_replayed(plugins, cloud_set, points):
    """A matrix, a direction, colours, a choice, a percentage and layers."""
    turn = np.array([[0.0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]])
    cloud_set.set_matrix(transformmatrix=turn)
    cloud_set.compute_matrix_from_rotation(
        rotaxis="custom axis", customaxis=np.array([1.0, 2.0, 2.0]), angle=25.0
    )
    cloud_set.set_color_per_vertex(color1=pymeshlab.Color(10, 20, 30, 40))
    cloud_set.meshing_merge_close_vertices(threshold=pymeshlab.PureValue(1e-5))
    cloud_set.grow_points()
    cloud_set.get_hausdorff_distance(sampledmesh=0, targetmesh=1)
    expected = cloud_set.mesh(1)

    again = pymeshlab.MeshSet(verbose=False)
    again.add_mesh(pymeshlab.Mesh(vertex_matrix=points), "scan")
    restore(again, read_history(cloud_set))
    again.apply_filter_script()
    grown = again.mesh(1)
    np.testing.assert_allclose(grown.vertex_matrix(), expected.vertex_matrix(), atol=1e-5)
    np.testing.assert_array_equal(grown.vertex_color_matrix(), expected.vertex_color_matrix())
    assert np.rint(grown.vertex_color_matrix()[0] * 255).tolist() == [10, 20, 30, 40]


def test_a_script_is_checked_before_its_first_step_runs(plugins, cloud_set):
    cube, bad = Step("Box/Cube", ()), {"type": "RichFloat", "name": "factor", "value": "-2"}
    for step, reason in (
        (Step("No Such Filter", ()), "no filter is called 'No Such Filter'"),
        (Step("Grow Points", (bad,)), "parameter 'factor' must be a number of at least 0"),
        (Step("Grow Points", ({**bad, "name": "size"},)), "unknown parameter 'size'"),
    ):
        restore(cloud_set, [cube, step])
        with pytest.raises(ScriptError, match=f"^filter history: step 2: .*{reason}"):
            cloud_set.apply_filter_script()
        assert cloud_set.mesh_number() == 1
        assert names(cloud_set) == ["Box/Cube", step.menu_name]


def test_a_step_that_fails_in_a_replay_is_named_and_the_history_stays(plugins):
    mesh_set = pymeshlab.MeshSet(verbose=False)
    steps = [Step("Do Nothing", ()), Step("Grow Points", ())]
    restore(mesh_set, steps)
    with pytest.raises(ScriptError, match=r"^filter history: step 2: 'Grow Points'"):
        mesh_set.apply_filter_script()
    assert names(mesh_set) == ["Do Nothing", "Grow Points"]


def test_a_history_with_a_camera_is_not_rewritten(plugins, cloud_set, monkeypatch):
    """The native reader would end the process."""
    camera = (
        '<FilterScript><filter name="Set Camera"><Param type="RichShotf" name="Shot"/></filter>'
    )

    def save(mesh_set):
        from defusedxml.ElementTree import fromstring

        return fromstring(camera + "</FilterScript>")

    loads = []
    monkeypatch.setattr(history, "_saved", save)
    monkeypatch.setattr(history, "_load", lambda *given: loads.append(given))
    with pytest.warns(SymReconWarning, match="'Do Nothing' ran, but is not in the filter history"):
        registration.apply_filter(cloud_set, "apply_nothing")
    with pytest.raises(HostError, match="step 'Set Camera' has a camera"):
        restore(cloud_set, read_history(cloud_set))
    with pytest.raises(HostError, match="step 'Set Camera' has a camera"):
        cloud_set.apply_filter_script()
    with pytest.raises(HostError, match="step 'Set Camera' has a camera"):
        cloud_set.save_filter_script("camera.mlx")
    assert loads == []
    assert not Path("camera.mlx").exists()


def test_an_empty_history(cloud_set):
    assert read_history(cloud_set) == ()
    restore(cloud_set, ())
    assert read_history(cloud_set) == ()
