"""Ctrl-C at every stage of real commands."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals of Posix")

SENTENCE = "interrupted; nothing was left half-written\n"
BIG, SMALL = 250_000, 40_000  # points
HANGS = 60  # seconds after which a process will never end, on a busy machine, too
START = "from meshlab_symrecon.cli.start import symrecon; symrecon()"
AT_IMPORT = """
import os, sys
class Finder:
    def find_spec(self, name, path=None, target=None):
        if name == {moment!r}:
            os.kill(os.getpid(), {number})
sys.meta_path.insert(0, Finder())
"""
AT_LINE = """
import os
from meshlab_symrecon.cli.work_log import WorkLog
say = WorkLog.say
def say_and_signal(self, sentence):
    say(self, sentence)
    if {moment!r} in sentence:
        os.kill(os.getpid(), {number})
WorkLog.say = say_and_signal
"""
# MeshLab writes into a pipe that nobody empties: it is amid its writing for good.
AT_SAVING = """
import os, signal, subprocess, sys
import pymeshlab
save = pymeshlab.MeshSet.save_current_mesh
READER = (
    "import os, sys, time; path, number, process = sys.argv[1], *map(int, sys.argv[2:]);"
    "pipe = open(path, 'rb', 0); pipe.read(1); os.kill(process, number)\\n"
    "while os.getppid() == process: time.sleep(0.02)"
)
def save_into_pipe(self, path, *given, **more):
    if path.endswith({moment!r}):
        os.mkfifo(path)
        signal.siginterrupt({number}, False)  # as on a disk, whose writing no signal breaks off
        words = [sys.executable, "-c", READER, path, "{number}", str(os.getpid())]
        subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    save(self, path, *given, **more)
pymeshlab.MeshSet.save_current_mesh = save_into_pipe
"""


def bust(count):
    """Return a cloud that is symmetric, with a part missing."""
    drawn = np.random.default_rng(0).normal(size=(count, 3))
    x, y, z = (drawn / np.linalg.norm(drawn, axis=1, keepdims=True)).T
    radius = 1.0 + 0.35 * z + 0.3 * y * z - 0.25 * y**3 + 0.3 * z * x**2
    points = radius[:, np.newaxis] * np.column_stack([x, y, z])
    return points[~((points[:, 0] > 0.5) & (points[:, 1] > 0.0))]


@pytest.fixture(scope="module")
def scans(tmp_path_factory):
    """Scans by their number of points; on the large one the first stages take a while."""
    folder = tmp_path_factory.mktemp("scans")
    written = {}
    for count in (BIG, SMALL):
        path = written[count] = folder / f"{count}.ply"
        points = bust(count)
        header = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n"
        header += "".join(f"property double {axis}\n" for axis in "xyz") + "end_header\n"
        path.write_bytes(header.encode() + points.astype("<f8").tobytes())
    return written


@pytest.fixture
def interrupted(tmp_path):
    """Return a function that starts a command, interrupts it, and checks what is left of it.

    It waits until the log has a line with ``after``, and a little more. With ``itself``, code that
    runs first, the process sends itself the signal: no stage is too short for that.
    """
    out, temporary, log = tmp_path / "out", tmp_path / "tmp", tmp_path / "log.txt"
    out.mkdir()
    temporary.mkdir()

    def call(words, after, number=signal.SIGINT, itself=""):
        for name in ("old.ply", "old.json", "old.obj"):
            (out / name).write_bytes(b"old")
        program = itself.format(moment=after, number=int(number)) + START
        process = subprocess.Popen(
            [sys.executable, "-c", program, *map(str, words), "--log", str(log)],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=out,
            env=os.environ | {"TMPDIR": str(temporary)}, start_new_session=True,
        )  # fmt: skip
        try:
            if not itself:
                wait(process, log, after)
                process.send_signal(number)
            told, said = process.communicate(timeout=2 * HANGS)
        finally:
            process.kill()
        assert (process.returncode, told, said) == (128 + number, "", SENTENCE)
        assert sorted(path.name for path in out.iterdir()) == ["old.json", "old.obj", "old.ply"]
        assert all(path.read_bytes() == b"old" for path in out.iterdir())
        assert list(temporary.iterdir()) == []
        return log.read_text() if log.exists() else ""

    return call


def wait(process, log, after):
    until = time.monotonic() + HANGS
    while not (log.exists() and after in log.read_text()):
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < until
        time.sleep(0.01)
    time.sleep(random.Random(after).uniform(0.0, 0.15))


WHOLE = ("-o", "old.ply", "--project", "p.mlp", "--json", "old.json")


@pytest.mark.parametrize(
    ("count", "after", "number", "itself"),
    [
        (SMALL, "numpy", signal.SIGINT, AT_IMPORT),
        (BIG, "meshlab_symrecon ", signal.SIGINT, ""),
        (BIG, f"reading {BIG}.ply: ", signal.SIGINT, ""),  # native normals
        (BIG, "normals: ", signal.SIGTERM, ""),
        (SMALL, "following how the sides differ: ", signal.SIGINT, AT_LINE),
        (SMALL, "triangulating the samples: ", signal.SIGHUP, AT_LINE),
        (SMALL, "carrying over attributes: ", signal.SIGINT, AT_LINE),
        (SMALL, "writing old.ply: ", signal.SIGINT, AT_LINE),  # the surface waits for the project
    ],
)
def test_reconstruct_ends_at_every_stage(interrupted, scans, count, after, number, itself):
    scan = scans[count]
    before = scan.stat().st_mtime_ns, scan.read_bytes()
    log = interrupted(["reconstruct", scan, *WHOLE], after, number, itself)
    assert before == (scan.stat().st_mtime_ns, scan.read_bytes())
    if itself != AT_IMPORT:
        *_, said, ended = log.splitlines() if "ended after" in log else [*log.splitlines(), ""]
        assert said.endswith(SENTENCE.strip())
        assert not ended or "ended after" in ended


def test_native_saving_ends(interrupted):
    """MeshLab writes a large file, and looks at no signal."""
    words = ["apply", "create_sphere", "--subdiv", "6", "-o", "old.obj"]
    interrupted(words, ".obj", itself=AT_SAVING)


def test_a_child_of_run_ends(interrupted, scans, tmp_path):
    script = tmp_path / "s.mlx"
    script.write_text(
        "<!DOCTYPE FilterScript><FilterScript>"
        '<filter name="Compute normals for point sets"/>'
        '<filter name="Surface Reconstruction: Power Crust"/></FilterScript>'
    )
    interrupted(["run", script, scans[BIG], "-o", "old.ply", "--isolate"], "reading")
