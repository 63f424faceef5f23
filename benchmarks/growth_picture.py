"""Draw the growth of time and memory, from the numbers of `growth.py`.

python benchmarks/growth_picture.py rows.json docs/pictures/growth.png
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
from matplotlib import pyplot as plt

STAGES = {
    "generate_reflection_planes": ("detection", "tab:blue"),
    "generate_mirror_completed_points": ("completion", "tab:green"),
    "generate_surface_reconstruction_power_crust": ("crust", "tab:red"),
}
MARKS = "os^v"


def main() -> None:
    rows = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    statues = list(dict.fromkeys(row["statue"] for row in rows))
    figure, (times, memories) = plt.subplots(1, 2, figsize=(9.0, 3.6), layout="constrained")
    for stage, (label, colour) in STAGES.items():
        for number, statue in enumerate(statues):
            chosen = [row for row in rows if row["stage"] == stage and row["statue"] == statue]
            points = [row["points"] for row in chosen]
            look = {"color": colour, "marker": MARKS[number], "linewidth": 1.2, "markersize": 4}
            name = f"{label}, {statue}"
            times.plot(points, [row["seconds"] for row in chosen], label=name, **look)
            memories.plot(points, [row["peak"] / 1e9 for row in chosen], **look)
    for axes, what in ((times, "CPU seconds"), (memories, "peak memory of the process, GB")):
        axes.set(xscale="log", yscale="log", xlabel="points", ylabel=what)
        axes.grid(which="major", alpha=0.4)
    for axes, ticks in ((times, (0.5, 1, 2, 5, 10, 20, 50)), (memories, (0.2, 0.5, 1, 2, 5))):
        axes.set_yticks(ticks, [f"{tick:g}" for tick in ticks])
        axes.set_yticks([], minor=True)
    times.legend(fontsize=7)
    figure.savefig(sys.argv[2], dpi=110, metadata={"Software": None})


if __name__ == "__main__":
    main()
