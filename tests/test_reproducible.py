"""The same input, seed and version give the same bytes, whatever the process is told otherwise."""

from __future__ import annotations

import hashlib
import json
import os
import re
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from meshlab_symrecon.host.files import load, new_document, save_current
from meshlab_symrecon.host.records import Input, read_record, record_of
from meshlab_symrecon.host.registration import apply_filter
from meshlab_symrecon.host.steps import run_filter
from meshlab_symrecon.one_thread import in_one_thread, one_thread
from meshlab_symrecon.plugin import Filter, Layer, Outcome, ParameterSet

ROOT = Path(__file__).parents[1]
NORMALS, DETECT = "compute_normal_for_point_clouds", "generate_reflection_planes"
SCAN = ROOT / "examples/data/nefertiti_small.ply"

# What a process does; it prints the checksum of every file that it has written.
WORK = """
import hashlib, json, pathlib, sys, warnings
from click.testing import CliRunner
from meshlab_symrecon.cli.main import main

warnings.simplefilter("ignore")
scan, scripts = "scan.ply", pathlib.Path(sys.argv[1])

def call(*arguments):
    done = CliRunner().invoke(main, [str(argument) for argument in arguments])
    assert done.exit_code == 0, (arguments, done.output, done.exception)

def without_seconds(data):
    if isinstance(data, dict):
        return {key: without_seconds(value) for key, value in data.items() if key != "seconds"}
    return [without_seconds(item) for item in data] if isinstance(data, list) else data

call("reconstruct", scan, "-o", "statue.ply", "--project", "all.mlp", "--json", "found.json")
call("apply", "simplify_points", scan, "-o", "few.ply", "--count", 300)
call("run", scripts / "deviation.mlx", scan, "-o", "deviation.mlp", "--json", "deviation.json")
call("run", scripts / "power_crust.mlx", scan, "-o", "crust.obj")
sums = {}
for path in sorted(pathlib.Path().iterdir()):
    content = path.read_bytes()
    if path.suffix == ".json":
        content = json.dumps(without_seconds(json.loads(content))).encode()
    sums[path.name] = hashlib.sha256(content).hexdigest()
print(json.dumps(sums))
"""
ORDINARY = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "PYTHONHASHSEED": "0"}
OTHERS = {
    "two threads": {
        "OPENBLAS_NUM_THREADS": "2", "OMP_NUM_THREADS": "2", "MKL_NUM_THREADS": "2",
        "PYTHONHASHSEED": "1",
    },
    "four threads, filled memory": {
        "OPENBLAS_NUM_THREADS": "4", "OMP_NUM_THREADS": "4", "MKL_NUM_THREADS": "4",
        "PYTHONHASHSEED": "random", "GLIBC_TUNABLES": "glibc.malloc.perturb=85",
        "TZ": "Asia/Kolkata", "LC_ALL": "de_DE.UTF-8",
    },
}  # fmt: skip


def sums_of_a_process(folder: Path, settings: dict[str, str]) -> dict[str, str]:
    """Return the checksum of every file that the work leaves in a process with such settings."""
    folder.mkdir()
    (folder / "scan.ply").write_bytes(SCAN.read_bytes())
    done = subprocess.run(
        [sys.executable, "-c", WORK, str(ROOT / "meshlab_scripts")],
        cwd=folder,
        env=os.environ | settings,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


@pytest.fixture(scope="module")
def ordinary(tmp_path_factory):
    folder = tmp_path_factory.mktemp("same") / "ordinary"
    return folder, sums_of_a_process(folder, ORDINARY)


@pytest.mark.parametrize("settings", OTHERS.values(), ids=OTHERS)
def test_threads_hashes_memory_zone_and_language_do_not_show(ordinary, tmp_path, settings):
    _, sums = ordinary
    assert len(sums) == 14
    assert sums_of_a_process(tmp_path / "other", settings) == sums


def test_every_layer_says_how_it_was_made(ordinary):
    folder, _ = ordinary
    for name in ("deviation-scan.ply.ply", "deviation-reflection-planes.ply"):
        record = read_record(folder / name)
        digest = hashlib.sha256(SCAN.read_bytes()).hexdigest()
        assert record.inputs == (Input("scan.ply", digest),)
        assert [step.filter for step in record.steps[:2]] == [NORMALS, DETECT]
        assert record.steps[1].parameters["randomseed"] == 0
        header = (folder / name).read_bytes().partition(b"end_header\n")[0]
        assert str(folder).encode() not in header


def blas_threads() -> set[int]:
    """Return the numbers of threads of each library for linear algebra."""
    return {known["num_threads"] for known in threadpool_info() if known["user_api"] == "blas"}


@pytest.fixture
def two_threads():
    with threadpool_limits(2, user_api="blas"):
        if blas_threads() != {2}:
            pytest.skip("the linear algebra here takes one thread at most, or does not tell")
        yield


@pytest.mark.usefixtures("two_threads")
def test_blocks_in_one_thread_are_nested_and_undone():
    with one_thread():
        with one_thread():
            assert blas_threads() == {1}
        assert blas_threads() == {1}
    assert blas_threads() == {2}
    assert in_one_thread(blas_threads)() == {1}
    with pytest.raises(ZeroDivisionError), one_thread():
        _ = 1 / 0
    assert blas_threads() == {2}


@pytest.mark.usefixtures("two_threads")
def test_a_block_that_ends_leaves_the_others_in_one_thread():
    entered, leave = threading.Event(), threading.Event()

    def other() -> None:
        with one_thread():
            entered.set()
            leave.wait(60)

    thread = threading.Thread(target=other)
    thread.start()
    entered.wait(60)
    with one_thread():
        leave.set()
        thread.join(60)
        assert blas_threads() == {1}
    assert blas_threads() == {2}


@pytest.mark.usefixtures("two_threads")
def test_every_filter_runs_in_one_thread():
    seen = []

    def run(layers, parameters, progress):
        seen.append(blas_threads())
        return Outcome(layers=(Layer([[0.0, 0.0, 0.0]], [], "one"),))

    item = Filter(
        "Look", "generate_look", "Look.", "Look.", ParameterSet, run, "Remeshing", "Creation",
        requires=(),
    )  # fmt: skip
    run_filter(new_document(), item, {})
    assert seen == [{1}]


def test_the_python_of_the_page_gives_the_same_bytes(tmp_path, monkeypatch):
    page = (ROOT / "docs/reproducible.md").read_text(encoding="utf-8")
    code = re.search(r"```python\n(.*?)```", page, re.DOTALL)
    assert code is not None
    monkeypatch.chdir(tmp_path)
    Path("scan.ply").write_bytes(SCAN.read_bytes())
    document = load("scan.ply")
    apply_filter(document, "simplify_points", count=100, detail=0.1)
    save_current(document, "statue.ply", record_of(document, [Path("scan.ply")], {"paint": True}))
    exec(code[1], {})
    assert Path("again.ply").read_bytes() == Path("statue.ply").read_bytes()
