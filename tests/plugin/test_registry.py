"""Filters found by their names, and through the entry points of installed distributions."""

from __future__ import annotations

import importlib
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from meshlab_symrecon.errors import PluginError, UnknownFilterError
from meshlab_symrecon.plugin import registry as registry_module
from meshlab_symrecon.plugin.registry import (
    ENTRY_POINT_GROUP,
    PluginFailure,
    Registry,
    installed_filters,
    origin,
    plain_name,
)

FOREIGN = Path(__file__).parents[1] / "foreign_plugin" / "foreign_filters.py"


@pytest.fixture
def other(grow_filter):
    return replace(grow_filter, menu_name="Other", python_name="apply_other", aliases=())


@pytest.fixture
def distribution(tmp_path, monkeypatch):
    """Return a function that installs the foreign package with given entry points."""
    shutil.copy(FOREIGN, tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))

    def install(name="foreign_filters", **entries):
        facts = tmp_path / f"{name}-1.0.dist-info"
        facts.mkdir()
        (facts / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
        lines = [f"{entry} = {value}" for entry, value in entries.items()]
        (facts / "entry_points.txt").write_text("\n".join([f"[{ENTRY_POINT_GROUP}]", *lines]))
        importlib.invalidate_caches()
        return tmp_path

    yield install
    sys.modules.pop("foreign_filters", None)


def only_foreign(found):
    return [item for item in found if item.run.__module__ == "foreign_filters"]


def test_names_are_compared_trimmed_with_single_spaces_in_any_case():
    assert plain_name("  Grow \t POINTS\n") == "grow points"


def test_every_name_finds_the_filter(grow_filter, other):
    registry = Registry([grow_filter, other])
    for name in ("generate_grown_points", " Grow_Points", "grow   points"):
        assert registry.find(name) is grow_filter
        assert name in registry
    assert list(registry) == [grow_filter, other]
    assert len(registry) == 2
    assert registry.names == ("generate_grown_points", "grow_points", "apply_other")
    assert 3 not in registry


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("grow_pionts", "no filter is called 'grow_pionts'; did you mean 'grow_points'?"),
        ("zzzz", "no filter is called 'zzzz'"),
    ],
)
def test_an_unknown_name_is_answered_with_the_nearest_one(grow_filter, name, sentence):
    with pytest.raises(UnknownFilterError) as caught:
        Registry([grow_filter]).find(name)
    assert str(caught.value) == sentence


@pytest.mark.parametrize(
    "clash",
    [
        {"menu_name": "GROW points"},
        {"python_name": "grow_points"},
        {"aliases": ("generate_grown_points",)},
    ],
)
def test_two_filters_cannot_claim_one_name(grow_filter, other, clash):
    second = replace(other, **clash)
    with pytest.raises(PluginError) as caught:
        Registry([grow_filter, second])
    assert origin(grow_filter) in str(caught.value)
    assert origin(second) in str(caught.value)


def test_a_filter_may_have_one_name_in_two_roles(grow_filter):
    assert len(Registry([replace(grow_filter, aliases=("generate_grown_points",))])) == 1


def test_failures_are_kept(grow_filter):
    failure = PluginFailure("a", "because")
    assert Registry([grow_filter], [failure]).failures == (failure,)


def test_a_foreign_filter_is_found(distribution):
    distribution(others="foreign_filters:FILTER")
    found = installed_filters()
    assert [item.python_name for item in only_foreign(found)] == ["get_every_other_point"]
    assert found.find("Count Every Other Point") is found.find("count_others")
    assert not [failure for failure in found.failures if failure.name == "others"]


def test_plugins_that_cannot_be_loaded_are_named_and_hold_up_nobody(distribution):
    folder = distribution(
        broken="broken_filters:FILTER",
        ends="ending_filters:FILTER",
        gone="no_such_module:FILTER",
        hollow="foreign_filters:MISSING",
        others="foreign_filters:FILTER",
        wrong="foreign_filters:NOT_A_FILTER",
    )
    (folder / "broken_filters.py").write_text("raise RuntimeError('not today')")
    (folder / "ending_filters.py").write_text("raise SystemExit(3)")
    found = installed_filters()
    reasons = {failure.name: failure.reason for failure in found.failures}
    assert (
        "'broken = broken_filters:FILTER' cannot be imported: RuntimeError: not today"
        in (reasons["broken"])
    )
    assert "SystemExit: 3" in reasons["ends"]
    assert "ModuleNotFoundError" in reasons["gone"]
    assert "AttributeError" in reasons["hollow"]
    assert reasons["wrong"] == (
        "plugin 'wrong = foreign_filters:NOT_A_FILTER' must be a Filter; got str"
    )
    assert len(only_foreign(found)) == 1


def test_two_installed_filters_cannot_claim_one_name(distribution):
    folder = distribution(others="foreign_filters:FILTER")
    (folder / "second_filters.py").write_text(
        "from dataclasses import replace\nimport foreign_filters\n"
        "FILTER = replace(foreign_filters.FILTER, menu_name='Second', aliases=())\n"
    )
    distribution("second", second="second_filters:FILTER")
    with pytest.raises(PluginError, match="two filters claim the name 'get_every_other_point'"):
        installed_filters()


def test_one_filter_installed_twice_is_one_filter(distribution):
    """As happens when a source tree and an installed wheel are both on the path."""
    distribution(others="foreign_filters:FILTER")
    distribution("copy", others="foreign_filters:FILTER")
    assert len(only_foreign(installed_filters())) == 1


def test_our_filters_come_first(monkeypatch, grow_filter, other):
    def ours(layers, parameters, progress):
        raise AssertionError("only its module is looked at")

    ours.__module__ = "meshlab_symrecon.filters.other"
    filters = {"a": grow_filter, "b": replace(other, run=ours)}

    class Point:
        def __init__(self, name):
            self.name, self.value = name, name

    monkeypatch.setattr(registry_module, "entry_points", lambda group: map(Point, filters))
    monkeypatch.setattr(registry_module, "_load", lambda point: filters[point.name])
    assert [item.python_name for item in installed_filters()] == [
        "apply_other",
        "generate_grown_points",
    ]


HOST = """
import numpy, pymeshlab, warnings, meshlab_symrecon
warnings.simplefilter("ignore")  # our own filters may not be built here
mesh_set = pymeshlab.MeshSet(verbose=False)
mesh_set.add_mesh(pymeshlab.Mesh(vertex_matrix=numpy.eye(3)))
assert meshlab_symrecon.apply_filter(mesh_set, "Count Every Other Point", every=1) == {"kept": 3}
meshlab_symrecon.load_plugins()
assert mesh_set.get_every_other_point() == mesh_set.count_others(every=2) == {"kept": 2}
assert mesh_set.apply_filter("count every other point") == {"kept": 2}
assert "get_every_other_point" in pymeshlab.filter_list()
mesh_set.apply_filter_script()
meshlab_symrecon.unload_plugins()
assert not hasattr(mesh_set, "count_others")
"""


def test_a_foreign_filter_has_the_same_rights_in_pymeshlab(distribution):
    folder = distribution(others="foreign_filters:FILTER")
    script = f"import sys; sys.path.insert(0, {str(folder)!r})\n" + HOST
    subprocess.run([sys.executable, "-c", script], check=True)
