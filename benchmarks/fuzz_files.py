"""Damaged files through the reader, each in a process of its own: what becomes of them.

    python benchmarks/fuzz_files.py [--inputs 2000] [--seed 0] [--only ply obj] [--raw] [--keep DIR]

Good files of every format are written by hand and by MeshLab, and read back; then damaged in the
ways of ``fuzz_damage`` and read again. ``--raw`` reads with pymeshlab alone, for comparison. Prints
a table of formats and outcomes, and each input that crashed, hung, took gigabytes, raised something
that is no error of ours, or lost points without a word; ``--keep`` saves those. Equal seeds give
equal inputs. Exit code 1 when there was such an input.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections import Counter
from pathlib import Path

import numpy as np
from fuzz_damage import DAMAGES, TRUNCATIONS
from fuzz_run import Outcome, raw_reader, run, whole_reader
from fuzz_writers import Good, good_files

KINDS = ("loaded", "warned", "refused", "false refusal", "silent", "traceback", "crash", "hang",
         "memory")  # fmt: skip
BAD = ("false refusal", "silent", "traceback", "crash", "hang", "memory")
UNCOUNTED = ("xyz", "obj", "qobj", "asc", "pts", "apts", "txt")  # a shorter one may be a whole file
SECONDS = 40.0


def judged(good: Good, outcome: Outcome, damage: object) -> str:
    """Return the kind of outcome, by what the file holds."""
    if outcome.kind != "loaded":
        return "false refusal" if damage is None and outcome.kind == "refused" else outcome.kind
    if outcome.warnings:
        return "silent" if any("SymRecon" not in w and "overflow" in w for w in outcome.warnings) \
            else "warned"  # fmt: skip
    extension = good.name.rsplit(".", 1)[1]
    if damage is None:
        return "loaded" if _same(good, outcome) else "silent"
    fewer = outcome.points < good.points or outcome.faces < good.faces
    if damage in TRUNCATIONS and fewer and extension not in UNCOUNTED:
        return "silent"
    return "loaded"


def _same(good: Good, outcome: Outcome) -> bool:
    if (outcome.points, outcome.faces) != (good.points, good.faces):
        return False
    if good.coordinates is None:
        return True
    found = np.array(outcome.coordinates)
    return bool(np.allclose(found, good.coordinates, rtol=good.exact, atol=0.0))


def inputs(seed: int, count: int, only: list[str]) -> list[tuple[Good, object, bytes]]:
    """Return inputs: every good file as it is, then damaged ones."""
    generator = np.random.default_rng(seed)
    chosen: list[tuple[Good, object, bytes]] = []
    round_ = 0
    while len(chosen) < count:
        goods = [
            good for good in good_files(seed * 1000 + round_)
            if not only or good.name.rsplit(".", 1)[1] in only
        ]  # fmt: skip
        chosen += [(good, None, good.content) for good in goods]
        for good in goods:
            for index in generator.choice(len(DAMAGES), 6, replace=False):
                chosen.append((good, DAMAGES[index], DAMAGES[index](good.content, generator)))
        round_ += 1
    return chosen[:count]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--inputs", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", nargs="*", default=[])
    parser.add_argument("--raw", action="store_true")
    parser.add_argument("--keep", type=Path)
    options = parser.parse_args()
    reader = raw_reader if options.raw else whole_reader
    import meshlab_symrecon.host.files  # noqa: F401  before the forks

    table: dict[str, Counter[str]] = {}
    with tempfile.TemporaryDirectory() as folder:
        for number, (good, damage, content) in enumerate(
            inputs(options.seed, options.inputs, options.only)
        ):
            extension = good.name.rsplit(".", 1)[1]
            path = Path(folder, f"{number}.{extension}")
            path.write_bytes(content)
            outcome = run(path, reader, SECONDS)
            kind = judged(good, outcome, damage)
            table.setdefault(extension, Counter())[kind] += 1
            if kind in BAD:
                how = getattr(damage, "__name__", "as it is")
                found = f"{outcome.points}/{good.points} points, {outcome.faces}/{good.faces}"
                print(f"{kind}: {number} {good.name}, {how}: {outcome.message[-300:]} ({found})"
                      f" {' '.join(outcome.warnings)[:200]}", flush=True)  # fmt: skip
                if options.keep:
                    options.keep.mkdir(parents=True, exist_ok=True)
                    (options.keep / path.name).write_bytes(content)
            path.unlink()
    _print(table)
    return int(any(counts[kind] for counts in table.values() for kind in BAD))


def _print(table: dict[str, Counter[str]]) -> None:
    print("| format | inputs | " + " | ".join(KINDS) + " |")
    print("|---" * (len(KINDS) + 2) + "|")
    total: Counter[str] = sum(table.values(), Counter())
    for name, counts in [*sorted(table.items()), ("all", total)]:
        cells = [str(counts[kind]) for kind in KINDS]
        print(f"| {name} | {sum(counts.values())} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    sys.exit(main())
