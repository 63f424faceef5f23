"""``symrecon reconstruct``: the whole method, from a scan to a closed statue."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import click

from meshlab_symrecon import __version__
from meshlab_symrecon.cli.progress import progress_bar
from meshlab_symrecon.errors import SymReconError

__all__ = ["reconstruct"]

DETECT = "generate_reflection_planes"
COMPLETE = "generate_mirror_completed_points"
CLOSE = "generate_surface_reconstruction_power_crust"
SHARES = {"compute_normal_for_point_clouds": 0.05, DETECT: 0.4, COMPLETE: 0.05, CLOSE: 0.5}
SCAN, PLANES, COMPLETED, SURFACE = LABELS = (
    "scan", "reflection planes", "completed points", "surface",
)  # fmt: skip
PICTURES = ("png", "pdf", "svg", "jpg")
SEED = "randomseed"
SEED_LIMIT = 2**31 - 1


@dataclass(frozen=True, slots=True)
class Outputs:
    """Where the results go."""

    surface: Path
    project: Path | None
    report: Path | None
    preview: Path | None


@dataclass(frozen=True, slots=True)
class Reconstruction:
    """The document after the whole method, its layers, and what each filter measured."""

    mesh_set: Any
    layers: Mapping[str, int]  # label: identifier
    points: int
    found: Mapping[str, Any]
    completed: Mapping[str, Any]
    surface: Mapping[str, Any]


@click.command()
@click.argument("scan", type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    required=True,
    metavar="STATUE",
    help="File of the closed surface; the extension chooses the format, .ply keeps everything.",
)
@click.option(
    "--project",
    type=click.Path(path_type=Path),
    metavar="P.mlp",
    help="Also save every layer, and a MeshLab project that lists them.",
)
@click.option(
    "--json",
    "report",
    type=click.Path(path_type=Path),
    metavar="R.json",
    help="Also save what was found and measured.",
)
@click.option(
    "--preview",
    type=click.Path(path_type=Path),
    metavar="P.png",
    help="Also draw scan, plane and surface side by side (needs matplotlib).",
)
@click.option(
    "--seed", type=click.IntRange(0, SEED_LIMIT), default=0, show_default=True,
    help="Seed of what is random; equal seeds give equal results.",
)  # fmt: skip
def reconstruct(
    scan: Path,
    output: Path,
    project: Path | None,
    report: Path | None,
    preview: Path | None,
    seed: int,
) -> None:
    """Complete SCAN from its own mirror symmetry and close it with the Power Crust.

    Says what it found. When SCAN has no mirror plane, a warning says so and the surface closes
    what was measured.
    """
    from meshlab_symrecon.host.files import check_output, save_current

    started = time.perf_counter()
    outputs = Outputs(output, project, report, preview)
    _check_outputs(scan, outputs, check_output)
    with progress_bar("reconstructing") as progress:
        result = whole_method(scan, seed, progress)
    save_current(result.mesh_set, output)
    _write_extras(scan, outputs, result)
    seconds = time.perf_counter() - started
    if report is not None:
        from meshlab_symrecon.cli.reports import write_json

        write_json(report, as_data(scan, outputs, result, seed, seconds))
    for line in in_words(scan, result):
        click.echo(line)
    click.echo(f"written         {output} in {seconds:.1f} s")


def _check_outputs(scan: Path, outputs: Outputs, check_output: Callable[..., None]) -> None:
    """Refuse every bad output path before the work starts."""
    from meshlab_symrecon.host.files import PROJECT, layer_files

    check_output(outputs.surface, [scan])
    used = [scan, outputs.surface]
    others = ((outputs.project, (PROJECT,)), (outputs.report, ()), (outputs.preview, PICTURES))
    for path, known in others:
        if path is not None:
            check_output(path, used, known)
            used.append(path)
    if outputs.project is not None:
        for name in layer_files(outputs.project, dict(enumerate(LABELS))).values():
            check_output(outputs.project.parent / name, used)
    if outputs.preview is not None:
        missing = [
            name for name in ("matplotlib", "meshlab_symrecon.pictures") if find_spec(name) is None
        ]
        if missing:
            message = (
                f"--preview needs {missing[0]}, which is not installed; run "
                "pip install 'meshlab-symrecon[report]'"
            )
            raise SymReconError(message)


def whole_method(scan: Path, seed: int, progress: Callable[[float, str], None]) -> Reconstruction:
    """Load a scan and run the filters of the documented chain on it."""
    from meshlab_symrecon.host.files import load
    from meshlab_symrecon.host.meshset import current_identifier

    progress(0.0, f"reading {scan.name}")
    mesh_set = load(scan)
    layers = {SCAN: current_identifier(mesh_set)}
    points = mesh_set.current_mesh().vertex_number()
    run = _runner(mesh_set, seed, progress)
    run("compute_normal_for_point_clouds", "normals")
    found = run(DETECT, "looking for mirror planes")
    completed: Mapping[str, Any] = {"measured": points, "mirrored": 0}
    if len(found["planes"]):
        layers[PLANES] = _newest(mesh_set)
        completed = run(COMPLETE, "mirroring points")
        layers[COMPLETED] = current_identifier(mesh_set)
    surface = run(CLOSE, "closing the surface")
    layers[SURFACE] = current_identifier(mesh_set)
    return Reconstruction(mesh_set, layers, points, found, completed, surface)


def _runner(
    mesh_set: Any, seed: int, progress: Callable[[float, str], None]
) -> Callable[[str, str], Mapping[str, Any]]:
    """Return a function that runs one filter with its defaults and the seed."""
    from meshlab_symrecon.host.registration import apply_filter

    done = 0.0

    def run(name: str, title: str) -> Mapping[str, Any]:
        nonlocal done
        start, share = done, SHARES[name]
        progress(start, title)
        measures = apply_filter(
            mesh_set,
            name,
            progress=lambda fraction, _: progress(start + share * fraction, title),
            **_seeded(name, seed),
        )
        done = start + share
        return measures

    return run


def _seeded(name: str, seed: int) -> dict[str, int]:
    """Return the seed as a parameter of a filter that declares one."""
    from meshlab_symrecon.host.registration import registry

    declared = registry().find(name).parameters.declared() if name in registry() else ()
    return {SEED: seed} if SEED in (parameter.name for parameter in declared) else {}


def _bound(name: str, seed: int) -> Mapping[str, Any]:
    """Return every parameter of one of our filters as it ran."""
    from meshlab_symrecon.host.registration import registry

    return registry().find(name).bind(_seeded(name, seed)).values()


def _newest(mesh_set: Any) -> int:
    return max(int(mesh.id()) for mesh in mesh_set)


def _write_extras(scan: Path, outputs: Outputs, result: Reconstruction) -> None:
    if outputs.project is not None:
        from meshlab_symrecon.host.files import save_project

        labels = {identifier: label for label, identifier in result.layers.items()}
        save_project(
            result.mesh_set, outputs.project, inputs=[scan, outputs.surface], labels=labels
        )
    if outputs.preview is not None:
        from meshlab_symrecon.host.atomic import replacing

        with replacing(outputs.preview) as staged:
            _draw(scan, result, staged)


def _draw(scan: Path, result: Reconstruction, path: Path) -> None:
    import numpy as np

    from meshlab_symrecon.host.meshset import read_layer
    from meshlab_symrecon.pictures.main_job import main_job_picture

    layers = {label: read_layer(result.mesh_set, n) for label, n in result.layers.items()}
    measured, surface = layers[SCAN], layers[SURFACE]
    completed = layers.get(COMPLETED, measured)
    mirrored = np.arange(len(completed.points)) >= len(measured.points)
    invented = surface.quality if surface.quality is not None else np.zeros(len(surface.points))
    main_job_picture(
        measured.points, result.found["planes"], completed.points, mirrored,
        surface.points, surface.faces, invented, path, title=scan.name,
    )  # fmt: skip


def in_words(scan: Path, result: Reconstruction) -> list[str]:
    """Return what was found, one line a finding."""
    from meshlab_symrecon.cli.reports import detection

    lines = [f"scan            {scan} with {result.points} points"]
    planes = detection(result.found)["planes"]
    for plane in planes:
        numbers = " ".join(f"{number:.6g}" for number in plane["plane"])
        lines.append(f"mirror plane    {numbers} (A B C D), confidence {plane['confidence']:.2f}")
    if not planes:
        lines.append("mirror plane    none, so the surface closes what was measured")
    if not result.found["converged"]:
        lines.append("                the clustering stopped before it had converged")
    counts = result.completed
    lines.append(f"points          {counts['measured']} measured, {counts['mirrored']} mirrored")
    measures = result.surface
    closed = "closed" if measures["closed"] else "NOT closed"
    components = measures["components"]
    pieces = f"{components} component" + ("" if components == 1 else "s")
    faces = f"{measures['faces']} faces"
    lines.append(f"surface         {closed}, genus {measures['genus']}, {pieces}, {faces}")
    return lines


def as_data(
    scan: Path, outputs: Outputs, result: Reconstruction, seed: int, seconds: float
) -> dict[str, Any]:
    """Return everything that was found and measured; the planes as in every other report."""
    from importlib.metadata import version

    from meshlab_symrecon.cli.reports import detection

    completed = dict(result.completed)
    return {
        **detection(result.found),
        "measured": completed.pop("measured"),
        "mirrored": completed.pop("mirrored"),
        "completion": completed,
        "surface": dict(result.surface),
        "seconds": seconds,
        "input": str(scan),
        "output": str(outputs.surface),
        "project": None if outputs.project is None else str(outputs.project),
        "parameters": {
            SEED: seed,
            **{name: _bound(name, seed) for name in (DETECT, COMPLETE, CLOSE)},
        },
        "versions": {"meshlab_symrecon": __version__, "pymeshlab": version("pymeshlab")},
    }
