"""A corpus of scripts as people write them: each runs, or is refused for the right reason."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from scripts.documents import DOCUMENTS
from scripts.manifest import CASES, FOLDER, MAPPED, RAN, REFUSALS, RUNS
from scripts.snapshots import assert_equal, assert_same_documents, snapshot
from scripts_by_hand import BY_HAND, SAME_SHAPE, WITH_PLUGINS, same_shape

from meshlab_symrecon import load_plugins, unload_plugins
from meshlab_symrecon.errors import ScriptError, SymReconWarning
from meshlab_symrecon.host.document_state import DocumentState
from meshlab_symrecon.host.mlx import Script
from meshlab_symrecon.host.mlx_reading import read_script
from meshlab_symrecon.host.prediction import after
from meshlab_symrecon.host.resolution import matched
from meshlab_symrecon.host.script import run_script, run_steps


@pytest.fixture(autouse=True)
def _own_folder(tmp_path, monkeypatch):
    """MeshLab writes pictures and temporary files into the current folder."""
    monkeypatch.chdir(tmp_path)


@contextmanager
def quietly() -> Iterator[None]:
    """Steps that warn say so in their notes, too."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SymReconWarning)
        yield


def ran(name, mesh_set, **how):
    with quietly():
        return run_script(mesh_set, FOLDER / f"{name}.mlx", **how)


def test_every_script_has_an_expectation():
    assert sorted(CASES) == sorted(path.stem for path in FOLDER.glob("*.mlx"))
    assert len(CASES) >= 70
    assert {case.document for case in CASES.values()} == set(DOCUMENTS)


@pytest.mark.parametrize("name", RUNS)
def test_a_script_runs_whole(name):
    case = RUNS[name]
    mesh_set = DOCUMENTS[case.document]()
    report = ran(name, mesh_set)
    assert " ".join(step.filter for step in report.steps) == case.steps
    written = read_script(FOLDER / f"{name}.mlx").steps
    assert [step.line for step in report.steps] == [step.line for step in written]
    check_notes(case, report)
    by_line = {step.line: step.measures for step in report.steps}
    for line, measures in case.measures.items():
        assert {key: by_line[line][key] for key in measures} == pytest.approx(measures)
    check_layers(case, mesh_set)


def check_notes(case, report):
    for step in report.steps:
        mapped = case.mapped.get(step.line, ())
        assert step.status == (MAPPED if mapped else RAN), step
        words = (*mapped, *case.remarked.get(step.line, ()))
        assert len(step.notes) == len(words), step
        for wanted, note in zip(words, step.notes, strict=True):
            assert wanted in note


def check_layers(case, mesh_set):
    layers = list(mesh_set)
    assert [layer.label() for layer in layers] == [label for label, _, _ in case.layers]
    for layer, (label, vertices, faces) in zip(layers, case.layers, strict=True):
        if vertices is not None:
            assert (layer.vertex_number(), layer.face_number()) == (vertices, faces), label
    assert mesh_set.current_mesh_id() == layers[case.current].id()


@pytest.mark.parametrize("name", REFUSALS)
def test_a_script_that_cannot_run_is_refused_with_line_and_reason(name):
    case = REFUSALS[name]
    mesh_set = DOCUMENTS[case.document]()
    before = snapshot(mesh_set)
    with pytest.raises(ScriptError) as caught:
        ran(name, mesh_set)
    path = FOLDER / f"{name}.mlx"
    lines = str(caught.value).splitlines()
    assert len(lines) == len(case.refused)
    for line, (number, words) in zip(lines, case.refused.items(), strict=True):
        assert line.startswith(f"{path}:{number}: ")
        assert words in line
    if case.untouched:
        assert_same_documents(snapshot(mesh_set), before)
    else:  # the step itself found it, after those before it
        with pytest.raises(AssertionError):
            assert_same_documents(snapshot(mesh_set), before)


@pytest.mark.parametrize("name", REFUSALS)
def test_a_lenient_run_passes_over_what_cannot_run_and_says_so(name):
    case = REFUSALS[name]
    report = ran(name, DOCUMENTS[case.document](), lenient=True)
    assert [step.status for step in report.steps] == case.lenient.split()
    notes = {step.line: " ".join(step.notes) for step in report.steps}
    everything = " ".join(notes.values())
    for words in case.refused.values():
        assert words in everything


@pytest.mark.parametrize("name", [name for name, case in RUNS.items() if case.mapped])
def test_a_strict_run_refuses_what_would_be_mapped(name):
    case = RUNS[name]
    mesh_set = DOCUMENTS[case.document]()
    before = snapshot(mesh_set)
    with pytest.raises(ScriptError) as caught:
        ran(name, mesh_set, strict=True)
    assert all(line.startswith(f"{FOLDER / name}.mlx:") for line in str(caught.value).splitlines())
    assert_same_documents(snapshot(mesh_set), before)


@pytest.mark.parametrize(
    "name", [name for name, case in RUNS.items() if case.remarked and not case.mapped]
)
def test_a_strict_run_refuses_no_change_of_layer(name):
    check_notes(RUNS[name], ran(name, DOCUMENTS[RUNS[name].document](), strict=True))


@pytest.mark.parametrize("name", BY_HAND)
def test_a_script_does_what_the_same_calls_of_pymeshlab_do(name):
    document = DOCUMENTS[RUNS[name].document]
    by_script, by_hand = document(), document()
    report = ran(name, by_script)
    measured = BY_HAND[name](by_hand)
    got, wanted = snapshot(by_script), snapshot(by_hand)
    if name in SAME_SHAPE:
        same_shape(got, wanted)
        return
    assert_same_documents(got, wanted)
    measures = [dict(step.measures) for step in report.steps if step.measures]
    assert len(measures) == len(measured)
    for one, other in zip(measures, measured, strict=True):
        assert_equal(one, other, "measures")


@pytest.mark.parametrize("name", WITH_PLUGINS)
def test_a_mixed_script_does_what_the_same_methods_do(name):
    document = DOCUMENTS[RUNS[name].document]
    by_script, by_hand = document(), document()
    ran(name, by_script)
    load_plugins()
    try:
        with quietly():
            WITH_PLUGINS[name](by_hand)
    finally:
        unload_plugins()
    assert_same_documents(snapshot(by_script), snapshot(by_hand))


@pytest.mark.parametrize("name", RUNS)
def test_what_is_foreseen_of_each_step_comes_true(name):
    mesh_set = DOCUMENTS[RUNS[name].document]()
    script = read_script(FOLDER / f"{name}.mlx")
    for step, resolved in zip(script.steps, matched(script).steps, strict=True):
        foreseen = after(DocumentState.of(mesh_set), resolved)
        with quietly():
            run_steps(mesh_set, Script(script.path, (step,)))
        check_foreseen(foreseen, DocumentState.of(mesh_set), step)


def check_foreseen(foreseen, came, step):
    assert foreseen.most is None or len(came.layers) <= foreseen.most, step
    assert foreseen.current in (None, came.current), step
    for one, other in zip(foreseen.layers, came.layers, strict=False):
        known = {fact: held for fact, held in one.facts.items() if other.has(fact) is not None}
        assert known == {fact: other.has(fact) for fact in known}, step
        assert one.vertices in (None, other.vertices), step


def test_enough_scripts_are_compared_with_calls_by_hand():
    assert len(BY_HAND) >= 30
    assert len(set(BY_HAND) - set(SAME_SHAPE)) >= 30
