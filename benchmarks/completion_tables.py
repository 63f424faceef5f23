"""The tables of the benchmark of completion: columns, bars, and lines a model."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from completion_rows import Row
from completion_surfaces import SURFACES, Nearness

SYMMETRIC = 0.5  # % of the diagonal
LEAST = {"f": 0.97, "missing": 0.90}
OF_BEST = 0.97  # where the true plane cannot give that much

Column = Callable[[Row], float]
POINTS: dict[str, tuple[Column, str]] = {
    "plane °": (lambda row: row.plane[0], ".1f"),
    "plane %": (lambda row: row.plane[1], ".2f"),
    "asym. med %": (lambda row: row.asymmetric[0], ".2f"),
    "asym. 95 %": (lambda row: row.asymmetric[1], ".2f"),
    "F scan": (lambda row: row.before.f, ".3f"),
    "F whole": (lambda row: row.whole.f, ".3f"),
    "**F**": (lambda row: row.done.f, ".3f"),
    "F best": (lambda row: row.best.f, ".3f"),
    "P": (lambda row: row.done.precision, ".3f"),
    "P best": (lambda row: row.best.precision, ".3f"),
    "R": (lambda row: row.done.recall, ".3f"),
    "missing scan": (lambda row: row.before.missing, ".3f"),
    "missing whole": (lambda row: row.whole.missing, ".3f"),
    "**missing**": (lambda row: row.done.missing, ".3f"),
    "missing reach": (lambda row: row.reachable, ".3f"),
    "missing best": (lambda row: row.best.missing, ".3f"),
    "H95": (lambda row: row.done.hausdorff95, ".2f"),
    "H95 best": (lambda row: row.best.hausdorff95, ".2f"),
    "H": (lambda row: row.done.hausdorff, ".1f"),
    "H best": (lambda row: row.best.hausdorff, ".1f"),
}
JOIN: dict[str, tuple[Column, str]] = {
    "normal °": (lambda row: row.angle, ".1f"),
    "directed °": (lambda row: row.directed, ".1f"),
    "normal best °": (lambda row: row.best_angle, ".1f"),
    "scan's °": (lambda row: row.own_angle, ".1f"),
    "seam": (lambda row: row.seam.spacing, ".2f"),
    "off": (lambda row: row.seam.off, ".2f"),
    "own off": (lambda row: row.seam.own_off, ".2f"),
    "step %": (lambda row: row.seam.step, ".2f"),
    "own": (lambda row: row.seam.own_step, ".2f"),
    "rough": (lambda row: row.seam.roughness, ".2f"),
    "invented": (lambda row: row.done.invented, ".4f"),
    "of strays": (lambda row: row.images_of[0], ".4f"),
    "of plinth": (lambda row: row.images_of[1], ".4f"),
    "inv. best": (lambda row: row.best.invented, ".4f"),
    "inv. whole": (lambda row: row.whole.invented, ".3f"),
    "added": (lambda row: row.share, ".2f"),
    "CPU s": (lambda row: row.seconds, ".2f"),
}

Bar = tuple[Callable[[Row], bool], Callable[[Row], bool]]  # where it counts, whether it holds
BARS: dict[str, Bar] = {
    "F": (lambda row: True, lambda row: reaches(row, "f")),
    "recall on the removed part": (lambda row: True, lambda row: reaches(row, "missing")),
    "recall on the removed part, of what was measured on the other side": (
        lambda row: True,
        lambda row: row.done.missing >= min(LEAST["missing"], OF_BEST * row.reachable),
    ),
    "precision >= .98, median asymmetry <= .5 %": (
        lambda row: row.asymmetric[0] <= SYMMETRIC,
        lambda row: row.done.precision >= 0.98,
    ),
    "precision >= .98, 95 % asymmetry <= .5 %": (
        lambda row: row.asymmetric[1] <= SYMMETRIC,
        lambda row: row.done.precision >= 0.98,
    ),
    "median normal angle <= 8°": (
        lambda row: np.isfinite(row.angle),
        lambda row: row.angle <= 8.0,
    ),
    "median normal angle <= 8°, or 2° above that of the scan's normals": (
        lambda row: np.isfinite(row.angle),
        lambda row: row.angle <= max(8.0, row.own_angle + 2.0),
    ),
    "seam spacing within 25 %": (
        lambda row: np.isfinite(row.seam.spacing),
        lambda row: abs(row.seam.spacing - 1.0) <= 0.25,
    ),
    "at most a tenth of the seam out by more than 25 %, beyond the complete cloud's own": (
        lambda row: np.isfinite(row.seam.spacing),
        lambda row: row.seam.off <= row.seam.own_off + 0.1,
    ),
    "invented < 1 %": (lambda row: row.planes > 0, lambda row: row.done.invented < 0.01),
    "invented < 1 % more than the true plane invents": (
        lambda row: row.planes > 0,
        lambda row: row.done.invented < row.best.invented + 0.01,
    ),
    "invented images of strays and plinth < 1 %": (
        lambda row: row.planes > 0,
        lambda row: sum(row.images_of) < 0.01,
    ),
    "F above no completion": (
        lambda row: row.planes > 0,
        lambda row: row.done.f > row.before.f,
    ),
    "F above the whole mirror": (
        lambda row: row.planes > 0,
        lambda row: row.done.f >= row.whole.f - 1e-3,
    ),
}


def reaches(row: Row, measure: str) -> bool:
    """Tell whether a measure is high enough, or almost what the true plane can give."""
    best = getattr(row.best, measure)
    least = LEAST[measure] if best >= LEAST[measure] else OF_BEST * best
    return getattr(row.done, measure) >= least


# ----------------------------------------------------------------------------------------- tables


def line(cells) -> str:
    return "| " + " | ".join(cells) + " |"


def print_table(rows: list[Row], columns: dict[str, tuple[Column, str]]) -> None:
    """One line a model: means over its seeds."""
    print()
    print(line(["model", "found", *columns]))
    print(line(["---"] * (2 + len(columns))))
    for name in dict.fromkeys(row.model for row in rows):
        group = [row for row in rows if row.model == name]
        found = f"{sum(row.planes > 0 for row in group)}/{len(group)}"
        cells = []
        for value, form in columns.values():
            values = [value(row) for row in group if np.isfinite(value(row))]
            cells.append(f"{np.mean(values):{form}}" if values else "-")
        print(line([name, found, *cells]), flush=True)


def print_bars(rows: list[Row], condition: str) -> None:
    """Say how many scans each bar holds for, and for which it does not."""
    print(f"\nBars, {condition}:\n")
    for name, (counts, holds) in BARS.items():
        judged = [row for row in rows if counts(row)]
        failed = [f"{row.model} {row.seed}" for row in judged if not holds(row)]
        words = f": not {', '.join(failed)}" if failed else ""
        print(f"* {name}: {len(judged) - len(failed)}/{len(judged)}{words}")


def print_surfaces(rows: list[tuple[str, int, dict[str, Nearness]]]) -> None:
    """One line a model: means over its seeds; and whether ours is the nearest one, and closed."""
    print("\nMean distance % / Hausdorff distance % / F at 1 % / closed\n")
    print(line(["model", *SURFACES]))
    print(line(["---"] * (1 + len(SURFACES))))
    for name in dict.fromkeys(name for name, _, _ in rows):
        groups = [[found[way] for n, _, found in rows if n == name] for way in SURFACES]
        print(line([name, *map(surface_cell, groups)]))
    print()
    unclosed = [f"{name} {seed}" for name, seed, found in rows if not found["ours"].closed]
    print(f"* closed: {len(rows) - len(unclosed)}/{len(rows)} {', '.join(unclosed)}")
    for way in list(SURFACES)[1:]:
        for measure in ("mean", "hausdorff"):
            lost = [
                f"{name} {seed}"
                for name, seed, found in rows
                if getattr(found["ours"], measure) >= getattr(found[way], measure)
            ]
            words = f": not {', '.join(lost)}" if lost else ""
            count = f"{len(rows) - len(lost)}/{len(rows)}"
            print(f"* {measure} distance below that of *{way}*: {count}{words}")


def surface_cell(group: list[Nearness]) -> str:
    mean, hausdorff, f = (
        np.mean([getattr(one, name) for one in group]) for name in ("mean", "hausdorff", "f")
    )
    return f"{mean:.2f} / {hausdorff:.1f} / {f:.3f} / {sum(one.closed for one in group)}"
