"""Call the kernel and the algorithms with hostile input; report crashes, hangs and foreign errors.

    python benchmarks/fuzz_kernel.py --seeds 2000

The calls are those of tests/hostile_calls.py. They run in a child process: one that crashes, or
that takes longer than the limit, is reported with its seed, and the next one goes on behind it. Odd
seeds call the bindings with arrays that do not fit, even ones the public functions with clouds that
nobody wants.
"""

from __future__ import annotations

import argparse
import collections
import os
import queue
import subprocess
import sys
import threading
import time
import traceback
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
LAST_LINES, WIDTH = 30, 200  # of what a dead child said


def work(seeds):
    """Run calls one after the other, telling before and after each."""
    sys.path.insert(0, str(ROOT / "tests"))
    import hostile_calls

    recorded = hostile_calls.recorded_calls()
    for seed in seeds:
        call = hostile_calls.call_of(seed, recorded)
        print(f"begin {seed} {call.name}", flush=True)
        try:
            told = hostile_calls.outcome(call)
        except Exception:  # noqa: BLE001  # a foreign error is what is looked for
            told = "foreign: " + traceback.format_exc().replace("\n", "\\n")
        print(f"end {seed} {told.splitlines()[0] if told else ''}", flush=True)


class Child:
    """A process that makes calls, and what it says."""

    def __init__(self, first, end):
        command = [sys.executable, __file__, "--child", f"{first}:{end}"]
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True)
        self.lines = queue.Queue()
        self.complaints = collections.deque(maxlen=500)
        self.readers = [threading.Thread(target=self._listen), threading.Thread(target=self._note)]
        for reader in self.readers:
            reader.start()

    def _listen(self):
        for line in self.process.stdout:
            self.lines.put(line.rstrip("\n"))
        self.lines.put(None)

    def _note(self):
        self.complaints.extend(self.process.stderr)

    def calls(self, limit):
        """Yield (seed, name, outcome, seconds); the last one may be a crash or a hang."""
        seed, name, since = None, "", time.monotonic()
        while (line := self._next(since + limit)) is not None:
            word, number, rest = line.split(" ", 2)
            if word == "end":
                yield int(number), name, rest, time.monotonic() - since
                seed = None
            else:
                seed, name, since = int(number), rest, time.monotonic()
        hangs = self.process.poll() is None and self.readers[0].is_alive()
        if hangs:
            self.process.kill()
        for reader in self.readers:
            reader.join()
        code = self.process.wait()
        said = "".join(line[:WIDTH].rstrip() + "\n" for line in list(self.complaints)[:LAST_LINES])
        if seed is not None:
            failure = "hang" if hangs else f"crash {code}: {said}"
            yield seed, name, failure, time.monotonic() - since
        elif code != 0:
            raise SystemExit(f"a child failed between two calls: {said}")

    def _next(self, until):
        try:
            return self.lines.get(timeout=max(0.1, until - time.monotonic()))
        except queue.Empty:
            return None


def watched(first, end, limit):
    """Yield (seed, name, outcome, seconds) of each call, over as many children as it takes."""
    while first < end:
        for call in Child(first, end).calls(limit):
            first = call[0] + 1
            yield call


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=2000, help="number of calls")
    parser.add_argument("--first", type=int, default=0, help="seed of the first call")
    parser.add_argument("--limit", type=float, default=60.0, help="seconds a call may take")
    parser.add_argument("--child", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.child:
        first, end = map(int, options.child.split(":"))
        return work(range(first, end))
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    outcomes = collections.Counter()
    defects, slowest = 0, (0.0, None, "")
    end = options.first + options.seeds
    for seed, name, told, seconds in watched(options.first, end, options.limit):
        kind = told.split(":", 1)[0].split(" ", 1)[0]
        outcomes[name, kind] += 1
        slowest = max(slowest, (seconds, seed, name))
        if kind not in ("result", "refused", "stopped"):
            defects += 1
            print(f"seed {seed}, {name}: {told}".replace("\\n", "\n"), flush=True)
    kinds = sorted({kind for _, kind in outcomes})
    print(f"{'function':28}" + "".join(f"{kind:>10}" for kind in kinds))
    for name in sorted({name for name, _ in outcomes}):
        print(f"{name:28}" + "".join(f"{outcomes[name, kind]:10}" for kind in kinds))
    print(f"{sum(outcomes.values())} calls, {defects} defects; ", end="")
    print(f"the slowest took {slowest[0]:.1f} s: seed {slowest[1]}, {slowest[2]}")
    return 1 if defects else 0


if __name__ == "__main__":
    sys.exit(main())
