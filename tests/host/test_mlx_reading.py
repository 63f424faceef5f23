"""Reading filter scripts."""

from __future__ import annotations

from pathlib import Path

import pytest

from meshlab_symrecon.errors import FileError, ScriptError
from meshlab_symrecon.host.mlx import Param, Script, Step
from meshlab_symrecon.host.mlx_reading import read_script

EVERY_FORM = """<!DOCTYPE FilterScript>
<FilterScript>
 <!-- a comment -->
 <filter name=" Close  Holes ">
  <Param type="RichInt" value="30" name="MaxHoleSize" description="d" tooltip="t"/>
  <Param type="RichAbsPerc" name="t" value="0.123456789012345678" min="0" max="34.6"/>
  <Param type="RichEnum" name="e" value="1" enum_cardinality="2" enum_val0="a"
     enum_val1="b &lt; c"/>
  <Param type="RichColor" name="c" r="255" g="0" b="0" a="255"/>
  <Param type="RichPosition" name="p" x="0" y="0" z="1"></Param>
  <Param type="RichMatrix44f" name="M"
     val0="1" val15="1"/>
  <Param type="RichOpenFile" name="o" value="größe 1.ply" exts_cardinality="1" exts_val0="*.ply"/>
 </filter>
 <xmlfilter name="Screened Poisson"><xmlparam name="depth" value="8"/></xmlfilter>
</FilterScript>
"""


def written(tmp_path: Path, content: str | bytes, name: str = "scan.mlx") -> Path:
    path = tmp_path / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def test_every_form_is_read_with_its_lines(tmp_path):
    script = read_script(written(tmp_path, EVERY_FORM))
    first, second = script.steps
    assert (first.name, first.line, first.from_xml_plugin) == (" Close  Holes ", 4, False)
    assert [parameter.line for parameter in first.parameters] == [5, 6, 7, 9, 10, 11, 13]
    by_name = {parameter.name: parameter for parameter in first.parameters}
    assert by_name["MaxHoleSize"].text == "30"
    assert by_name["t"].text == "0.123456789012345678"
    assert by_name["t"].attributes == {"min": "0", "max": "34.6"}
    assert by_name["e"].attributes["enum_val1"] == "b < c"
    assert by_name["c"].text is None
    assert by_name["c"].attributes == {"r": "255", "g": "0", "b": "0", "a": "255"}
    assert by_name["M"].attributes == {"val0": "1", "val15": "1"}
    assert by_name["o"].text == "größe 1.ply"
    assert second == Step(
        "Screened Poisson", 15, (Param("depth", 15, "", "8"),), from_xml_plugin=True
    )


def test_a_script_without_steps_is_a_script(tmp_path):
    path = written(tmp_path, "<FilterScript/>")
    assert read_script(str(path)) == Script(path, ())


A_STEP = '<filter name="größe"><Param type="RichInt" name="n" value="1"/></filter>'
SAME_SCRIPT = {
    "blank lines before the first of XML": '\n \n<?xml version="1.0" encoding="UTF-8"?>\n{}',
    "blank lines before the document type": "\n\n<!DOCTYPE FilterScript>\n{}",
    "comments everywhere": "<!-- a --><!DOCTYPE FilterScript><!-- b -->{}<!-- c -->",
    "no document type": "{}",
}


@pytest.mark.parametrize("form", SAME_SCRIPT.values(), ids=SAME_SCRIPT)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig"])
def test_forms_of_one_script(tmp_path, form, encoding):
    content = form.format(f"<FilterScript> text {A_STEP} text</FilterScript>")
    (step,) = read_script(written(tmp_path, content.encode(encoding))).steps
    assert step == Step("größe", 0, (Param("n", 0, "RichInt", "1"),))
    assert step.line == content.count("\n") + 1


@pytest.mark.parametrize(
    ("encoding", "declared"),
    [("utf-16", "utf-16"), ("latin-1", "ISO-8859-1"), ("cp1252", "windows-1252")],
)
def test_encodings(tmp_path, encoding, declared):
    content = f'<?xml version="1.0" encoding="{declared}"?><FilterScript>{A_STEP}</FilterScript>'
    (step,) = read_script(written(tmp_path, content.encode(encoding))).steps
    assert step.name == "größe"


def test_tags_in_any_case_and_parameters_of_either_kind(tmp_path):
    path = written(
        tmp_path,
        "<filterscript><FILTER name='a'><param name='n' value='1' type='RichInt' shape='round'/>"
        "<xmlparam name='m' value='2'/></FILTER><XmlFilter name='b'><Param name='o' value='3'/>"
        "</XmlFilter></filterscript>",
    )
    first, second = read_script(path).steps
    assert [(known.name, known.rich_type, known.text) for known in first.parameters] == [
        ("n", "RichInt", "1"),
        ("m", "", "2"),
    ]
    assert first.parameters[0].attributes == {"shape": "round"}
    assert (first.from_xml_plugin, second.from_xml_plugin) == (False, True)
    assert second.parameters == (Param("o", 0, "", "3"),)


def test_a_parameter_that_is_given_twice_alike_is_read_once(tmp_path):
    path = written(tmp_path, inside("<Param name='n' value='1'/><Param name='n ' value='1'/>"))
    assert read_script(path).steps[0].parameters == (Param("n", 0, "", "1"),)


@pytest.mark.parametrize(
    ("second", "count"),
    [
        ("name='Flag' value='TRUE '", 1),
        ("type='RichBool' name=' flag' value=' True'", 1),
        ("name='flag' value='false'", 2),
        ("name='flag'", 2),
        ("name='flag' value='true' min='0'", 2),
        ("type='RichString' name='flag' value='true '", 1),
        ("type='RichString' name='flag' value='True'", 2),  # a text, of which case is a part
    ],
)
def test_only_a_parameter_that_says_the_same_again_is_left_out(tmp_path, second, count):
    first = "<Param type='RichBool' name='flag' value='true'/>"
    path = written(tmp_path, inside(f"{first}<Param name='m' value='1'/><Param {second}/>"))
    (step,) = read_script(path).steps
    assert step.parameters[:2] == (
        Param("flag", 0, "RichBool", "true"),
        Param("m", 0, "", "1"),
    )
    assert len(step.parameters) == 1 + count


def test_what_has_no_name_is_read_with_its_line(tmp_path):
    text = (
        "\n\n<?xml version='1.0'?>\n<FilterScript><filter/>\n<xmlfilter name=' '>\n{}{}</xmlfilter>"
    )
    nameless = "<xmlparam value='1'/>"
    path = written(tmp_path, text.format(nameless, nameless) + "</FilterScript>")
    first, second = read_script(path).steps
    assert (first.name, first.line, second.name, second.line) == ("", 4, " ", 5)
    assert [(known.name, known.line) for known in second.parameters] == [("", 6), ("", 6)]


def inside(parameters: str) -> str:
    return f"<FilterScript><filter name='a'>{parameters}</filter></FilterScript>"


BOMB = """<!DOCTYPE FilterScript [
<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>
<FilterScript><filter name="&b;"/></FilterScript>"""
STOLEN = """<!DOCTYPE FilterScript [<!ENTITY a SYSTEM "file:///etc/passwd">]>
<FilterScript><filter name="&a;"/></FilterScript>"""


@pytest.mark.parametrize(
    ("content", "line", "words"),
    [
        ("", 1, "not XML: no element found"),
        ("hello\n", 1, "not XML: syntax error"),
        ("<FilterScript>\n<filter name='a'>\n</FilterScript>", 3, "not XML: mismatched tag"),
        ("<FilterScript>\n", 2, "not XML: no element found"),
        ("<FilterScript/>\n<more/>", 2, "not XML: junk after document element"),
        (b"<FilterScript>\n\n<filter name='\xff'/></FilterScript>", 3, "not XML"),
        (b"<?xml version='1.0' encoding='no-such'?><FilterScript/>", 1, "not"),
        ("\n<MeshLabProject/>", 2, "must be <FilterScript>; got <MeshLabProject>"),
        (BOMB, 2, "must not define entities"),
        (STOLEN, 1, "must not define entities"),
        ("<FilterScript>\n<filtre name='a'/></FilterScript>", 2, "or <xmlfilter>; got <filtre>"),
        (inside("\n<filter name='n'/>"), 2, "<filter> has no place inside <filter>"),
        ("\r\n \r\n<?xml version='1.0'?>\r\n<FilterScript>", 4, "not XML: no element found"),
        (
            inside("<Param type='RichInt' name='n'>\n<Param/></Param>"),
            2,
            "<Param> has no place inside <param>",
        ),
    ],
)  # fmt: skip
def test_bad_scripts_are_named_with_their_line(tmp_path, content, line, words):
    path = written(tmp_path, content)
    with pytest.raises(ScriptError) as caught:
        read_script(path)
    assert str(caught.value).startswith(f"{path}:{line}: ")
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(FileError, match=r"none\.mlx cannot be read: No such file"):
        read_script(tmp_path / "none.mlx")
    with pytest.raises(FileError, match="cannot be read: Is a directory"):
        read_script(tmp_path)
    with pytest.raises(FileError, match="cannot be read: embedded null"):
        read_script("a\0b.mlx")
