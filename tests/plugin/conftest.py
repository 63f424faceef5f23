"""A small filter and small layers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from meshlab_symrecon.errors import ParameterError
from meshlab_symrecon.plugin import (
    Citation,
    Filter,
    Layer,
    Layers,
    Outcome,
    ParameterSet,
    choice,
    number,
)


class Growth(ParameterSet):
    """How much to grow."""

    factor: float = number(2.0, "Factor", "Points move away from 0 by this.", low=0.0)
    about: str = choice("origin", ("origin", "centre"), "About", "What stays where it is.")


def check_growth(parameters):
    if parameters.factor == 0.0 and parameters.about == "centre":
        raise ParameterError("a factor of 0 about the centre leaves nothing; got both; drop one")


def grow(layers, parameters, progress):
    progress(0.5, "growing")
    layer = layers.current
    return Outcome(
        layers=(replace(layer, points=layer.points * parameters.factor, label="grown"),),
        measures={"factor": parameters.factor},
    )


@pytest.fixture
def grow_filter():
    return Filter(
        menu_name="Grow Points",
        python_name="generate_grown_points",
        aliases=("grow_points",),
        summary="Move points away from the origin.",
        description="Every point is multiplied by a factor.",
        parameters=Growth,
        check=check_growth,
        run=grow,
        meshlab_class="Remeshing",
        category="Creation/Sampling",
        creates=("grown",),
        citations=(Citation("A. Author", "On growth", "Journal", 2001, "10.1/2"),),
    )


@pytest.fixture
def cloud():
    points = np.array([[1.0, 2.0, 3.0], [0.0, 0.0, 1.0]])
    return Layer(points=points, faces=np.zeros((0, 3), np.int64), label="scan", identifier=4)


@pytest.fixture
def document():
    """Return a function that makes a document of layers; the last is current."""

    def make(*given):
        by_number = {layer.identifier: layer for layer in given}
        current = given[-1].identifier if given else -1
        labels = {number: layer.label for number, layer in by_number.items()}
        return Layers(labels, current, by_number.__getitem__)

    return make
