"""Throw broken, odd and malicious command lines at the real commands, and look at what they do.

    python benchmarks/fuzz_commands.py [--count N] [--seed N] [--jobs N] [--only KIND ...]

Each is a command in a folder of its own: filters of ours and MeshLab's with values from every
corner, filter scripts with words, numbers and structure changed, options that do not exist, files
that are no meshes, pipes and links, outputs in impossible places, batches with odd templates,
patterns and limits, broken projects, and meshlabserver's command line. A command must end within a
minute with the exit code 0, 1 or 2; with a sentence and without a traceback; its inputs must be as
they were, what it wrote must be whole, and nothing half-written may be left. Ends with 1 when one
does not; the folders of those are kept, in ``--keep DIR`` when it is given.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from fuzz_inputs import Input
from fuzz_kinds import NAMES, drawn

MINUTE = 60.0
MEMORY = 6 << 30  # bytes of memory of its own that a command may use


@dataclass(frozen=True)
class Outcome:
    """What a command did, and what is wrong with that."""

    number: int
    given: Input
    code: int
    seconds: float
    said: str
    faults: tuple[str, ...]


def limited() -> None:
    import resource

    resource.setrlimit(resource.RLIMIT_DATA, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def tried(given: Input, number: int, keep: Path) -> Outcome:
    folder = keep / f"{number:05}"
    folder.mkdir(parents=True)
    prepared(folder, given)
    program = "server" if given.server else "main"
    command = [sys.executable, "-m", f"meshlab_symrecon.cli.{program}", *given.words]
    one = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
    started = time.monotonic()
    process = subprocess.Popen(
        [word.encode("utf-8", "surrogateescape") for word in command], cwd=folder,
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        env=os.environ | one, preexec_fn=limited, start_new_session=True,
    )  # fmt: skip
    try:
        out, err = process.communicate(timeout=2 * MINUTE)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, 9)
        out, err = process.communicate()
    seconds = time.monotonic() - started
    said = (out + b"\n" + err).decode("utf-8", "replace")
    faults = tuple(faults_of(given, folder, process.returncode, seconds, said))
    outcome = Outcome(number, given, process.returncode, seconds, said, faults)
    if not faults:
        shutil.rmtree(folder)
    return outcome


def prepared(folder: Path, given: Input) -> None:
    """Make the files, pipes, folders and links that a command finds."""
    for name, content in given.files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)
    for name, kind in given.made.items():
        if kind == "fifo":
            os.mkfifo(folder / name)
        elif kind == "folder":
            (folder / name).mkdir()
        else:
            (folder / name).symlink_to(kind)


def faults_of(given: Input, folder: Path, code: int, seconds: float, said: str) -> Iterator[str]:
    if code < 0:
        yield f"ended by signal {-code}"
    elif code not in (0, 1, 2) and not (given.server and code < 256):
        yield f"exit code {code}"
    if seconds > MINUTE:
        yield f"{seconds:.0f} s"
    if "Traceback" in said:
        yield "a traceback"
    if code in (1, 2) and not said.strip():
        yield "no sentence"
    if code == 0 and re.search(r"(?m)^error: ", said):
        yield "an error, but exit code 0"
    outputs = set(given.words)
    scripts_written = outputs if outputs & {"--to-python", "--explain"} else set()
    for name, content in given.files.items():
        path = folder / name
        if given.server and name in outputs and given.words.count(name) > 1:
            continue  # meshlabserver may replace its input
        if not path.is_file() or sha(path.read_bytes()) != sha(content):
            yield f"{name} was changed"
    for path in folder.rglob("*"):
        if path.name.startswith(".symrecon"):
            yield f"{path.name} was left"
        elif (
            path.is_file()
            and str(path.relative_to(folder)) not in {*given.files, *given.made, *scripts_written}
            and not whole(path)
        ):
            yield f"{path.name} is not whole"


def sha(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def whole(path: Path) -> bool:
    """Say whether a file that was written is not cut off, as far as a glance can tell."""
    content = path.read_bytes()
    if path.suffix == ".json":
        return is_json(content)
    if path.suffix == ".jsonl":
        return all(is_json(line) for line in content.splitlines())
    if path.suffix in (".mlx", ".mlp"):
        return content.rstrip().endswith(b">")
    if path.suffix == ".ply":
        return whole_ply(content)
    return bool(content)


def is_json(content: bytes) -> bool:
    try:
        json.loads(content)
    except ValueError:
        return False
    return True


def whole_ply(content: bytes) -> bool:
    """Count the bytes of the vertices that the header announces; faces follow."""
    header, _, body = content.partition(b"end_header\n")
    sizes = {b"float": 4, b"double": 8, b"uchar": 1, b"int": 4, b"char": 1, b"short": 2}
    sizes |= {b"uint": 4, b"ushort": 2}
    least, count, each = 0, 0, 0
    for line in header.splitlines():
        words = line.split()
        if words[:1] == [b"element"]:
            least, count, each = least + count * each, int(words[2]), 0
        elif words[:2] == [b"property", b"list"]:
            each += sizes[words[2]]
        elif words[:1] == [b"property"]:
            each += sizes[words[1]]
    return b"ascii" in header or len(body) >= least + count * each


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--only", nargs="*", default=[], choices=NAMES)
    parser.add_argument("--keep", type=Path)
    given = parser.parse_args()
    keep = given.keep or Path(tempfile.mkdtemp(prefix="fuzz-commands-"))
    codes: Counter[int] = Counter()
    slowest, faulty = 0.0, 0
    numbers = range(given.first, given.first + given.count)
    with ThreadPoolExecutor(given.jobs) as pool:
        inputs = (drawn(given.seed, number, given.only) for number in numbers)
        for outcome in pool.map(lambda one, number: tried(one, number, keep), inputs, numbers):
            codes[outcome.code] += 1
            slowest = max(slowest, outcome.seconds)
            if outcome.faults:
                faulty += 1
                words = [word[:80] for word in outcome.given.words]
                last = " | ".join(outcome.said.strip().splitlines()[-2:])[-300:]
                print(
                    f"{outcome.number}: {', '.join(outcome.faults)}: {words!r}: {last}", flush=True
                )
    print(
        f"{given.count} commands, exit codes {dict(sorted(codes.items()))}, slowest {slowest:.0f} s"
    )
    print(f"{faulty} with faults" + (f", kept in {keep}" if faulty else ""))
    return 1 if faulty else 0


if __name__ == "__main__":
    sys.exit(main())
