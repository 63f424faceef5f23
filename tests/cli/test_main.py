"""The border: exit codes, sentences, interruption; and the list of filters."""

from __future__ import annotations

import json
import os
import shlex
import subprocess
import sys
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

import meshlab_symrecon
from meshlab_symrecon.cli.border import BorderGroup
from meshlab_symrecon.cli.progress import progress_bar
from meshlab_symrecon.cli.reports import detection, plain
from meshlab_symrecon.errors import FileError, HostError, ParameterError
from meshlab_symrecon.host.files import load
from meshlab_symrecon.host.native_filters import native_filters
from meshlab_symrecon.host.registration import registry
from meshlab_symrecon.plugin.documentation import describe


def ended(error):
    @click.group(cls=BorderGroup)
    def group():
        """Stand in."""

    @group.command()
    def fail():
        raise error

    return CliRunner().invoke(group, ["fail"])


class Foreign(Exception):
    __module__ = "pymeshlab.pmeshlab"


@pytest.mark.parametrize(
    ("error", "code", "said"),
    [
        (ParameterError("'a' must be 1; got 2"), 1, "error: 'a' must be 1; got 2"),
        (FileError("a.ply is empty"), 1, "error: a.ply is empty"),
        (OSError(28, "No space left", "a.ply"), 1, "error: a.ply: No space left"),
        (OSError("odd"), 1, "error: odd"),
        (HostError("s.mlx:3: 'X': std::bad_alloc; look for it"), 1, "error: s.mlx:3: 'X': there is "
         "not enough memory for this; close programs or thin the scan out first"),
        (Foreign("std::bad_array_new_length"), 1, "error: MeshLab: there is not enough memory for "
         "this; close programs or thin the scan out first"),
        (MemoryError(), 1, "error: there is not enough memory for this; close programs or thin the "
         "scan out first"),
        (ImportError("libGL.so.1: no such file", name="pmeshlab"), 1, "error: pymeshlab cannot be "
         "loaded: libGL.so.1: no such file; install what it lacks, on a server without a screen "
         "often the packages libgl1 and libopengl0, or see docs/install.md"),
        (Foreign("it\n went wrong"), 1, "error: MeshLab: it went wrong"),
        (KeyboardInterrupt(), 130, "interrupted; nothing was left half-written"),
        (click.Abort(), 130, "interrupted; nothing was left half-written"),
        (click.UsageError("no"), 2, "Error: no"),
    ],
)  # fmt: skip
def test_errors_become_codes_and_one_sentence(error, code, said):
    result = ended(error)
    assert result.exit_code == code
    assert result.stderr.strip().splitlines()[-1] == said
    assert "Traceback" not in result.stderr


def test_our_own_mistakes_are_not_hidden():
    assert isinstance(ended(ZeroDivisionError("ours")).exception, ZeroDivisionError)
    assert isinstance(ended(ImportError("ours", name="ours")).exception, ImportError)


def test_version_and_help(run, shell):
    for word in ("--version", "-V"):
        assert run(word).stdout == f"symrecon {meshlab_symrecon.__version__}\n"
    for word in ("reconstruct", "apply", "run", "filters"):
        assert word in run("--help").stdout
        assert run(word, "--help").exit_code == 0
    assert shell().returncode == 2
    assert run("nothing").exit_code == 2


def test_help_needs_no_heavy_imports():
    code = (
        "import sys, meshlab_symrecon.cli.main\n"
        "heavy = {'numpy', 'scipy', 'sklearn', 'pymeshlab', 'rich', 'matplotlib'}\n"
        "print(sorted(heavy & set(sys.modules)))"
    )
    result = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert result.stdout == "[]\n"


INTERRUPTED = """
import os, signal, sys, time
from meshlab_symrecon.cli import reconstruct
from meshlab_symrecon.cli.main import main
from meshlab_symrecon.host import files, reconstruction

real = files.write_layer

def slow(*given, **more):
    real(*given, **more)
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(60)

files.write_layer = slow
reconstruction.whole_method = lambda scan, *given, **more: reconstruction.Reconstruction(
    files.load(scan), {}, 0, {}, {}, {}
)
main(sys.argv[1:])
"""


@pytest.mark.skipif(sys.platform == "win32", reason="signals of Posix")
def test_interruption_leaves_nothing_half_written(statue, tmp_path):
    command = [sys.executable, "-c", INTERRUPTED, "reconstruct", statue, "-o", tmp_path / "a.ply"]
    ended = subprocess.run(command, capture_output=True, text=True, check=False)
    assert ended.returncode == 130
    assert ended.stderr == "interrupted; nothing was left half-written\n"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("language", ["C", "POSIX"])
def test_names_of_files_are_utf_8_in_any_language(tmp_path, language):
    start = "from meshlab_symrecon.cli.start import symrecon; symrecon()"
    words = ["apply", "create_cube", "-o", "größe.ply"]
    environment = os.environ | {"LC_ALL": language}
    command = [sys.executable, "-c", start, *words]
    ended = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, env=environment)
    assert (ended.returncode, ended.stderr) == (0, "")
    assert [path.name for path in tmp_path.iterdir()] == ["größe.ply"]


@pytest.mark.skipif(sys.platform == "win32", reason="pipes of Posix")
def test_a_reader_that_goes_away_is_no_traceback():
    command = f"{sys.executable} -m meshlab_symrecon.cli.main filters --all --json | head -c 10"
    result = subprocess.run(command, shell=True, capture_output=True, text=True, check=False)
    assert result.stderr == ""


START = "from meshlab_symrecon.cli import start; start.{}()"


@pytest.mark.skipif(sys.platform == "win32", reason="streams of Posix shells")
@pytest.mark.parametrize("closed", ["0<&-", "1>&-", "2>&-", "0<&- 1>&- 2>&-"])
@pytest.mark.parametrize("program", ["symrecon", "server"])
def test_closed_streams_change_nothing(tmp_path, program, closed):
    made = tmp_path / "s.mlx"
    made.write_text('<FilterScript>\n<filter name="Icosahedron"/>\n</FilterScript>\n')
    words = {
        "symrecon": ["run", made, "-o", tmp_path / "a.ply", "--isolate"],
        "server": ["-s", made, "-o", tmp_path / "a.ply"],
    }[program]
    command = shlex.join([sys.executable, "-c", START.format(program), *map(str, words)])
    ended = subprocess.run(f"{command} {closed}", shell=True, capture_output=True, text=True)
    assert (ended.returncode, ended.stderr) == (0, "")
    assert ("cosahedron" in ended.stdout) == ("1" not in closed)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.ply", "s.mlx"]
    assert load(tmp_path / "a.ply").current_mesh().vertex_number() == 12


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a full device is there on Linux")
def test_an_output_that_is_full_is_one_sentence(tmp_path):
    words = [sys.executable, "-c", START.format("server"), "-s", "s.mlx", "-o", "a.ply"]
    (tmp_path / "s.mlx").write_text('<FilterScript><filter name="Icosahedron"/></FilterScript>')
    with Path("/dev/full").open("w") as full:
        ended = subprocess.run(words, stdout=full, stderr=subprocess.PIPE, text=True, cwd=tmp_path)
    assert (ended.returncode, ended.stderr) == (1, "error: No space left on device\n")


FILES = [
    ["reconstruct", "{}", "-o", "a.ply"],
    ["reconstruct", "b.ply", "-o", "{}"],
    ["reconstruct", "b.ply", "-o", "a.ply", "--report", "{}"],
    ["apply", "create_cube", "-o", "{}"],
    ["apply", "--json", "{}", "create_cube"],
    ["apply", "get_geometric_measures", "{}", "--json", "r.json"],
    ["run", "{}", "-o", "a.ply"],
    ["run", "s.mlx", "{}", "-o", "a.ply"],
    ["run", "s.mlx", "-o", "a.ply", "--log", "{}"],
    ["batch", "s.mlx", "b.ply", "-d", "out", "--json", "{}"],
    ["check", "{}"],
    ["check", "s.mlx", "--json", "{}"],
    ["upgrade", "{}"],
    ["upgrade", "s.mlx", "{}"],
]


@pytest.mark.parametrize("words", FILES, ids=" ".join)
def test_no_name_and_a_stream_are_no_files(run, tmp_path, monkeypatch, words):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "s.mlx").write_text('<FilterScript><filter name="Icosahedron"/></FilterScript>')
    for path, said in (("", "the path is empty"), ("-", "'-' is no file")):
        result = run(*(word.format(path) for word in words))
        assert result.exit_code == 2
        assert said in result.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["s.mlx"]


def without_rights(monkeypatch, *, path, denied):
    """Have the system deny a right to a file, for the superuser has every right."""
    real = os.access

    def access(asked, mode, **more):
        return not (Path(asked).name == path and mode & denied) and real(asked, mode, **more)

    monkeypatch.setattr(os, "access", access)


@pytest.mark.parametrize(
    "words",
    [
        ["apply", "create_cube", "-o", "a.ply"],
        ["apply", "get_geometric_measures", "b.ply", "--json", "a.ply"],
        ["run", "s.mlx", "-o", "a.ply"],
        ["run", "s.mlx", "-o", "c.ply", "--log", "a.ply"],
        ["reconstruct", "b.ply", "-o", "a.ply"],
    ],
    ids=" ".join,
)
def test_a_read_only_file_stays(run, tmp_path, monkeypatch, words):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "s.mlx").write_text('<FilterScript><filter name="Icosahedron"/></FilterScript>')
    assert run("apply", "create_cube", "-o", "b.ply").exit_code == 0
    (tmp_path / "a.ply").write_bytes(b"")
    without_rights(monkeypatch, path="a.ply", denied=os.W_OK)
    result = run(*words)
    told = "error: a.ply cannot be written: the file there is read-only; give another path\n"
    assert (result.exit_code, result.stderr) == (1, told)
    assert (tmp_path / "a.ply").read_bytes() == b""
    assert not (tmp_path / "c.ply").exists()


def test_an_unreadable_file_is_no_wrong_usage(run, tmp_path, monkeypatch):
    """Only the reader knows: an output that exists need not be readable."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.ply").write_bytes(b"")
    without_rights(monkeypatch, path="a.ply", denied=os.R_OK)
    assert run("apply", "create_cube", "-o", "a.ply").exit_code == 0
    assert load(tmp_path / "a.ply").current_mesh().vertex_number() == 8


def test_a_file_may_be_called_like_a_stream(run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run("apply", "create_cube", "-o", "a.ply").exit_code == 0
    assert run("apply", "get_geometric_measures", "a.ply", "--json", "./-").exit_code == 0
    assert json.loads((tmp_path / "-").read_text())["surface_area"] == pytest.approx(6.0)


def test_the_package_is_the_program(tmp_path):
    command = [sys.executable, "-m", "meshlab_symrecon", "--version"]
    told = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert told == f"symrecon {meshlab_symrecon.__version__}\n"


def test_filters_are_listed(run):
    listed = run("filters").stdout
    for item in registry():
        assert item.python_name in listed
        assert item.menu_name in listed
        assert item.summary in listed
    assert f"{len(native_filters())} of MeshLab's own" in listed
    everything = run("filters", "--all").stdout
    assert all(item.python_name in everything for item in native_filters().values())
    assert json.loads(run("filters", "--json").stdout) == [describe(item) for item in registry()]


def test_one_filter_is_shown(run):
    for item in registry():
        for name in item.names:
            assert json.loads(run("filters", name, "--json").stdout) == describe(item)
            page = run("filters", name).stdout
            assert item.description in page
            for parameter in item.parameters.declared():
                assert f"`{parameter.name}`" in page
    page = run("filters", "close holes").stdout
    assert "meshing_close_holes" in page
    assert "`maxholesize` : Int" in page
    assert "No parameters." in run("filters", "Remove Duplicate Vertices").stdout
    facts = json.loads(run("filters", "Close Holes", "--json").stdout)
    assert facts["parameters"][0]["script_name"] == "MaxHoleSize"
    result = run("filters", "close hole")
    assert result.exit_code == 1
    assert result.stderr == (
        "error: no filter is called 'close hole'; did you mean 'Close Holes'?\n"
    )


def test_progress_is_silent_in_a_pipe(capsys):
    with progress_bar("work") as progress:
        progress(0.5, "half")
    captured = capsys.readouterr()
    assert captured.err == captured.out == ""


def test_progress_shows_on_a_terminal(capsys, monkeypatch):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TERM", "xterm")
    with progress_bar("work [1]") as progress:
        progress(0.5, "half [red]way[/red]")
    assert "half [red]way[/red]" in capsys.readouterr().err.replace("\x1b", "")


def test_measures_become_plain_data():
    import numpy as np

    assert plain({"a": np.array([1.0, np.nan]), 1: (np.int64(2), True, None, "x")}) == {
        "a": [1.0, None],
        "1": [2, True, None, "x"],
    }
    assert plain(np.float32(0.5)) == 0.5
    assert plain(object).startswith("<class")
    two = {
        "planes": np.eye(2, 4),
        "support": np.array([0.9, 0.8]),
        "residual": np.array([0.1, 0.2]),
        "confidence": np.array([1.0, 0.5]),
        "converged": np.bool_(False),
    }
    assert detection(two) == {
        "planes": [
            {"plane": [1, 0, 0, 0], "support": 0.9, "residual": 0.1, "confidence": 1.0},
            {"plane": [0, 1, 0, 0], "support": 0.8, "residual": 0.2, "confidence": 0.5},
        ],
        "converged": False,
    }
    none = {name: values[:0] if name != "converged" else True for name, values in two.items()}
    assert detection(none) == {"planes": [], "converged": True}
