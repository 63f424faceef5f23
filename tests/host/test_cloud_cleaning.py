"""Cleaning steps that would delete a cloud are passed over."""

from __future__ import annotations

import numpy as np
import pytest

from meshlab_symrecon.errors import SymReconWarning
from meshlab_symrecon.host.cloud_cleaning import EMPTY_CLOUDS
from meshlab_symrecon.host.native_filters import apply_native, find_native


@pytest.mark.parametrize("name", sorted(EMPTY_CLOUDS))
def test_a_cleaning_step_that_would_delete_a_cloud_is_skipped(cloud_set, points, name):
    menu = find_native(name).menu_name
    with pytest.warns(SymReconWarning, match="was skipped: layer 'scan' has no faces") as caught:
        assert apply_native(cloud_set, menu, {}) == {}
    assert caught[0].filename == __file__
    np.testing.assert_array_equal(cloud_set.current_mesh().vertex_matrix(), points)


@pytest.mark.parametrize("name", sorted(EMPTY_CLOUDS))
def test_pymeshlab_itself_does_delete_the_cloud(cloud_set, name):
    """When this fails, the guard is no longer needed."""
    cloud_set.apply_filter(name)
    assert cloud_set.current_mesh().vertex_number() == 0


def test_cleaning_steps_run_on_meshes(cloud_set):
    cloud_set.create_cube()
    apply_native(cloud_set, "meshing_remove_unreferenced_vertices", {})
    assert cloud_set.current_mesh().vertex_number() == 8


def test_a_repair_that_would_delete_a_cloud_is_skipped(cloud_set, points):
    name, menu = "meshing_repair_non_manifold_edges", "'Repair non Manifold Edges' was skipped"
    with pytest.warns(SymReconWarning, match=menu):
        apply_native(cloud_set, name, {"method": "Split Vertices"})
    apply_native(cloud_set, name, {"method": "Remove Faces"})
    np.testing.assert_array_equal(cloud_set.current_mesh().vertex_matrix(), points)
