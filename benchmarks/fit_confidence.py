"""The fit behind `symmetry/confidence.py`: traits of planes, true or not, and their weights.

    python benchmarks/fit_confidence.py [--models NAME ...] [--conditions r25 cut50] [--seeds 0 1]

prints the constant and the weights of the two regressions (clouds that end at a flat break, and all
others), and how they do on families of models that they were not fitted on.  Models are made
(`shapes.py`); those of the folders in SYMRECON_DATA come on top.  The shipped weights are such a
fit on 961 clouds: made shapes of seeds 0 to 2, eight scanned models and 29 from package samples,
whole and under eight kinds of damage.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass

import numpy as np
from damage import CONDITIONS, damaged
from mirror_peers import refined
from scipy.optimize import minimize
from symmetry_models import model, names
from symmetry_success import NEAR, NOTHING, SETTLED, nearest_within

from meshlab_symrecon.symmetry.candidates import vote
from meshlab_symrecon.symmetry.cascade import QUERIES, TOLERANCE, refine_and_verify
from meshlab_symrecon.symmetry.exemplars import choose_exemplars
from meshlab_symrecon.symmetry.preparation import prepare
from meshlab_symrecon.symmetry.traits import TRAITS, traits

AGAINST = {"near misses", "residual", "turn", "excused", "broken off", "rim excused"}
FREE = {"roughness"}  # of the other traits none may speak against a plane
VARIANT = (np.radians(8.0), 0.05)  # nearly true planes: wrong, but not very
VARIANT_WEIGHT = 0.3
STRENGTH = 0.5  # of the data against the prior that weights are small
FOLDS = 10


@dataclass(frozen=True, eq=False)
class Judged:
    """All verified planes of a cloud."""

    family: str
    broken: bool
    symmetric: bool
    traits: np.ndarray  # (k, t)
    right: np.ndarray  # (k,)
    weights: np.ndarray  # (k,)


def judged(name: str, condition: str, seed: int) -> Judged:
    scan = damaged(model(name, seed), CONDITIONS[condition], seed)
    cloud = prepare(scan.points, None, QUERIES)
    candidates = vote(cloud, 1200, 30_000, np.random.default_rng(0))
    starts, _ = choose_exemplars(cloud, candidates.planes)
    planes, evidence = refine_and_verify(cloud, starts)
    settled, right, variant = refined(scan.points, scan.planes), [], []
    for plane in cloud.to_input(planes):
        true = nearest_within(scan.planes, plane, scan, NEAR) != NOTHING
        true |= nearest_within(settled, plane, scan, SETTLED) != NOTHING
        if scan.axis is not None:
            apart = plane[:3] @ scan.axis[0] + plane[3]
            true |= abs(plane[:3] @ scan.axis[1]) < np.sin(NEAR[0]) and (
                abs(apart) < NEAR[1] * scan.diagonal
            )
        right.append(true)
        variant.append(nearest_within(scan.planes, plane, scan, VARIANT) != NOTHING)
    right = np.array(right, dtype=bool)
    weights = np.where(np.array(variant, dtype=bool) & ~right, VARIANT_WEIGHT, 1.0)
    symmetric = len(scan.planes) > 0 or scan.axis is not None
    found = traits(planes, evidence, cloud, TOLERANCE)
    return Judged(name, cloud.broken, symmetric, found, right, weights)


def fit(cases: list[Judged]) -> tuple[np.ndarray, float]:
    """Logistic regression whose weights may not contradict their meaning."""
    rows = np.concatenate([case.traits for case in cases])
    right = np.concatenate([case.right for case in cases]).astype(float)
    weights = np.concatenate([case.weights for case in cases])
    mean, spread = rows.mean(axis=0), rows.std(axis=0) + 1e-9
    rows = (rows - mean) / spread
    bounds = [
        (None, None) if name in FREE else (None, 0.0) if name in AGAINST else (0.0, None)
        for name in TRAITS
    ]

    def loss(unknown):
        odds = rows @ unknown[:-1] + unknown[-1]
        misfit = weights * (1.0 / (1.0 + np.exp(-odds)) - right)
        value = STRENGTH * (weights * (np.logaddexp(0.0, odds) - right * odds)).sum()
        slope = np.append(STRENGTH * misfit @ rows + unknown[:-1], STRENGTH * misfit.sum())
        return value + 0.5 * (unknown[:-1] ** 2).sum(), slope

    start = np.zeros(len(TRAITS) + 1)
    found = minimize(loss, start, jac=True, bounds=[*bounds, (None, None)], method="L-BFGS-B").x
    slopes = found[:-1] / spread
    return slopes, float(found[-1] - slopes @ mean)


def held_out(cases: list[Judged]) -> str:
    """Say how first planes do on families of models that were left out of the fit."""
    families = sorted({case.family for case in cases})
    counts = {True: [0, 0, 0], False: [0, 0, 0]}  # cases, right, wrong
    for fold in range(min(FOLDS, len(families))):
        out = set(families[fold::FOLDS])
        slopes, constant = fit([case for case in cases if case.family not in out])
        for case in cases:
            if case.family in out:
                odds = case.traits @ slopes + constant
                first = int(np.argmax(odds)) if len(odds) else -1
                count = counts[case.symmetric]
                count[0] += 1
                if first >= 0 and odds[first] > 0.0:
                    count[1 if case.right[first] else 2] += 1
    (cases_with, right, wrong), (cases_without, _, invented) = counts[True], counts[False]
    return (
        f"left out of the fit: {right} of {cases_with} right and {wrong} wrong with a plane, "
        f"{invented} of {cases_without} reported without"
    )


def main():
    """Print both fits."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--models", nargs="+", choices=names(), default=names(), metavar="NAME")
    parser.add_argument("--conditions", nargs="+", choices=CONDITIONS, default=list(CONDITIONS))
    parser.add_argument("--seeds", nargs="+", type=int, default=[0])
    options = parser.parse_args()
    cases = [
        judged(name, condition, seed)
        for name in options.models
        for seed in options.seeds
        for condition in options.conditions
    ]
    for broken in (False, True):
        some = [case for case in cases if case.broken == broken and len(case.traits)]
        if len({case.family for case in some}) < 2:
            continue
        slopes, constant = fit(some)
        print("\nflat breaks" if broken else "other clouds", len(some), held_out(some))
        print(f"constant {constant:.2f}")
        for name, slope in zip(TRAITS, slopes, strict=True):
            print(f"{name:16s}{slope:8.2f}")


if __name__ == "__main__":
    main()
