"""Scripts as programs for pymeshlab."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pymeshlab
import pytest

from meshlab_symrecon.host.files import load, save_current
from meshlab_symrecon.host.filter_script import FilterScript
from meshlab_symrecon.host.meshset import read_layer
from meshlab_symrecon.host.mlx import Param, Step
from meshlab_symrecon.host.script import run_script

WHOLE = """# The steps of old.mlx, for pymeshlab.

import sys

import pymeshlab


def apply_script(ms):
    # line 2: 'Quadric Edge Collapse Decimation' is 'Simplification: Quadric Edge Collapse
    # Decimation' today
    # line 3: parameter 'TextureWeight' ignored: it is gone from 'Simplification: Quadric Edge
    # Collapse Decimation'
    ms.meshing_decimation_quadric_edge_collapse(
        targetfacenum=100,
        qualitythr=0.3,
        preserveboundary=False,
        preservenormal=False,
        preservetopology=False,
        optimalplacement=True,
        planarquadric=False,
        planarweight=0.001,
        qualityweight=False,
    )
    # line 6: Compact faces
    # MeshLab does this by itself today
    # line 7: Merge Close Vertices
    ms.meshing_merge_close_vertices(threshold=pymeshlab.PureValue(0.02))
    # line 9: 'Screened Poisson' is 'Surface Reconstruction: Screened Poisson' today
    # the layer that it worked on stays current, as in the MeshLab of such scripts, since the next
    # step deletes the current one
    before = ms.current_mesh_id()
    ms.generate_surface_reconstruction_screened_poisson(depth=4, threads=1)
    ms.set_current_mesh(before)
    # line 11: Delete Current Mesh
    ms.delete_current_mesh()
    # line 12: Change the current layer
    # the current layer changes, by position
    ms.set_current_mesh([mesh.id() for mesh in ms][0])


def main():
    if len(sys.argv) < 3:
        sys.exit(f"usage: python {sys.argv[0]} IN... OUT")
    ms = pymeshlab.MeshSet()
    for path in sys.argv[1:-1]:
        ms.load_new_mesh(path)
    apply_script(ms)
    ms.apply_matrix_freeze()  # files have no place for a layer's matrix
    ms.save_current_mesh(sys.argv[-1])


if __name__ == "__main__":
    main()
"""
OLD = """<FilterScript>
<filter name="Quadric Edge Collapse Decimation">
<Param type="RichFloat" name="TextureWeight" value="1"/>
<Param type="RichInt" name="TargetFaceNum" value="100"/>
</filter>
<filter name="Compact faces"/>
<filter name="Merge Close Vertices"><Param type="RichAbsPerc" name="Threshold" value="0.02"/>
</filter>
<xmlfilter name="Screened Poisson"><xmlparam name="depth" value="4"/>
<xmlparam name="threads" value="1"/></xmlfilter>
<filter name="Delete Current Mesh"/>
<filter name="Change the current layer"><Param type="RichMesh" name="mesh" value="0"/></filter>
</FilterScript>
"""


@pytest.fixture
def old(tmp_path):
    path = tmp_path / "old.mlx"
    path.write_text(OLD.replace('"Screened Poisson"', '"Screened Poisson "'))
    return path


@pytest.fixture
def ball(tmp_path):
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.create_sphere(subdiv=3)
    save_current(mesh_set, tmp_path / "ball.ply")
    return tmp_path / "ball.ply"


def body(script):
    """Return the lines of the steps, without those that name them."""
    lines = script.to_python().partition("def apply_script(ms):\n")[2].partition("\n\n\n")[0]
    return [line[4:] for line in lines.splitlines() if not line.startswith("    #")]


def test_a_whole_program(old):
    assert FilterScript.read(old).to_python() == WHOLE


def test_the_program_does_to_files_what_the_script_does(old, ball, tmp_path):
    turned = FilterScript.read(old).with_step("compute_matrix_from_rotation", angle=30.0)
    turned.write(tmp_path / "turned.mlx")
    (tmp_path / "same.py").write_text(turned.to_python())
    command = [sys.executable, "same.py", ball.name, "made.ply"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    by_script = load(ball)
    run_script(by_script, tmp_path / "turned.mlx")
    expected = read_layer(by_script, by_script.current_mesh_id())
    made = read_layer(load(tmp_path / "made.ply"), 0)
    assert np.array_equal(made.faces, expected.faces)
    np.testing.assert_allclose(made.points, expected.points, rtol=0, atol=1e-6)
    done = subprocess.run(command[:2], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert done.stderr == "usage: python same.py IN... OUT\n"


def test_an_empty_script_is_a_program():
    names = {"__name__": "generated"}
    exec(FilterScript().to_python(), names)
    assert names["apply_script"](None) is None
    nothing = FilterScript((Step("Compact faces", 0),)).to_python()
    exec(nothing, names)
    assert names["apply_script"](None) is None


@pytest.mark.parametrize(
    ("name", "values", "line"),
    [
        ("set_color_per_vertex", {"color1": (255, 0, 9)},
         "ms.set_color_per_vertex(color1=pymeshlab.Color(255, 0, 9, 255))"),
        ("meshing_merge_close_vertices", {"threshold": pymeshlab.PercentageValue(2.5)},
         "ms.meshing_merge_close_vertices(threshold=pymeshlab.PercentageValue(2.5))"),
        ("compute_matrix_from_rotation", {"customaxis": (0, 0.1, 1)},
         "ms.compute_matrix_from_rotation(customaxis=np.array([0.0, 0.1, 1.0]))"),
        ("set_mesh_name", {"newname": 'the "head"'}, "ms.set_mesh_name(newname='the \"head\"')"),
        ("set_mesh_name", {"newname": "Kopf's\n"}, 'ms.set_mesh_name(newname="Kopf\'s\\n")'),
        ("set_mesh_name", {"newname": "größe"}, 'ms.set_mesh_name(newname="größe")'),
        ("get_hausdorff_distance", {"sampledmesh": 1},
         "ms.get_hausdorff_distance(sampledmesh=[mesh.id() for mesh in ms][1])"),
    ],
)  # fmt: skip
def test_values_as_they_are_written(name, values, line):
    assert body(FilterScript().with_step(name, **values)) == [line]


def test_what_would_delete_a_cloud_is_marked():
    lines = FilterScript().with_step("meshing_remove_unreferenced_vertices").to_python()
    warning = "    # beware: it deletes every point of a cloud without faces\n"
    assert f"{warning}    ms.meshing_remove_unreferenced_vertices()\n" in lines


def test_long_texts_are_cut_and_stay_equal():
    text = "x*" + "'\\\n\"" * 60
    program = FilterScript().with_step("compute_scalar_by_function_per_vertex", q=text).to_python()
    assert max(map(len, program.splitlines())) <= 100

    class Recorder:
        def compute_scalar_by_function_per_vertex(self, q):
            self.q = q

    names, recorder = {"__name__": "generated"}, Recorder()
    exec(program, names)
    names["apply_script"](recorder)
    assert recorder.q == text


def test_a_matrix_has_a_line_for_each_row():
    values = np.arange(16.0).reshape(4, 4)
    lines = body(FilterScript().with_step("set_matrix", transformmatrix=values))
    assert lines[0] == "ms.set_matrix("
    (array,) = (line for line in lines if line.strip().startswith("transformmatrix=np.array("))
    assert array == "    transformmatrix=np.array("
    assert "            [4.0, 5.0, 6.0, 7.0]," in lines
    assert np.array_equal(eval("".join(lines[1:-1]).strip().removeprefix("transformmatrix=")
                               .removesuffix(","), {"np": np}), values)  # fmt: skip


def test_layers_of_plugins_are_positions_too(installed):
    script = FilterScript().with_step("generate_grown_points", factor=1.5)
    text = script.to_python()
    assert "\nimport meshlab_symrecon\n" in text
    assert body(script)[0] == "meshlab_symrecon.load_plugins()"
    assert body(script)[1].startswith("ms.generate_grown_points(")


def test_names_cannot_leave_their_comment():
    name = "Compact\x85faces\nimport os\r#"
    step = Step("Close Holes", 0, (Param(name, 0, "RichInt", "1"),))
    text = FilterScript((step,)).to_python(lenient=True)
    assert "import os" in text
    assert all(line.lstrip().startswith("#") for line in text.splitlines() if "import os" in line)
    compile(text, "generated", "exec")


@pytest.mark.parametrize("faces", [True, False])
def test_what_an_old_parameter_selected_is_selected_where_there_are_faces(faces):
    step = Step("Conditional Vertex Selection", 0, (
        Param("condSelect", 0, "RichString", "(z > 0.1)"),
        Param("strictSelect", 0, "RichBool", "true"),
    ))  # fmt: skip
    mesh_set = pymeshlab.MeshSet(verbose=False)
    if faces:
        mesh_set.create_sphere(subdiv=2)
    else:
        mesh_set.create_sphere_points(pointnum=60)
    names = {"__name__": "generated"}
    exec(compile(FilterScript((step,)).to_python(), "made.py", "exec"), names)
    names["apply_script"](mesh_set)
    mesh = mesh_set.current_mesh()
    assert mesh.selected_vertex_number() == np.count_nonzero(mesh.vertex_matrix()[:, 2] > 0.1) > 0
    above = (mesh.vertex_matrix()[:, 2] > 0.1)[mesh.face_matrix()].all(axis=1) if faces else []
    assert mesh.selected_face_number() == np.count_nonzero(above)
