"""Limits and sizes."""

from __future__ import annotations

from pathlib import Path

import pytest

from meshlab_symrecon.batch import Batch, Limits
from meshlab_symrecon.batch.request import bytes_of, in_bytes
from meshlab_symrecon.errors import ParameterError


@pytest.mark.parametrize(
    ("text", "size"),
    [("4G", 4 << 30), ("500m", 500 << 20), ("1.5 GiB", 3 << 29), ("12", 12), ("2KB", 2048)],
)
def test_sizes(text, size):
    assert bytes_of(text) == size


@pytest.mark.parametrize(
    "text",
    ["", "G", "-1G", "4X", "0", "0M", "1e9", "4 G B", "nan", "9" * 400 + "G", "9999999T"],
)
def test_what_is_no_size(text):
    with pytest.raises(ParameterError, match="is no size of memory"):
        bytes_of(text)


def test_sizes_in_words():
    words = [in_bytes(size) for size in (12, 2048, 3 << 29, 4 << 40)]
    assert words == ["12 bytes", "2 KiB", "1.5 GiB", "4 TiB"]


@pytest.mark.parametrize("name", ["seconds", "memory", "points", "threads"])
@pytest.mark.parametrize("value", [0, -1, float("nan"), float("inf")])
def test_limits_are_above_zero(name, value):
    with pytest.raises(
        ParameterError, match=f"the limit of {name} is a (whole )?number above zero"
    ):
        Limits(**{name: value})


@pytest.mark.parametrize("name", ["memory", "points", "threads"])
@pytest.mark.parametrize("value", [150.5, "5", True])
def test_what_is_counted_is_whole(name, value):
    with pytest.raises(ParameterError, match=f"{name} is a whole number above zero; got"):
        Limits(**{name: value})


def test_seconds_are_any_number_above_zero():
    assert Limits(seconds=2.5).seconds == 2.5
    with pytest.raises(ParameterError, match="seconds is a number above zero; got '5'"):
        Limits(seconds="5")


@pytest.mark.parametrize("jobs", [0, -1, "2", 1.5, True])
def test_jobs_are_a_whole_number_above_zero(jobs):
    with pytest.raises(ParameterError, match="jobs is a whole number above zero; got"):
        Batch("s.mlx", ["in"], "out", jobs=jobs)


@pytest.mark.parametrize("inputs", ["in", b"in", Path("in")])
def test_inputs_are_a_sequence(inputs):
    with pytest.raises(ParameterError, match=r"inputs is a sequence .* write it in brackets"):
        Batch("s.mlx", inputs, "out")
