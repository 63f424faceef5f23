"""A result made again from what the JSON says alone."""

from __future__ import annotations

import json

import numpy as np
import pytest

from meshlab_symrecon import FilterScript
from meshlab_symrecon.host.files import load
from meshlab_symrecon.host.meshset import read_layer
from meshlab_symrecon.host.native_filters import native_filters
from meshlab_symrecon.host.records import read_record, versions
from meshlab_symrecon.host.registration import registry

THIRD = 1.0 / 3.0  # more digits than MeshLab's own history keeps
OURS = {
    "generate_reflection_planes": ("--maxplanes", 2, "--seed", 5),
    "generate_mirror_completed_points": ("--planes", 0),
    "generate_surface_reconstruction_power_crust": ("--medialaxis", "true"),
    "compute_scalar_by_mirror_symmetry_per_vertex": ("--planes", 0),
    "generate_simplified_points": ("--percentage", 7 * THIRD),
}
NATIVE = {
    "generate_resampled_uniform_mesh": ("--cellsize", "7.3%", "--offset", "50.3%"),
    "apply_coord_random_displacement": ("--randomseed", 9, "--displacement", "3.3%"),
    "compute_matrix_from_rotation": (
        "--rotaxis", "custom axis", "--customaxis", "0.1 0.7 -0.3", "--angle", 100 * THIRD,
    ),
    "meshing_merge_close_vertices": ("--threshold", THIRD / 10),
    "generate_surface_reconstruction_screened_poisson": ("--depth", 4, "--scale", 1.0 + THIRD),
    "meshing_decimation_quadric_edge_collapse": ("--targetfacenum", 60, "--planarweight", THIRD),
    "compute_coord_by_function": ("--x", "x + 0.1*y", "--z", "z/3"),
}  # fmt: skip
WITH_PLANES = "compute_scalar_by_mirror_symmetry_per_vertex", "generate_mirror_completed_points"


def strict(path):
    """Read JSON that may hold no NaN and no Infinity."""

    def refuse(word):
        raise AssertionError(f"{word} is no JSON")

    return json.loads(path.read_text(encoding="utf-8"), parse_constant=refuse)


@pytest.fixture
def inputs(run, statue, tmp_path):
    """What a filter is given: planes and a statue, a statue, or a sphere."""
    sphere, planes = tmp_path / "sphere.ply", tmp_path / "planes.ply"

    def of(name):
        if name in NATIVE:
            assert run("apply", "create_sphere", "-o", sphere, "--subdiv", 3).exit_code == 0
            return (sphere,)
        if name not in WITH_PLANES:
            return (statue,)
        assert run("apply", "detect_reflection_planes", statue, "-o", planes).exit_code == 0
        return planes, statue

    return of


def words_of(parameters):
    """Return the options of a command line for recorded parameters."""
    words = []
    for name, value in parameters.items():
        text = " ".join(map(repr, value)) if isinstance(value, list) else str(value)
        flag = "parameter-threads" if name == "threads" else name.strip("_")
        words.append(f"--{flag}={text}")
    return words


@pytest.mark.parametrize("name", [*OURS, *NATIVE])
def test_the_same_bytes_from_filter_and_parameters_alone(run, inputs, tmp_path, name):
    given = inputs(name)
    report = tmp_path / "r.json"

    def done(out, *command):
        result = run(*command[:2], *given, "-o", tmp_path / out, "--json", report, *command[2:])
        assert result.exit_code == 0, result.stderr
        return strict(report)

    first = done("a.ply", "apply", name, *(OURS | NATIVE)[name])
    assert first["filter"] == name
    assert first["versions"] == versions()
    item = registry().find(name) if name in OURS else native_filters()[name]
    declared = item.parameters.declared() if name in OURS else item.parameters
    assert list(first["parameters"]) == [known.name for known in declared]
    again = done("b.ply", "apply", first["filter"], *words_of(first["parameters"]))
    assert {**again, "seconds": None} == {**first, "seconds": None}
    script = tmp_path / "again.mlx"
    FilterScript().with_step(first["filter"], **first["parameters"]).write(script)
    # A detection leaves the scan current, so that all layers are saved.
    out = "c.mlp" if name == "generate_reflection_planes" else "c.ply"
    (step,) = done(out, "run", script)["steps"]
    assert (step["filter"], step["parameters"]) == (name, first["parameters"])
    by_script = sorted(tmp_path.glob("c*.ply"))[0]
    outputs = [(tmp_path / file).read_bytes() for file in ("a.ply", "b.ply", by_script)]
    assert outputs[0] == outputs[1] == outputs[2]
    recorded = read_record(tmp_path / "a.ply").steps[-1]
    assert (recorded.filter, recorded.parameters) == (name, first["parameters"])


def test_what_was_given_is_among_what_is_told(run, inputs, tmp_path):
    report = tmp_path / "r.json"
    (scan,) = inputs("generate_reflection_planes")
    words = ("apply", "detect_reflection_planes", scan, "--json", report)
    assert run(*words, "--seed", 5, "--minconfidence", 0.25, "--max-points", 900).exit_code == 0
    data = strict(report)
    assert list(data) == ["planes", "converged", "filter", "parameters", "versions", "max_points"]
    assert data["parameters"]["randomseed"] == 5
    assert data["parameters"]["minconfidence"] == 0.25
    assert data["max_points"] == 900


@pytest.mark.parametrize("isolate", [(), ("--isolate",)])
def test_a_script_without_parameters_is_told_with_all_of_them(run, inputs, tmp_path, isolate):
    (scan,) = inputs("generate_simplified_points")
    script, out, report = (tmp_path / name for name in ("s.mlx", "o.stl", "r.json"))
    script.write_text(
        '<FilterScript><filter name="Simplify Points (AP)"/><filter name="Convex Hull"/>'
        '<filter name="Compact vertices"/><filter name="Change the current layer">'
        '<Param type="RichMesh" name="mesh" value="0"/></filter>'
        '<filter name="generate_surface_reconstruction_ball_pivoting">'
        '<Param type="RichAbsPerc" name="BallRadius" value="5%"/></filter></FilterScript>'
    )
    result = run("run", script, scan, "-o", out, "--json", report, *isolate)
    assert result.exit_code == 0, result.stderr
    data = strict(report)
    assert data["versions"] == versions()
    simplified, hull, nothing, change, pivoted = (step["parameters"] for step in data["steps"])
    simplify = registry().find("generate_simplified_points")
    assert simplified == simplify.bind({}).values()
    assert (hull, nothing, change) == ({}, {}, {"mesh": 0})
    diagonal = np.linalg.norm(np.ptp(read_layer(load(scan), 0).points, axis=0))
    assert pivoted["ballradius"] == pytest.approx(0.05 * diagonal, rel=1e-6)
    assert set(pivoted) == {"ballradius", "clustering", "creasethr", "deletefaces"}


def test_skipped_steps_ran_with_nothing(run, inputs, tmp_path):
    (scan,) = inputs("generate_simplified_points")
    script, report = tmp_path / "s.mlx", tmp_path / "r.json"
    script.write_text(
        '<FilterScript><filter name="No Such Filter"/>'
        '<filter name="Remove Unreferenced Vertices"/></FilterScript>'
    )
    words = ("run", script, scan, "-o", tmp_path / "o.ply", "--json", report, "--lenient")
    assert run(*words).exit_code == 0
    steps = strict(report)["steps"]
    assert [step["status"] for step in steps] == ["skipped"] * 2
    assert [step["parameters"] for step in steps] == [{}, {}]


def test_what_an_old_parameter_stood_for_is_told_with_its_own(run, inputs, tmp_path):
    (sphere,) = inputs("meshing_merge_close_vertices")
    script, report = tmp_path / "s.mlx", tmp_path / "r.json"
    script.write_text(
        '<FilterScript><filter name="Conditional Vertex Selection">'
        '<Param type="RichString" name="condSelect" value="(z &gt; 0)"/>'
        '<Param type="RichBool" name="strictSelect" value="true"/></filter></FilterScript>'
    )
    result = run("run", script, sphere, "-o", tmp_path / "o.ply", "--json", report)
    assert result.exit_code == 0, result.stderr
    (step,) = strict(report)["steps"]
    assert step["parameters"] == {"condselect": "(z > 0)"}
    assert step["then"] == {
        "filter": "compute_selection_transfer_vertex_to_face", "parameters": {"inclusive": True},
    }  # fmt: skip


@pytest.mark.parametrize("name", ["get_geometric_measures", "get_topological_measures"])
def test_measures_have_no_name_of_what_is_beside_them(run, inputs, tmp_path, name):
    report = tmp_path / "r.json"
    result = run("apply", name, *inputs(next(iter(NATIVE))), "--json", report)
    assert result.exit_code == 0, result.stderr
    data = strict(report)
    beside = {"filter": name, "parameters": {}, "versions": versions()}
    assert {key: data[key] for key in beside} == beside
    assert set(data) > set(beside)


def test_a_measure_wins_over_what_is_beside_it(run, inputs, tmp_path, monkeypatch):
    monkeypatch.setattr(
        "meshlab_symrecon.host.registration.apply_filter", lambda *_, **__: {"filter": 0.5}
    )
    report = tmp_path / "r.json"
    words = ("apply", "get_geometric_measures", *inputs("generate_simplified_points"))
    assert run(*words, "--json", report).exit_code == 0
    assert strict(report) == {"filter": 0.5, "parameters": {}, "versions": versions()}


def test_a_batch_tells_what_each_step_ran_with(run, inputs, tmp_path):
    (scan,) = inputs("generate_simplified_points")
    script = tmp_path / "s.mlx"
    script.write_text('<FilterScript><filter name="Simplify Points (AP)"/></FilterScript>')
    report, out = tmp_path / "r.json", tmp_path / "out"
    result = run("batch", script, scan, "-d", out, "--json", report, "--name", "{stem}.xyz")
    assert result.exit_code == 0, result.stderr
    logged = json.loads((out / "batch.jsonl").read_text(encoding="utf-8"))
    expected = registry().find("generate_simplified_points").bind({}).values()
    assert logged["steps"][0]["parameters"] == expected
    assert strict(report)["scans"][0]["steps"] == logged["steps"]
