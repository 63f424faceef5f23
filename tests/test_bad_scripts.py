"""Damaged, hostile and mistaken scripts: each is refused with file, line and reason, unrun.

The scripts are made here, the same at every run. Each states what it is refused for; a few that
only look bad say that they run.
"""

from __future__ import annotations

import gzip
import json
import os
import random
import re
import resource
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pymeshlab
import pytest
from click.testing import CliRunner

from meshlab_symrecon.cli.main import main

LIMIT = 300  # seconds after which a script counts as one that hangs, on a busy machine, too
ADDRESSES = 3 << 30  # bytes that a process may ask for, several times what starting it takes
NOT_XML = "this is not XML"
GOOD = """<!DOCTYPE FilterScript>
<FilterScript>
 <filter name="Laplacian Smooth">
  <Param type="RichInt" name="stepSmoothNum" value="3"/>
  <Param type="RichBool" name="Boundary" value="true"/>
 </filter>
 <filter name="Close Holes">
  <Param type="RichInt" name="MaxHoleSize" value="30"/>
 </filter>
 <filter name="Rename Current Mesh">
  <Param type="RichString" name="newName" value="cleaned"/>
 </filter>
</FilterScript>
"""


def script(*steps: str, head: str = "<!DOCTYPE FilterScript>\n") -> str:
    return head + "<FilterScript>\n" + "\n".join(steps) + "\n</FilterScript>\n"


def step(name: str, *parameters: str, tag: str = "filter") -> str:
    return f'<{tag} name="{name}">{"".join(parameters)}</{tag}>'


def param(name: str, value: str, rich_type: str = "RichInt") -> str:
    return f'<Param type="{rich_type}" name="{name}" value="{value}"/>'


SMOOTH = step("Laplacian Smooth")


def truncated() -> Iterator[tuple[str, str]]:
    """Cut the good script off at 30 places before its last bracket."""
    end = GOOD.rindex(">")
    for place in sorted(random.Random(1).sample(range(1, end), 30)):
        yield f"cut off after {place} characters", GOOD[:place]


def without_a_character(signs: str, count: int, seed: int) -> Iterator[tuple[str, str]]:
    """Leave out one of the characters without which nothing is well-formed."""
    places = [place for place, letter in enumerate(GOOD) if letter in signs]
    for place in sorted(random.Random(seed).sample(places, count)):
        yield f"without {GOOD[place]!r} at {place}", GOOD[:place] + GOOD[place + 1 :]


def not_well_formed() -> Iterator[tuple[str, str | bytes]]:
    yield from truncated()
    yield from without_a_character('"', 12, 2)
    yield from without_a_character(">", 6, 3)
    yield "another end tag", GOOD.replace("</filter>", "</Filter>", 1)
    yield (
        "end tags in the wrong order",
        GOOD.replace("</filter>\n</FilterScript>", "</FilterScript></filter>"),
    )
    yield "no end of the last step", GOOD.replace(" </filter>\n</", "</", 1)
    yield "one end too many", GOOD + "</FilterScript>\n"
    yield "two roots", GOOD + "<FilterScript/>\n"
    yield "text behind the end", GOOD + "that was all\n"
    yield "an ampersand", GOOD.replace("cleaned", "rock & roll")
    yield "a bracket in a value", GOOD.replace("cleaned", "z < 0")
    yield "an attribute twice", GOOD.replace('value="3"', 'value="3" value="4"')
    yield "an attribute without quotes", GOOD.replace('value="3"', "value=3")
    yield (
        "two hyphens in a comment",
        GOOD.replace("<FilterScript>", "<FilterScript><!-- a -- b -->"),
    )
    yield "a comment without end", GOOD.replace("<FilterScript>", "<FilterScript><!-- a")
    yield "an undeclared entity", GOOD.replace("cleaned", "a&nbsp;b")
    yield "a NUL", GOOD.replace("cleaned", "a\0b")
    yield "a bell", GOOD.replace("cleaned", "a\ab")
    yield "a reference to NUL", GOOD.replace("cleaned", "&#0;")
    yield "a reference to a surrogate", GOOD.replace("cleaned", "&#xD800;")
    yield "a reference beyond Unicode", GOOD.replace("cleaned", "&#x110000;")
    yield "bytes that are no UTF-8", GOOD.encode().replace(b"cleaned", b"\xff\xfe")
    yield "a surrogate in UTF-8", GOOD.encode().replace(b"cleaned", b"\xed\xa0\x80")
    yield "UTF-8 that says UTF-16", b'<?xml version="1.0" encoding="UTF-16"?>' + GOOD.encode()
    yield "UTF-16 cut in half", GOOD.encode("utf-16")[: len(GOOD)]
    yield "UTF-32", GOOD.encode("utf-32")
    yield "nothing", ""
    yield "blanks", " \n\t\n"
    yield "a byte order mark", b"\xef\xbb\xbf"
    yield "a doctype only", "<!DOCTYPE FilterScript>\n"
    yield "a comment only", "<!-- later -->\n"
    yield "a declaration only", '<?xml version="1.0"?>\n'
    yield "zeros", bytes(4096)
    yield "random bytes", random.Random(4).randbytes(4096)
    yield "ten million random bytes", random.Random(5).randbytes(10_000_000)
    yield "ten million letters", "A" * 10_000_000
    yield "a compressed script", gzip.compress(GOOD.encode(), mtime=0)
    yield "JSON", json.dumps({"filters": [{"name": "Laplacian Smooth"}]})
    yield "a Python script", "import pymeshlab\nms = pymeshlab.MeshSet()\n"
    yield "a mesh", "ply\nformat ascii 1.0\nelement vertex 1\nend_header\n0 0 0\n"


def laughs(levels: int) -> str:
    lines = ['<!ENTITY l0 "ha">']
    for level in range(1, levels):
        lines.append(f'<!ENTITY l{level} "{f"&l{level - 1};" * 10}">')
    head = "<!DOCTYPE FilterScript [\n" + "\n".join(lines) + "\n]>\n"
    return script(step(f"&l{levels - 1};"), head=head)


def with_doctype(inside: str, use: str = "Laplacian Smooth") -> str:
    return script(step(use), head=f"<!DOCTYPE FilterScript {inside}>\n")


ENTITIES = "must not define entities"
OUTSIDE = "must not name a file or address"


def hostile() -> Iterator[tuple[str, str, int, str]]:
    """Yield what makes readers of XML fetch files or fill the memory; with line and reason."""
    yield "a billion laughs", laughs(10), 2, ENTITIES
    yield "three laughs", laughs(2), 2, ENTITIES
    quadratic = with_doctype(f'[<!ENTITY a "{"a" * 50_000}">]', "&a;" * 50_000)
    yield "one long entity, often", quadratic, 1, ENTITIES
    file = '[<!ENTITY x SYSTEM "file:///etc/passwd">]'
    yield "an entity from a file", with_doctype(file, "&x;"), 1, ENTITIES
    yield (
        "the same in the text",
        with_doctype(file).replace("</filter>", "&x;</filter>"),
        1,
        ENTITIES,
    )
    web = '[<!ENTITY x SYSTEM "http://127.0.0.1:9/x">]'
    yield "an entity from the web", with_doctype(web, "&x;"), 1, ENTITIES
    public = '[<!ENTITY x PUBLIC "-//A//B" "http://127.0.0.1:9/x">]'
    yield "a public entity", with_doctype(public), 1, ENTITIES
    inner = '[<!ENTITY % p SYSTEM "http://127.0.0.1:9/x"> %p;]'
    yield "a parameter entity", with_doctype(inner), 1, ENTITIES
    yield "a parameter entity with text", with_doctype('[<!ENTITY % p "x"> %p;]'), 1, ENTITIES
    pair = '[<!ENTITY a "&b;"><!ENTITY b "&a;">]'
    yield "entities in a circle", with_doctype(pair, "&a;"), 1, ENTITIES
    unparsed = '[<!NOTATION n SYSTEM "n"><!ENTITY x SYSTEM "x.gif" NDATA n>]'
    yield "an unparsed entity", with_doctype(unparsed), 1, ENTITIES
    yield "a doctype from a file", with_doctype('SYSTEM "file:///etc/passwd"'), 1, OUTSIDE
    yield "a doctype from the web", with_doctype('SYSTEM "http://127.0.0.1:9/x.dtd"'), 1, OUTSIDE
    yield "a public doctype", with_doctype('PUBLIC "-//A//B" "http://127.0.0.1:9/x"'), 1, OUTSIDE
    included = '<xi:include xmlns:xi="http://www.w3.org/2001/XInclude" href="/etc/passwd"/>'
    yield "an inclusion", script(included), 3, "a step must be a <filter> or <xmlfilter>"
    inside = SMOOTH.replace("></", f">{included}</")
    yield "an inclusion in a step", script(inside), 3, "has no place inside <filter>"


def misshapen() -> Iterator[tuple[str, str, int, str]]:
    """Yield XML that is no filter script; with line and reason."""
    root = "the outermost element must be <FilterScript>"
    yield "a project", "<!DOCTYPE MeshLabDocument>\n<MeshLabProject/>\n", 2, root
    yield "a web page", "<html><body/></html>", 1, root
    page = "<!DOCTYPE html><html><head><meta charset=utf-8><p>404</html>"
    yield "an old web page", page, 1, root
    yield "a lone step", SMOOTH, 1, root
    inside = GOOD.replace(" </filter>\n", "", 1)
    yield "no end of the first step", inside, 6, "<filter> has no place inside <filter>"
    unknown = '<?xml version="1.0" encoding="klingon"?>\n' + GOOD
    yield "an encoding of no kind", unknown, 1, "unknown encoding: klingon"
    yield "a drawing", '<svg xmlns="http://www.w3.org/2000/svg"/>', 1, root
    yield (
        "a root of a namespace",
        GOOD.replace("<FilterScript>", '<FilterScript xmlns="a">'),
        2,
        root,
    )
    deep = "<FilterScript>" * 100_000 + "</FilterScript>" * 100_000
    yield "a hundred thousand roots", deep, 1, "a step must be a <filter>"
    deep = script("<filter name='a'>" * 100_000 + "</filter>" * 100_000)
    yield "a hundred thousand steps in each other", deep, 3, "has no place inside <filter>"
    deep = script(step("a", "<Param type='RichInt' name='a' value='1'>" * 100_000))
    yield "a hundred thousand parameters in each other", deep, 3, "has no place inside <param>"
    yield "a parameter outside", script(param("a", "1")), 3, "a step must be a <filter>"
    yield "a step of another kind", script("<plugin name='x'/>"), 3, "a step must be a <filter>"
    yield (
        "an unknown child",
        script(step("Laplacian Smooth", "<Value/>")),
        3,
        "<Value> has no place",
    )
    yield "a script in a script", script(script(head="").strip()), 3, "a step must be a <filter>"
    yield "no name of a step", script("<filter/>"), 3, "this <filter> has no name"
    yield "an empty name of a step", script('<filter name="  "/>'), 3, "this <filter> has no name"
    nameless = step("Laplacian Smooth", '<Param type="RichInt" value="1"/>')
    yield "no name of a parameter", script(nameless), 3, "this parameter has no name"
    twice = step("Close Holes", param("MaxHoleSize", "3"), param("maxholesize", "4"))
    yield "a parameter twice", script(SMOOTH, twice), 4, "is given twice"


def wrong(name: str, *parameters: str) -> str:
    """Return a script whose second step is the wrong one."""
    return script(SMOOTH, step(name, *parameters))


def mistaken() -> Iterator[tuple[str, str, int, str]]:
    """Yield scripts that ask for what is not there; with line and reason."""
    whole = "must be a whole number"
    for value in ("three", "", "3.5", "1e400", "NaN", "inf", "-inf", "0x10", "3 4", "1,5"):
        bad = wrong("Close Holes", param("MaxHoleSize", value))
        yield f"{value!r} for a whole number", bad, 4, whole
    for value in (str(10**30), str(-(10**30)), str(2**31), "9" * 5000):
        bad = wrong("Close Holes", param("MaxHoleSize", value))
        yield f"{value[:12]}... of {len(value)} digits for a whole number", bad, 4, whole
    for value in ("nan", "inf", "1e400", "-1e400", "half", "1.2.3"):
        bad = wrong("Taubin Smooth", param("lambda", value, "RichFloat"))
        yield f"{value!r} for a number", bad, 4, "must be a number"
    for value in ("yes", "2", "wahr", "", "-1"):
        bad = wrong("Laplacian Smooth", param("Boundary", value, "RichBool"))
        yield f"{value!r} for a boolean", bad, 4, "must be true or false"
    for value in ("Mean", "99", "-1", "Mean Curvature "[::-1], ""):
        bad = wrong("Discrete Curvatures", param("CurvatureType", value, "RichEnum"))
        yield f"{value!r} for a choice", bad, 4, "must be one of 'Mean Curvature'"
    for value in ("wide", "nan", "1e999", "5%%", "-5%", "101%", "nan%", "%"):
        bad = wrong("Merge Close Vertices", param("Threshold", value, "RichAbsPerc"))
        yield f"{value!r} for a length", bad, 4, "must be a length"
    for attributes in ('r="1" g="2"', 'r="256" g="0" b="0"', 'r="red" g="0" b="0" a="0"', ""):
        colour = f'<Param type="RichColor" name="color1" {attributes}/>'
        yield f"the colour {attributes}", wrong("Vertex Color Filling", colour), 4, "'color1'"
    for attributes in ('x="0" y="1"', 'x="0" y="1" z="up"', 'x="nan" y="0" z="1"'):
        point = f'<Param type="RichPosition" name="viewPos" {attributes}/>'
        named = "Compute normals for point sets"
        yield f"the position {attributes}", wrong(named, point), 4, "parameter 'view"
    matrix = '<Param type="RichMatrix44f" name="TransformMatrix" val0="1"/>'
    yield (
        "a matrix of one",
        wrong("Matrix: Set/Copy Transformation", matrix),
        4,
        "no attribute 'val1'",
    )
    negative = wrong("Change the current layer", param("mesh", "-2", "RichMesh"))
    yield "a negative layer", negative, 4, "must be a layer"
    for name in ("..", "pictures/", "C:\\pictures\\"):
        bad = wrong("Vertex Color to Texture", param("textname", name, "RichString"))
        yield f"{name!r} for a picture", bad, 4, "must be a picture's name"
    yield "no layer", wrong("Change the current layer"), 4, "needs the parameter 'mesh'"
    beyond = wrong("Change the current layer", param("mesh", "9", "RichMesh"))
    yield "a layer that is not there", beyond, 4, "got 9"
    yield "an unknown filter", wrong("Laplacian Smoth"), 4, "did you mean 'Laplacian Smooth'?"
    yield "a filter of letters", wrong("x" * 1_000_000), 4, "no filter is called"
    yield "a path for a filter", wrong("../../../etc/passwd"), 4, "no filter is called"
    unknown = wrong("Close Holes", param("x" * 1_000_000, "1"))
    yield "a parameter of letters", unknown, 4, "unknown parameter"
    long = wrong("Close Holes", param("MaxHoleSize", "A" * 5_000_000))
    yield "a value of letters", long, 4, whole
    ours = "Detect Reflection Planes (AP)"
    yield "too many planes", wrong(ours, param("maxplanes", "33")), 4, "from 1 to 32; got 33"
    yield "no planes", wrong(ours, param("maxplanes", "-5")), 4, "from 1 to 32; got -5"
    yield "too many digits of ours", wrong(ours, param("randomseed", "9" * 5000)), 4, whole
    infinite = wrong("Mirror-Complete Points", param("gap", "1e400", "RichFloat"))
    yield "an infinite gap", infinite, 4, "parameter 'gap' must be"
    crust = wrong("Surface Reconstruction: Power Crust", param("surface", "smooth", "RichEnum"))
    yield "an unknown surface", crust, 4, "must be one of 'power crust'"
    gpu = "draws with OpenGL"
    yield "a picture", wrong("Ambient Occlusion"), 4, gpu
    yield "a picture by its Python name", wrong("save_snapshot"), 4, gpu
    yield "a crash", wrong("Structure Synth Mesh Creation"), 4, "aborts in pymeshlab"


BAD = [
    *((name, content, None, NOT_XML) for name, content in not_well_formed()),
    *hostile(),
    *misshapen(),
    *mistaken(),
]
FINE = {  # these only look bad
    "a processing instruction": GOOD.replace("<FilterScript>", "<?php exit(1); ?><FilterScript>"),
    "a style sheet": '<?xml-stylesheet href="http://127.0.0.1:9/x.xsl"?>\n' + GOOD,
    "a step in a comment": GOOD.replace("<FilterScript>\n", f"<FilterScript>\n<!--{SMOOTH}-->"),
    "a character section": GOOD.replace(">\n </filter>", "><![CDATA[ \n ]]></filter>"),
    "characters by number": GOOD.replace("cleaned", "&#99;l&#x65;aned"),
    "tabs and line ends": GOOD.replace(" ", "\t").replace("Laplacian\tSmooth", "Laplacian Smooth")
    .replace("Close\tHoles", "Close Holes").replace("Rename\tCurrent\tMesh", "Rename Current Mesh")
    .replace("\n", "\r"),
    "a long label": GOOD.replace("cleaned", "b" * 100_000),
}  # fmt: skip


@pytest.fixture(scope="module")
def sphere(tmp_path_factory):
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.create_sphere(subdiv=2)
    path = tmp_path_factory.mktemp("scans") / "sphere.ply"
    mesh_set.save_current_mesh(str(path))
    return path


@pytest.fixture
def desk(tmp_path, monkeypatch, sphere):
    """The current folder, with a mesh, a script to be filled in, and an output of before."""
    monkeypatch.chdir(tmp_path)
    Path("scan.ply").write_bytes(sphere.read_bytes())
    Path("out.ply").write_bytes(b"what was there before")
    return tmp_path


@pytest.fixture
def limited() -> Iterator[None]:
    """End a script that hangs."""

    def stop(*_: object) -> None:
        pytest.fail(f"no end after {LIMIT} seconds")

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(LIMIT)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


def contents(folder: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def filled(content: str | bytes) -> Path:
    path = Path("bad.mlx")
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def run_in_process(path: Path) -> tuple[int, str]:
    result = CliRunner().invoke(main, ["run", str(path), "scan.ply", "-o", "out.ply"])
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    return result.exit_code, result.stderr


def run_in_shell(path: Path) -> tuple[int, str]:
    command = [sys.executable, "-m", "meshlab_symrecon.cli.main", "run", str(path), "scan.ply"]
    ended = subprocess.run(
        [*command, "-o", "out.ply"], capture_output=True, text=True, check=False, timeout=LIMIT,
        env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},  # whose threads ask for addresses
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (ADDRESSES, ADDRESSES)),
    )  # fmt: skip
    return ended.returncode, ended.stderr


def check_refused(
    run: Callable[[Path], tuple[int, str]], content: str | bytes, line: int | None, words: str
) -> None:
    path = filled(content)
    before = contents(Path())
    code, said = run(path)
    assert code == 1, said[:2000]
    assert "Traceback" not in said
    assert said.startswith(f"error: {path}:")
    found = said.removeprefix("error: ").splitlines()
    for sentence in found:
        assert re.match(rf"{re.escape(str(path))}:\d+: \S", sentence), sentence[:300]
        assert len(sentence) < 1000
    assert any(words in sentence for sentence in found), said[:2000]
    if line is not None:
        assert [sentence.split(":")[1] for sentence in found] == [str(line)]
    assert contents(Path()) == before


@pytest.mark.parametrize(
    ("content", "line", "words"), [bad[1:] for bad in BAD], ids=[bad[0][:60] for bad in BAD]
)
def test_a_bad_script_is_refused_with_file_line_and_reason(desk, limited, content, line, words):
    check_refused(run_in_process, content, line, words)


@pytest.mark.parametrize(
    ("content", "line", "words"), [bad[1:] for bad in BAD], ids=[bad[0][:60] for bad in BAD]
)
def test_a_check_finds_the_same_and_writes_nothing(desk, limited, content, line, words):
    path = filled(content)
    before = contents(Path())
    result = CliRunner().invoke(main, ["check", str(path), "scan.ply"])
    assert result.exit_code == 1
    assert result.exception is None or isinstance(result.exception, SystemExit)
    told = result.stdout.splitlines() + result.stderr.removeprefix("error: ").splitlines()
    found = [sentence for sentence in told if words in sentence]
    assert found, told
    for sentence in found:
        assert sentence.startswith(f"{path}:")
        assert line is None or sentence.split(":")[1] == str(line)
    assert contents(Path()) == before


IN_SHELL = (
    "a billion laughs", "one long entity, often", "an entity from the web", "a NUL", "zeros",
    "ten million random bytes", "a hundred thousand steps in each other", "a crash",
    "a layer that is not there", "a value of letters",
)  # fmt: skip


@pytest.mark.parametrize("name", IN_SHELL)
def test_a_bad_script_ends_a_process_of_little_memory_in_order(desk, name):
    _, content, line, words = next(bad for bad in BAD if bad[0] == name)
    check_refused(run_in_shell, content, line, words)


@pytest.mark.parametrize("name", FINE)
def test_a_script_that_only_looks_bad_runs(desk, limited, name):
    path = filled(FINE[name])
    before = contents(Path())
    code, said = run_in_process(path)
    assert (code, said) == (0, "")
    after = contents(Path())
    assert after.pop("out.ply").startswith(b"ply")
    assert after == {name: held for name, held in before.items() if name != "out.ply"}


def test_what_is_no_file_is_no_script(desk):
    for path, reason in ((Path("folder"), "is a directory"), (Path("gone.mlx"), "no such file")):
        if path.suffix == "":
            path.mkdir()
        before = contents(Path())
        code, said = run_in_process(path)
        assert code == 1
        assert said.startswith(f"error: script {path} cannot be read: ")
        assert reason in said.lower()
        assert contents(Path()) == before


@pytest.mark.parametrize("extension", ["ply", "obj", "dae"])
@pytest.mark.parametrize("folder", ["..", "../..", "sub/../../..", "{desk}"])
def test_a_texture_of_a_script_is_written_beside_the_output_only(desk, folder, extension):
    work = desk / "work" / "today"  # folders that "../.." does not leave
    work.mkdir(parents=True)
    os.chdir(work)
    Path("scan.ply").write_bytes(Path("..", "..", "scan.ply").read_bytes())
    named = folder.format(desk=desk) + "/evil.png"
    path = filled(
        script(
            step("Vertex Color Filling"),
            step("Parametrization: Trivial Per-Triangle"),
            step("Transfer: Vertex Color to Texture", param("textname", named, "RichString")),
        )
    )
    before = contents(desk)
    words = ["run", str(path), "scan.ply", "-o", f"out.{extension}"]
    result = CliRunner().invoke(main, words)
    assert result.exit_code == 0, result.stderr
    new = {name for name, held in contents(desk).items() if held != before.get(name)}
    assert f"work/today/out.{extension}" in new
    assert {str(Path(name).parent) for name in new} == {"work/today"}
    assert "the folder of" in result.stdout
    assert not desk.parent.joinpath("evil.png").exists()


def test_there_are_more_than_a_hundred_and_no_two_are_alike():
    contents_of_all = [content for _, content, _, _ in BAD]
    assert len(BAD) > 100
    assert len({name for name, *_ in BAD}) == len(BAD)
    assert len(set(map(str, contents_of_all))) == len(BAD)
