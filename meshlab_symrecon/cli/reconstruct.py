"""``symrecon reconstruct``: the whole method, from a scan to a closed statue."""

from __future__ import annotations

import shlex
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from meshlab_symrecon.cli.long_work import LongWork, long_work, max_points_option
from meshlab_symrecon.errors import SymReconError

if TYPE_CHECKING:
    from meshlab_symrecon.host.reconstruction import Reconstruction

__all__ = ["reconstruct"]

PICTURES = ("png",)
PAGES = ("html", "htm")
SEED_LIMIT = 2**31 - 1
# Shares of the whole command that are done.
METHOD_DONE, SURFACE_WRITTEN, PROJECT_WRITTEN, PREVIEW_DRAWN = 0.96, 0.97, 0.98, 0.99


@dataclass(frozen=True, slots=True)
class Outputs:
    """Where the results go."""

    surface: Path
    project: Path | None = None
    json: Path | None = None
    preview: Path | None = None
    report: Path | None = None


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
    "json_path",
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
    "--report",
    type=click.Path(path_type=Path),
    metavar="R.html",
    help="Also write a page to judge and repeat the result by: a view to turn, what was found and "
    "invented, every parameter and version (needs plotly and matplotlib).",
)
@click.option(
    "--seed", "randomseed", type=click.IntRange(0, SEED_LIMIT), default=0, show_default=True,
    help="Seed of what is random; equal seeds give equal results.",
)  # fmt: skip
@max_points_option
@click.option(
    "--paint", is_flag=True,
    help="Colour the completed points and the surface by what was measured and what was invented.",
)  # fmt: skip
@long_work
def reconstruct(
    scan: Path,
    output: Path,
    project: Path | None,
    json_path: Path | None,
    preview: Path | None,
    report: Path | None,
    *,
    work: LongWork,
    **settings: Any,
) -> None:
    """Complete SCAN from its own mirror symmetry and close it with the Power Crust.

    Says what it found. When SCAN has no mirror plane, a warning says so and the surface closes
    what was measured.
    """
    from meshlab_symrecon.host.atomic import together
    from meshlab_symrecon.host.reconstruction import whole_method
    from meshlab_symrecon.host.thinning import check_most

    started = time.perf_counter()
    outputs = Outputs(output, project, json_path, preview, report)
    _check_outputs(scan, outputs)
    most = settings.pop("max_points")
    if most is not None:
        check_most(most)
    with together(), work.progress("reconstructing") as progress:
        result = whole_method(
            scan,
            settings,
            lambda fraction, message: progress(METHOD_DONE * fraction, message),
            most=most,
        )
        settings |= {} if most is None else {"max_points": most}
        _write(scan, outputs, result, settings, progress)
        seconds = time.perf_counter() - started
        if json_path is not None:
            from meshlab_symrecon.cli.reports import write_json

            write_json(json_path, as_data(scan, outputs, result, settings, seconds))
    for line in in_words(scan, result):
        work.say(line)
    work.say(f"written         {output} in {seconds:.1f} s")


def _check_outputs(scan: Path, outputs: Outputs) -> None:
    """Refuse every bad output path before the work starts."""
    from meshlab_symrecon.host.files import check_output
    from meshlab_symrecon.host.projects import PROJECT, layer_files
    from meshlab_symrecon.host.reconstruction import LABELS

    check_output(outputs.surface, [scan])
    used = [scan, outputs.surface]
    others = (
        (outputs.project, (PROJECT,)), (outputs.json, ()), (outputs.preview, PICTURES),
        (outputs.report, PAGES),
    )  # fmt: skip
    for path, known in others:
        if path is not None:
            check_output(path, used, known)
            used.append(path)
    if outputs.project is not None:
        for name in layer_files(outputs.project, dict(enumerate(LABELS))).values():
            check_output(outputs.project.parent / name, used)
    for option, path, libraries in (
        ("--preview", outputs.preview, ("matplotlib",)),
        ("--report", outputs.report, ("plotly", "matplotlib")),
    ):
        for library in libraries if path is not None else ():
            if find_spec(library) is None:
                message = (
                    f"{option} needs {library}, which is not installed; run "
                    "pip install 'meshlab-symrecon[report]'"
                )
                raise SymReconError(message)


def _write(
    scan: Path,
    outputs: Outputs,
    result: Reconstruction,
    settings: Mapping[str, Any],
    progress: Callable[[float, str], None],
) -> None:
    """Write all that was asked for but the JSON, which tells how long it took."""
    from meshlab_symrecon.host.files import save_current
    from meshlab_symrecon.host.records import record_of

    progress(METHOD_DONE, f"writing {outputs.surface}")
    # The others are parameters of the steps, which the record has anyway.
    own = {name: settings[name] for name in ("max_points",) if name in settings}
    record = record_of(result.mesh_set, [scan], own)
    save_current(result.mesh_set, outputs.surface, record)
    if outputs.project is not None:
        from meshlab_symrecon.host.projects import save_project

        progress(SURFACE_WRITTEN, f"writing {outputs.project}")
        labels = {identifier: label for label, identifier in result.layers.items()}
        inputs = [scan, outputs.surface]
        save_project(result.mesh_set, outputs.project, inputs, labels, record)
    if outputs.preview is not None:
        from meshlab_symrecon.host.atomic import replacing

        progress(PROJECT_WRITTEN, f"drawing {outputs.preview}")
        with replacing(outputs.preview) as staged:
            _draw(scan, result, staged)
    if outputs.report is not None:
        from meshlab_symrecon.cli.report import write_report

        progress(PREVIEW_DRAWN, f"drawing {outputs.report}")
        write_report(outputs.report, scan, result, command_line(scan, outputs, settings))
    progress(1.0, "")


def command_line(scan: Path, outputs: Outputs, settings: Mapping[str, Any]) -> str:
    """Return the command that gives these outputs again."""
    options = {
        "-o": outputs.surface,
        "--project": outputs.project,
        "--json": outputs.json,
        "--preview": outputs.preview,
        "--report": outputs.report,
        "--seed": settings["randomseed"],
        "--max-points": settings.get("max_points"),
    }
    given = [(name, str(value)) for name, value in options.items() if value is not None]
    flags = ["--paint"] if settings["paint"] else []
    return shlex.join(["symrecon", "reconstruct", str(scan), *chain.from_iterable(given), *flags])


def _draw(scan: Path, result: Reconstruction, path: Path) -> None:
    from meshlab_symrecon.cli.report import scene_of
    from meshlab_symrecon.pictures.main_job import main_job_picture

    seen = scene_of(result)
    main_job_picture(
        seen.scan, seen.planes, seen.completed, seen.mirrored, seen.surface, seen.faces,
        seen.share, path, title=scan.name,
    )  # fmt: skip


def in_words(scan: Path, result: Reconstruction) -> list[str]:
    """Return what was found, one line a finding."""
    from meshlab_symrecon.cli.reports import detection
    from meshlab_symrecon.cli.unfilled import holes, left_alone, place, width

    thinned = "" if result.measured in (0, result.points) else f", thinned out of {result.measured}"
    lines = [f"scan            {scan} with {result.points} points{thinned}"]
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
    lines += [f"not mirrored    {phrase}" for phrase in left_alone(counts)]
    unfilled = holes(counts)
    if len(unfilled):
        several = "1 hole" if len(unfilled) == 1 else f"{len(unfilled)} holes, the widest"
        widest = f"{width(unfilled[0])} wide at {place(unfilled[0])}"
        lines.append(f"not filled      {several} {widest}: missing on both sides of the plane")
    measures = result.surface
    closed = "closed" if measures["closed"] else "NOT closed"
    components = measures["components"]
    pieces = f"{components} component" + ("" if components == 1 else "s")
    faces = f"{measures['faces']} faces"
    lines.append(f"surface         {closed}, genus {measures['genus']}, {pieces}, {faces}")
    return lines


def as_data(
    scan: Path,
    outputs: Outputs,
    result: Reconstruction,
    settings: Mapping[str, Any],
    seconds: float,
) -> dict[str, Any]:
    """Return everything that was found and measured; the planes as in every other report."""
    from meshlab_symrecon.host.measures import findings
    from meshlab_symrecon.host.reconstruction import parameters_as_run
    from meshlab_symrecon.host.records import versions

    return {
        **findings(result),
        "seconds": seconds,
        "input": str(scan),
        "output": str(outputs.surface),
        "project": None if outputs.project is None else str(outputs.project),
        "parameters": parameters_as_run(settings),
        "versions": versions(),
    }
