"""Stand-in filters, and MeshSets."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pymeshlab
import pytest

from meshlab_symrecon.host import registration, steps
from meshlab_symrecon.plugin import (
    Filter,
    Outcome,
    ParameterSet,
    boolean,
    choice,
    integer,
    number,
    text,
)
from meshlab_symrecon.plugin.registry import Registry


class Growth(ParameterSet):
    """One parameter of most kinds."""

    factor: float = number(2.0, "Factor", "Points move away from 0 by this.", low=0.0)
    randomseed: int = integer(0, "Seed", "Seed.", low=0)
    mode: str = choice("plain", ("plain", "Loud"), "Mode", "Loud warns.")
    keep: bool = boolean(False, "Keep", "Leave the current layer current.")
    title: str = text("grown", "Title", "Label of the new layer.")


def grow(layers, parameters, progress):
    progress(1.0, "grown")
    layer = layers.current
    grown = replace(layer, points=layer.points * parameters.factor, label=parameters.title)
    return Outcome(
        layers=(grown,),
        current=None if parameters.keep else 0,
        measures={"factor": parameters.factor, "centre": grown.points.mean(axis=0)},
        warnings=("it is loud",) if parameters.mode == "Loud" else (),
    )


def nothing(layers, parameters, progress):
    return Outcome()


class NoParameters(ParameterSet):
    """Nothing to choose."""


GROW = Filter(
    menu_name="Grow Points",
    python_name="generate_grown_points",
    aliases=("grow_points",),
    summary="Move points away from the origin.",
    description="Every point is multiplied by a factor.",
    parameters=Growth,
    run=grow,
    meshlab_class="Remeshing",
    category="Creation/Sampling",
)
NOTHING = replace(
    GROW,
    menu_name="Do Nothing",
    python_name="apply_nothing",
    aliases=(),
    parameters=NoParameters,
    run=nothing,
    requires=(),
)


@pytest.fixture
def grow_filter():
    """Return a filter with parameters, a layer, measures and a warning."""
    return GROW


@pytest.fixture
def nothing_filter():
    """Return a filter that needs, makes and measures nothing."""
    return NOTHING


@pytest.fixture
def install(monkeypatch):
    """Return a function that makes given filters the installed ones; undo everything later."""

    def give(*filters, failures=()):
        monkeypatch.setattr(steps, "installed_filters", lambda: Registry(filters, failures))
        steps._found.clear()

    yield give
    registration.unload_plugins()
    steps._found.clear()


@pytest.fixture
def plugins(install):
    """Two stand-in filters installed, and loaded into pymeshlab."""
    install(GROW, NOTHING)
    registration.load_plugins()


@pytest.fixture
def installed(install):
    """Two stand-in filters installed, not loaded into pymeshlab."""
    install(GROW, NOTHING)


@pytest.fixture
def points():
    return np.random.default_rng(7).normal(size=(40, 3))


@pytest.fixture
def cloud_set(points):
    """A document with one cloud, 'scan'."""
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.add_mesh(pymeshlab.Mesh(vertex_matrix=points), "scan")
    return mesh_set
