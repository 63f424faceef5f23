"""Names of results."""

from __future__ import annotations

from pathlib import Path

import pytest

from meshlab_symrecon.batch.inputs import Scan
from meshlab_symrecon.batch.names import named
from meshlab_symrecon.errors import ParameterError

SCANS = (
    Scan(Path("in/head.obj"), Path()),
    Scan(Path("in/left/arm.ply"), Path("left")),
    Scan(Path("in/right/leg.{x}.xyzw"), Path("right")),
)


def names(template, scans=SCANS):
    found = named(template, scans, script="../clean up.mlx", writable=("ply", "obj", "mlp"))
    return [path.as_posix() for path in found]


@pytest.mark.parametrize(
    ("template", "expected"),
    [
        ("{stem}.ply", ["head.ply", "arm.ply", "leg.{x}.ply"]),
        ("{stem}.{extension}", ["head.obj", "arm.ply", "leg.{x}.ply"]),
        ("{parent}/{stem}.ply", ["in/head.ply", "left/arm.ply", "right/leg.{x}.ply"]),
        ("{folder}/{stem}.ply", ["head.ply", "left/arm.ply", "right/leg.{x}.ply"]),
        ("{number:03}.PLY", ["001.PLY", "002.PLY", "003.PLY"]),
        ("{stem} {script}.mlp", ["head clean up.mlp", "arm clean up.mlp", "leg.{x} clean up.mlp"]),
    ],
)
def test_templates(template, expected):
    assert names(template) == expected


@pytest.mark.parametrize(
    ("template", "words"),
    [
        ("{name}.ply", "unknown field '{name}'"),
        ("{stem.upper}.ply", "unknown field"),
        ("{stem!r}.ply", "unknown field"),
        ("{stem:>9}.ply", "unknown field"),
        ("{}.ply", "unknown field"),
        ("{stem.ply", "cannot be read"),
        ("{number:x.y}.ply", "'x.y' is no width of up to 99"),
        ("{number:099999999}.ply", "is no width of up to 99"),  # gigabytes
        ("{number:{stem}}.ply", "is no width of up to 99"),  # a scan's name may be a number
        ("../{stem}.ply", "not inside of the folder"),
        ("/elsewhere/{stem}.ply", "not inside of the folder"),
        ("", "not inside of the folder"),
        (".{stem}.ply", "hidden"),
        ("{stem}.pdf", "'.pdf', which cannot be written"),
        ("{stem}", "which cannot be written"),
    ],
)
def test_what_a_template_cannot_be(template, words):
    with pytest.raises(ParameterError) as caught:
        names(template)
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("first", "second", "template", "field"),
    [
        ("a/x.ply", "a/x.obj", "{stem}.ply", "{extension}"),
        ("a/x.ply", "b/x.ply", "{stem}.ply", "{parent}"),
        ("a/c/x.ply", "b/c/x.ply", "{stem}.ply", "{folder}"),
        ("a/x.ply", "a/y.ply", "all.ply", "{stem}"),
        ("a/Größe.ply", "a/GRÖSSE.ply", "{stem}.ply", "{number}"),
        ("a/gr\u00fc\u00df.ply", "a/gru\u0308\u00df.ply", "{stem}.ply", "{number}"),
        ("a/x.ply", "b/x.ply", "{parent}x{script}.ply", None),
    ],
)
def test_two_scans_of_one_name_are_told_how_to_differ(first, second, template, field):
    scans = tuple(Scan(path, path.parent) for path in map(Path, (first, second)))
    if field is None:
        assert len(set(names(template, scans))) == 2
        return
    with pytest.raises(ParameterError) as caught:
        names(template, scans)
    message = str(caught.value)
    assert f"{first} and {second} would both become" in message
    assert f"by {field}" in message
    advice = message.split("--name '")[1].rstrip("'")
    assert len(set(names(advice, scans))) == 2  # the advice works
