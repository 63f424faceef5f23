"""Signals at chosen moments: Python running, native code that keeps it waiting, renames."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pytest

from meshlab_symrecon.errors import FileError
from meshlab_symrecon.host import interruption
from meshlab_symrecon.host.atomic import replacing, together
from meshlab_symrecon.host.interruption import (
    GRACE,
    SENTENCE,
    Interruption,
    guard_folder,
    interruptible,
    interruption_settled,
    signal_of_interruption,
    unbroken,
)

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals of Posix")

HANGS = 60  # seconds after which a process will never end, on a busy machine, too
BUSY = """
import collections, functools, itertools, os, sys, tempfile, time
from pathlib import Path
from meshlab_symrecon.host.atomic import replacing, together
from meshlab_symrecon.host.interruption import Interruption, interruptible
out = Path(sys.argv[1])

def stuck(then=itertools.repeat(None)):
    # One loop of native code that looks at no signal; its first step says that it has begun.
    collections.deque(itertools.chain(map(os.write, [1], [b"stuck\\n"]), then), maxlen=0)

def stuck_for_a_while():
    # until there is a file
    there = functools.partial(os.access, out.with_name("go on"), os.F_OK)
    stuck(iter(there, True))
"""
STUCK = {
    "while it writes": """
with interruptible(), replacing(out / "a.ply") as staged:
    staged.write_bytes(b"half")
    stuck()
""",
    "in temporary files": """
with interruptible(), tempfile.TemporaryDirectory() as folder:
    Path(folder, "x").write_bytes(b"half")
    stuck()
""",
    "and swallows the exception": """
with interruptible(), replacing(out / "a.ply") as staged:
    staged.write_bytes(b"half")
    while True:
        try:
            print("stuck", flush=True)
            time.sleep(60)
        except KeyboardInterrupt:
            pass
""",
    "with others waiting": """
with interruptible(), together():
    with replacing(out / "a.ply") as staged:
        staged.write_bytes(b"whole")
    with replacing(out / "b.json") as staged:
        staged.write_bytes(b"half")
        stuck()
""",
    "while a stream is diverted": """
with interruptible(), replacing(out / "a.ply") as staged:
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    staged.write_bytes(b"half")
    stuck()
""",
}


@pytest.fixture
def start(tmp_path):
    """Return a function that starts a program in folders of its own and waits for its word."""
    out, temporary = tmp_path / "größe out", tmp_path / "tmp"
    out.mkdir()
    temporary.mkdir()
    folders = {"TMPDIR": str(temporary), "PYTHONPATH": str(tmp_path)}

    def call(program, ignored=()):
        for number in ignored:
            signal.signal(number, signal.SIG_IGN)
        try:
            process = subprocess.Popen(
                [sys.executable, "-c", BUSY + program, out],
                stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                env=os.environ | folders, start_new_session=True,
            )  # fmt: skip
        finally:
            for number in ignored:
                default = signal.default_int_handler if number == signal.SIGINT else signal.SIG_DFL
                signal.signal(number, default)
        started.append(process)
        assert process.stdout.readline() == "stuck\n"
        return process

    started = []
    call.out, call.temporary, call.go_on = out, temporary, tmp_path / "go on"
    yield call
    for process in started:
        process.kill()
        process.communicate()


@pytest.mark.parametrize("program", STUCK.values(), ids=STUCK)
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_stuck_native_code_is_ended_and_leaves_nothing(start, program, number):
    old = start.out / "a.ply"
    old.write_bytes(b"old")
    process = start(program)
    process.send_signal(number)
    _, said = process.communicate(timeout=HANGS)
    assert process.returncode == 128 + number
    assert said == f"{SENTENCE}\n"
    assert [path.name for path in start.out.iterdir()] == ["a.ply"]
    assert old.read_bytes() == b"old"
    assert list(start.temporary.iterdir()) == []


def test_impatience_changes_nothing(start):
    process = start(STUCK["while it writes"])
    for _ in range(5):
        process.send_signal(signal.SIGINT)
        time.sleep(0.02)
    _, said = process.communicate(timeout=HANGS)
    assert (process.returncode, said) == (130, f"{SENTENCE}\n")
    assert list(start.out.iterdir()) == []


def test_ignored_signals_stay_ignored(start):
    program = STUCK["while it writes"].replace("stuck()", "stuck_for_a_while()")
    process = start(program, ignored=[signal.SIGHUP, signal.SIGINT])
    process.send_signal(signal.SIGHUP)
    process.send_signal(signal.SIGINT)
    time.sleep(2 * GRACE)
    start.go_on.touch()
    assert process.communicate(timeout=HANGS)[1] == ""
    assert process.returncode == 0
    assert (start.out / "a.ply").read_bytes() == b"half"


def test_renames_that_have_begun_are_not_torn(start):
    """The interruption comes while files take their places, native code stuck between two."""
    process = start("""
real = Path.replace
def slow(self, target):
    result = real(self, target)
    if self.name == "a.ply":
        stuck_for_a_while()
    return result
Path.replace = slow
try:
    with interruptible(), together():
        for name in ("a.ply", "b.json"):
            with replacing(out / name) as staged:
                staged.write_bytes(b"new")
except Interruption as error:
    sys.exit(error.number + 40)
""")
    process.send_signal(signal.SIGINT)
    time.sleep(2 * GRACE)
    start.go_on.touch()
    process.communicate(timeout=HANGS)
    assert process.returncode in (130, 42)
    assert {path.name: path.read_bytes() for path in start.out.iterdir()} == {
        "a.ply": b"new", "b.json": b"new",
    }  # fmt: skip


SLOW_JOB = """
import os, time
from pathlib import Path
from meshlab_symrecon.host.atomic import replacing

def work(folder, *, progress):
    Path(folder, "pid").write_text(str(os.getpid()))
    with replacing(Path(folder, "a.ply")) as staged:
        staged.write_bytes(b"half")
        progress(0.5, "working")
        time.sleep(60)
"""
WITH_CHILD = """
import slow_job
from meshlab_symrecon.host.isolation import isolated
with interruptible():
    isolated(slow_job.work, out, progress=lambda fraction, message: stuck(), folders=[out])
"""


def test_children_end_too(start, tmp_path):
    (tmp_path / "slow_job.py").write_text(SLOW_JOB)
    process = start(WITH_CHILD)
    child = int((start.out / "pid").read_text())
    assert is_running(child)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=HANGS)
    assert (process.returncode, said) == (130, f"{SENTENCE}\n")
    assert [path.name for path in start.out.iterdir()] == ["pid"]
    assert list(start.temporary.iterdir()) == []
    assert_gone(child)


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells children at once")
def test_a_child_ends_with_a_killed_parent(start, tmp_path):
    (tmp_path / "slow_job.py").write_text(SLOW_JOB)
    process = start(WITH_CHILD)
    child = int((start.out / "pid").read_text())
    assert is_running(child)
    process.kill()
    process.communicate(timeout=HANGS)
    assert_gone(child)


def assert_gone(process):
    """Wait for the end of a process that has been killed; that takes the system a moment."""
    until = time.monotonic() + HANGS
    while is_running(process):
        assert time.monotonic() < until, "the child lives on"
        time.sleep(0.02)


def is_running(process):
    """Say whether a process runs; one that waits for a parent to ask for it does not."""
    try:
        status = Path(f"/proc/{process}/stat").read_text()
    except (FileNotFoundError, ProcessLookupError):
        return False
    return status.rpartition(")")[2].split()[0] != "Z"


def test_python_code_is_interrupted_by_an_exception():
    def work():
        with interruptible():
            try:
                signal.raise_signal(signal.SIGTERM)
            finally:
                signal.raise_signal(signal.SIGTERM)  # nothing: the first one counts
                assert signal_of_interruption() == signal.SIGTERM
                interruption_settled()

    before = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)]
    with pytest.raises(Interruption) as caught:
        work()
    assert caught.value.number == signal.SIGTERM
    assert isinstance(caught.value, KeyboardInterrupt)
    assert signal_of_interruption() == 0
    assert [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)] == before


def test_an_interruption_waits_for_an_unbroken_block():
    done = []

    def work():
        with interruptible():
            with unbroken():
                with unbroken():
                    signal.raise_signal(signal.SIGINT)
                    done.append("inner")
                done.append("outer")
            done.append("after")

    with pytest.raises(Interruption):
        work()
    assert done == ["inner", "outer"]


def test_work_with_many_children_may_take_its_time(start):
    process = start("""
from meshlab_symrecon.host.interruption import unhurried
try:
    with interruptible(), unhurried(600.0):
        stuck_for_a_while()
except Interruption:
    print("tidied up")
    sys.exit(3)
""")
    process.send_signal(signal.SIGINT)
    time.sleep(2 * GRACE)
    start.go_on.touch()
    told, said = process.communicate(timeout=HANGS)
    assert (process.returncode, told, said) == (3, "tidied up\n", "")


def test_settling_removes_what_an_interrupted_removal_left(tmp_path):
    (tmp_path / ".half-1").mkdir()
    (tmp_path / ".half-1" / "x").write_bytes(b"x")
    (tmp_path / ".whole").mkdir()
    with interruptible():
        guard_folder(tmp_path, ".half-")
        interruption_settled()
    assert [path.name for path in tmp_path.iterdir()] == [".whole"]


def test_temporary_files_have_a_folder_that_goes():
    before = tempfile.gettempdir(), os.environ.get("TMPDIR")
    with interruptible():
        inside = Path(tempfile.gettempdir())
        assert inside.parent == Path(before[0])
        assert os.environ["TMPDIR"] == str(inside)
        (inside / "left").write_bytes(b"x")
    assert not inside.exists()
    assert (tempfile.gettempdir(), os.environ.get("TMPDIR")) == before


def test_nothing_happens_in_a_library(tmp_path):
    """Outside of ``interruptible`` there are no guards, and signals are the program's."""
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    (tmp_path / ".half-1").mkdir()
    guard_folder(tmp_path, ".half-")
    interruption_settled()
    assert (tmp_path / ".half-1").exists()
    with pytest.raises(KeyboardInterrupt) as caught, unbroken():
        signal.raise_signal(signal.SIGINT)
    assert not isinstance(caught.value, Interruption)


def test_files_take_their_places_together(tmp_path):
    with together():
        for name in ("a.ply", "b.json"):
            with replacing(tmp_path / name) as staged:
                staged.write_text(name)
        assert not list(tmp_path.glob("[ab].*"))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.ply", "b.json"]


def write_two(folder, error):
    """Write a file, and fail while the second one is written."""
    with together():
        with replacing(folder / "a.ply") as staged:
            staged.write_text("new")
        with replacing(folder / "b.json") as staged:
            staged.write_text("half")
            raise error


def test_after_an_error_what_is_whole_is_kept(tmp_path):
    with pytest.raises(ValueError, match="drawing"):
        write_two(tmp_path, ValueError("drawing"))
    assert [path.name for path in tmp_path.iterdir()] == ["a.ply"]
    assert (tmp_path / "a.ply").read_text() == "new"


def test_after_an_interruption_nothing_is_new(tmp_path):
    (tmp_path / "a.ply").write_text("old")
    with pytest.raises(KeyboardInterrupt):
        write_two(tmp_path, KeyboardInterrupt())
    assert [path.name for path in tmp_path.iterdir()] == ["a.ply"]
    assert (tmp_path / "a.ply").read_text() == "old"


def test_files_that_the_system_refuses_together(tmp_path, monkeypatch):
    def refuse(*given):
        raise PermissionError(13, "Permission denied")

    def work():
        with together(), replacing(tmp_path / "a.ply") as staged:
            staged.write_text("new")
            monkeypatch.setattr(Path, "replace", refuse)

    with pytest.raises(FileError, match=r"a.ply cannot be written: Permission denied"):
        work()
    assert list(tmp_path.iterdir()) == []


def test_a_writer_that_made_no_file_among_others(tmp_path):
    def work():
        with together(), replacing(tmp_path / "a.ply"):
            pass

    with pytest.raises(FileError, match="the writer made no file"):
        work()
    assert list(tmp_path.iterdir()) == []


def test_a_copy_of_the_process_keeps_its_signals_to_itself():
    with interruptible():
        assert interruption._state.watching
        process = os.fork() if sys.version_info < (3, 12) else None
        if process == 0:
            os._exit(0 if signal.set_wakeup_fd(-1) == -1 else 1)
        if process is not None:
            assert os.waitpid(process, 0)[1] == 0
