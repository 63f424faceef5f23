"""``--quiet``, ``--log``, ``--threads`` and ``--max-points``, before and after the command."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

from meshlab_symrecon import __version__
from meshlab_symrecon.cli import work_log
from meshlab_symrecon.cli.apply import RESERVED
from meshlab_symrecon.cli.long_work import long_options, long_work, max_points
from meshlab_symrecon.cli.main import main
from meshlab_symrecon.cli.progress import progress_bar
from meshlab_symrecon.cli.threads import VARIABLES, asked_threads, limited_threads
from meshlab_symrecon.errors import FileError
from meshlab_symrecon.host.fewest_points import FEWEST_POINTS
from meshlab_symrecon.host.native_filters import native_filters
from meshlab_symrecon.host.registration import registry

LINE = re.compile(r"\d{4}-\d\d-\d\d \d\d:\d\d:\d\d \S.*")
STAGE = re.compile(r".{20}(.+): (\d+\.\d\d) s(?:, peak \d+ MB)?")

SCRIPT = (
    "<!DOCTYPE FilterScript><FilterScript>"
    '<filter name="Compute normals for point sets"/></FilterScript>'
)


@pytest.fixture
def script(tmp_path):
    path = tmp_path / "normals.mlx"
    path.write_text(SCRIPT)
    return path


@pytest.fixture(params=["before", "after"])
def command(request, run, statue, script):
    """Return a function that runs each long command with options before or after its name."""

    def call(name, output, *options):
        words = {
            "reconstruct": ["reconstruct", statue, "-o", output],
            "apply": ["apply", "compute_normal_for_point_clouds", statue, "-o", output],
            "run": ["run", script, statue, "-o", output],
        }[name]
        given = [*options, *words] if request.param == "before" else [*words, *options]
        return run(*given)

    return call


COMMANDS = pytest.mark.parametrize("name", ["reconstruct", "apply", "run"])


@COMMANDS
def test_quiet_says_nothing(command, name, tmp_path):
    result = command(name, tmp_path / "a.ply", "--quiet")
    assert (result.exit_code, result.output) == (0, "")
    assert (tmp_path / "a.ply").exists()


def test_quiet_keeps_warnings_to_the_log(run, lopsided, tmp_path):
    log = tmp_path / "l.txt"
    result = run("reconstruct", lopsided, "-o", tmp_path / "a.ply", "-q", "--log", log)
    assert (result.exit_code, result.output) == (0, "")
    assert " warning: no reflection plane was found" in log.read_text()


def test_quiet_still_tells_errors(run, tmp_path):
    result = run("-q", "reconstruct", tmp_path / "none.ply", "-o", tmp_path / "a.ply")
    assert result.exit_code == 1
    assert result.stdout == ""
    assert result.stderr.startswith("error: ")
    assert len(result.stderr.splitlines()) == 1


@COMMANDS
def test_the_log_tells_what_happened(command, name, tmp_path):
    log = tmp_path / "größe l.txt"
    for _ in range(2):
        result = command(name, tmp_path / "a.ply", "--log", log)
        assert result.exit_code == 0, result.stderr
    lines = log.read_text(encoding="utf-8").splitlines()
    assert all(LINE.fullmatch(line) for line in lines)
    beginnings = [number for number, line in enumerate(lines) if line[20:].startswith("symrecon")]
    assert len(beginnings) == 2  # appended
    versions = lines[1][20:]
    assert versions.startswith(f"meshlab_symrecon {__version__}, pymeshlab 2")
    assert f"Python {sys.version_info.major}.{sys.version_info.minor}." in versions
    assert any(STAGE.fullmatch(line) for line in lines[2:])
    assert [line for line in result.stdout.splitlines() if line not in log.read_text()] == []
    assert re.search(r"done after \d+\.\d\d s", lines[-1])


def test_the_log_names_the_stages(run, statue, tmp_path):
    log = tmp_path / "l.txt"
    assert run("reconstruct", statue, "-o", tmp_path / "a.ply", "--log", log).exit_code == 0
    stages = [found[1] for found in map(STAGE.fullmatch, log.read_text().splitlines()) if found]
    for wanted in (
        "normals", "looking for mirror planes: preparing the cloud",
        "mirroring points: learning how the sides differ",
        "closing the surface: building the power diagram", f"writing {tmp_path / 'a.ply'}",
    ):  # fmt: skip
        assert wanted in stages


def test_the_log_tells_the_error(run, lopsided, tmp_path):
    log, flat = tmp_path / "l.txt", tmp_path / "flat.xyz"
    flat.write_text("0 0 0\n1 0 0\n0 1 0\n1 1 0\n2 1 0\n")
    result = run("reconstruct", flat, "-o", tmp_path / "a.ply", "--log", log)
    assert result.exit_code == 1
    *_, error, end = log.read_text().splitlines()
    assert error[20:] == result.stderr.splitlines()[-1]
    assert "ended after" in end


@pytest.mark.parametrize(
    ("place", "words"),
    [
        ("none/l.txt", "no directory is at"),
        (".", "it is not an ordinary file"),
        ("a.ply", "is another file of this command"),
        ("{scan}", "is another file of this command"),
        ("other.txt", "holds something else than a log"),
    ],
)
def test_a_bad_log_is_an_error_before_the_work(run, statue, tmp_path, place, words, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "other.txt").write_text("dear diary")
    before = statue.read_bytes()
    result = run("reconstruct", statue, "-o", "a.ply", "--log", place.format(scan=statue))
    assert result.exit_code == 1
    assert words in result.stderr
    assert len(result.stderr.splitlines()) == 1
    assert [path.name for path in tmp_path.iterdir()] == ["other.txt"]
    assert (tmp_path / "other.txt").read_text() == "dear diary"
    assert statue.read_bytes() == before


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="root may write everything")
@pytest.mark.parametrize("mode", [0o000, 0o400])
def test_a_log_without_permission(tmp_path, mode):
    path = tmp_path / "l.txt"
    path.touch(mode)
    with pytest.raises(FileError, match="cannot be"):
        work_log.WorkLog(path)


@pytest.mark.parametrize("method", ["open"])
def test_a_log_that_the_system_refuses(tmp_path, monkeypatch, method):
    def refuse(*given, **more):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(work_log.Path, method, refuse)
    with pytest.raises(FileError, match=r"cannot be written: Permission denied; give another path"):
        work_log.WorkLog(tmp_path / "l.txt")
    (tmp_path / "l.txt").touch()
    with pytest.raises(FileError, match=r"cannot be read: Permission denied; give another path"):
        work_log.WorkLog(tmp_path / "l.txt")


@pytest.mark.skipif(sys.platform != "linux", reason="a device of Linux")
def test_a_full_disk_ends_the_log_and_not_the_work(tmp_path):
    log = work_log.WorkLog(tmp_path / "l.txt")
    with Path("/dev/full").open("wb", buffering=0) as full:
        log._file.close()
        log._file = full
        with pytest.warns(UserWarning, match="the log ends here"):
            log.say("something")
        log.say("something else")
        log.end("done")


@pytest.mark.parametrize("name", [item.python_name for item in registry()])
def test_no_parameter_of_ours_clashes(name):
    item = registry().find(name)
    options = {parameter.name.replace("_", "-") for parameter in item.parameters.declared()}
    assert options.isdisjoint(RESERVED)


def test_parameters_of_meshlab_that_clash_have_another_option(run):
    new = {word.lstrip("-") for option in [*long_options(), max_points()] for word in option.opts}
    clashes = {
        (name, parameter.name)
        for name, item in native_filters().items()
        for parameter in item.parameters
        if parameter.name.replace("_", "-").strip("-") in new - {"q"}
    }
    assert clashes == {("generate_surface_reconstruction_screened_poisson", "threads")}
    (name, _), *_ = clashes
    shown = run("apply", name, "--help").stdout
    assert "--parameter-threads VALUE" in shown
    assert "--threads N" in shown


def test_every_filter_has_each_option_once():
    """A parameter's option that is also a common one would silently take its place."""
    group = main.commands["apply"]
    for name in [*native_filters(), *(item.python_name for item in registry())]:
        command = group.get_command(click.Context(group), name)
        spelled = [word for option in command.params for word in option.opts]
        assert len(spelled) == len(set(spelled)), name


@pytest.mark.parametrize(
    ("words", "count"),
    [
        ([], None),
        (["--threads", "3"], 3),
        (["a", "--threads=12", "b"], 12),
        (["--threads", "1", "--threads", "2"], 2),
        (["--threads"], None),
        (["--threads", "x"], None),
        (["--threads=0"], None),
        (["--thread", "3"], None),
    ],
)
def test_threads_are_found_before_parsing(words, count):
    assert asked_threads(words) == count


def test_threads_are_limited_for_a_while(monkeypatch):
    import numpy as np  # noqa: F401  loads a BLAS
    from threadpoolctl import threadpool_info

    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    monkeypatch.delenv("MKL_NUM_THREADS", raising=False)
    before = {name: os.environ.get(name) for name in VARIABLES}
    counts = [pool["num_threads"] for pool in threadpool_info()]
    with limited_threads(1):
        assert {os.environ[name] for name in VARIABLES} == {"1"}
        assert {pool["num_threads"] for pool in threadpool_info()} == {1}
    assert {name: os.environ.get(name) for name in VARIABLES} == before
    assert [pool["num_threads"] for pool in threadpool_info()] == counts
    with limited_threads(None):
        assert {name: os.environ.get(name) for name in VARIABLES} == before


TOLD = """
import os, sys
class Early:
    def find_spec(self, name, path=None, target=None):
        if name in ("numpy", "pymeshlab"):
            print(name, os.environ.get("OMP_NUM_THREADS"), os.environ.get("OPENBLAS_NUM_THREADS"))
sys.meta_path.insert(0, Early())
from meshlab_symrecon.cli.main import main
main(sys.argv[1:])
"""


@pytest.mark.parametrize(
    "words",
    [
        ["--threads", "3", "apply", "create_cube", "-o", "a.ply"],
        ["apply", "create_cube", "-o", "a.ply", "--threads=3"],
        ["reconstruct", "none.ply", "-o", "a.ply", "--threads", "3"],
        ["run", "none.mlx", "-o", "a.ply", "--threads", "3"],
    ],
)
def test_libraries_are_loaded_with_the_number_of_threads(words, tmp_path):
    import subprocess

    ended = subprocess.run(
        [sys.executable, "-c", TOLD, *words],
        capture_output=True, text=True, check=False, cwd=tmp_path,
    )  # fmt: skip
    told = [line for line in ended.stdout.splitlines() if line.startswith(("numpy", "pymesh"))]
    assert {"numpy 3 3", "pymeshlab 3 3"} <= set(told), ended
    assert all(line.endswith(" 3 3") for line in told)


@COMMANDS
@pytest.mark.parametrize("value", ["0", "-1", "x"])
def test_a_bad_number_of_threads_is_wrong_usage(command, name, tmp_path, value):
    result = command(name, tmp_path / "a.ply", "--threads", value)
    assert result.exit_code == 2
    assert "--threads" in result.stderr


def test_threads_do_not_change_the_result(run, statue, tmp_path):
    for count in (1, 2):
        output = tmp_path / f"{count}" / "a.ply"
        output.parent.mkdir()
        result = run("reconstruct", statue, "-o", output, "--threads", count)
        assert result.exit_code == 0, result.stderr
    assert (tmp_path / "1" / "a.ply").read_bytes() == (tmp_path / "2" / "a.ply").read_bytes()


@pytest.mark.parametrize("name", ["reconstruct", "apply"])
def test_a_scan_is_thinned_out_first(run, statue, tmp_path, name):
    import json

    words = {
        "reconstruct": ["reconstruct", statue, "-o", tmp_path / "a.ply"],
        "apply": ["apply", "generate_reflection_planes", statue],
    }[name]
    result = run(*words, "--max-points", "1500", "--json", tmp_path / "a.json")
    assert result.exit_code == 0, result.stderr
    report = json.loads((tmp_path / "a.json").read_text())
    assert len(report["planes"]) == 1
    if name == "reconstruct":
        assert report["measured"] <= 1500
        assert report["parameters"]["max_points"] == 1500
        assert "thinned out of" in result.stdout


@pytest.mark.parametrize(
    "words",
    [
        ["reconstruct", "-o", "a.ply"],
        ["apply", "generate_reflection_planes", "-o", "a.ply"],
        ["run", "s.mlx", "-o", "a.ply"],
        ["batch", "reconstruct", "-d", "out"],
    ],
)
def test_too_few_points_are_wrong_usage(run, statue, tmp_path, monkeypatch, words):
    monkeypatch.chdir(tmp_path)
    result = run(*words, statue, "--max-points", FEWEST_POINTS - 1)
    assert result.exit_code == 2
    assert f"{FEWEST_POINTS - 1} is not in the range x>={FEWEST_POINTS}" in result.stderr
    assert f"[x>={FEWEST_POINTS}]" in " ".join(run(words[0], "--help").stdout.split())
    assert list(tmp_path.iterdir()) == []


def test_other_commands_can_have_the_options(tmp_path):
    @click.command()
    @click.argument("word")
    @long_work
    def say(word, *, work):
        with work.progress(word) as progress:
            progress(0.0, "first")
        work.say(word)
        work.warn("loud")

    log = tmp_path / "l.txt"
    result = CliRunner().invoke(say, ["hello", "--log", str(log)])
    assert result.stdout == "hello\n"
    assert result.stderr == "warning: loud\n"
    assert [line[20:] for line in log.read_text().splitlines()][2:4] == ["hello", "warning: loud"]


def test_progress_never_goes_back_on_a_terminal(monkeypatch):
    import rich.progress

    shown = []

    def update(self, task, *, completed, description):
        shown.append((completed, description))

    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    monkeypatch.setattr(rich.progress.Progress, "update", update)
    told = []
    with progress_bar("title", stage=told.append) as progress:
        for fraction, message in [
            (0.0, "a"), (0.5, "b"), (0.4, "c"), (0.45, "c"), (0.7, "[x]"), (1.5, ""),
        ]:  # fmt: skip
            progress(fraction, message)
    assert shown == [(0.0, "a"), (0.5, "b"), (0.5, "c"), (0.7, r"\[x]"), (1.0, "title")]
    assert told == ["a", "b", "c", "[x]", ""]


@pytest.mark.parametrize("target", ["a.txt"])
def test_stages_do_not_go_below_what_was_said(tmp_path, target, monkeypatch):
    """A stage that comes again counts anew; one of no length has no line."""
    monkeypatch.setattr(work_log.time, "perf_counter", lambda: 7.0)
    log = work_log.WorkLog(tmp_path / target)
    log.stage("quick")
    log.stage("")
    log.end("done")
    lines = (tmp_path / target).read_text().splitlines()
    assert len(lines) == 1
    assert "done after 0.0" in lines[0]
