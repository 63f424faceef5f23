"""How often planes are found, how often wrong ones, and at what cost, beside other methods.

    python benchmarks/symmetry_success.py                                   ours, all models
    python benchmarks/symmetry_success.py --methods ours mean-shift multistart pca --seeds 1 2
    python benchmarks/symmetry_success.py --models bust jug dancer --conditions r25 cut50

prints one table a method, models by conditions, and one of totals.  Models are made (`shapes.py`);
those of the folders in SYMRECON_DATA come on top.

A plane is right within 3 degrees and 2 % of the diagonal (at the centre of the object) of a true
one, or within 0.5 degrees and 0.5 % of where the finest refinement on the damaged cloud ends when
it starts from the true one: no statue is exact, and half a statue has an optimum of its own.  With
a plane, a method is right when the first plane it reports is; without one, when it reports none.
Every method is judged on the same damaged clouds and by the same verification and confidence
(`mirror_peers.py`); *if forced* counts its first plane whatever the confidence.

The weights in ``symmetry/confidence.py`` were fitted on nefertiti, squirrel, max_planck, column,
skull, trim_star, bunny and twirl, on models from package samples, and on made shapes of seeds 0 to
2, with damage by another program (`fit_confidence.py`); moai, falcon, wingnut, demosthenes,
sea_vase and shepherd_boy had no part in it.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import defaultdict
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from damage import CONDITIONS, Scan, damaged
from mirror_peers import METHODS, Found, refined
from symmetry_models import KINDS, model, names

NEAR = (np.radians(3.0), 0.02)  # of a true plane
SETTLED = (np.radians(0.5), 0.005)  # of where refinement ends that started there
ASTRAY = (np.radians(8.0), 0.06)  # refinement that ends farther away shows nothing
SUMMED = ("true", "found", "reported", "wrong", "duplicates")  # of outcomes
NOTHING, ROUND = -1, -2  # instead of the number of a true plane


@dataclass(frozen=True)
class Outcome:
    """What a method said of one scan."""

    model: str
    kind: str
    condition: str
    seed: int
    method: str
    symmetric: bool
    right: bool  # the first reported plane is; without a true one, none is reported
    forced: bool  # the first plane is, whatever the confidence
    reported: int
    wrong: int  # reported planes
    duplicates: int  # reported planes that repeat a right one
    true: int  # planes that there are, besides those through an axis
    found: int  # of them, reported
    seconds: float  # CPU


# -------------------------------------------------------------------------------------- judgement


def apart(planes, plane, scan: Scan) -> tuple[np.ndarray, np.ndarray]:
    """Angles and, in diagonals at the centre, offsets between planes (k, 4) and one plane."""
    sines = np.linalg.norm(np.cross(planes[:, :3], plane[:3]), axis=1)
    cosines = planes[:, :3] @ plane[:3]
    heights = planes[:, :3] @ scan.centre + planes[:, 3]
    own = plane[:3] @ scan.centre + plane[3]
    signs = np.where(cosines < 0.0, -1.0, 1.0)
    return np.arctan2(sines, np.abs(cosines)), np.abs(signs * heights - own) / scan.diagonal


def nearest_within(planes, plane, scan: Scan, limits) -> int:
    """Number of the plane within the limits that is nearest in angle."""
    if len(planes) == 0:
        return NOTHING
    angles, offsets = apart(planes, plane, scan)
    inside = (angles < limits[0]) & (offsets < limits[1])
    return int(np.argmin(np.where(inside, angles, np.inf))) if inside.any() else NOTHING


class Judge:
    """Tells right planes of one scan; refinement from the true ones only when it is asked for."""

    def __init__(self, scan: Scan):
        self.scan = scan
        self.settled: np.ndarray | None = None

    def matched(self, plane) -> int:
        """The number of the true plane that this is, ROUND through the axis, or NOTHING."""
        found = nearest_within(self.scan.planes, plane, self.scan, NEAR)
        if found == NOTHING and self._through_axis(plane):
            return ROUND
        if found == NOTHING and len(self.scan.planes):
            found = nearest_within(self._settled(), plane, self.scan, SETTLED)
        return found

    def _through_axis(self, plane) -> bool:
        if self.scan.axis is None:
            return False
        point, direction = self.scan.axis
        sine = abs(plane[:3] @ direction)
        gap = abs(plane[:3] @ point + plane[3]) / self.scan.diagonal
        return bool(sine < np.sin(NEAR[0]) and gap < NEAR[1])

    def _settled(self) -> np.ndarray:
        if self.settled is None:
            ends = refined(self.scan.points, self.scan.planes)
            for row, (end, true) in enumerate(zip(ends, self.scan.planes, strict=True)):
                if nearest_within(true[np.newaxis], end, self.scan, ASTRAY) == NOTHING:
                    ends[row] = true
            self.settled = ends
        return self.settled

    def duplicates(self, planes, matches) -> int:
        """Count right planes that repeat an earlier one."""
        count = 0
        for row, match in enumerate(matches):
            earlier = [k for k in range(row) if matches[k] == match]
            if match == ROUND:  # others through the axis are planes of their own
                beside = nearest_within(planes[earlier], planes[row], self.scan, ASTRAY)
                count += beside != NOTHING
            elif match != NOTHING:
                count += bool(earlier)
        return count


def judged(judge: Judge, found: Found) -> dict:
    """Return the counts of an outcome."""
    matches = [judge.matched(plane) for plane in found.reported]
    symmetric = len(judge.scan.planes) > 0 or judge.scan.axis is not None
    first = len(found.ranked) > 0 and judge.matched(found.ranked[0]) != NOTHING
    return {
        "symmetric": symmetric,
        "right": bool(matches and matches[0] != NOTHING) if symmetric else not matches,
        "forced": bool(symmetric and first),
        "reported": len(matches),
        "wrong": sum(match == NOTHING for match in matches),
        "duplicates": judge.duplicates(found.reported, matches),
        "true": len(judge.scan.planes),
        "found": len({match for match in matches if match >= 0}),
        "seconds": found.seconds,
    }


def outcomes(chosen, conditions, seeds, methods):
    """Yield the outcomes, model by model."""
    for name in chosen:
        for seed in seeds:
            shape = model(name, seed)
            for condition in conditions:
                scan = damaged(shape, CONDITIONS[condition], seed)
                judge = Judge(scan)
                for method in methods:
                    counts = judged(judge, METHODS[method](scan.points))
                    yield Outcome(name, shape.kind, condition, seed, method, **counts)
        print(".", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)


# ----------------------------------------------------------------------------------------- tables


def row_of(cells) -> str:
    return "| " + " | ".join(str(cell) for cell in cells) + " |"


def cell_of(group: list[Outcome]) -> str:
    """Right of cases; ``+k``: k wrong planes were reported."""
    wrong = sum(one.wrong for one in group)
    return f"{sum(one.right for one in group)}/{len(group)}" + (f" +{wrong}" if wrong else "")


def share(part: float, whole: float) -> str:
    return f"{part / whole:.2f}" if whole else "-"


def print_models(results: list[Outcome], method: str, conditions) -> None:
    """One row a model, one column a condition."""
    cells: dict[tuple[str, str], list[Outcome]] = defaultdict(list)
    kinds = {}
    for one in results:
        if one.method == method:
            cells[one.model, one.condition].append(one)
            kinds[one.model] = one.kind
    print(f"\n**{method}**: right of cases, + wrong planes reported\n")
    print(row_of(["model", "kind", *conditions]))
    print(row_of(["---"] * (2 + len(conditions))))
    for name, kind in sorted(kinds.items(), key=lambda item: KINDS.index(item[1])):
        print(row_of([name, kind, *(cell_of(cells[name, c]) for c in conditions)]))


def print_conditions(results: list[Outcome], methods, conditions) -> None:
    """One row a method, with a plane and without; one column a condition."""
    print("\nShare right\n")
    print(row_of(["method", "models", *conditions, "all", "if forced"]))
    print(row_of(["---"] * (4 + len(conditions))))
    for symmetric, label in ((True, "with a plane"), (False, "without")):
        for method in methods:
            group = [r for r in results if r.method == method and r.symmetric == symmetric]
            if not group:
                continue
            shares = [
                share(sum(r.right for r in part), len(part))
                for part in ([r for r in group if r.condition == c] for c in conditions)
            ]
            forced = share(sum(r.forced for r in group), len(group)) if symmetric else "-"
            every = share(sum(r.right for r in group), len(group))
            print(row_of([method, label, *shares, every, forced]))


def print_kinds(results: list[Outcome], methods) -> None:
    """One row a method, one column a kind of models."""
    kinds = [kind for kind in KINDS if any(r.kind == kind for r in results)]
    print("\nShare right, by kinds of models\n")
    print(row_of(["method", *kinds]))
    print(row_of(["---"] * (1 + len(kinds))))
    for method in methods:
        groups = [[r for r in results if r.method == method and r.kind == kind] for kind in kinds]
        print(row_of([method, *(share(sum(r.right for r in g), len(g)) for g in groups)]))


def print_totals(results: list[Outcome], methods) -> None:
    """What was reported, and the time."""
    print(
        "\nWhat was reported; *none reported* counts models with a plane, *without* those without\n"
    )
    heads = ["method", "cases", "none reported", "true planes", "found", "reported", "wrong"]
    heads += ["repeated", "cases without", "with a plane reported", "median CPU s", "most"]
    print(row_of(heads))
    print(row_of(["---"] * len(heads)))
    for method in methods:
        group = [one for one in results if one.method == method]
        without = [one for one in group if not one.symmetric]
        none = sum(one.symmetric and not one.reported for one in group)
        totals = [sum(getattr(one, name) for one in group) for name in SUMMED]
        times = [one.seconds for one in group]
        row = [method, len(group), none, *totals, len(without)]
        row += [sum(one.reported > 0 for one in without)]
        print(row_of([*row, f"{np.median(times):.2f}", f"{max(times):.2f}"]))


def main():
    """Print the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--models", nargs="+", choices=names(), default=names(), metavar="NAME")
    parser.add_argument("--kinds", nargs="+", choices=KINDS, help="only models of these kinds")
    parser.add_argument("--conditions", nargs="+", choices=CONDITIONS, default=list(CONDITIONS))
    parser.add_argument("--seeds", nargs="+", type=int, default=[401])
    parser.add_argument("--methods", nargs="+", choices=METHODS, default=["ours"])
    parser.add_argument("--json", type=Path, help="write all outcomes to this file")
    options = parser.parse_args()
    chosen = options.models
    if options.kinds:
        chosen = [n for n in chosen if model(n, options.seeds[0]).kind in options.kinds]
    results = list(outcomes(chosen, options.conditions, options.seeds, options.methods))
    if options.json:
        options.json.write_text(json.dumps([asdict(one) for one in results], indent=1))
    for method in options.methods:
        print_models(results, method, options.conditions)
    print_conditions(results, options.methods, options.conditions)
    print_kinds(results, options.methods)
    print_totals(results, options.methods)


if __name__ == "__main__":
    main()
