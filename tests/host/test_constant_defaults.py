"""Defaults of MeshLab's filters that do not depend on the layer."""

from __future__ import annotations

import numpy as np
import pymeshlab
import pytest

from meshlab_symrecon.host.constant_defaults import constant_defaults
from meshlab_symrecon.host.native_filters import find_native, native_filters
from meshlab_symrecon.host.native_values import checked_value


@pytest.fixture
def cloud():
    mesh_set = pymeshlab.MeshSet(verbose=False)
    points = np.random.default_rng(5).normal(size=(50, 3))
    mesh_set.add_mesh(pymeshlab.Mesh(vertex_matrix=points, v_scalar_array=points[:, 0]), "fifty")
    return mesh_set


def test_a_filter_of_both_kinds():
    known = constant_defaults("meshing_decimation_quadric_edge_collapse")
    assert known["qualitythr"] == pytest.approx(0.3)
    assert known["preserveboundary"] is False
    assert not {"targetfacenum", "selected"} & set(known)
    assert "threshold" not in constant_defaults("meshing_merge_close_vertices")
    assert not {"sampledmesh", "targetmesh"} & set(constant_defaults("get_hausdorff_distance"))
    assert constant_defaults("set_mesh_name") == {}
    assert "threads" not in constant_defaults("generate_surface_reconstruction_screened_poisson")
    assert constant_defaults("set_color_per_vertex")["color1"].red() == 0


@pytest.mark.parametrize("name", ["compute_matrix_from_rotation", "create_torus", "set_matrix",
                                  "compute_normal_for_point_clouds", "generate_alpha_wrap",
                                  "generate_surface_reconstruction_ball_pivoting",
                                  "apply_scalar_clamping_per_vertex"])  # fmt: skip
def test_a_third_layer_has_the_same(cloud, name):
    there = cloud.filter_parameter_values(name)
    for parameter, value in constant_defaults(name).items():
        got = checked_value(find_native(name).find(parameter), there[parameter])
        if isinstance(value, pymeshlab.PureValue):
            got, value = got.value(), value.value()
        assert np.array_equal(got, value), parameter


def test_every_filter_can_be_asked():
    known = {name: constant_defaults(name) for name in native_filters()}
    total = sum(len(item.parameters) for item in native_filters().values())
    assert 0.85 * total < sum(map(len, known.values())) < total
