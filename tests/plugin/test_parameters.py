"""Parameters: every kind, every refusal, and the round trip through text."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshlab_symrecon.errors import ParameterError
from meshlab_symrecon.plugin import ParameterSet
from meshlab_symrecon.plugin import parameter_sets as declare
from meshlab_symrecon.plugin.parameters import Kind, nearest_names


class Every(ParameterSet):
    """One parameter of each kind."""

    orient: bool = declare.boolean(True, "Orient", "Turn outward.")
    count: int = declare.integer(3, "Count", "How many.", low=1, high=9)
    weight: float = declare.number(0.5, "Weight", "How heavy.", low=-1.0)
    gap: float = declare.diagonal_fraction(0.1, "Gap", "How wide.")
    reach: float = declare.spacing_multiple(2.0, "Reach", "How far.", high=8.0)
    mode: str = declare.choice("fast", ("fast", "Exact"), "Mode", "How well.")
    planes: int = declare.layer(-1, "Planes", "Which layer.")
    title: str = declare.text("a b", "Title", "What it is called.")


KINDS = {
    "orient": Kind.BOOLEAN,
    "count": Kind.INTEGER,
    "weight": Kind.NUMBER,
    "gap": Kind.DIAGONAL_FRACTION,
    "reach": Kind.SPACING_MULTIPLE,
    "mode": Kind.CHOICE,
    "planes": Kind.LAYER,
    "title": Kind.TEXT,
}


def test_each_function_declares_its_kind_in_order():
    assert {known.name: known.kind for known in Every.declared()} == KINDS
    assert [known.name for known in Every.declared()] == list(KINDS)


def test_defaults_stand_when_nothing_is_given():
    assert Every().values() == {
        "orient": True,
        "count": 3,
        "weight": 0.5,
        "gap": 0.1,
        "reach": 2.0,
        "mode": "fast",
        "planes": -1,
        "title": "a b",
    }


@pytest.mark.parametrize(
    ("name", "given_value", "checked"),
    [
        ("orient", False, False),
        ("orient", np.bool_(False), False),
        ("count", 9, 9),
        ("count", np.int32(1), 1),
        ("count", 4.0, 4),
        ("weight", 7, 7.0),
        ("weight", np.float32(0.25), 0.25),
        ("weight", np.array(0.25), 0.25),
        ("gap", 0, 0.0),
        ("reach", 8.0, 8.0),
        ("mode", "EXACT", "Exact"),
        ("mode", 1, "Exact"),
        ("mode", np.int64(0), "fast"),
        ("planes", 12, 12),
        ("title", "", ""),
    ],
)
def test_a_good_value_becomes_the_kinds_own_type(name, given_value, checked):
    value = getattr(Every.from_values({name: given_value}), name)
    assert value == checked
    assert type(value) is type(checked)


@pytest.mark.parametrize(
    ("name", "refused", "allowed"),
    [
        ("orient", 1, "true or false"),
        ("orient", "true", "true or false"),
        ("count", 0, "a whole number from 1 to 9"),
        ("count", 10, "a whole number from 1 to 9"),
        ("count", 2.5, "a whole number from 1 to 9"),
        ("count", True, "a whole number from 1 to 9"),
        ("count", "3", "a whole number from 1 to 9"),
        ("count", math.inf, "a whole number from 1 to 9"),
        ("count", math.nan, "a whole number from 1 to 9"),
        ("weight", -1.5, "a number of at least -1"),
        ("weight", math.nan, "a number of at least -1"),
        ("weight", math.inf, "a number of at least -1"),
        ("weight", False, "a number of at least -1"),
        ("weight", None, "a number of at least -1"),
        ("weight", np.array([0.5]), "a number of at least -1"),
        ("gap", 1.5, "a fraction of the box diagonal from 0 to 1"),
        ("reach", 8.5, "a multiple of the mean spacing from 0 to 8"),
        ("mode", "slow", "one of 'fast', 'Exact'"),
        ("mode", 2, "one of 'fast', 'Exact'"),
        ("mode", -1, "one of 'fast', 'Exact'"),
        ("mode", True, "one of 'fast', 'Exact'"),
        ("planes", -2, "a layer's number of at least -1"),
        ("title", 3, "text"),
    ],
)
def test_a_bad_value_is_refused_with_what_is_allowed_and_what_was_got(name, refused, allowed):
    with pytest.raises(ParameterError) as caught:
        Every.from_values({name: refused})
    assert str(caught.value) == f"parameter '{name}' must be {allowed}; got {refused!r}"


@pytest.mark.parametrize(
    ("name", "sign", "digits"),
    [("count", 1, 400), ("count", -1, 5000), ("weight", 1, 400), ("weight", -1, 5000),
     ("mode", 1, 5000), ("planes", 1, 20), ("planes", 1, 5000), ("title", 1, 5000)],
)  # fmt: skip
def test_whole_numbers_that_no_float_holds_are_refused_in_a_short_sentence(name, sign, digits):
    refused = sign * 10**digits
    with pytest.raises(ParameterError, match=f"parameter '{name}' must be") as caught:
        Every.from_values({name: refused})
    assert len(str(caught.value)) < 300


@pytest.mark.parametrize("name", ["orient", "count", "weight", "gap", "mode", "planes"])
@pytest.mark.parametrize("written", ["9" * 400, "9" * 5000, "x" * 5000])
def test_long_words_are_refused_in_a_short_sentence(name, written):
    with pytest.raises(ParameterError, match=f"parameter '{name}' must be") as caught:
        Every.find(name).parse(written)
    assert len(str(caught.value)) < 300


@pytest.mark.parametrize(
    ("name", "written", "value"),
    [
        ("orient", " True ", True),
        ("orient", "0", False),
        ("count", " 7 ", 7),
        ("weight", "1e-3", 0.001),
        ("gap", ".5", 0.5),
        ("mode", "1", "Exact"),
        ("mode", "exact", "Exact"),
        ("planes", "-1", -1),
        ("title", " kept as it is ", " kept as it is "),
    ],
)
def test_text_is_read(name, written, value):
    assert Every.find(name).parse(written) == value


@pytest.mark.parametrize(
    ("name", "written"),
    [
        ("orient", "yes"),
        ("orient", ""),
        ("count", "3.0"),
        ("count", "three"),
        ("count", "99"),
        ("weight", "heavy"),
        ("weight", "nan"),
        ("weight", "inf"),
        ("gap", "50%"),
        ("mode", "slow"),
        ("mode", "2"),
        ("planes", "first"),
    ],
)
def test_text_that_stands_for_nothing_is_refused(name, written):
    with pytest.raises(ParameterError, match=f"parameter '{name}' must be"):
        Every.find(name).parse(written)


@given(
    weight=st.floats(min_value=-1.0, allow_nan=False, allow_infinity=False),
    count=st.integers(1, 9),
    mode=st.sampled_from(["fast", "Exact"]),
    orient=st.booleans(),
    title=st.text(),
)
def test_format_then_parse_is_the_identity(**values):
    parameters = Every.from_values(values)
    for known in Every.declared():
        value = getattr(parameters, known.name)
        back = known.parse(known.format(value))
        assert (back, type(back)) == (value, type(value))


def test_parameters_are_frozen_and_keyword_only():
    with pytest.raises(AttributeError):
        Every().count = 4
    with pytest.raises(TypeError):
        Every(True)


def test_names_are_found_in_any_case():
    assert Every.find(" COUNT ").name == "count"
    assert Every.from_values({"Count": 5}).count == 5


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("cuont", "; did you mean 'count'?"),
        ("zzzz", "; known are orient, count, weight, gap, reach, mode, planes, title"),
    ],
)
def test_an_unknown_name_is_answered_with_the_nearest_one(name, hint):
    with pytest.raises(ParameterError) as caught:
        Every.find(name)
    assert str(caught.value) == f"unknown parameter '{name}'{hint}"


def test_a_filter_without_parameters_says_so():
    class Nothing(ParameterSet):
        pass

    with pytest.raises(ParameterError, match="this filter has no parameters"):
        Nothing.from_values({"count": 1})


def test_a_field_must_be_declared():
    with pytest.raises(TypeError, match=r"Bad\.count must be declared"):

        class Bad(ParameterSet):
            count: int = 3


def test_a_default_out_of_its_own_range_is_refused_at_declaration():
    with pytest.raises(ParameterError, match="parameter 'count' must be"):

        class Bad(ParameterSet):
            count: int = declare.integer(3, "Count", "How many.", low=4)


@pytest.mark.parametrize(
    ("low", "high", "words"),
    [
        (None, None, "a number"),
        (0.0, None, "a number of at least 0"),
        (None, 2.0, "a number of at most 2"),
        (0.0, 2.0, "a number from 0 to 2"),
    ],
)
def test_ranges_in_words(low, high, words):
    class One(ParameterSet):
        weight: float = declare.number(1.0, "Weight", "How heavy.", low=low, high=high)

    assert One.find("weight").range_words == words


def test_nearest_name_keeps_its_own_case():
    assert (
        nearest_names("POWER crst", ["Power Crust", "Poisson"]) == "; did you mean 'Power Crust'?"
    )
    assert nearest_names("zebra", ["Power Crust"]) == ""
