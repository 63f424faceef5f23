"""Read one file in a forked child with limits of time and memory, and say what became of it."""

from __future__ import annotations

import json
import os
import resource
import select
import signal
import sys
import time
import traceback
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

__all__ = ["Outcome", "Reader", "raw_reader", "run", "whole_reader"]

SECONDS = 10.0
ADDRESS_SPACE = 6 << 30  # bytes; a guard of the machine, not what is measured
TOO_MUCH = 700 << 20  # bytes resident, for files of some kilobytes
NOTHING = (0, 0, [], [])
Reader = Callable[[Path], tuple[int, int, list[list[float]], list[str]]]


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of reading a file.

    Attributes
    ----------
    kind : str
        ``loaded``, ``refused``, ``traceback``, ``crash``, ``hang`` or ``memory``.
    message : str
        Of the error, or how the process ended.
    points, faces : int
    coordinates : list of rows
    warnings : list of str
    seconds : float
    """

    kind: str
    message: str = ""
    points: int = 0
    faces: int = 0
    coordinates: tuple[tuple[float, ...], ...] = ()
    warnings: tuple[str, ...] = ()
    seconds: float = 0.0


def whole_reader(path: Path) -> tuple[int, int, list[list[float]], list[str]]:
    """Read as every command does; return points, faces, coordinates and warnings."""
    from meshlab_symrecon.host.files import load

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        mesh_set = load(path)
    return *_content(mesh_set), [str(one.message) for one in caught]


def raw_reader(path: Path) -> tuple[int, int, list[list[float]], list[str]]:
    """Read with pymeshlab alone; return the same."""
    import pymeshlab

    from meshlab_symrecon.errors import FileError

    mesh_set = pymeshlab.MeshSet(verbose=False)
    try:
        mesh_set.load_new_mesh(str(path))
    except pymeshlab.PyMeshLabException as error:
        raise FileError(" ".join(str(error).split())) from error
    return *_content(mesh_set), []


def _content(mesh_set: object) -> tuple[int, int, list[list[float]]]:
    points, faces, coordinates = 0, 0, []
    for mesh in mesh_set:
        points += mesh.vertex_number()
        faces += mesh.face_number()
        if mesh.vertex_number() <= 5000:
            coordinates += mesh.vertex_matrix().tolist()
    return points, faces, coordinates


def run(path: Path, reader: Reader, seconds: float = SECONDS) -> Outcome:
    """Return what becomes of reading a file."""
    receiving, sending = os.pipe()
    started = time.perf_counter()
    child = os.fork()
    if child == 0:
        os.close(receiving)
        _work(path, reader, sending, seconds)
    os.close(sending)
    text = _received(receiving, started + seconds)
    if text is None:
        _kill(child)
    _, status, used = os.wait4(child, 0)
    took = time.perf_counter() - started
    if text is None:
        return Outcome("hang", f"no end after {seconds:g} s", seconds=took)
    if used.ru_maxrss * 1024 > TOO_MUCH:
        what = f"{used.ru_maxrss >> 10} MB for {_size(path)} bytes: {text[:200]}"
        return Outcome("memory", what, seconds=took)
    if os.WIFSIGNALED(status) or not text:
        number = os.WTERMSIG(status) if os.WIFSIGNALED(status) else 0
        name = (
            signal.Signals(number).name if number else f"exit {os.waitstatus_to_exitcode(status)}"
        )
        return Outcome("crash", name, seconds=took)
    kind, message, content = json.loads(text)
    points, faces, coordinates, told = content
    rows = tuple(tuple(row) for row in coordinates)
    return Outcome(kind, message, points, faces, rows, tuple(told), took)


def _size(path: Path) -> int:
    return path.stat().st_size if path.is_file() else 0


def _kill(child: int) -> None:
    try:
        os.killpg(child, signal.SIGKILL)
    except ProcessLookupError:
        os.kill(child, signal.SIGKILL)


def _received(receiving: int, end: float) -> str | None:
    """Return all that the child wrote, None when it did not end in time."""
    parts = []
    with os.fdopen(receiving, "rb", buffering=0) as stream:
        while True:
            ready, _, _ = select.select([stream], [], [], max(0.0, end - time.perf_counter()))
            if not ready:
                return None
            part = stream.read(1 << 20)
            if not part:
                return b"".join(parts).decode()
            parts.append(part)


def _work(path: Path, reader: Reader, sending: int, seconds: float) -> None:
    from meshlab_symrecon.errors import SymReconError

    os.setpgid(0, 0)
    resource.setrlimit(resource.RLIMIT_AS, (ADDRESS_SPACE, ADDRESS_SPACE))
    resource.setrlimit(resource.RLIMIT_CPU, (int(seconds) + 2, int(seconds) + 2))
    quiet = os.open(os.devnull, os.O_WRONLY)
    os.dup2(quiet, 1)
    os.dup2(quiet, 2)
    try:
        answer = ("loaded", "", reader(path))
    except SymReconError as error:
        answer = ("refused", str(error), NOTHING)
    except BaseException:  # noqa: BLE001  what else comes out is what is looked for
        answer = ("traceback", "".join(traceback.format_exception(*sys.exc_info())[-3:]), NOTHING)
    with os.fdopen(sending, "w") as stream:
        json.dump(answer, stream)
        stream.flush()
    os._exit(0)
