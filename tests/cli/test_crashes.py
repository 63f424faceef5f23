"""Crashes of native code in real commands: one sentence, exit code 1, and nothing half-written."""

from __future__ import annotations

import os
import signal
import subprocess
import sys

import pytest

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals of Posix")

START = "from meshlab_symrecon.cli.start import {0}; {0}()"
ADVICE = "leave that step out, or run it in the MeshLab program\n"
PLUGIN = """
import ctypes, os, signal, sys, threading, time
from pathlib import Path
import pymeshlab
from meshlab_symrecon.host.atomic import replacing
from meshlab_symrecon.host.interruption import unbroken
from meshlab_symrecon.plugin import Filter, Outcome, ParameterSet

C = ctypes.CDLL(None)


def read_nothing():
    ctypes.string_at(0)


def in_another_thread():
    threading.Thread(target=read_nothing).start()
    time.sleep(60)


def overflow():
    compared = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p)
    sys.setrecursionlimit(10**9)
    numbers = (ctypes.c_int * 2)(2, 1)

    def compare(first, second):
        C.qsort(ctypes.byref(numbers), 2, 4, native)
        return 0

    native = compared(compare)
    compare(0, 0)


def break_the_heap():
    C.malloc.restype = ctypes.c_void_p
    C.free.argtypes = [ctypes.c_void_p]
    place = C.malloc(2000)
    ctypes.memset(place - 16, 255, 16)
    C.free(place)


def in_a_fork():
    child = os.fork()
    if child == 0:
        read_nothing()
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == -signal.SIGSEGV


def without_the_watching_thread():
    # Its end of the pipe is closed when nobody can write into it any more.
    pipe = signal.set_wakeup_fd(-1)
    other = os.pipe()
    os.dup2(other[1], pipe)
    read_nothing()


def after_a_file():
    with replacing(Path("first.txt")) as staged:
        staged.write_text("whole")
    read_nothing()


def between_renames():
    with unbroken():
        read_nothing()


def in_meshlab():
    # Past the checks by which this package keeps its users from it.
    mesh_set = pymeshlab.MeshSet()
    mesh_set.create_cube()
    mesh_set.compute_scalar_by_aspect_ratio_per_face(metric=6)


def send(name):
    return lambda: os.kill(os.getpid(), getattr(signal, name))


WAYS = {
    "null": read_nothing, "abort": os.abort, "thread": in_another_thread, "overflow": overflow,
    "heap": break_the_heap, "fork": in_a_fork, "alone": without_the_watching_thread,
    "later": after_a_file, "exit": lambda: C.exit(0), "bus": send("SIGBUS"),
    "meshlab": in_meshlab, "between": between_renames,
}


def run(layers, parameters, progress):
    WAYS[os.environ["CRASH"]]()
    return Outcome(())


FILTER = Filter(
    menu_name="Crash In Native Code", python_name="apply_crash", aliases=(), summary="Crashes.",
    description="Crashes.", parameters=type("Parameters", (ParameterSet,), {}), run=run,
    meshlab_class="Sampling", category="Creation/Sampling",
)
"""
SCRIPT = (
    '<!DOCTYPE FilterScript><FilterScript>\n<filter name="Remove Duplicate Vertices"/>\n'
    '<filter name="Crash In Native Code"/>\n</FilterScript>'
)
OFF = "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n"


@pytest.fixture
def command(tmp_path):
    """Return a function that runs a program with the plugin, in a folder with what it needs."""
    plugins, out, temporary = (tmp_path / name for name in ("plugins", "out", "tmp"))
    for folder in (plugins, out, temporary, plugins / "crash-1.dist-info"):
        folder.mkdir()
    (plugins / "crash_plugin.py").write_text(PLUGIN)
    about = plugins / "crash-1.dist-info"
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: crash\nVersion: 1\n")
    (about / "entry_points.txt").write_text(
        "[meshlab_symrecon.filters]\ncrash = crash_plugin:FILTER\n"
    )
    (tmp_path / "scan.off").write_text(OFF)
    (tmp_path / "crash.mlx").write_text(SCRIPT)

    def call(words, way="", program="symrecon", **more):
        return subprocess.run(
            [sys.executable, "-c", START.format(program), *words],
            capture_output=True, text=True, timeout=60, cwd=out,
            env=os.environ
            | {"PYTHONPATH": str(plugins), "TMPDIR": str(temporary), "CRASH": way, **more},
        )  # fmt: skip

    call.out, call.temporary = out, temporary
    return call


APPLY = ("apply", "apply_crash", "../scan.off", "-o", "result.ply")


def sentence(name, doing="Crash In Native Code", files="nothing was written"):
    return f"error: {doing}: MeshLab's native code ended the process by {name}; {files}; {ADVICE}"


@pytest.mark.parametrize(
    ("way", "name"),
    [
        ("null", "SIGSEGV"), ("abort", "SIGABRT"), ("thread", "SIGSEGV"), ("overflow", "SIGSEGV"),
        ("heap", "SIGABRT"), ("bus", "SIGBUS"),
    ],
)  # fmt: skip
def test_a_crash_is_one_sentence(command, way, name):
    (command.out / "result.ply").write_bytes(b"old")
    done = command(APPLY, way)
    before, _, last = done.stderr.rpartition("error: ")
    assert (done.returncode, "error: " + last) == (1, sentence(name))
    assert "Traceback" not in before
    assert [path.name for path in command.out.iterdir()] == ["result.ply"]
    assert (command.out / "result.ply").read_bytes() == b"old"
    assert list(command.temporary.iterdir()) == []


def test_a_broken_thread_does_not_keep_the_sentence(command):
    done = command((*APPLY, "--log", "log.txt"), "alone")
    assert (done.returncode, done.stderr) == (1, sentence("SIGSEGV"))
    assert (command.out / "log.txt").read_text().endswith(sentence("SIGSEGV"))


def test_native_code_that_exits_is_no_success(command):
    done = command(APPLY, "exit")
    told = "error: Crash In Native Code: native code ended the process; nothing was written; "
    assert (done.returncode, done.stderr) == (1, told + ADVICE)
    assert list(command.temporary.iterdir()) == []


def test_files_that_are_there_are_not_denied(command):
    done = command(("run", "../crash.mlx", "../scan.off", "-o", "result.ply"), "later")
    step = "../crash.mlx:3: 'Crash In Native Code'"
    assert done.stderr == sentence("SIGSEGV", step, "what was written before is whole")
    assert [path.name for path in command.out.iterdir()] == ["first.txt"]


def test_a_fork_crashes_by_itself(command):
    done = command(APPLY, "fork")
    assert (done.returncode, done.stderr) == (0, "")
    assert (command.out / "result.ply").exists()


def test_the_log_ends_with_the_crash_and_names_the_line(command):
    words = ("run", "../crash.mlx", "../scan.off", "-o", "result.ply", "--log", "log.txt")
    done = command(words, "null")
    told = sentence("SIGSEGV", "../crash.mlx:3: 'Crash In Native Code'")
    assert (done.returncode, done.stderr) == (1, told)
    assert (command.out / "log.txt").read_text().endswith(told)
    assert command((*words, "--isolate"), "null").stderr == told


def test_the_old_server_tells_too(command):
    words = ("-i", "../scan.off", "-s", "../crash.mlx", "-o", "result.ply", "-l", "log.txt")
    done = command(words, "abort", program="server")
    told = sentence("SIGABRT", "../crash.mlx:3: 'Crash In Native Code'")
    assert (done.returncode, done.stderr) == (1, told)
    assert (command.out / "log.txt").read_text().endswith(told)
    assert [path.name for path in command.out.iterdir()] == ["log.txt"]


@pytest.mark.parametrize("program", ["symrecon", "server"])
def test_faulthandler_still_tells_where(command, program):
    words = {
        "symrecon": ("run", "../crash.mlx", "../scan.off", "-o", "result.ply"),
        "server": ("-i", "../scan.off", "-s", "../crash.mlx", "-o", "result.ply"),
    }
    done = command(words[program], "null", program=program, PYTHONFAULTHANDLER="1")
    assert "Fatal Python error: Segmentation fault" in done.stderr
    assert "in read_nothing" in done.stderr
    assert done.stderr.endswith(sentence("SIGSEGV", "../crash.mlx:3: 'Crash In Native Code'"))
    assert done.returncode == 1


def test_a_crash_of_meshlab_itself(command):
    done = command(APPLY, "meshlab")
    assert (done.returncode, done.stderr) == (1, sentence("SIGSEGV"))


def test_a_crash_amid_renames_says_what_is_true(command):
    done = command(APPLY, "between")
    true = "each file that was being replaced is whole, the old or the new one"
    assert (done.returncode, done.stderr) == (1, sentence("SIGSEGV", files=true))


def test_handlers_are_given_back(tmp_path):
    program = (
        "import ctypes\n"
        "from meshlab_symrecon.host.interruption import interruptible\n"
        "with interruptible():\n    pass\n"
        "ctypes.string_at(0)\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (-signal.SIGSEGV, b"")
