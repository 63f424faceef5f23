"""What MeshLab remembers from one step must not change the next."""

from __future__ import annotations

import json
import subprocess
import sys

import numpy as np
import pymeshlab
import pytest

from meshlab_symrecon.host.native_filters import apply_native, find_native, native_filters
from meshlab_symrecon.host.remembered import first_defaults

REMEMBERING = [name for name in native_filters() if first_defaults(name)]
ASK = (
    "import json, sys, pymeshlab\n"
    "mesh_set = pymeshlab.MeshSet(verbose=False)\n"
    "mesh_set.create_sphere()\n"
    "names = json.loads(sys.argv[1])\n"
    "found = {name: mesh_set.filter_parameter_values(name) for name in names}\n"
    "print(json.dumps(found))\n"
)


def test_the_table_is_what_a_fresh_process_says():
    done = subprocess.run(
        [sys.executable, "-c", ASK, json.dumps(REMEMBERING)],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    fresh = json.loads(done.stdout)
    assert len(REMEMBERING) == 5
    for name in REMEMBERING:
        for parameter, value in first_defaults(name).items():
            assert fresh[name][parameter] == pytest.approx(value, rel=1e-6)


def other(value):
    return not value if isinstance(value, bool) else type(value)(value * 0.9)


def sphere():
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.create_sphere(subdiv=3)
    return mesh_set


@pytest.mark.parametrize(
    "name", ["meshing_decimation_quadric_edge_collapse", "meshing_isotropic_explicit_remeshing"]
)
def test_a_step_does_not_depend_on_the_one_before(name):
    values = {"targetfacenum": 300} if "decimation" in name else {"targetlen": 0.2}
    first, second, spoiled = sphere(), sphere(), sphere()
    apply_native(first, name, values)
    changed = {key: other(value) for key, value in first_defaults(name).items()}
    spoiled.apply_filter(name, **changed)
    remembered = sphere().filter_parameter_values(name)
    item = find_native(name)
    assert any(remembered[key] != value for key, value in first_defaults(name).items()), item
    apply_native(second, name, values)
    for read in (lambda mesh: mesh.vertex_matrix(), lambda mesh: mesh.face_matrix()):
        np.testing.assert_array_equal(read(first.current_mesh()), read(second.current_mesh()))
