"""Our filters as steps of scripts."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshlab_symrecon.errors import ParameterError
from meshlab_symrecon.host.mlx import Param, step_of
from meshlab_symrecon.host.mlx_reading import read_script
from meshlab_symrecon.host.mlx_writing import write_script
from meshlab_symrecon.plugin import (
    Filter,
    Outcome,
    ParameterSet,
    boolean,
    choice,
    diagonal_fraction,
    integer,
    layer,
    number,
    text,
)


class Everything(ParameterSet):
    switch: bool = boolean(True, "l", "t")
    count: int = integer(3, "l", "t", low=0)
    share: float = number(0.1, "l", "t")
    gap: float = diagonal_fraction(1.0 / 3.0, "l", "t")
    mode: str = choice("b <", ("a", "b <"), "l", "t")
    source: int = layer(-1, "l", "t")
    note: str = text(" x ", "l", "t")


FILTER = Filter(
    menu_name="Do: Everything (AP)",
    python_name="do_everything",
    summary="s",
    description="d",
    parameters=Everything,
    run=lambda layers, parameters, progress: Outcome(),
    meshlab_class="Remeshing",
    category="Creation/Reconstruction",
)


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_our_steps_come_back_to_the_last_bit(tmp_path_factory, share):
    path = tmp_path_factory.getbasetemp() / "ours.mlx"
    step = step_of(FILTER, {"share": share})
    write_script([step], path)
    (read,) = read_script(path).steps
    assert read == step
    assert [parameter.name for parameter in read.parameters] == list(FILTER.bind({}).values())
    values = {
        parameter.name: FILTER.parameters.find(parameter.name).parse(parameter.text)
        for parameter in read.parameters
    }
    assert values == FILTER.bind({"share": share}).values()
    assert math.copysign(1.0, values["share"]) == math.copysign(1.0, share)


def test_our_steps_carry_their_types_and_words():
    by_name = {parameter.name: parameter for parameter in step_of(FILTER, {}).parameters}
    assert by_name["mode"] == Param(
        "mode",
        0,
        "RichEnum",
        "1",
        {"enum_cardinality": "2", "enum_val0": "a", "enum_val1": "b <"},
    )
    assert by_name["switch"] == Param("switch", 0, "RichBool", "true")
    assert by_name["gap"].text == repr(1.0 / 3.0)
    assert by_name["source"].rich_type == "RichMesh"


def test_our_steps_are_checked():
    with pytest.raises(ParameterError, match="unknown parameter 'cuont'; did you mean 'count'"):
        step_of(FILTER, {"cuont": 1})
