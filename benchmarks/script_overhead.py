"""What the runner of scripts costs a step, over calling pymeshlab directly.

``python benchmarks/script_overhead.py [REPEATS]``. Forty light steps of MeshLab, and three steps of
ours, are run on a small mesh and on one of a million vertices: by ``run_script``, by
``load_plugins`` and its ``apply_filter``, and by pymeshlab alone. The table has, for each, the time
that is spent outside of the filters themselves, in milliseconds a step: median and worst of the
repeats. It is measured twice, as the difference of two runs, and within one run as the time that no
filter was running; the second does not depend on how long the filters take. Time is that of the
processor, so that other programs of the machine do not count.
"""

from __future__ import annotations

import statistics
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pymeshlab

import meshlab_symrecon
from meshlab_symrecon.host.script import run_script
from meshlab_symrecon.plugin import Filter

REPEATS = 5
BAR = 20.0  # ms a step

LIGHT = [  # menu name, Python name, parameters as scripts write them, as Python does
    ("Select All", "set_selection_all", {}, {}),
    ("Invert Selection", "apply_selection_inverse", {}, {}),
    ("Select None", "set_selection_none", {}, {}),
    ("Rename Current Mesh", "set_mesh_name", {"newName": "scan"}, {"newname": "scan"}),
    ("Vertex Color Filling", "set_color_per_vertex", {}, {}),
    (
        "Matrix: Set from translation/rotation/scale",
        "compute_matrix_from_translation_rotation_scale",
        {"translationX": "1", "Freeze": "false"},
        {"translationx": 1.0, "freeze": False},
    ),
    ("Matrix: Reset Current Matrix", "set_matrix_identity", {}, {}),
    (  # a length that is left to its default, a share of the box
        "ScaleDependent Laplacian Smooth",
        "apply_coord_laplacian_smoothing_scale_dependent",
        {"stepSmoothNum": "0"},
        {"stepsmoothnum": 0},
    ),
    ("Normalize Vertex Normals", "apply_normal_normalization_per_vertex", {}, {}),
    ("Vertex Color Invert", "apply_color_inverse_per_vertex", {}, {}),
] * 4
OURS = [
    ("Simplify Points (AP)", "generate_simplified_points", {"count": "100"}, {"count": 100}),
    ("Detect Reflection Planes (AP)", "generate_reflection_planes", {}, {}),
    ("Mirror Symmetry Deviation", "compute_scalar_by_mirror_symmetry_per_vertex", {}, {}),
]


def mesh_of(vertices: int) -> Any:
    """Return a closed grid on a bent box with about that many vertices."""
    mesh_set = pymeshlab.MeshSet(verbose=False)
    side = max(4, round(vertices**0.5))
    mesh_set.create_grid(numvertx=side, numverty=side, absscalex=3.0, absscaley=2.0, center=True)
    mesh_set.compute_coord_by_function(x="x", y="y", z="0.3*cos(3*x)*cos(2*y)+0.1*x*x*y")
    mesh_set.clear_filter_script()
    return mesh_set


def written(steps: list[Any], folder: Path) -> Path:
    lines = ["<!DOCTYPE FilterScript>", "<FilterScript>"]
    for name, _, texts, _ in steps:
        lines.append(f' <filter name="{name}">')
        lines += [f'  <Param name="{key}" value="{text}"/>' for key, text in texts.items()]
        lines.append(" </filter>")
    path = folder / "steps.mlx"
    path.write_text("\n".join([*lines, "</FilterScript>", ""]))
    return path


class Clock:
    """Time that was spent inside of filters."""

    def __init__(self) -> None:
        self.seconds = 0.0

    def around(self, function: Callable[..., Any]) -> Callable[..., Any]:
        def timed(*values: Any, **named: Any) -> Any:
            started = time.process_time()
            try:
                return function(*values, **named)
            finally:
                self.seconds += time.process_time() - started

        return timed


@contextmanager
def watched(clock: Clock) -> Iterator[None]:
    """Time every filter, MeshLab's and ours, wherever it is called from."""
    native, plugin = pymeshlab.MeshSet.apply_filter, Filter.apply
    pymeshlab.MeshSet.apply_filter = clock.around(native)
    Filter.apply = clock.around(plugin)  # type: ignore[method-assign]
    try:
        yield
    finally:
        pymeshlab.MeshSet.apply_filter = native
        Filter.apply = plugin  # type: ignore[method-assign]


def by_script(mesh_set: Any, steps: list[Any], path: Path) -> None:
    run_script(mesh_set, path)


def by_plugins(mesh_set: Any, steps: list[Any], path: Path) -> None:
    for _, name, _, values in steps:
        mesh_set.apply_filter(name, **values)


def outside(
    way: Callable[..., None], mesh_set: Any, steps: list[Any], path: Path
) -> tuple[float, float]:
    """Return the seconds of a run, and how many of them no filter was running."""
    clock = Clock()
    with watched(clock):
        if way is by_plugins:
            meshlab_symrecon.load_plugins()  # on top of the clock, which then sees what is native
        try:
            started = time.process_time()
            way(mesh_set, steps, path)
            seconds = time.process_time() - started
        finally:
            if way is by_plugins:
                meshlab_symrecon.unload_plugins()
    return seconds, seconds - clock.seconds


def row(
    steps: list[Any], vertices: int, folder: Path, repeats: int, direct_runs: bool
) -> list[str]:
    path = written(steps, folder)
    mesh_set = mesh_of(vertices)
    run_script(mesh_set, path)  # reads tables, imports
    cells = []
    for way in (by_script, by_plugins):
        inner, difference = [], []
        for _ in range(repeats):
            fresh = mesh_of(vertices)
            seconds, spent = outside(way, fresh, steps, path)
            inner.append(1000.0 * spent / len(steps))
            if direct_runs:
                fresh = mesh_of(vertices)
                started = time.process_time()
                by_plugins(fresh, steps, path)  # nothing is loaded: pymeshlab alone
                direct = time.process_time() - started
                difference.append(1000.0 * (seconds - direct) / len(steps))
        cells.append(f"{statistics.median(inner):.2f} / {max(inner):.2f}")
        cells.append(f"{statistics.median(difference):.2f}" if difference else "-")
    return cells


def main() -> None:
    repeats = int(sys.argv[1]) if len(sys.argv) > 1 else REPEATS
    warnings.simplefilter("ignore")
    print("| steps | vertices | script: outside filters, median / worst | difference | "
          "load_plugins: outside filters | difference |")  # fmt: skip
    print("|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory(prefix="overhead-") as name:
        for title, steps, sizes in (
            ("40 of MeshLab's", LIGHT, (1_000, 1_000_000)),
            ("3 of ours", OURS, (1_000, 100_000)),
            ("2 of ours", OURS[1:], (1_000_000,)),
        ):
            for vertices in sizes:
                cells = row(steps, vertices, Path(name), repeats, steps is LIGHT)
                print("|", " | ".join([title, f"{vertices:,}", *cells]), "|", flush=True)
    print(f"\nms a step; the bar is {BAR:.0f}")


if __name__ == "__main__":
    main()
