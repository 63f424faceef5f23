"""Writing filter scripts, and reading them back."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from meshlab_symrecon.errors import FileError, ScriptError
from meshlab_symrecon.host.mlx import Param, Step
from meshlab_symrecon.host.mlx_reading import read_script
from meshlab_symrecon.host.mlx_writing import write_script

XML_TEXT = st.text(
    st.characters(codec="utf-8", exclude_categories=("Cc", "Cs"), exclude_characters="\ufffe\uffff")
    | st.sampled_from("\t\n\r<>&\"' "),
    max_size=12,
)
NAMES = XML_TEXT.filter(lambda name: bool(name.strip()))
ATTRIBUTES = st.dictionaries(
    st.sampled_from(["min", "max", "x", "enum_val0", "tooltip"]), XML_TEXT, max_size=3
)


@st.composite
def steps(draw):
    from_xml_plugin = draw(st.booleans())
    types = st.just("") if from_xml_plugin else st.sampled_from(["RichInt", "RichString"])
    names = draw(st.lists(NAMES, max_size=4, unique_by=str.lower))
    parameters = tuple(
        Param(name, 0, draw(types), draw(st.none() | XML_TEXT), draw(ATTRIBUTES)) for name in names
    )
    return Step(draw(NAMES), 0, parameters, from_xml_plugin)


@settings(max_examples=80)
@given(st.lists(steps(), max_size=4))
def test_reading_what_was_written_gives_it_back(tmp_path_factory, written_steps):
    path = tmp_path_factory.getbasetemp() / "round trip.mlx"
    write_script(written_steps, path)
    assert read_script(path).steps == tuple(written_steps)
    assert path.read_text(encoding="utf-8").startswith("<!DOCTYPE FilterScript>\n<FilterScript")


def test_characters_that_xml_cannot_hold(tmp_path):
    path = tmp_path / "a.mlx"
    for bad in ("\0", "\x1b", "\ud800", "\uffff"):
        with pytest.raises(ScriptError, match="XML cannot hold the character"):
            write_script([Step(f"a{bad}", 0)], path)
        with pytest.raises(ScriptError, match="XML cannot hold the character"):
            write_script([Step("a", 0, (Param("n", 0, "RichString", bad),))], path)
    assert list(tmp_path.iterdir()) == []


def test_a_script_goes_nowhere_without_its_directory(tmp_path):
    with pytest.raises(FileError, match="no directory is at"):
        write_script([], tmp_path / "none" / "a.mlx")
