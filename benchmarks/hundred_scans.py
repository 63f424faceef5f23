"""A hundred scans in one batch, and what becomes of them when the plug is pulled.

``python benchmarks/hundred_scans.py [--seed N] [--kills N] [--folder DIR]``. The scans of
``scan_folder.py`` go through one script by ``symrecon batch``: without an interruption; killed with
SIGKILL at random moments and started again each time; and on a scheduler with two workers (needs
the extra ``distributed``), one of which is killed in the middle. Says what each gave, and ends with
1 unless all three gave the same bytes, 92 results and 8 reports.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from scan_folder import GOOD, SCRIPT, make_folder, make_plugin

LIMIT = "2G"  # of memory for a scan
LOG = "batch.jsonl"
PATIENCE = 3600.0  # seconds for one batch
GONE = 5.0  # seconds until no process of a killed batch is left


class Show:
    """The folders of the show, and the commands that work on them."""

    def __init__(self, folder: Path, seed: int) -> None:
        self.folder, self.scans = folder, folder / "scans"
        self.failing = make_folder(self.scans, seed)
        self.script = folder / "statue.mlx"
        self.script.write_text(SCRIPT)
        plugin = make_plugin(folder / "plugin")
        one = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
        self.environment = os.environ | one | {"PYTHONPATH": str(plugin)}
        self.inputs = checksums(self.scans)

    def start(self, output: Path, *more: str) -> subprocess.Popen:
        command = [
            sys.executable, "-m", "meshlab_symrecon.cli.main", "batch", str(self.script),
            str(self.scans), "-d", str(output), "--memory-limit", LIMIT, *more,
        ]  # fmt: skip
        with (self.folder / f"{output.name}.txt").open("a") as said:
            return subprocess.Popen(command, stdout=said, stderr=said, env=self.environment)

    def checked(self, output: Path, code: int) -> Mapping[str, str]:
        """Say what a finished batch gave; return its results' checksums."""
        lines = [json.loads(line) for line in (output / LOG).read_text().splitlines()]
        last = {Path(line["scan"]).name: line for line in lines}
        results = {name: sum_ for name, sum_ in checksums(output).items() if name != LOG}
        failed = {name for name, line in last.items() if line["status"] != "done"}
        states = Counter(last[name]["status"] for name in failed)
        print(f"{output.name}: exit code {code}, {len(results)} results, reports: {dict(states)}")
        for name in sorted(failed):
            print(f"  {name} ({self.failing.get(name)}): {last[name]['error']}")
        fine = code == 1 and len(results) == GOOD and failed == set(self.failing)
        if not fine:
            print(f"  NOT as expected; see {self.folder / output.name}.txt")
        if checksums(self.scans) != self.inputs:
            print("  INPUTS CHANGED")
            fine = False
        leftovers = [path for path in output.parent.rglob(".symrecon-*") if path.is_dir()]
        if leftovers:
            print(f"  LEFT: {leftovers}")
        return results if fine and not leftovers else {}


def checksums(folder: Path) -> dict[str, str]:
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and not path.name.startswith(".")
    }


def uninterrupted(show: Show) -> Mapping[str, str]:
    started = time.monotonic()
    output = show.folder / "uninterrupted"
    code = show.start(output).wait(PATIENCE)
    print(f"uninterrupted: {time.monotonic() - started:.0f} s")
    return show.checked(output, code)


def killed(show: Show, kills: int, rng: np.random.Generator) -> Mapping[str, str]:
    output = show.folder / "killed"
    for _ in range(kills):
        batch = show.start(output)
        time.sleep(rng.uniform(3.0, 25.0))
        batch.kill()
        batch.wait()
        done = len(checksums(output)) if output.exists() else 0
        time.sleep(GONE)
        print(f"killed with {done} files there; {orphans(output)} processes live on")
    return show.checked(output, show.start(output).wait(PATIENCE))


def orphans(output: Path) -> int:
    """Count the processes that still hold a folder's name on their command line."""
    found = subprocess.run(
        ["pgrep", "-f", str(output)], capture_output=True, text=True, check=False
    )
    return len(found.stdout.split())


@contextmanager
def cluster(show: Show) -> Iterator[tuple[str, list[subprocess.Popen]]]:
    """Start a scheduler and two workers; yield its address and the workers."""
    place = show.folder / "scheduler.json"
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "env": show.environment}
    dask = [sys.executable, "-m", "distributed.cli"]
    scheduler = subprocess.Popen(
        [f"{dask[0]}", "-m", "distributed.cli.dask_scheduler", "--port", "0", "--no-dashboard",
         "--host", "127.0.0.1", "--scheduler-file", str(place)], **quiet,
    )  # fmt: skip
    workers = []
    try:
        while not place.exists():
            time.sleep(0.1)
        address = json.loads(place.read_text())["address"]
        workers = [
            subprocess.Popen(
                [dask[0], "-m", "distributed.cli.dask_worker", address, "--nworkers", "1",
                 "--nthreads", "1", "--no-dashboard", "--no-nanny",
                 "--local-directory", str(show.folder / f"worker-{number}")], **quiet,
            )
            for number in range(2)
        ]  # fmt: skip
        yield address, workers
    finally:
        for process in (*workers, scheduler):
            process.send_signal(signal.SIGTERM)
        for process in (*workers, scheduler):
            process.wait(30)


def distributed(show: Show, rng: np.random.Generator) -> Mapping[str, str]:
    output = show.folder / "distributed"
    with cluster(show) as (address, workers):
        batch = show.start(output, "--scheduler", address)
        time.sleep(rng.uniform(15.0, 45.0))
        workers[0].kill()
        print(f"a worker killed with {len(checksums(output))} files there")
        return show.checked(output, batch.wait(PATIENCE))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kills", type=int, default=5)
    parser.add_argument("--folder", type=Path)
    given = parser.parse_args()
    rng = np.random.default_rng(given.seed)
    folder = given.folder or Path(tempfile.mkdtemp(prefix="hundred-scans-"))
    show = Show(folder, given.seed)
    print(f"{len(show.inputs)} scans in {show.scans}, of which {len(show.failing)} must fail")
    first = uninterrupted(show)
    same = {
        "killed and resumed": bool(first) and killed(show, given.kills, rng) == first,
        "two workers, one killed": bool(first) and distributed(show, rng) == first,
    }
    for name, equal in same.items():
        print(f"{name}: {'identical bytes' if equal else 'NOT identical'}")
    return 0 if all(same.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
