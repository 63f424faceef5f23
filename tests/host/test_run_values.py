"""What filters ran with, and MeshLab's own steps noted to the last bit."""

from __future__ import annotations

import numpy as np
import pymeshlab
import pytest

from meshlab_symrecon import FilterScript
from meshlab_symrecon.errors import HostError
from meshlab_symrecon.host import exact_steps
from meshlab_symrecon.host.files import new_document
from meshlab_symrecon.host.mlx import Param, Step
from meshlab_symrecon.host.native_filters import apply_native, find_native
from meshlab_symrecon.host.recorded_values import recorded_values
from meshlab_symrecon.host.records import record_of
from meshlab_symrecon.host.registration import apply_filter, registry
from meshlab_symrecon.host.run_values import noted_steps, values_of_run

THIRD = 1.0 / 3.0


def sphere():
    mesh_set = new_document()
    mesh_set.create_sphere(subdiv=2)
    mesh_set.clear_filter_script()
    return mesh_set


def test_numbers_of_native_steps_are_kept_to_the_last_bit_without_plugins():
    mesh_set = sphere()
    apply_filter(mesh_set, "compute_matrix_from_scaling_or_normalization", axisx=THIRD)
    apply_native(mesh_set, "compute_matrix_from_translation", {"axisy": 7 * THIRD})
    scale, move = record_of(mesh_set, []).steps
    assert scale.parameters["axisx"] == THIRD
    assert move.parameters["axisy"] == 7 * THIRD


def test_each_step_is_noted_once():
    mesh_set = sphere()
    apply_native(mesh_set, "compute_matrix_from_translation", {"axisy": 1.0})
    assert noted_steps(mesh_set) == 1
    with pytest.raises(HostError):
        apply_native(mesh_set, "compute_color_from_scalar_per_face", {})
    assert noted_steps(mesh_set) == 1


def test_each_step_is_noted_once_with_plugins(plugins):
    mesh_set = sphere()
    apply_native(mesh_set, "compute_matrix_from_translation", {"axisy": THIRD})
    mesh_set.compute_matrix_from_translation(axisy=THIRD)
    assert noted_steps(mesh_set) == 2
    assert [step.parameters["axisy"] for step in record_of(mesh_set, []).steps] == [THIRD, THIRD]


def test_the_means_of_a_filter_of_ours_leave_the_notes_before_it():
    mesh_set = sphere()
    apply_native(mesh_set, "compute_matrix_from_translation", {"axisy": THIRD})
    before = exact_steps.notes_of(mesh_set).steps
    apply_filter(mesh_set, "detect_reflection_planes")
    apply_filter(mesh_set, "mirror_symmetry_deviation")
    notes = exact_steps.notes_of(mesh_set).steps
    assert notes[:1] == before
    assert len(notes) == 3


def test_the_report_of_a_script_in_python_tells_the_values():
    mesh_set = sphere()
    script = FilterScript().with_step("compute_matrix_from_translation", axisy=THIRD)
    script = script.with_step("simplify_points", count=20).with_step("Transform: Scale, Normalize")
    move, simplified, scale = script.run(mesh_set).steps
    assert move.parameters["axisy"] == THIRD
    assert move.parameters == record_of(mesh_set, []).steps[0].parameters
    simplify = registry().find("simplify_points")
    assert simplified.parameters == simplify.bind({"count": 20}).values()
    assert set(scale.parameters) == {known.name for known in find_native(scale.name).parameters}
    assert (move.then, simplified.then, scale.then) == ({}, {}, {})


def test_layers_are_told_as_positions():
    mesh_set = pymeshlab.MeshSet(verbose=False)
    for _ in range(3):
        mesh_set.create_cube()
    mesh_set.set_current_mesh(0)
    mesh_set.delete_current_mesh()
    script = FilterScript().with_step("get_hausdorff_distance", sampledmesh=1, targetmesh=0)
    (step,) = script.run(mesh_set).steps
    assert (step.parameters["sampledmesh"], step.parameters["targetmesh"]) == (1, 0)
    noted = noted_steps(mesh_set)
    apply_filter(mesh_set, "get_hausdorff_distance", sampledmesh=2, targetmesh=1)
    known = values_of_run(mesh_set, find_native("get_hausdorff_distance"), {}, noted)
    assert (known["sampledmesh"], known["targetmesh"]) == (1, 0)


def test_of_a_step_that_is_not_noted_what_it_was_given_is_told():
    mesh_set = sphere()
    decimation = find_native("meshing_decimation_quadric_edge_collapse")
    known = values_of_run(mesh_set, decimation, {"targetfacenum": 50, "planarweight": THIRD}, 0)
    assert known["targetfacenum"] == 50
    assert known["planarweight"] == THIRD
    assert known["optimalplacement"] is True  # which is never left to MeshLab
    ours = registry().find("simplify_points")
    assert values_of_run(mesh_set, ours, {"count": 5}, 0) == ours.bind({"count": 5}).values()


@pytest.mark.parametrize(("folders", "told"), [(True, "/home/a/skin.png"), (False, "skin.png")])
def test_the_folders_of_files_are_told_or_not(folders, told):
    step = Step("Of nobody", 0, (Param("File", 0, "RichOpenFile", "/home/a/skin.png"),))
    assert recorded_values(step, folders=folders) == {"file": told}


def test_lengths_are_absolute_and_give_the_same_again():
    first, second = sphere(), sphere()
    given = {"cellsize": pymeshlab.PercentageValue(7.3)}
    apply_filter(first, "generate_resampled_uniform_mesh", **given)
    (step,) = record_of(first, []).steps
    apply_filter(second, step.filter, **step.parameters)
    assert record_of(second, []).steps == (step,)
    points = [mesh_set.current_mesh().vertex_matrix() for mesh_set in (first, second)]
    np.testing.assert_array_equal(*points)
