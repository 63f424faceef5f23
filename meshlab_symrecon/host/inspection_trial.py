"""Files of rare formats, read by a child process first: what it dies of is told, not died of."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pymeshlab

from meshlab_symrecon.errors import FileError, SymReconError
from meshlab_symrecon.host.held import check_box
from meshlab_symrecon.host.own_program import own_program
from meshlab_symrecon.host.ply_header import damaged
from meshlab_symrecon.host.process_state import process_kept
from meshlab_symrecon.host.translation import translated

__all__ = ["try_in_child"]

CHILD = own_program("meshlab_symrecon.host.inspection_trial")
SECONDS = 10  # of the processor, for a small file
SECONDS_A_MEGABYTE = 3
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1"}  # 40 MB of addresses go to each, one for each core
WAITING = 4  # times as long, on a busy machine
MEMORY = 1 << 30  # bytes of addresses, for a small file; the child without one has a third
TIMES_THE_FILE = 100  # and so much for a large one
OUT_OF_TIME = "the reading took longer than {seconds} s, and MeshLab's reader seems to hang on it"
OUT_OF_MEMORY = "reading its {size} bytes takes more than {memory} MB of memory"


def try_in_child(path: Path) -> int:
    """Let a child process read the file first; return how many points it found.

    Raises
    ------
    FileError
        The child crashed, took too long or too much memory, or could not read the file.
    """
    size = path.stat().st_size
    seconds = SECONDS + SECONDS_A_MEGABYTE * (size >> 20)
    memory = MEMORY + TIMES_THE_FILE * size
    command = [*CHILD, str(path.resolve()), str(path), str(seconds), str(memory)]
    try:
        ended = subprocess.run(  # noqa: S603  our own interpreter, our own program
            command, capture_output=True, check=False, timeout=WAITING * seconds,
            env=os.environ | ONE_THREAD,
        )  # fmt: skip
    except subprocess.TimeoutExpired as error:
        raise damaged(path, OUT_OF_TIME.format(seconds=WAITING * seconds)) from error
    if ended.returncode in (-getattr(signal, "SIGXCPU", 0), -signal.SIGKILL):
        raise damaged(path, OUT_OF_TIME.format(seconds=seconds))
    try:
        points, problem = json.loads(ended.stdout)
    except ValueError as error:
        raise damaged(path, "MeshLab's reader crashes on it") from error
    if points < 0:
        raise damaged(path, OUT_OF_MEMORY.format(size=size, memory=memory >> 20))
    if problem:
        raise FileError(problem)
    if points == 0:
        raise FileError(f"{path} holds no points; scan again or pick another file")
    return int(points)


def main() -> None:
    """Read the file that the command line names, within its limits; print what was found."""
    file, shown, seconds, memory = sys.argv[1:]
    answer = _own_output()
    _limit(int(seconds), int(memory))
    try:
        found = (_points(Path(file), Path(shown)), "")
    except MemoryError:
        found = (-1, "")
    except SymReconError as error:
        out_of_memory = isinstance(error.__cause__, MemoryError) or "bad_alloc" in str(error)
        found = (-1 if out_of_memory else 0, str(error))
    os.write(answer, json.dumps(found).encode())


def _own_output() -> int:
    """Return the standard output; what MeshLab's readers print, at once or at the end, is lost."""
    answer = os.dup(1)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.close(nowhere)
    return answer


def _limit(seconds: int, memory: int) -> None:
    """Limit this process where the system can."""
    try:
        import resource
    except ImportError:
        return
    _, most = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (memory, most))
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 1))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def _points(file: Path, shown: Path) -> int:
    mesh_set: Any = pymeshlab.MeshSet(verbose=False)
    try:
        with translated(f"{shown} cannot be read"), process_kept():
            mesh_set.load_new_mesh(str(file))
    except SymReconError as error:
        cause = error.__cause__
        if isinstance(cause, MemoryError):
            raise cause from error
        raise FileError(f"{error}; write or download it again") from cause
    for mesh in mesh_set:
        if mesh.vertex_number():
            check_box(shown, mesh)
            _check_corners(shown, mesh)
    return sum(int(mesh.vertex_number()) for mesh in mesh_set)


def _check_corners(shown: Path, mesh: Any) -> None:
    """Refuse faces that lead out of the mesh: some readers take any number for a point's."""
    corners = mesh.face_matrix()
    highest = int(corners.max(initial=-1))
    if highest >= mesh.vertex_number() or corners.min(initial=0) < 0:
        message = f"a face names a point that is none of its {mesh.vertex_number()} points"
        raise damaged(shown, message)
