"""What a result's file says of how it came about."""

from __future__ import annotations

import hashlib
import json
import platform
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pymeshlab
import pytest

from meshlab_symrecon.errors import FileError, SymReconWarning
from meshlab_symrecon.host import history, record_text
from meshlab_symrecon.host.file_job import Manner, run_on_files
from meshlab_symrecon.host.files import load, new_document, save_current
from meshlab_symrecon.host.meshset import add_layer, read_layer
from meshlab_symrecon.host.projects import save_project
from meshlab_symrecon.host.records import Input, Record, Step, read_record, record_of, versions
from meshlab_symrecon.host.registration import apply_filter
from meshlab_symrecon.plugin import Layer
from meshlab_symrecon.plugin.filter import silent

SIMPLIFY = "generate_simplified_points"
NORMALS = "compute_normal_for_point_clouds"
USED = {
    name: version(name) for name in ("meshlab_symrecon", "pymeshlab", "numpy", "scipy")
} | {"scikit-learn": version("scikit-learn")}  # fmt: skip
NASTY = (
    "scan.ply",
    "end_header.ply",
    "two\nend_header\nlines.ply",
    "äöü 漢字 🗿.ply",
    '\'quotes\' "and" \\ {"name": 1}.ply',
    "two  spaces .ply",
    "\udce4 of another encoding.ply",
    "long" * 60 + ".ply",
)


def cloud(count: int = 300, seed: int = 0) -> Layer:
    generator = np.random.default_rng(seed)
    points = generator.normal(size=(count, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    return Layer(points=points, faces=np.zeros((0, 3), dtype=np.int64), label="cloud")


def document(layer: Layer | None = None):
    mesh_set = new_document()
    add_layer(mesh_set, cloud() if layer is None else layer, current=True)
    return mesh_set


def saved(path: Path, mesh_set=None, record: Record | None = None) -> Path:
    save_current(document() if mesh_set is None else mesh_set, path, record)
    return path


def header_lines(path: Path) -> list[bytes]:
    """Read a header as the simplest of readers do: to the first line that is its end."""
    header, found, _ = path.read_bytes().partition(b"end_header\n")
    assert found
    return header.split(b"\n")


def many_steps(count: int) -> tuple[history.Step, ...]:
    def step(number: int) -> history.Step:
        return history.Step(
            "Simplify Points (AP)", ({"type": "RichInt", "name": "count", "value": str(number)},)
        )

    return tuple(step(number) for number in range(1, count + 1))


def test_a_record_says_versions_inputs_and_every_parameter(tmp_path):
    scan = saved(tmp_path / "scan.ply")
    mesh_set = load(scan)
    apply_filter(mesh_set, NORMALS, k=12)
    apply_filter(mesh_set, SIMPLIFY, detail=0.1, count=20)
    record = record_of(mesh_set, [scan], {"paint": True, "tilt": 0.1})
    digest = hashlib.sha256(scan.read_bytes()).hexdigest()
    normals = {"k": 12, "smoothiter": 0, "flipflag": False, "viewpos": [0.0, 0.0, 0.0]}
    simplified = {
        "count": 20, "percentage": 10.0, "preference": 0.0, "detail": 0.1, "onlyselected": False,
    }  # fmt: skip
    assert record == Record(
        versions=USED,
        inputs=(Input("scan.ply", digest),),
        parameters={"paint": True, "tilt": 0.1},
        steps=(Step(NORMALS, normals), Step(SIMPLIFY, simplified)),
    )
    assert read_record(saved(tmp_path / "out.ply", mesh_set, record)) == record


def test_the_steps_of_a_record_give_the_same_file_again(tmp_path):
    scan = saved(tmp_path / "scan.ply", document(cloud(600)))
    mesh_set = load(scan)
    apply_filter(mesh_set, "generate_reflection_planes", randomseed=5, maxplanes=1)
    apply_filter(mesh_set, "generate_surface_reconstruction_power_crust")
    apply_filter(
        mesh_set, "meshing_decimation_quadric_edge_collapse", targetfacenum=200, planarweight=1e-3
    )
    apply_filter(
        mesh_set, "generate_resampled_uniform_mesh", cellsize=pymeshlab.PercentageValue(7.3)
    )
    first = saved(tmp_path / "first.ply", mesh_set, record_of(mesh_set, [scan]))
    again = load(scan)
    record = read_record(first)
    assert record.steps[0].parameters["randomseed"] == 5
    for step in record.steps:
        apply_filter(again, step.filter, **step.parameters)
    second = saved(tmp_path / "second.ply", again, record_of(again, [scan]))
    assert first.read_bytes() == second.read_bytes()


@pytest.mark.parametrize("name", NASTY, ids=ascii)
def test_any_name_of_an_input_comes_back_and_hurts_no_reader(tmp_path, name):
    folder = tmp_path / "private"
    folder.mkdir()
    try:
        scan = saved(tmp_path / "plain.ply").rename(folder / name)
    except (OSError, ValueError):
        pytest.skip("the file system takes no such name")
    mesh_set = document()
    record = record_of(mesh_set, [scan], {"note": f"end_header\n{name}"})
    out = saved(tmp_path / "out.ply", mesh_set, record)
    bare = saved(tmp_path / "bare.ply", mesh_set)
    assert read_record(out) == record
    assert record.inputs[0].name == name
    assert record.parameters["note"] == f"end_header\n{name}"
    lines = header_lines(out)
    assert lines[:2] == header_lines(bare)[:2]
    assert [line for line in lines if not line.startswith(record_text.MARK)] == header_lines(bare)
    assert all(len(line) <= 400 for line in lines)
    assert all(32 <= byte < 127 for line in lines for byte in line)
    assert b"private" not in out.read_bytes()
    assert out.read_bytes().count(b"end_header") == 1


def test_the_data_are_those_of_a_file_without_record(tmp_path):
    generator = np.random.default_rng(3)
    mesh_set = document(
        Layer(
            points=generator.normal(size=(50, 3)) * 1e5,
            faces=np.array([[0, 1, 2], [2, 1, 3]]),
            label="all",
            quality=generator.normal(size=50),
            colours=generator.integers(0, 256, size=(50, 4)) / 255.0,
            attributes={"mirrored": generator.normal(size=50)},
        )
    )
    out = saved(tmp_path / "out.ply", mesh_set, record_of(mesh_set, []))
    bare = saved(tmp_path / "bare.ply", mesh_set)
    tail = [path.read_bytes().partition(b"end_header\n")[2] for path in (out, bare)]
    assert tail[0] == tail[1]
    ours = read_layer(load(out), 0)
    theirs = pymeshlab.MeshSet(verbose=False)
    theirs.load_new_mesh(str(out))
    written = read_layer(mesh_set, 0)
    np.testing.assert_array_equal(theirs.current_mesh().vertex_matrix(), written.points)
    np.testing.assert_array_equal(theirs.current_mesh().vertex_scalar_array(), written.quality)
    np.testing.assert_array_equal(theirs.current_mesh().face_matrix(), written.faces)
    np.testing.assert_array_equal(ours.points, written.points)
    np.testing.assert_array_equal(ours.colours, written.colours)
    np.testing.assert_array_equal(ours.attributes["mirrored"], written.attributes["mirrored"])


def test_what_a_result_was_made_from_keeps_its_own_record(tmp_path):
    scan = saved(tmp_path / "scan.ply")
    first = load(scan)
    apply_filter(first, NORMALS)
    completed = saved(tmp_path / "completed.ply", first, record_of(first, [scan]))
    second = load(completed)
    apply_filter(second, "generate_surface_reconstruction_power_crust")
    record = read_record(saved(tmp_path / "crust.ply", second, record_of(second, [completed])))
    assert [step.filter for step in record.steps] == ["generate_surface_reconstruction_power_crust"]
    assert record.inputs[0].record == read_record(completed)
    assert record.inputs[0].record.inputs[0].name == "scan.ply"


def test_a_long_row_of_results_stays_readable(tmp_path):
    path = saved(tmp_path / "0.ply")
    for number in range(1, 20):
        mesh_set = load(path)
        record = record_of(mesh_set, [path])
        path = saved(tmp_path / f"{number}.ply", mesh_set, record)
    names = []
    record = read_record(path)
    while record is not None and record.inputs:
        names.append(record.inputs[0].name)
        last, record = record, record.inputs[0].record
    assert names == [f"{number}.ply" for number in range(18, 2, -1)]
    assert last.left_out == {"records": 1}


@pytest.mark.parametrize("count", [20, 1000])
def test_the_latest_of_many_steps_have_room(tmp_path, count):
    mesh_set = document()
    history.restore(mesh_set, many_steps(count))
    out = saved(tmp_path / "out.ply", mesh_set, record_of(mesh_set, []))
    record = read_record(out)
    counts = [step.parameters["count"] for step in record.steps]
    lost = record.left_out.get("steps", 0)
    assert counts == list(range(lost + 1, count + 1))
    assert bool(lost) == (count == 1000)
    assert len(counts) >= min(count, 250)
    assert len(b"\n".join(header_lines(out))) < 1.2 * record_text.TEXT_LIMIT
    theirs = pymeshlab.MeshSet(verbose=False)
    theirs.load_new_mesh(str(out))
    np.testing.assert_array_equal(theirs.current_mesh().vertex_matrix(), cloud().points)


@pytest.mark.parametrize(
    ("record", "left_out"),
    [
        (Record(USED, parameters={"text": "x" * 10**6}), {"parameters": 1}),
        (Record(USED, steps=(Step("x", {"text": "end_header " * 10**5}),)), {"steps": 1}),
        (
            Record(USED, inputs=(Input("a", "b", Record({}, parameters={"text": "x" * 10**6})),)),
            {"records": 1},
        ),
    ],
    ids=["parameters", "steps", "records"],
)
def test_what_has_no_room_is_counted(record, left_out):
    text = record_text.record_text(record)
    assert len(text) <= record_text.TEXT_LIMIT
    assert json.loads(text)["left_out"] == left_out
    assert json.loads(text)["versions"] == USED


def test_thousands_of_inputs_are_counted():
    inputs = tuple(Input(f"{number}.ply", "0" * 64) for number in range(5000))
    data = json.loads(record_text.record_text(Record(USED, inputs=inputs)))
    assert len(data["inputs"]) + data["left_out"]["inputs"] == 5000
    assert data["inputs"][0]["name"] == "0.ply"


def test_files_are_recorded_without_their_folders():
    mesh_set = document()
    values = ("/home/somebody/picture.png", "C:\\Users\\somebody\\picture.png")
    parameters = tuple(
        {"type": "RichOpenFile", "name": f"file{number}", "value": value, "exts_cardinality": "0"}
        for number, value in enumerate(values)
    )
    history.restore(mesh_set, [history.Step("Set Texture", parameters)])
    step = record_of(mesh_set, []).steps[0]
    assert set(step.parameters.values()) == {"picture.png"}


def test_every_type_of_value_is_told_as_python_has_it():
    mesh_set = document()
    colour = {"type": "RichColor", "name": "Colour", "r": "1", "g": "2", "b": "3", "a": "255"}
    choice = {
        "type": "RichEnum", "name": "Choice", "value": "1", "enum_cardinality": "2",
        "enum_val0": "plain", "enum_val1": "loud",
    }  # fmt: skip
    length = {"type": "RichAbsPerc", "name": "Length", "value": "0.5", "min": "0", "max": "2"}
    flag = {"type": "RichBool", "name": "lambda", "value": "true"}
    endless = {"type": "RichFloat", "name": "Endless", "value": "inf"}
    words = {"type": "RichString", "name": "Words", "value": "12"}
    kinds = (colour, choice, length, flag, endless, words)
    history.restore(mesh_set, [history.Step("Of nobody", kinds)])
    assert record_of(mesh_set, []).steps == (
        Step(
            "Of nobody",
            {
                "colour": [1, 2, 3, 255], "choice": "loud", "length": 0.5, "lambda_": True,
                "endless": "inf", "words": "12",
            },
        ),
    )  # fmt: skip


def test_settings_become_plain_data():
    settings = {"array": np.eye(2), "path": Path("a"), "nan": float("nan"), "list": (None, {1: 2})}
    assert record_of(document(), [], settings).parameters == {
        "array": [[1.0, 0.0], [0.0, 1.0]], "path": "a", "nan": "nan", "list": [None, {"1": 2}],
    }  # fmt: skip


def test_every_layer_of_a_project_has_the_record(tmp_path):
    mesh_set = document()
    apply_filter(mesh_set, SIMPLIFY)
    record = record_of(mesh_set, [])
    save_project(mesh_set, tmp_path / "all.mlp", record=record)
    written = sorted(tmp_path.glob("*.ply"))
    assert len(written) == 2
    assert [read_record(path) for path in written] == [record, record]


@pytest.mark.parametrize("isolate", [False, True])
def test_a_script_leaves_its_steps(tmp_path, isolate):
    scan = saved(tmp_path / "scan.ply")
    script = tmp_path / "script.mlx"
    script.write_text(
        "<FilterScript><filter name='Simplify Points (AP)'>"
        "<Param type='RichInt' name='count' value='17'/></filter></FilterScript>"
    )
    out = tmp_path / "out.ply"
    run_on_files(script, [scan], out, manner=Manner(isolate=isolate), progress=silent)
    record = read_record(out)
    assert [item.name for item in record.inputs] == ["scan.ply"]
    assert [step.filter for step in record.steps] == [SIMPLIFY]
    assert record.steps[0].parameters["count"] == 17


def test_other_formats_and_plain_files_have_no_record(tmp_path):
    mesh_set = document()
    record = record_of(mesh_set, [])
    assert read_record(saved(tmp_path / "bare.ply", mesh_set)) is None
    assert read_record(saved(tmp_path / "out.xyz", mesh_set, record)) is None


DAMAGED = (
    '{"layout":1',
    "[]",
    '"text"',
    "é",
    '{"versions":{},"inputs":[],"parameters":{"x":1e999},"steps":[],"left_out":{}}',
    '{"versions":{},"inputs":[],"parameters":{"x":NaN},"steps":[],"left_out":{}}',
    '{"versions":{"a":1},"inputs":[],"parameters":{},"steps":[],"left_out":{}}',
    '{"versions":{},"inputs":[],"parameters":{},"steps":[{"filter":1}],"left_out":{}}',
    '{"versions":{},"inputs":[],"parameters":{},"steps":[],"left_out":{"steps":[]}}',
    "[" * 10**5,
    '{"versions":{},"parameters":{},"steps":[],"left_out":{},"inputs":[{"name":"","sha256":"",'
    '"record":' * 17 + "0" + "}]}" * 17,
)


@pytest.mark.parametrize("text", DAMAGED, ids=lambda text: ascii(text[:40]))
def test_a_damaged_record_is_told_and_does_not_go_along(tmp_path, text):
    path = saved(tmp_path / "scan.ply")
    data = path.read_bytes()
    line = record_text.MARK + text.encode() + b"\n"
    path.write_bytes(data.replace(b"comment VCGLIB", line + b"comment VCGLIB", 1))
    with pytest.raises(FileError, match=r"scan.ply: the record in its header is damaged"):
        read_record(path)
    with pytest.warns(SymReconWarning, match=r"damaged.*does not go along"):
        record = record_of(document(), [path])
    assert record.inputs[0].record is None


def test_files_that_are_not_there(tmp_path):
    with pytest.raises(FileError, match=r"cannot be read: .*; check its path"):
        read_record(tmp_path / "none.ply")
    with pytest.raises(FileError, match=r"cannot be read: .*; check its path"):
        record_of(document(), [tmp_path / "none.ply"])


def test_a_file_without_an_end_is_read_to_a_limit(tmp_path):
    path = tmp_path / "endless.ply"
    path.write_bytes(b"ply\n" + b"comment x\n" * 300_000 + record_text.MARK + b"{\nend_header\n")
    assert read_record(path) is None


def test_versions_are_those_installed():
    assert versions() == USED | {"python": platform.python_version()}
