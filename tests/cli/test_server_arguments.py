"""Command lines as shell scripts have them: what each asks for."""

from __future__ import annotations

import shlex
from pathlib import Path

import click
import pytest

from meshlab_symrecon.cli.server_arguments import parse
from meshlab_symrecon.cli.server_job import (
    CURRENT,
    FLAGS,
    LAST,
    Job,
    Load,
    Output,
    ProjectOutput,
)


def mesh(path):
    return Load(Path(path))


def project(path):
    return Load(Path(path), True)


def out(path, mask="", layer=CURRENT):
    return Output(Path(path), layer, frozenset(mask.split()))


def scripts(*paths):
    return tuple(Path(path) for path in paths)


A, B, AB = (mesh("a.ply"),), (mesh("b.ply"),), (mesh("a.ply"), mesh("b.ply"))
S = scripts("s.mlx")
ALL = "vc vf vq vn vt fc ff fq fn wc wn wt"

FORMS = {
    # conversions
    "-i a.ply -o b.obj": Job(A, outputs=(out("b.obj"),)),
    "-i A.STL -o a.OBJ": Job((mesh("A.STL"),), outputs=(out("a.OBJ"),)),
    "-i 'my scan.ply' -o 'out dir/my scan.obj'": Job(
        (mesh("my scan.ply"),), outputs=(out("out dir/my scan.obj"),)
    ),
    "-i ./in/a.dae -o ../a.dae -m vc vn": Job(
        (mesh("in/a.dae"),), outputs=(out("../a.dae", "vc vn"),)
    ),
    "-i a.wrl -o a.off -om vn fn": Job((mesh("a.wrl"),), outputs=(out("a.off", "vn fn"),)),
    "-i a.ply -o a.ply -om vn": Job(A, outputs=(out("a.ply", "vn"),)),
    "-o b.obj -i a.ply": Job(A, outputs=(out("b.obj"),)),
    "-i C:/Code/a.ply -o C:/Code/b.obj": Job(
        (mesh("C:/Code/a.ply"),), outputs=(out("C:/Code/b.obj"),)
    ),
    # with a script, in every order
    "-i a.ply -o b.ply -s s.mlx": Job(A, S, (out("b.ply"),)),
    "-i a.ply -s s.mlx -o b.ply": Job(A, S, (out("b.ply"),)),
    "-s s.mlx -i a.ply -o b.ply": Job(A, S, (out("b.ply"),)),
    "-o b.ply -s s.mlx -i a.ply": Job(A, S, (out("b.ply"),)),
    "-s s.mlx -o b.ply -i a.ply": Job(A, S, (out("b.ply"),)),
    "-i a.ply -o b.ply -m vc fq wn -s s.mlx": Job(A, S, (out("b.ply", "vc fq wn"),)),
    "-i a.ply -o b.ply -s s.mlx -om vc fq wn": Job(A, S, (out("b.ply", "vc fq wn"),)),
    "-i a.ply -o b.ply -s s.mlx -m vc": Job(A, S, (out("b.ply", "vc"),)),
    "-i a.ply -s s.mlx -o b.ply -m vc vn  fc fn wt": Job(
        A, S, (out("b.ply", "vc vn fc fn wt"),)
    ),
    f"-i a.ply -o b.ply -s s.mlx -om {ALL}": Job(A, S, (out("b.ply", ALL),)),
    "-i a.ply -o b.ply -s s.mlx -om": Job(A, S, (out("b.ply"),)),
    "-om vn -i a.ply -o b.ply -s s.mlx": Job(A, S, (out("b.ply", "vn"),)),
    "-om wt -i a.ply -o b.obj": Job(A, outputs=(out("b.obj", "wt"),)),
    "-m vc -i a.ply -o b.ply -o c.ply": Job(A, outputs=(out("b.ply", "vc"), out("c.ply", "vc"))),
    "-i a.ply -o b.ply -m vc -m vn": Job(A, outputs=(out("b.ply", "vc vn"),)),
    "-i a.ply -o b.ply -m vc vc vn": Job(A, outputs=(out("b.ply", "vc vn"),)),
    "-i a.ply -o b.ply -m 'vc vn'": Job(A, outputs=(out("b.ply", "vc vn"),)),
    "-i a.ply -o b.ply -m vc,vn": Job(A, outputs=(out("b.ply", "vc vn"),)),
    "-i a.ply -o b.ply -m VC Vn": Job(A, outputs=(out("b.ply", "vc vn"),)),
    "-i a.ply -s s.mlx": Job(A, S),
    "-s s.mlx -o b.ply": Job((), S, (out("b.ply"),)),
    "-i a.ply -s s.mlx -s t.mlx -o b.ply": Job(A, scripts("s.mlx", "t.mlx"), (out("b.ply"),)),
    "-i a.ply -o b.ply -s s.mlx -o c.obj -m vn -s t.mlx": Job(
        A, scripts("s.mlx", "t.mlx"), (out("b.ply"), out("c.obj", "vn"))
    ),
    "-i a.ply -s script_for_apss.xml -o b.xyz": Job(
        A, scripts("script_for_apss.xml"), (out("b.xyz"),)
    ),
    # several inputs and outputs
    "-i a.ply b.ply -s s.mlx": Job(AB, S),
    "-i a.ply -i b.ply -s s.mlx": Job(AB, S),
    "-i a.ply -s s.mlx -i b.ply": Job(AB, S),
    "-i a.ply b.ply -s s.mlx -o c.ply -om vn fn vc": Job(AB, S, (out("c.ply", "vn fn vc"),)),
    "-i a.ply -o x.ply -m vc -o y.ply -m vn": Job(
        A, outputs=(out("x.ply", "vc"), out("y.ply", "vn"))
    ),
    "-i a.ply b.ply -o x.ply y.ply -om vc": Job(
        AB, outputs=(out("x.ply", "vc", 0), out("y.ply", "vc", 1))
    ),
    "-i a.ply -o x.ply -o y.ply -om vc": Job(
        A, outputs=(out("x.ply", "vc"), out("y.ply", "vc"))
    ),
    "-i a.ply -o x.ply -om vc -o y.ply -om vn": Job(
        A, outputs=(out("x.ply", "vc"), out("y.ply", "vn"))
    ),
    "-i a.ply -o x.stl -o y.stl -m sa fc -o z.stl": Job(
        A, outputs=(out("x.stl"), out("y.stl", "sa fc"), out("z.stl", "sa"))
    ),
    # layers and the log
    "-i a.ply -o b.ply -l 0": Job(A, outputs=(out("b.ply", layer=0),)),
    "-i a.ply -o b.ply -l c": Job(A, outputs=(out("b.ply"),)),
    "-i a.ply -o b.ply -l x -s s.mlx": Job(A, S, (out("b.ply", layer=LAST),)),
    "-i a.ply -o b.ply -l l": Job(A, outputs=(out("b.ply", layer=LAST),)),
    "-i a.ply -o b.ply -l 12 -m vc": Job(A, outputs=(out("b.ply", "vc", 12),)),
    "-i a.ply -o b.ply -m vc -l 2": Job(A, outputs=(out("b.ply", "vc", 2),)),
    "-i a.ply -o b.ply -l 0 -m vc fq wt -o last.ply -l l -s s.mlx": Job(
        A, S, (out("b.ply", "vc fq wt", 0), out("last.ply", layer=LAST))
    ),
    "-l log.txt -i a.ply -o b.ply -m vn fn -s s.mlx": Job(
        A, S, (out("b.ply", "vn fn"),), log=Path("log.txt")
    ),
    "-l log.txt -i a.ply -o b.ply -l x -s s.mlx": Job(
        A, S, (out("b.ply", layer=LAST),), log=Path("log.txt")
    ),
    "-l c -i a.ply -o b.ply -l c": Job(A, outputs=(out("b.ply"),), log=Path("c")),
    "-i a.ply -o b.ply -s s.mlx -l log.txt": Job(A, S, (out("b.ply"),), log=Path("log.txt")),
    "-i a.ply -o b.ply -l log.txt -s s.mlx": Job(A, S, (out("b.ply"),), log=Path("log.txt")),
    "-i a.ply -o b.ply -s s.mlx -l 1": Job(A, S, (out("b.ply", layer=1),)),
    "-l log.txt -d list.txt -i a.ply": Job(A, log=Path("log.txt"), dump=Path("list.txt")),
    "-d list.txt": Job(dump=Path("list.txt")),
    # projects
    "-p in.mlp -s s.mlx -w out.mlp": Job(
        (project("in.mlp"),), S, projects=(ProjectOutput(Path("out.mlp")),)
    ),
    "-p in.mlp -i a.ply -w out.mlp -x -s s.mlx": Job(
        (project("in.mlp"), *A), S, projects=(ProjectOutput(Path("out.mlp"), True),)
    ),
    "-i a.ply -i b.ply -w out.mlp -x -s s.mlx": Job(
        AB, S, projects=(ProjectOutput(Path("out.mlp"), True),)
    ),
    "-i a.ply -o b.off -w out.mlp -x -s s.mlx": Job(
        A, S, (out("b.off"),), (ProjectOutput(Path("out.mlp"), True),)
    ),
    "-p in.mlp -w a.mlp -w b.mlp -x": Job(
        (project("in.mlp"),),
        projects=(ProjectOutput(Path("a.mlp")), ProjectOutput(Path("b.mlp"), True)),
    ),
    "-p in.mlp -o b.ply -m vn -s s.mlx": Job((project("in.mlp"),), S, (out("b.ply", "vn"),)),
    "-i in.MLP -o out.mlp": Job(
        (project("in.MLP"),), projects=(ProjectOutput(Path("out.mlp")),)
    ),
    "-p scans.aln -o b.ply": Job((project("scans.aln"),), outputs=(out("b.ply"),)),
    # around it
    "-platform offscreen -i a.ply -o b.ply": Job(A, outputs=(out("b.ply"),)),
    "-i a.ply '' -o b.ply ''": Job(A, outputs=(out("b.ply"),)),
    "-h": Job(help=True),
    "--version": Job(version=True),
    "-V": Job(version=True),
    "--list-filters": Job(list_filters=True),
    "-i a.ply --json=r=1.json": Job(loads=A, report=Path("r=1.json")),
    "-i a.ply -o b.ply --keep-all --bake --strict --dry-run --json r.json": Job(
        A, outputs=(out("b.ply"),), keep_all=True, bake=True, strict=True, dry_run=True,
        report=Path("r.json"),
    ),
    "--lenient -i a.ply -s s.mlx": Job(A, S, lenient=True),
}  # fmt: skip


@pytest.mark.parametrize("line", FORMS)
def test_command_lines(line):
    assert parse(shlex.split(line)) == FORMS[line]


def test_what_was_read_otherwise_is_said():
    job = parse(shlex.split("-i a.ply -w out -o b.ply -m binary -o c.ply -m ascii"))
    assert job.projects == (ProjectOutput(Path("out.mlp")),)
    assert job.outputs == (out("b.ply"), out("c.ply", "sa"))
    assert [note.split()[0] for note in job.notes] == ["the", "'binary'", "'ascii'"]
    assert parse(["-i", "a.ply", "-o", "b.ply"]).notes == ()


@pytest.mark.parametrize("flag", FLAGS)
def test_every_flag_alone(flag):
    assert parse(["-i", "a.ply", "-o", "b.ply", "-m", flag]).outputs == (out("b.ply", flag),)


WRONG = {
    "": "there is nothing to do",
    "-l log.txt": "there is nothing to do",
    "-o b.ply": "there is nothing to save",
    "-w out.mlp": "there is nothing to save",
    "-i": "-i needs a value",
    "-i a.ply -o": "-o needs a value",
    "-i -o b.ply": "-i needs a value behind it; got '-o'",
    "-i a.ply -s -o b.ply": "-s needs a value",
    "-p -o b.ply": "-p needs a value",
    "-i a.ply -w -x": "-w needs a value",
    "-i a.ply -d": "-d needs a value behind it; got none",
    "-i a.ply -o b.ply -l": "-l needs a value",
    "-i a.ply -o b.ply -l -1": "-l behind -o takes a layer: N, c or x; got '-1'",
    "-i a.ply -o b.ply -m vc -l -12": "takes a layer: N, c or x; got '-12'",
    "-l -1 -i a.ply": "-l needs a value behind it; got '-1'",
    "-i a.ply --jsonr": "there is no option --jsonr",
    "-i a.ply --json": "--json needs a value",
    "-platform": "-platform needs a value",
    "a.ply b.ply": "'a.ply' stands behind no option",
    "-i a.ply -q": "there is no option -q",
    "-i a.ply -v": "there is no option -v",
    "-i a.ply --keepall": "there is no option --keepall",
    "-i a.ply -x": "-x has its place behind -w",
    "-i a.ply -o b.ply -x": "-x has its place behind -w",
    "-i a.ply -o b.ply -m vz": "'vz' is no flag of -m",
    "-i a.ply -o b.ply -m cv": "'cv' is no flag of -m",
    "-i a.ply -m vc b.ply": "'b.ply' is no flag of -m",
    "-i a.ply -o b.ply -l y": "-l behind -o takes a layer",
    "-i a.ply -o b.ply -l 1 -l 2": "'b.ply' has two layers",
    "-i a.ply -o b.ply c.ply -l 1": "-l names one layer, and 2 files",
    "-l a.txt -i a.ply -s s.mlx -l b.txt": "-l is given twice, 'a.txt' and 'b.txt'",
    "-d a.txt -d b.txt": "-d is given twice",
    "-i a.ply --json a.json --json b.json": "--json is given twice",
    "-i a.ply --strict --lenient": "--strict and --lenient exclude each other",
}


@pytest.mark.parametrize("line", WRONG)
def test_wrong_usage(line):
    with pytest.raises(click.UsageError, match=WRONG[line]):
        parse(shlex.split(line))
