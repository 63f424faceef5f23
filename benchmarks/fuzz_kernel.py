"""Call the kernel and the algorithms with hostile input; report crashes, hangs and foreign errors.

    python benchmarks/fuzz_kernel.py --seeds 2000

The calls are those of tests/hostile_calls.py. They run in a child process: one that crashes, or that takes longer than
the limit, is reported with its seed, and the next one goes on behind it. Odd seeds call the bindings with arrays that
do not fit, even ones the public functions with clouds that nobody wants.
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
LAST_LINES = 12  # of what a dead child said


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


def watched(seeds, limit):
    """Yield (seed, name, outcome, seconds) of each call, over as many children as it takes."""
    seeds = list(seeds)
    while seeds:
        arguments = [sys.executable, __file__, "--child", f"{seeds[0]}:{seeds[-1] + 1}"]
        child = subprocess.Popen(
            arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        lines: queue.Queue[str | None] = queue.Queue()
        said: collections.deque[str] = collections.deque(maxlen=500)
        readers = [
            threading.Thread(target=lambda: [lines.put(line) for line in child.stdout]),
            threading.Thread(target=lambda: said.extend(child.stderr)),
        ]
        for reader in readers:
            reader.start()
        seed, name, since = None, "", time.monotonic()
        failure = None
        while True:
            try:
                line = lines.get(timeout=1.0)
            except queue.Empty:
                if time.monotonic() - since > limit:
                    child.kill()
                    failure = "hang"
                    break
                if child.poll() is not None and not readers[0].is_alive() and lines.empty():
                    break
                continue
            word, number, rest = (line.rstrip("\n").split(" ", 2) + ["", ""])[:3]
            if word == "begin":
                seed, name, since = int(number), rest, time.monotonic()
            elif word == "end":
                yield seed, name, rest, time.monotonic() - since
                seeds = [s for s in seeds if s > seed]
                seed, since = None, time.monotonic()
        for reader in readers:
            reader.join()
        child.wait()
        if not seeds and child.returncode == 0:
            return
        if seed is None and failure is None:
            raise SystemExit(f"a child died before it began: {''.join(said)}")
        if failure is None:
            failure = f"crash {child.returncode}: " + "".join(list(said)[:LAST_LINES])
        yield seed, name, failure, time.monotonic() - since
        seeds = [s for s in seeds if seed is None or s > seed]


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
    for seed, name, told, seconds in watched(
        range(options.first, options.first + options.seeds), options.limit
    ):
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
    print(
        f"{sum(outcomes.values())} calls, {defects} defects; the slowest took {slowest[0]:.1f} s: seed {slowest[1]}, {slowest[2]}"
    )
    return 1 if defects else 0


if __name__ == "__main__":
    sys.exit(main())
