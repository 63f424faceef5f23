"""Plugin filters on MeshSets: everywhere pymeshlab's own filters are, and gone afterwards."""

from __future__ import annotations

import inspect
import re
import subprocess
import sys
import threading
from dataclasses import replace

import numpy as np
import pymeshlab
import pytest

import meshlab_symrecon
from meshlab_symrecon.errors import (
    GeometryError,
    HostError,
    ParameterError,
    PluginError,
    SymReconWarning,
    UnknownFilterError,
)
from meshlab_symrecon.host import registration, steps
from meshlab_symrecon.host.history import read_history
from meshlab_symrecon.plugin import Outcome
from meshlab_symrecon.plugin.registry import PluginFailure, installed_filters

LISTS = ("filter_list", "print_filter_list", "print_filter_parameter_list", "search")
NAMES = ("generate_grown_points", "grow_points", "Grow Points")
BROKEN = PluginFailure("rotten_apple", "plugin 'rotten_apple = x:y' cannot be imported: E: no")


def everything_touched():
    return dict(vars(pymeshlab.MeshSet)), {name: getattr(pymeshlab, name) for name in LISTS}


def assert_same_objects(before, after):
    for one, other in zip(before, after, strict=True):
        assert one.keys() == other.keys()
        assert all(one[name] is other[name] for name in one)


# --- without touching pymeshlab -------------------------------------------------------------------


@pytest.mark.parametrize("name", [*NAMES, "  grow   POINTS "])
def test_apply_filter_knows_every_name_and_patches_nothing(installed, cloud_set, points, name):
    before = everything_touched()
    measures = meshlab_symrecon.apply_filter(cloud_set, name, factor=3.0)
    assert_same_objects(before, everything_touched())
    assert measures["factor"] == 3.0
    np.testing.assert_array_equal(measures["centre"], (3.0 * points).mean(axis=0))
    np.testing.assert_array_equal(cloud_set.current_mesh().vertex_matrix(), 3.0 * points)


def test_the_input_layer_is_left_alone(installed, cloud_set, points):
    meshlab_symrecon.apply_filter(cloud_set, "grow_points")
    np.testing.assert_array_equal(cloud_set.mesh(0).vertex_matrix(), points)
    assert [mesh.label() for mesh in cloud_set] == ["scan", "grown"]


def test_a_filter_may_leave_the_current_layer_current(installed, cloud_set):
    meshlab_symrecon.apply_filter(cloud_set, "grow_points", keep=True)
    assert (cloud_set.current_mesh_id(), cloud_set.mesh_number()) == (0, 2)


def test_several_layers_come_in_order_and_the_chosen_one_is_current(
    install, cloud_set, grow_filter
):
    def run(layers, parameters, progress):
        made = tuple(replace(layers.current, label=label) for label in ("a", "b", "c"))
        return Outcome(layers=made, current=1)

    install(replace(grow_filter, run=run))
    meshlab_symrecon.apply_filter(cloud_set, "grow_points")
    assert [mesh.label() for mesh in cloud_set] == ["scan", "a", "b", "c"]
    assert cloud_set.current_mesh().label() == "b"


def test_a_filter_that_chooses_a_layer_it_did_not_make_is_refused(install, cloud_set, grow_filter):
    def run(layers, parameters, progress):
        return Outcome(layers=(layers.current,), current=1)

    install(replace(grow_filter, run=run))
    with pytest.raises(HostError, match="made 1 layers and wants number 1 to be the current one"):
        meshlab_symrecon.apply_filter(cloud_set, "grow_points")
    assert cloud_set.mesh_number() == 1


def test_layers_are_added_all_or_none(install, cloud_set, grow_filter):
    def run(layers, parameters, progress):
        empty = replace(layers.current, points=np.zeros((0, 3)), label="void")
        return Outcome(layers=(layers.current, empty))

    install(replace(grow_filter, run=run))
    with pytest.raises(HostError, match="layer 'void' cannot be added"):
        meshlab_symrecon.apply_filter(cloud_set, "grow_points")
    assert cloud_set.mesh_number() == 1
    assert read_history(cloud_set) == ()


def test_progress_is_heard(installed, cloud_set):
    heard = []
    meshlab_symrecon.apply_filter(
        cloud_set, "grow_points", progress=lambda *news: heard.append(news)
    )
    assert heard == [(1.0, "grown"), (1.0, "adding layers")]


def test_progress_of_a_native_filter_is_its_start_and_its_end(installed, cloud_set):
    heard = []
    meshlab_symrecon.apply_filter(
        cloud_set, "create_cube", progress=lambda *news: heard.append(news)
    )
    assert heard == [(0.0, "Box/Cube"), (1.0, "Box/Cube")]


def test_nothing_measured_is_an_empty_dict(installed, cloud_set):
    assert meshlab_symrecon.apply_filter(cloud_set, "apply_nothing") == {}


@pytest.mark.parametrize("name", ["create_cube", "Box/Cube", " box/CUBE"])
def test_native_filters_run_by_python_and_menu_name(installed, cloud_set, name):
    assert meshlab_symrecon.apply_filter(cloud_set, name, size=2.0) == {}
    assert np.ptp(cloud_set.current_mesh().vertex_matrix(), axis=0).tolist() == [2.0] * 3


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("grow_pionts", "did you mean 'grow_points'"),
        ("create_cubbe", "did you mean 'create_cube'"),
    ],
)
def test_an_unknown_name_is_answered_with_the_nearest_one(installed, cloud_set, name, hint):
    with pytest.raises(UnknownFilterError, match=hint):
        meshlab_symrecon.apply_filter(cloud_set, name)


def test_errors_of_parameters_and_geometry_come_out_as_they_are(installed, cloud_set):
    with pytest.raises(ParameterError, match="parameter 'factor' must be a number of at least 0"):
        meshlab_symrecon.apply_filter(cloud_set, "grow_points", factor=-1.0)
    with pytest.raises(GeometryError, match="got an empty document"):
        meshlab_symrecon.apply_filter(pymeshlab.MeshSet(verbose=False), "grow_points")
    assert read_history(cloud_set) == ()


def test_warnings_point_at_the_line_of_the_user(installed, cloud_set):
    with pytest.warns(SymReconWarning, match="^it is loud$") as caught:
        meshlab_symrecon.apply_filter(cloud_set, "grow_points", mode="loud")
    assert caught[0].filename == __file__


def test_a_plugin_that_failed_is_named_when_asked_for(install, cloud_set, grow_filter):
    install(grow_filter, failures=[BROKEN])
    meshlab_symrecon.apply_filter(cloud_set, "grow_points")
    for name in ("rotten_apple", "Generate Rotten-Apple"):
        with pytest.raises(PluginError, match="rotten_apple = x:y' cannot be imported: E: no"):
            meshlab_symrecon.apply_filter(cloud_set, name)
    with pytest.raises(UnknownFilterError):
        meshlab_symrecon.apply_filter(cloud_set, "zzzz")


def test_a_plugin_cannot_take_the_name_of_a_native_filter(install, cloud_set, grow_filter):
    install(replace(grow_filter, menu_name="box/cube"))
    with pytest.raises(PluginError, match="claims the name 'box/cube' of one of MeshLab's own"):
        meshlab_symrecon.apply_filter(cloud_set, "grow_points")
    meshlab_symrecon.apply_filter(cloud_set, "create_cube")


def test_the_registry_is_found_once_and_again_on_request(monkeypatch, install, grow_filter):
    install(grow_filter)
    first = steps.registry()
    assert steps.registry() is first
    assert steps.registry(refresh=True) is not first


# --- as pymeshlab's own ---------------------------------------------------------------------------


def test_unloading_restores_the_very_objects(install, grow_filter, nothing_filter):
    before = everything_touched()
    install(grow_filter, nothing_filter)
    registration.load_plugins()
    registration.load_plugins()
    assert hasattr(pymeshlab.MeshSet, "grow_points")
    registration.unload_plugins()
    registration.unload_plugins()
    assert_same_objects(before, everything_touched())


@pytest.mark.parametrize("name", NAMES[:2])
def test_filters_are_methods(plugins, cloud_set, points, name):
    assert getattr(cloud_set, name)(factor=0.5)["factor"] == 0.5
    np.testing.assert_array_equal(cloud_set.current_mesh().vertex_matrix(), 0.5 * points)


def test_a_method_returns_none_and_apply_filter_an_empty_dict_when_nothing_is_measured(
    plugins, cloud_set
):
    assert cloud_set.apply_nothing() is None
    assert cloud_set.apply_filter("apply_nothing") == {}
    assert cloud_set.create_cube() is None
    assert cloud_set.apply_filter("create_cube") == {}


@pytest.mark.parametrize("name", NAMES)
def test_apply_filter_of_the_class_knows_every_name(plugins, cloud_set, points, name):
    assert cloud_set.apply_filter(filter_name=name, factor=4.0)["factor"] == 4.0
    np.testing.assert_array_equal(cloud_set.current_mesh().vertex_matrix(), 4.0 * points)


@pytest.mark.parametrize("name", NAMES)
def test_parameter_values(plugins, cloud_set, name):
    defaults = {"factor": 2.0, "randomseed": 0, "mode": "plain", "keep": False, "title": "grown"}
    assert cloud_set.filter_parameter_values(name) == defaults
    assert cloud_set.filter_parameter_values(name, factor=7) == defaults | {"factor": 7.0}
    with pytest.raises(ParameterError, match="unknown parameter 'size'"):
        cloud_set.filter_parameter_values(name, size=1)


def test_parameter_values_of_native_filters_and_formats_are_unchanged(plugins, cloud_set):
    assert cloud_set.filter_parameter_values("ply") == {"binary": True}
    assert cloud_set.filter_parameter_values("create_cube", size=3.0)["size"] == 3.0


def test_filter_list(plugins):
    names = pymeshlab.filter_list()
    assert names == sorted(names) == meshlab_symrecon.filter_list()
    assert {"generate_grown_points", "apply_nothing", "create_cube"} <= set(names)
    assert len(names) == len(set(names)) == len(registration._native_filter_list()) + 2


def printed_by(*calls):
    """Return what a process of its own prints, to C++'s standard output and to Python's."""
    lines = ["import pymeshlab, meshlab_symrecon", "meshlab_symrecon.load_plugins()", *calls]
    done = subprocess.run(
        [sys.executable, "-c", "\n".join(lines)], capture_output=True, text=True, check=True
    )
    return done.stdout


def test_our_names_go_on_with_the_native_list_in_its_form():
    ours = [item.python_name for item in installed_filters()]
    lines = printed_by("pymeshlab.print_filter_list()").splitlines()
    assert lines[1:] == [f"\t{name}" for name in [*registration._native_filter_list(), *ours]]


def test_our_parameters_are_printed_in_the_native_form():
    lines = printed_by(
        "pymeshlab.print_filter_parameter_list('generate_simplified_points')",
        "pymeshlab.print_filter_parameter_list('compute_matrix_from_rotation')",
    ).splitlines()
    form = re.compile(
        r"\t\w+ : (bool|int|float|str|numpy[^ ]*)( \(bounded\))? = .*?( \[min: .*; max: .*\])?"
    )
    shown = [line for line in lines if line.startswith("\t")]
    assert all(form.fullmatch(line) for line in shown)
    assert "\tangle : float (bounded) = 0 [min: -360; max: 360]" in shown
    assert "\tpercentage : float (bounded) = 10.0 [min: 0; max: 100]" in shown
    titles = [line for line in lines if line.endswith(" filter - list of parameter names:")]
    assert [title.split()[0] for title in titles] == [
        "generate_simplified_points", "compute_matrix_from_rotation",
    ]  # fmt: skip


def test_printed_lists(plugins, capsys):
    pymeshlab.print_filter_parameter_list("Grow Points")
    assert capsys.readouterr().out == (
        "generate_grown_points filter - list of parameter names:\n"
        "\tfactor : float = 2.0\n\trandomseed : int = 0\n\tmode : str = 'plain'\n"
        "\tkeep : bool = False\n\ttitle : str = 'grown'\n"
    )
    pymeshlab.print_filter_parameter_list("create_cube")
    pymeshlab.search("grow")
    shown = capsys.readouterr().out
    assert "generate_grown_points : Move points away from the origin.\n" in shown
    pymeshlab.search("no such word")
    assert "generate_grown_points" not in capsys.readouterr().out


def test_the_method_tells_its_signature_and_its_docs(plugins, grow_filter):
    method = pymeshlab.MeshSet.generate_grown_points
    assert method.__name__ == "generate_grown_points"
    assert str(inspect.signature(method)) == (
        "(self, /, *, factor: float = 2.0, randomseed: int = 0, mode: str = 'plain', "
        "keep: bool = False, title: str = 'grown')"
    )
    for known in grow_filter.parameters.declared():
        assert f"{known.name} : {known.range_words}" in method.__doc__


def test_native_exceptions_and_docs_are_unchanged(plugins, cloud_set):
    with pytest.raises(pymeshlab.PyMeshLabException, match="Filter does not exists"):
        cloud_set.apply_filter("no_such_filter")
    with pytest.raises(pymeshlab.PyMeshLabException, match="Parameter foo not found"):
        cloud_set.create_cube(foo=1)
    with pytest.raises(RuntimeError, match="Unable to cast"):
        cloud_set.create_cube(size="large")
    assert pymeshlab.MeshSet.apply_filter.__doc__.startswith("apply_filter(self")


def test_native_results_are_unchanged(plugins, cloud_set):
    def measured():
        mesh_set = pymeshlab.MeshSet(verbose=False)
        mesh_set.create_cube()
        return mesh_set.get_geometric_measures()["mesh_volume"]

    loaded = measured()
    registration.unload_plugins()
    assert loaded == measured() == 1.0


def test_a_plugin_that_failed_is_named_on_loading_and_holds_up_nobody(install, grow_filter):
    install(grow_filter, failures=[BROKEN])
    with pytest.warns(SymReconWarning, match="plugin 'rotten_apple = x:y' cannot be imported"):
        registration.load_plugins()
    assert "generate_grown_points" in pymeshlab.filter_list()


def test_a_plugin_cannot_take_the_name_of_a_method(install, grow_filter):
    before = everything_touched()
    install(replace(grow_filter, aliases=("add_mesh",)))
    with pytest.raises(PluginError, match="'Grow Points' claims the name 'add_mesh'"):
        registration.load_plugins()
    assert_same_objects(before, everything_touched())


def test_subclasses_of_meshset_have_the_filters_too(plugins, points):
    class Mine(pymeshlab.MeshSet):
        pass

    mesh_set = Mine(verbose=False)
    mesh_set.add_mesh(pymeshlab.Mesh(vertex_matrix=points))
    assert mesh_set.grow_points()["factor"] == 2.0


def test_loading_from_many_threads_is_loading_once(install, grow_filter):
    before = everything_touched()
    install(grow_filter)
    threads = [threading.Thread(target=registration.load_plugins) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert pymeshlab.filter_list().count("generate_grown_points") == 1
    registration.unload_plugins()
    assert_same_objects(before, everything_touched())


def test_an_unknown_name_of_the_package_is_an_attribute_error():
    with pytest.raises(AttributeError, match="has no attribute 'load_plugin'"):
        meshlab_symrecon.load_plugin()


def test_the_package_runs_scripts(tmp_path, cloud_set):
    heard = []
    (tmp_path / "a.mlx").write_text(
        '<FilterScript><filter name="Compute normals for point sets"/></FilterScript>'
    )
    report = meshlab_symrecon.apply_filter_script(
        cloud_set, tmp_path / "a.mlx", progress=lambda *what: heard.append(what)
    )
    assert [step.filter for step in report.steps] == ["compute_normal_for_point_clouds"]
    assert cloud_set.current_mesh().vertex_normal_matrix().any()
    assert heard[-1] == (1.0, "done")
