"""How well mirror completion fills what a scan lacks, over models, damage and seeds.

    SYMRECON_DATA=FOLDER:... python benchmarks/completion.py [NAME ...]
        [--conditions region occlusion cut blobs noise clutter] [--seeds 1 2 3] [--size 50000]
        [--true-planes] [--set blend=0.06 ...] [--surfaces] [--quick] [--json FILE]

prints a Markdown table for each condition, one line a model (means over the seeds), and which of
the bars hold.  Without names, all models of SYMRECON_DATA that have a plane.  Scans are sampled and
damaged by `completion_scans.py`; planes are those that ours detects on them, or the true ones.
Each measure is a function of `completion_measures.py`.

*best* is what the true plane can give: the measured points, and the image of the complete statue
where the scan lacks it; *reach* is what the scan and its image at the true plane give, since what
is missing on both sides no mirror can fill.  *scan* is no completion, *whole* adds the whole
scan's mirror image.

With ``--surfaces``, surfaces are compared instead, those of `completion_surfaces.py`: ours end to
end, and what MeshLab makes of the scan as it is.
"""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import asdict, replace
from pathlib import Path

from completion_methods import ours
from completion_rows import row_of
from completion_scans import CONDITIONS, case_of
from completion_surfaces import surfaces_of
from completion_tables import JOIN, POINTS, print_bars, print_surfaces, print_table
from symmetry_models import entries, model

QUICK = ("nefertiti", "skull", "moai")


def setting(words: str) -> tuple[str, float | int]:
    name, value = words.split("=")
    return name, int(value) if value.lstrip("-").isdigit() else float(value)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--conditions", nargs="+", choices=CONDITIONS, default=["region"])
    parser.add_argument("--seeds", nargs="+", type=int, default=[1, 2, 3])
    parser.add_argument("--size", type=int, default=50_000, help="samples before the damage")
    parser.add_argument("--true-planes", action="store_true", help="do not detect planes")
    parser.add_argument("--set", nargs="+", type=setting, default=[], metavar="NAME=VALUE")
    parser.add_argument("--surfaces", action="store_true", help="compare surfaces instead")
    parser.add_argument("--quick", action="store_true", help="three models, one seed")
    parser.add_argument("--json", type=Path, help="write all rows to this file")
    options = parser.parse_args()
    chosen = options.names or [name for name, (_, entry) in entries().items() if entry["planes"]]
    if options.quick:
        chosen, options.seeds = [n for n in QUICK if n in entries()], options.seeds[:1]
    if not chosen:
        parser.error("no models: SYMRECON_DATA names no folder that has planes.json and meshes")
    kept = [one for condition in options.conditions for one in tables(condition, chosen, options)]
    if options.json:
        options.json.write_text(json.dumps(kept, indent=1))


def tables(condition: str, chosen: list[str], options: argparse.Namespace) -> list[dict]:
    """Print the tables of a condition; return what they hold."""
    rows, surfaces = [], []
    damage = replace(CONDITIONS[condition], count=options.size)
    for name in chosen:
        for seed in options.seeds:
            case = case_of(model(name, seed), damage, seed)
            if options.surfaces:
                surfaces.append((name, seed, surfaces_of(case)))
                continue
            planes = case.planes if options.true_planes else None
            done = ours(case.points, planes, **dict(options.set))
            rows.append(row_of((name, condition, seed), case, done))
        print(".", end="", file=sys.stderr, flush=True)
    print(f"\n## {condition}")
    if options.surfaces:
        print_surfaces(surfaces)
        return [
            {"model": name, "condition": condition, "seed": seed, "way": way, **asdict(one)}
            for name, seed, found in surfaces
            for way, one in found.items()
        ]
    print_table(rows, POINTS)
    print_table(rows, JOIN)
    print_bars(rows, condition)
    return [asdict(row) for row in rows]


if __name__ == "__main__":
    main()
